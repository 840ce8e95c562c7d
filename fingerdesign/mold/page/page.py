"""A mold's report.html: verdict, picture, casting notes to tick, tables; offline and printable."""

from __future__ import annotations

import math
from html import escape
from pathlib import Path
from typing import Any

from markupsafe import Markup

from fingerdesign.mold.page.picture import Exploded
from fingerdesign.mold.page.tables import (
    DASH,
    as_words,
    bill_table,
    effects_table,
    fixture_table,
    hardware_text,
    limits_table,
    parts_table,
    patterns_table,
    plates_table,
)
from fingerdesign.mold.products.warnings import (
    DOUBTFUL_SHARE,
    placement_remedy,
    placement_worst,
)
from fingerdesign.report.page import rendered
from fingerdesign.report.table import Table

# The base plate as its caster sees it: a labelled plan of its holes, as SVG, and a table.
#
# Seen from the back, as it lies on top while the finger is cast: x to the right, z up.

TEMPLATES = Path(__file__).parent / "templates"

KINDS = {
    "gate": ("G", "gate: pour in here"),
    "riser": ("R", "riser"),
    "vent": ("V", "vent"),
    "lock": ("L", "lock: rubber rises in it and holds"),
    "screw": ("S", "screw of the core"),
}
_FILLS = {"gate": "#c9302c", "riser": "#c77700", "vent": "#2f6fb0", "lock": "#7a7f87"}
_WIDE = 640.0  # of the picture, its own units
_EDGE = 46.0
_ROOM = 11.0  # half of a label: smaller holes have theirs beside them, outward


def labels(holes: list[dict[str, Any]]) -> list[str]:
    """A label a hole: its kind's letter, and a number where there are more of them.

    >>> labels([{"kind": "gate"}, {"kind": "vent"}, {"kind": "vent"}])
    ['G', 'V1', 'V2']
    """
    kinds = [hole["kind"] for hole in holes]
    reported, seen = [], dict.fromkeys(kinds, 0)
    for kind in kinds:
        seen[kind] += 1
        number = str(seen[kind]) if kinds.count(kind) > 1 else ""
        reported.append(f"{KINDS[kind][0]}{number}")
    return reported


def holes_table(base: dict[str, Any] | None) -> Table | None:
    """The holes of the base plate; None without any."""
    if base is None or not base["holes"]:
        return None
    rows = tuple(
        (
            label,
            KINDS[hole["kind"]][1],
            f"{hole['x_mm']:.2f}",
            f"{hole['z_mm']:.2f}",
            f"{hole['diameter_mm']:.2f}",
            f"{hole['outer_diameter_mm']:.2f}",
        )
        for label, hole in zip(labels(base["holes"]), base["holes"], strict=True)
    )
    columns = ("", "hole", "x (mm)", "z (mm)", "diameter inside (mm)", "at the back (mm)")
    return Table("base-holes", "Holes of the base plate", columns, rows, frozenset({0, 1}))


def base_svg(base: dict[str, Any] | None) -> str:
    """The plan as an <svg>; "" without holes."""
    if base is None or not base["holes"]:
        return ""
    half_x, half_z = base["half_x_mm"], base["half_z_mm"]
    scale = (_WIDE - 2.0 * _EDGE) / (2.0 * half_x)
    high = 2.0 * half_z * scale + 2.0 * _EDGE

    def at(x: float, z: float) -> tuple[float, float]:
        return 0.5 * _WIDE + scale * x, 0.5 * high - scale * z

    def frame(wide: float, deep: float, style: str) -> str:
        left, top = at(-wide, deep)
        size = f'width="{2.0 * scale * wide:.1f}" height="{2.0 * scale * deep:.1f}"'
        return f'<rect x="{left:.1f}" y="{top:.1f}" {size} {style}/>'

    drawn = [
        frame(half_x, half_z, 'fill="#e9ebee" stroke="#3b4048" stroke-width="1.5"'),
        frame(
            base["finger_half_x_mm"],
            base["finger_half_z_mm"],
            'fill="#fdfdfc" stroke="#3b4048" stroke-dasharray="5 4"',
        ),
    ]
    for label, hole in zip(labels(base["holes"]), base["holes"], strict=True):
        x, y = at(hole["x_mm"], hole["z_mm"])
        radius = 0.5 * scale * max(hole["diameter_mm"], hole["outer_diameter_mm"])
        fill = _FILLS.get(hole["kind"], "#3b4048")
        drawn.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" fill="{fill}" '
            'fill-opacity="0.35" stroke="#1c1d1f"/>'
        )
        beside = 0.0 if radius > _ROOM else (radius + _ROOM) * (1.0 if hole["x_mm"] > 0.0 else -1.0)
        drawn.append(_text(x + beside, y + 4.0, label, "700"))
    drawn += [
        _text(0.5 * _WIDE, 0.5 * _EDGE, "front (+z)"),
        _text(0.5 * _WIDE, high - 0.35 * _EDGE, "back (-z)"),
        _text(0.45 * _EDGE, 0.5 * high, "-x"),
        _text(_WIDE - 0.45 * _EDGE, 0.5 * high, "+x"),
    ]
    reported = ", ".join(
        f"{label} {hole['kind']} at x {hole['x_mm']:.1f}, z {hole['z_mm']:.1f} mm"
        for label, hole in zip(labels(base["holes"]), base["holes"], strict=True)
    )
    name = escape(f"Plan of the base plate from its back: {reported}.", quote=True)
    body = "".join(drawn)
    return (
        f'<svg viewBox="0 0 {_WIDE:g} {high:.0f}" role="img" aria-label="{name}" '
        f'style="max-width: 40rem; width: 100%; height: auto; background: #fff">{body}</svg>'
    )


def _text(x: float, y: float, text: str, weight: str = "400") -> str:
    font = f'font-size="13" font-family="sans-serif" font-weight="{weight}" fill="#1c1d1f"'
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle" {font}>{escape(text)}</text>'


# A mold's checks as tables: every one, or a row a kind with the one that is nearest its bound.

HEADS = ("check", "part", "measured", "bound", "unit", "what was found")


def checks_table(checks: list[dict[str, Any]], key: str, caption: str) -> Table | None:
    """Checks, a row each; None where there are none."""
    if not checks:
        return None
    rows = tuple((check["name"], *_check_cells(check)) for check in checks)
    return Table(f"checks-{key}", f"{caption}: {len(rows)}", HEADS, rows, frozenset({0, 1, 4, 5}))


def kinds_table(checks: list[dict[str, Any]]) -> Table | None:
    """What was checked, a row a kind: how often, how many failed, and the one nearest its bound."""
    kinds: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        kinds.setdefault(check["name"], []).append(check)
    rows = []
    for name, alike in kinds.items():
        failed = [check for check in alike if not check["ok"]]
        nearest = min(failed or alike, key=_room)
        count = (str(len(alike)), str(len(failed) or DASH))
        rows.append((name, *count, *_check_cells(nearest)))
    if not rows:
        return None
    columns = ("check", "checked", "failed", "nearest its bound", *HEADS[2:])
    caption = "What was checked; of each kind the one that is nearest its bound"
    return Table("checks-kinds", caption, columns, tuple(rows), frozenset({0, 3, 6, 7}))


def _check_cells(check: dict[str, Any]) -> tuple[str, ...]:
    return (
        as_words(check["part"]) or "mold",
        _measure(check["measured"]),
        _measure(check["bound"]),
        check["unit"] or DASH,
        check["sentence"],
    )


def _room(check: dict[str, Any]) -> float:
    """How far a measure is from its bound, relative to the larger; 0: at it, or not reported."""
    measured, bound = check["measured"], check["bound"]
    if measured is None or bound is None:
        return 0.0
    most = max(abs(measured), abs(bound))
    return float(abs(measured - bound) / most) if most > 0.0 else 0.0


def _measure(value: float | None) -> str:
    """A measured value in four digits; a dash where there is none.

    >>> _measure(0.123456), _measure(None), _measure(0.0), _measure(15.0)
    ('0.1235', '–', '0', '15')
    """
    if value is None or not math.isfinite(value):
        return DASH
    return "0" if abs(value) < 1e-12 else f"{value:.4g}"


PROCESSES = {"sla": "resin prints", "fdm": "filament prints", "machined": "machined parts"}


def mold_html(data: dict[str, Any], picture: Exploded | None, missing: str = "") -> str:
    """The page, from what mold_report.json holds; ``missing`` says why there is no picture."""
    failing = [check for check in data["checks"] if not check["ok"]]
    return rendered(
        TEMPLATES / "mold.html.j2",
        data=data,
        words=as_words,
        verdict=_verdict(data, failing),
        failing=failing,
        picture=picture,
        missing=missing,
        process=PROCESSES[data["process"]["name"]],
        parts=parts_table(data),
        holes=holes_table(data["base"]),
        base_plan=Markup(base_svg(data["base"])),
        hardware=hardware_text(data),
        kinds=kinds_table(data["checks"]),
        failed=checks_table(failing, "failed", "Failed"),
        passed=checks_table([c for c in data["checks"] if c["ok"]], "passed", "Passed"),
        plates=plates_table(data),
        patterns=patterns_table(data),
        fixture=fixture_table(data),
        effects=effects_table(data["placement"]),
        bill=bill_table(data),
        limits=limits_table(data),
    )


def _verdict(data: dict[str, Any], failing: list[dict[str, Any]]) -> dict[str, str]:
    count = len(data["checks"])
    worst = placement_worst(data["placement"])
    if data["failure"] is None and worst > DOUBTFUL_SHARE:
        remedy = placement_remedy(side["holding"] for side in data["fixture"])
        return {
            "kind": "partly",
            "answer": "can be cast, gages in doubt",
            "text": f"All {count} checks passed. But plates off their places by what holds them "
            f"change a reading by up to {100 * worst:.0f} % of the largest: to know what gages "
            f"read before you cast, {remedy}; else calibrate each finger.",
        }
    if data["failure"] is None:
        return {
            "kind": "yes",
            "answer": "ready to cast",
            "text": f"All {count} checks passed. {len(data['parts'])} parts.",
        }
    if not data["parts"]:
        return {"kind": "no", "answer": "not made", "text": data["failure"]}
    return {
        "kind": "no",
        "answer": "not ready",
        "text": f"{len(failing)} of {count} checks failed: see below before anything is printed.",
    }
