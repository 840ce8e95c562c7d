"""The base plate as its caster sees it: a labelled plan of its holes, as SVG, and a table.

Seen from the back, as it lies on top while the finger is cast: x to the right, z up.
"""

from __future__ import annotations

from html import escape
from typing import Any

from fingerdesign.report.tables import Table

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
    told, seen = [], dict.fromkeys(kinds, 0)
    for kind in kinds:
        seen[kind] += 1
        number = str(seen[kind]) if kinds.count(kind) > 1 else ""
        told.append(f"{KINDS[kind][0]}{number}")
    return told


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
    told = ", ".join(
        f"{label} {hole['kind']} at x {hole['x_mm']:.1f}, z {hole['z_mm']:.1f} mm"
        for label, hole in zip(labels(base["holes"]), base["holes"], strict=True)
    )
    name = escape(f"Plan of the base plate from its back: {told}.", quote=True)
    body = "".join(drawn)
    return (
        f'<svg viewBox="0 0 {_WIDE:g} {high:.0f}" role="img" aria-label="{name}" '
        f'style="max-width: 40rem; width: 100%; height: auto; background: #fff">{body}</svg>'
    )


def _text(x: float, y: float, text: str, weight: str = "400") -> str:
    font = f'font-size="13" font-family="sans-serif" font-weight="{weight}" fill="#1c1d1f"'
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle" {font}>{escape(text)}</text>'
