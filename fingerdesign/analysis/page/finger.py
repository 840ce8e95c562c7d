"""The finger in space, to be turned: what its contact and its plates do along the path of loads.

A slider goes along the increments; menus choose the colours of the contact, how the body is drawn,
and from where it is seen.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page.section import section_svg
from fingerdesign.analysis.page.surfaces import LIFT, Surface, gage_quads, patch_of, surface_of
from fingerdesign.analysis.page.tables import FIGURES
from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError, PictureError
from fingerdesign.layout.gaps import solids_of
from fingerdesign.records.arrays import OPEN, SLIP, STICK
from fingerdesign.records.result import Result
from fingerdesign.report import figure as draw
from fingerdesign.report.figure import LOOKS, START, Figure, Triangles
from fingerdesign.report.style import ReportFigure
from fingerdesign.report.table import without_noise

# A core is drawn in front of the section that it lies in.
_FORWARD = np.array([0.0, 0.0, LIFT])
MOVED = "displacement (mm)"
UNMOVED_MM = 1e-6  # A smaller displacement gives no picture.
_SHARP_DEG = 25.0  # Facets of one smooth surface meet at less.
RUBBER = "#8fb4cf"
SEEN_THROUGH = {"body": 0.3, "core": LOOKS["finger"]["core"]["opacity"]}
CONTACT = 0.55  # Its opacity: the plates beneath are seen through its colours.
ROOM = 1.3  # Of the finger's size: the dimensions around it need room.
# The scene is 2 high; so much of it is filled from its middle, upward and to the side.
_UP, _ASIDE = 0.88, 1.5
_OFF = 0.07  # Of the finger's diagonal: between it and its dimensions.
_SHADES = 250  # A colour scale shows no more steps.
_LABEL = {"bgcolor": "--paper", "opacity": 0.85, "borderpad": 1}
VIEWS = {"a corner": START, "the front": (0.0, 0.0), "the side": (-90.0, 0.0)}
VIEWS |= {"above": (0.0, 90.0), "behind": (148.0, 24.0)}
_STATES = "stick and slip"
_STATUS = ((OPEN, "--open", "open"), (STICK, "--blue", "stick"), (SLIP, "--vermilion", "slip"))


@dataclass(frozen=True)
class Painted:
    """A trace whose colours follow the increments: values (k, n) of its points or triangles.

    half: how many of its triangles lie at z <= 0, None where all are always drawn.
    """

    trace: Figure
    values: Array
    half: int | None = None


def finger_figure(analysis: Analysis, increment: int | None = None) -> Figure:
    """The finger at an increment (None: :func:`partly_slipping`) with its controls, as Plotly has
    them.

    Raises PictureError where there is no mesh, or the displacements are not of its nodes.
    """
    if (mesh := analysis.mesh) is None:
        raise PictureError("there is no mesh to draw")
    body = surface_of(mesh, analysis.depth_mm)
    is_core = mesh.parts["core"]
    core = surface_of(mesh, analysis.depth_mm, is_core) if is_core.any() else None
    painted = [*_plates(analysis), *_contact(analysis)]
    low, high = body.points.min(axis=0), body.points.max(axis=0)
    shown = Triangles(body.points, body.whole)
    gages = analysis.gages and draw.fans(gage_quads(analysis.plates, analysis.gages)).drawn()
    figure = draw.finger_in_space(
        {
            "body": {**(shown.drawn() or {}), "color": RUBBER, "opacity": SEEN_THROUGH["body"]},
            "core": core and Triangles(core.points + _FORWARD, core.whole).drawn(),
            "gages": gages and {**gages, "color": "--purple"},
            "edges": shown.outline(_SHARP_DEG, mirrored=mesh.symmetric),
            "size": ROOM * (high - [low[0], 0.0, low[2]]),
        }
    )
    lines, words = _dimensions(body.points, analysis.result.parameters)
    moved = _moved(analysis, body)
    figure["data"] += [*(each.trace for each in painted), *moved.values(), *lines]
    scene = figure["layout"]["scene"]
    scene |= {"annotations": words, "aspectratio": dict.fromkeys("xyz", _near(high - low))}
    title = {"text": "", "x": 0.01, "y": 0.99, "yanchor": "top", "font": {"size": 13}}
    figure["layout"] |= {"template": LOOKS["template"], "title": title, "height": 480}
    figure["layout"] |= {"margin": {"l": 0, "r": 0, "t": 24, "b": 64}}
    surfaces = {"body": body} | ({} if core is None else {"core": core})
    _add_menus(figure, painted, surfaces)
    at = partly_slipping(analysis.result) if increment is None else increment
    _add_slider(figure, painted, list(moved), analysis.result, at)
    return figure


def partly_slipping(result: Result) -> int:
    """The increment whose stick ratio is nearest to a half: it shows stick and slip side by side.

    -1, the last, where no increment has contact.
    """
    ratios = [row.stick_ratio for row in result.increments]
    away = {k: abs(ratio - 0.5) for k, ratio in enumerate(ratios) if ratio is not None}
    return min(away, key=away.__getitem__, default=-1)


def _plates(analysis: Analysis) -> Iterator[Painted]:
    """The plates, as they are cast (holes left out), in the colours of what their gages read."""
    if not analysis.plates:
        return
    solids = solids_of(analysis.plates)
    drawn = draw.triangles_of(solids).drawn() or {}
    trace = {"name": "plates", **LOOKS["solid"], **LOOKS["finger"]["plates"], **drawn}
    rows = analysis.result.increments
    if not rows or len(rows[0].gages) != len(solids):
        yield Painted(trace, np.zeros((0, 0)))
        return
    readings = without_noise(np.array([[gage.reading for gage in row.gages] for row in rows]))
    most = draw.number(np.abs(readings).max()) or 1.0
    scale = [[0.0, "--blue"], [0.5, "--open"], [1.0, "--vermilion"]]
    bar = _bar("gages (microstrain)", 0.76)
    look = {"colorscale": scale, "cmin": -most, "cmax": most, "colorbar": bar}
    owner = np.arange(len(solids)).repeat([solid.num_tri() for solid in solids])
    yield Painted({**trace, **look, "intensitymode": "cell"}, readings[:, owner])


def _contact(analysis: Analysis) -> Iterator[Painted]:
    """Everything that is ever in contact, coloured by status, pressure, shear traction or slip."""
    contact = analysis.contact
    if contact is None or not (contact.status != OPEN).any():
        return
    patch = patch_of(contact, analysis.depth_mm)
    flat = {"ambient": 1.0, "diffuse": 0.0, "specular": 0.0}
    common = {**LOOKS["solid"], "lighting": flat, "visible": False, "opacity": CONTACT}
    points, triangles, owner = patch.apart()
    apart = draw.places(points) | draw.corners(triangles)
    steps = [k / len(_STATUS) for k in range(len(_STATUS) + 1)]
    scale = [[end, each[1]] for k, each in enumerate(_STATUS) for end in steps[k : k + 2]]
    ticks = {"tickvals": [each[0] for each in _STATUS], "ticktext": [each[2] for each in _STATUS]}
    look = {"colorscale": scale, "cmin": -0.5, "cmax": 2.5, "intensitymode": "cell"}
    bar = {"colorbar": _bar(_STATES, 0.24) | ticks}
    yield Painted(
        {"name": _STATES, **common, **apart, **look, **bar},
        contact.status[:, owner].astype(float),
        6 * patch.half,
    )
    drawn = draw.places(patch.points) | draw.corners(patch.triangles)
    sizes = [np.linalg.norm(each, axis=2) for each in (contact.tangential_traction, contact.slip)]
    shades = {
        "pressure (MPa)": contact.normal_traction,
        "shear traction (MPa)": sizes[0],
        "slip (mm)": sizes[1],
    }
    for name, values in shades.items():
        most = draw.number(values.max(initial=0.0)) or 1.0
        look = {"colorscale": "Cividis", "cmin": 0.0, "cmax": most}
        trace = {"name": name, **common, **drawn, **look, "colorbar": _bar(name, 0.24)}
        yield Painted(trace, without_noise(values)[:, patch.owner], patch.half)


def _bar(title: str, x: float) -> Figure:
    """A colour scale below the scene."""
    place = {"orientation": "h", "x": x, "y": -0.005, "yanchor": "top", "len": 0.42, "thickness": 9}
    words = {"text": title, "side": "bottom", "font": {"size": 12}}
    return {**place, "title": words, "nticks": 5, "outlinewidth": 0, "tickfont": {"size": 11}}


def _moved(analysis: Analysis, body: Surface) -> dict[int, Figure]:
    """The body at each increment whose displacements are stored, true to scale; {} without any.

    Raises PictureError where the displacements are not of the mesh's nodes.
    """
    mesh, fields = analysis.mesh, analysis.fields
    if mesh is None or fields is None or not len(fields.increments):
        return {}
    if fields.displacement.shape[1] != len(mesh.points):
        raise PictureError("the displacement field does not belong to the mesh")
    shapes = [body.moved(displacement) for displacement in fields.displacement]
    sizes = [np.linalg.norm(shape - body.points, axis=1) for shape in shapes]
    most = float(max(each.max() for each in sizes))
    if most < UNMOVED_MM:
        return {}
    look = {**LOOKS["solid"], **draw.corners(body.whole), "colorscale": "Cividis", "visible": False}
    look |= {"cmin": 0.0, "cmax": draw.number(most), "name": MOVED}
    found: dict[int, Figure] = {}
    for increment, shape, size in zip(fields.increments, shapes, sizes, strict=True):
        bar = {"showscale": False} if found else {"colorbar": _bar(MOVED, 0.24)}
        found[increment] = {**look, **draw.places(shape), **bar, "intensity": _shades(size, most)}
    return found


def _shades(values: Array, most: float) -> list[float]:
    """Numbers of a colour scale that ends at ``most``, no finer than it is drawn."""
    digits = int(np.ceil(np.log10(_SHADES / most))) if most > 0.0 else 0
    return list((np.round(values, max(digits, 0)) + 0.0).tolist())


def _dimensions(points: Array, keys: Mapping[str, Any]) -> tuple[list[Figure], Any]:
    """Lines of width, depth and height and a bar of scale; their words, and the radius."""
    (x0, y0, z0), (x1, y1, z1) = low, high = points.min(axis=0), points.max(axis=0)
    off = _OFF * float(np.linalg.norm(high - low))
    front, back = z1 + off, z1 + 2.2 * off
    length = max(each for each in (0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0) if each < 0.4 * (x1 - x0))
    named = (
        (f"width {x1 - x0:.4g} mm", [x0, y0, front], [x1, y0, front]),
        (f"depth {z1 - z0:.4g} mm", [x1 + off, y0, z0], [x1 + off, y0, z1]),
        (f"height {y1 - y0:.4g} mm", [x0 - off, y0, z1], [x0 - off, y1, z1]),
        (f"{length:g} mm", [x0, y0, back], [x0 + length, y0, back]),
    )
    ends = np.array([each[1:] for each in named], dtype=float)
    words = [
        {**_place(0.5 * (a + b)), "text": each[0], "showarrow": False, **_LABEL}
        for each, (a, b) in zip(named, ends, strict=True)
    ]
    words[-1]["yshift"] = -14
    if (radius := keys.get("body.arc_radius_mm")) and keys.get("body.shape") != "step":
        near = points[np.linalg.norm(points - [0.6 * x1, y1, z0], axis=1).argmin()]
        arrow = {"ax": 34, "ay": -26, "arrowcolor": "--muted", "arrowwidth": 1, "arrowhead": 0}
        words.append({**_place(near), "text": f"radius {radius:g} mm", **arrow, **_LABEL})
    lines = np.insert(ends, 2, np.nan, axis=1)
    plain = {**LOOKS["edges"], "line": {"color": "--muted", "width": 2}}
    scale = {**LOOKS["edges"], "line": {"color": "--ink", "width": 7}}
    return [
        {"name": "dimensions", **plain, **draw.places(lines[:3].reshape(-1, 3))},
        {"name": "scale", **scale, **draw.places(lines[3])},
    ], words


def _near(size: Array) -> float:
    """Size of the scene's cube: the finger and its dimensions fill the view of START."""
    (st, sp), (ct, cp) = np.sin(np.radians(START)), np.cos(np.radians(START))
    length = float(np.linalg.norm(size))
    half = 0.5 * size + length * np.array([_OFF, 0.0, 2.2 * _OFF])
    up, aside = half @ np.abs([sp * st, cp, sp * ct]), half @ np.abs([ct, 0.0, st])
    return round(ROOM * length * float(min(_UP / up, _ASIDE / aside)), 3)


def _place(point: Sequence[float] | Array) -> Figure:
    return dict(zip("xyz", draw.micrometres(point), strict=True))


def _add_menus(figure: Figure, painted: Sequence[Painted], surfaces: Mapping[str, Surface]) -> None:
    """Add the menus of colours, body and view."""
    data, layout = figure["data"], figure["layout"]
    place = {each["name"]: k for k, each in enumerate(data)}
    kinds = [k for k, each in enumerate(data) if "visible" in each]
    own = [place["body"], *kinds]
    names = list(dict.fromkeys(data[k]["name"] for k in kinds))
    colours = {  # The displaced body replaces the body.
        name: [{"visible": [name != MOVED, *(data[j]["name"] == name for j in kinds)]}, own]
        for name in names
    }
    views = {name: [{"scene.camera": draw.camera(*at)}] for name, at in VIEWS.items()}
    menus = {
        "Contact": ("restyle", colours),
        "Body": ("restyle", _bodies(painted, surfaces, place)),
        "Seen from": ("relayout", views),
    }
    layout["updatemenus"] = []
    for name, (method, choices) in menus.items():
        buttons = [{"label": k, "method": method, "args": v} for k, v in choices.items()]
        layout["updatemenus"] += [{"name": name, "buttons": buttons}] if buttons else []
    for k in kinds:
        data[k]["visible"] = data[k]["name"] == names[0]


def _slider_steps(
    data: list[Figure], coloured: Sequence[Painted], stored: Sequence[int], result: Result
) -> list[Figure]:
    """The changes of the traces at each increment: colours, and which displaced body is shown."""
    place = {each["name"]: k for k, each in enumerate(data)}
    moved = [k for k, each in enumerate(data) if each["name"] == MOVED]
    traces = [place[each.trace["name"]] for each in coloured]
    count = max((len(each.values) for each in coloured), default=0)
    steps: list[Figure] = []
    for k in range(count):
        shades = [_shades(each.values[k], each.trace["cmax"]) for each in coloured]
        shades += [data[each]["intensity"] for each in moved]
        dense = [1.0 if each.half is None else CONTACT for each in coloured]
        dense += [float(k == each) for each in stored]
        change = {"intensity": shades, "opacity": dense}
        words = {"title.text": _step_words(result, k, count)}
        given = [change, words, traces + moved]
        steps.append({"label": f"{k + 1}", "method": "update", "args": given})
    return steps


def _add_slider(
    figure: Figure,
    painted: Sequence[Painted],
    stored: Sequence[int],
    result: Result,
    increment: int,
) -> None:
    """Add the slider along the increments, and show one of them.

    stored: increments with a displaced body; at the others there is none to be seen.
    """
    data, layout = figure["data"], figure["layout"]
    steps = _slider_steps(data, [each for each in painted if len(each.values)], stored, result)
    if not steps:
        return
    shown = increment % len(steps)
    layout["sliders"] = [{"name": "Increment", "steps": steps, "active": shown}]
    now, title, own = steps[shown]["args"]
    layout["title"]["text"] = title["title.text"]
    for trace, shade, opacity in zip(own, now["intensity"], now["opacity"], strict=True):
        data[trace] |= {"intensity": shade, "opacity": opacity}


def _bodies(
    painted: Sequence[Painted], surfaces: Mapping[str, Surface], place: Mapping[str, int]
) -> dict[str, Any]:
    """The looks of the body: the triangles of everything that is cut, and its opacity."""
    cut = [each for each in painted if each.half is not None]
    traces = [*(place[name] for name in surfaces), *(place[each.trace["name"]] for each in cut)]

    def look(opacity: Sequence[float], half: bool) -> list[Any]:
        found = [draw.corners(each.half if half else each.whole) for each in surfaces.values()]
        found += [{k: each.trace[k][: each.half if half else None] for k in "ijk"} for each in cut]
        dense = [*opacity, *(CONTACT for _ in cut)]
        return [{"opacity": dense} | {k: [each[k] for each in found] for k in "ijk"}, traces]

    usual, dense = [SEEN_THROUGH[name] for name in surfaces], [1.0 for _ in surfaces]
    return {
        "see-through": look(usual, False),
        "solid": look(dense, False),
        "cut at z = 0": look(dense, True),
    }


def _step_words(result: Result, k: int, count: int) -> str:
    row = result.increments[k]
    normal, tangential = row.normal_force_N, row.tangential_force_N
    forces = f"F<sub>n</sub> {normal:.3g} N, F<sub>t</sub> {tangential:.3g} N"
    return f"Increment {k + 1} of {count}: {forces}"


def finger_report(analysis: Analysis) -> ReportFigure:
    """The figure for the page, with its words. PictureError as of :func:`finger_figure`."""
    figure, mesh = finger_figure(analysis), analysis.mesh
    assert mesh is not None
    solid = mesh.parts["plates"]
    count = len(set(mesh.regions[solid].tolist())) if solid.any() else len(analysis.plates)
    moved = [each for each in figure["data"] if each["name"] == MOVED]
    stored = analysis.fields.increments if analysis.fields is not None and moved else ()
    values = {"plates": count or "no", "most": moved[0]["cmax"] if moved else 0.0}
    values["stored"] = " and ".join(f"{each + 1}" for each in stored) or "none"
    still = still_picture(analysis.result)
    return draw.caption_chart(figure, FIGURES, "space", still=still, **values)


def still_picture(result: Result) -> str:
    """The section of the design as an <svg>; "" where the result does not hold its keys."""
    tables: dict[str, Any] = {}
    for key, value in result.parameters.items():
        *path, last = key.split(".")
        table = tables
        for name in path:
            table = table.setdefault(name, {})
        table[last] = value
    shaping = {"design", "body", "plates", "gages", "materials"} & tables.keys()
    try:
        design = Design.model_validate({name: tables[name] for name in shaping})
        return section_svg(design, f"Section of {result.design}")
    except (FingerDesignError, ValueError):
        return ""
