"""Contact, gages and forces of one design as Plotly figures, for the comparison page.

A figure is {data, layout (as Plotly has them), steps, shared, words}. Colours are names of the
page's own ("--blue"). steps: by increment, the change of the layout that shows it; shared: axes
that two designs side by side have in common; words: the text alternative; marks: points whose
status changes with the increment. Numbers alone stand in
figures: no text of an outcome, which Plotly might take for markup.
"""

import json
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain, groupby, pairwise
from pathlib import Path
from typing import Any

from fingerdesign.records.outcome import GripOutcome, Numbers, Outcome, Traces
from fingerdesign.report.figure import LOOKS as COMMON_LOOKS
from fingerdesign.report.figure import Figure, finger_in_space, number, round_values

STATUS = "#/."  # stick, slip, open
# Colours, lines and marks, as Plotly has them. "looks": what the page's own charts have in common.
FIDELITIES = {
    "plane-strain": "plane strain",
    "3d": "three dimensions",
    "finite": "three dimensions, at finite strain",
    "auto": "chosen by tolerance",
}
LOOKS: Figure = json.loads(
    (Path(__file__).parent / "templates" / "looks.json").read_text(encoding="utf-8")
)
LOOKS["looks"] |= {name: COMMON_LOOKS[name] for name in ("options", "template")}


def frictions_of(outcomes: Sequence[Outcome]) -> dict[float, int]:
    """Every friction of a grip and the number of its look, from the lowest on."""
    found = {grip.friction_coefficient for outcome in outcomes for grip in outcome.grips}
    return {value: k for k, value in enumerate(sorted(each for each in found if each > 0))}


def shape_figure(geometry: Mapping[str, Any], deep: bool) -> Figure | None:
    """The finger in space, of what packed_geometry found; the page adds the camera.

    deep: of a 3-D model, whose contact is drawn point by point, else in lines along z.
    """
    if geometry["body"] is None:
        return None
    figure = finger_in_space(geometry)
    del figure["config"]  # the page's own
    first, mode = len(figure["data"]), {"mode": "markers" if deep else "lines"}
    marks = geometry["touch"] and {"first": first, "kinds": STATUS[:2], **geometry["touch"]}
    figure["data"] += [{**each, **mode} for each in LOOKS["touch"]]
    words = f"{geometry['words']} {geometry['note']}".strip()
    own: Figure = {"steps": [], "shared": [], "marks": marks, "words": words}
    return {**figure, **own}


def contact_figure(traces: Traces) -> Figure | None:
    """Status over x, a row an increment; in 3-D over x and z at one increment."""
    x, z = traces.contact_x_mm, traces.contact_z_mm
    wide = _touched_range(traces)
    if wide is None:
        return None
    words = contact_words(traces.status)
    if z:
        return _contact_points(traces, wide, words)
    count = len(traces.status)
    order = sorted(range(len(x)), key=lambda place: x[place] or 0.0)
    places = [x[k] or 0.0 for k in order]
    data = [
        {**look, **_bars(places, order, traces.status, character)}
        for look, character in zip(LOOKS["bars"], STATUS, strict=False)
    ]
    layout = {
        "height": 100 + min(340, max(60, 13 * count)),
        "barmode": "overlay",
        "plot_bgcolor": "--open",
        "showlegend": True,
        "xaxis": {"title": {"text": "x (mm)"}, "range": wide, "showgrid": False},
        "yaxis": {"title": {"text": "increment"}, "range": [count + 0.5, 0.5], "showgrid": False},
        "shapes": [LOOKS["row"]],
    }
    steps = [{"shapes[0].y0": k + 0.52, "shapes[0].y1": k + 1.48} for k in range(count)]
    return {"data": data, "layout": layout, "steps": steps, "shared": ["xaxis"], "words": words}


def _touched_range(traces: Traces) -> list[Any] | None:
    """The range of x that is ever touched, with some room; None where nothing is known."""
    points = [(place, x) for place, x in enumerate(traces.contact_x_mm) if x is not None]
    if not points or not traces.status:
        return None
    known = [x for _, x in points]
    closed = {k for row in traces.status for k, mark in enumerate(row) if mark != "."}
    touched = [x for place, x in points if place in closed] or known
    low, high = min(touched), max(touched)
    more = 0.15 * (high - low) + 0.1
    return [number(max(low - more, min(known))), number(min(high + more, max(known)))]


def _bars(
    x: Sequence[float], order: Sequence[int], status: Sequence[str], mark: str
) -> dict[str, Any]:
    """The runs of one character as bars: base, x (their length) and y (the increment)."""
    edge = [x[0], *(0.5 * (p + q) for p, q in pairwise(x)), x[-1]]
    found: dict[str, list[Any]] = {"base": [], "x": [], "y": []}
    for row, text in enumerate(status, 1):
        start = 0
        for character, group in groupby(text[k : k + 1] or "." for k in order):
            end = start + len(list(group))
            if character == mark:
                found["base"].append(number(edge[start]))
                found["x"].append(number(edge[end] - edge[start]))
                found["y"].append(row)
            start = end
    return found


def _contact_points(traces: Traces, wide: list[Any], words: str) -> Figure:
    """From above; the points of each status are filled in by the page."""
    x, z = round_values(traces.contact_x_mm), round_values(traces.contact_z_mm)
    each = 1
    if all(place is None or place >= -1e-9 for place in z):
        # A model of the half z >= 0 alone is its own mirror image.
        each = 2
        x = [value for value in x for _ in range(2)]
        z = [value for place in z for value in (place, None if place is None else -place)]
    layout = {
        "height": 300,
        "showlegend": True,
        "xaxis": {"title": {"text": "x (mm)"}, "range": wide},
        "yaxis": {"title": {"text": "z (mm)"}, "scaleanchor": "x"},
    }
    marks = {"first": 0, "kinds": STATUS, "places": {"x": x, "y": z}, "each": each}
    own = {"steps": [], "shared": ["xaxis"], "marks": marks, "words": words}
    return {"data": LOOKS["points"], "layout": layout, **own}


def gages_figure(traces: Traces) -> Figure | None:
    """Each gage along the path, a trace each; the page brings one out."""
    if not traces.gages or not traces.gages[0]:
        return None
    count, many = len(traces.gages), len(traces.gages[0])
    readings = (
        (value or 0.0, row, gage)
        for row, values in enumerate(traces.gages)
        for gage, value in enumerate(values)
    )
    value, row, best = max(readings, key=lambda each: abs(each[0]))
    steps = list(range(1, count + 1))
    data = [
        {
            "mode": "lines",
            "x": steps,
            "y": round_values([row[gage] for row in traces.gages]),
            "name": f"gage {gage + 1}",
            "line": {"color": "--muted", "width": 0.9},
        }
        for gage in range(many)
    ]
    layout = {
        "xaxis": {"title": {"text": "increment"}, "range": [1, max(2, count)]},
        "yaxis": {
            "title": {"text": "reading (microstrain)"},
            "zeroline": True,
            "range": _spread(traces.gages),
        },
        "shapes": [LOOKS["cursor"]],
    }
    places = traces.gage_x_mm
    names = [_placed(traces, gage) for gage in range(many)]
    order = sorted(range(many) if len(places) == many else (), key=lambda k: places[k] or 0.0)
    words = (
        f"Readings of {many} gages over {count} increments. The largest is {value:.3g} "
        f"microstrain, of {names[best]}, at increment {row + 1}."
    )
    return {
        "data": data,
        "layout": layout,
        "steps": [{"shapes[0].x0": k, "shapes[0].x1": k} for k in steps],
        "shared": ["yaxis"],
        "words": words,
        "names": names,
        "best": best,
        "order": order,
        "places": round_values([places[gage] for gage in order]),
    }


def _placed(traces: Traces, gage: int) -> str:
    place = traces.gage_x_mm[gage] if gage < len(traces.gage_x_mm) else None
    return f"gage {gage + 1}" + ("" if place is None else f", x = {place:.3g} mm")


def forces_figure(outcome: Outcome, frictions: Mapping[float, int]) -> Figure | None:
    """Tangential over normal force: the scene's path, every grip's, and their friction limits."""
    traces, grips = outcome.traces, outcome.grips
    if not traces.normal_force_N and not grips:
        return None
    paths: tuple[Traces | GripOutcome, ...] = (traces, *grips)
    wide = _spread(path.normal_force_N for path in paths)
    high = _spread(path.tangential_force_N for path in paths)
    shown = sorted({grip.friction_coefficient for grip in grips} & set(frictions))
    corner = wide[1], high[1]
    data = [_limit(friction, _look(friction, frictions), corner) for friction in shown]
    data += [_grip(grip, frictions) for grip in grips]
    normal = round_values(traces.normal_force_N)
    tangential = round_values(traces.tangential_force_N)
    if normal:
        data.append({"x": normal, "y": tangential, **LOOKS["scene_path"]})
    layout = {
        "height": 360,
        "showlegend": True,
        "xaxis": {"title": {"text": "normal force (N)"}, "range": wide},
        "yaxis": {"title": {"text": "tangential force (N)"}, "range": high},
        "shapes": [LOOKS["now"]] if normal else [],
    }
    steps = [
        {"shapes[0].xanchor": x, "shapes[0].yanchor": y}
        for x, y in zip(normal, tangential, strict=False)
    ]
    words = forces_words(traces, grips)
    own = {"steps": steps, "shared": ["xaxis", "yaxis"], "words": words}
    return {"data": data, "layout": layout, **own}


def _limit(friction: float, look: Mapping[str, Any], corner: tuple[Any, Any]) -> dict[str, Any]:
    """The line F_t = friction F_n, to where it leaves the picture; ``corner``: greatest forces."""
    far = max(corner[0] or 0.0, (corner[1] or 0.0) / friction)
    line = {"color": look["colour"], "dash": look["dash"], "width": 0.9}
    ends = {"x": [0, number(far)], "y": [0, number(friction * far)], "line": line}
    return {"mode": "lines", "name": f"limit μ = {friction:g}", "hoverinfo": "skip", **ends}


def _grip(grip: GripOutcome, frictions: Mapping[float, int]) -> dict[str, Any]:
    """Its path; the last point is a cross where it was not lifted or slipped as a whole."""
    look = _look(grip.friction_coefficient, frictions)
    good = grip.lifted and not grip.gross_slip
    count = len(grip.normal_force_N)
    sizes = [0] * (count - 1) + [9] * min(1, count)
    end = "lifted" if good else "not lifted or slipped"
    return {
        "mode": "lines+markers",
        "x": round_values(grip.normal_force_N),
        "y": round_values(grip.tangential_force_N),
        "name": f"grip μ = {grip.friction_coefficient:g}, {end}",
        "line": {"color": look["colour"], "dash": look["dash"], "width": 1.6},
        "marker": {
            "symbol": look["symbol"] if good else "x",
            "size": sizes,
            "color": look["colour"],
        },
    }


def _look(friction: float, frictions: Mapping[float, int]) -> dict[str, str]:
    """Colour, dashes and marker of a friction."""
    looks: list[dict[str, str]] = COMMON_LOOKS["series"]
    return looks[frictions.get(friction, -1) % len(looks)]


def _spread(lists: Iterable[Numbers]) -> list[float | int | None]:
    """The range of an axis that holds 0 and all numbers, with 6 % more at an end that is not 0."""
    values = [0.0, *(value for value in chain.from_iterable(lists) if value is not None)]
    low, high = min(values), max(values)
    more = 0.06 * (high - low) or 0.5
    return [number(low - more if low else 0.0), number(high + more if high else 0.0)]


def contact_words(rows: Sequence[str]) -> str:
    """The contact in words: where it begins, where most of it sticks, and its end."""
    touching = [k for k, row in enumerate(rows, 1) if "#" in row or "/" in row]
    if not touching:
        return "The object does not touch the finger in any increment."
    sticking = [row.count("#") for row in rows]
    most, last = sticking.index(max(sticking)), rows[-1]
    ends = f"{last.count('#')} points stick and {last.count('/')} slip"
    return (
        f"Contact begins at increment {touching[0]}; most sticks at increment {most + 1} "
        f"({sticking[most]} of {len(rows[most])} points); at the last, increment {len(rows)}, "
        f"{ends if touching[-1] == len(rows) else 'nothing touches'}."
    )


def forces_words(traces: Traces, grips: Sequence[GripOutcome]) -> str:
    """The forces in words: the end of the path, and how each grip ended."""
    found = []
    if traces.normal_force_N:
        ends = traces.normal_force_N[-1], traces.tangential_force_N[-1]
        normal, tangential = ("none" if each is None else f"{each:.3g}" for each in ends)
        found.append(f"The scene’s path ends at {normal} N normal and {tangential} N tangential.")
    for grip in grips:
        peak = "none" if grip.peak_normal_force_N is None else f"{grip.peak_normal_force_N:.3g}"
        found.append(
            f"Friction {grip.friction_coefficient:.3g}, {grip.object_mass_g:.3g} g, "
            f"{grip.controller}: {'' if grip.lifted else 'not '}lifted"
            f"{', slipped as a whole' if grip.gross_slip else ''}, peak {peak} N."
        )
    return " ".join(found)


def accuracy(outcome: Outcome) -> list[tuple[str, str]]:
    """The accuracy of a design's numbers: what, and how far."""

    def percent(share: float | None) -> str:
        return "not estimated" if share is None else f"{100 * share:.2g} %"

    computed = FIDELITIES.get(outcome.fidelity, outcome.fidelity or "not known")
    flat = percent(outcome.validity.plane_strain_error)
    deep = outcome.fidelity in ("3d", "finite")
    return [
        ("Computed in", computed),
        ("Plane strain overstates the normal force by", "not used" if deep else flat),
        ("Error from the mesh", percent(outcome.validity.mesh_error)),
    ]
