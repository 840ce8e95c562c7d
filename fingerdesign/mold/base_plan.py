"""Plan of the base plate from its back, as it lies on top while the finger is cast.

x is to the right and z up. The drawing is 640 wide, with an edge of 46 all round for the words.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.mold.tables import labels

if TYPE_CHECKING:
    from fingerdesign.mold.record import BaseData

WIDE, EDGE = 640.0, 46.0
LABEL = 11.0  # Half of a label's size: smaller holes have theirs next to them, outward.
FILLS = {
    "gate": "#c9302c",
    "riser": "#c77700",
    "vent": "#2f6fb0",
    "lock": "#7a7f87",
    "screw": "#3b4048",
    "wires": "#6b4fa0",
}
PLATE = 'fill="#e9ebee" stroke="#3b4048" stroke-width="1.5"'
FINGER = 'fill="#fdfdfc" stroke="#3b4048" stroke-dasharray="5 4"'
STYLE = "max-width: 40rem; width: 100%; height: auto; background: #fff"


def plan_words(base: BaseData) -> str:
    """The plan in words: each hole with its label and place."""
    holes = ", ".join(
        f"{label} {hole['kind']} at x {hole['x_mm']:.1f}, z {hole['z_mm']:.1f} mm"
        for label, hole in zip(labels(base["holes"]), base["holes"], strict=True)
    )
    return f"Plan of the base plate from its back: {holes}."


def plan_svg(base: BaseData) -> str:
    """The plan as an <svg>: the plate, the finger's bounds, and each hole with its label."""
    scale = (WIDE - 2.0 * EDGE) / (2.0 * base["half_x_mm"])
    high = 2.0 * base["half_z_mm"] * scale + 2.0 * EDGE
    middle = 0.5 * high
    drawn = [
        _rectangle(0.5 * WIDE, middle, scale * base["half_x_mm"], scale * base["half_z_mm"], PLATE),
        _rectangle(
            0.5 * WIDE,
            middle,
            scale * base["finger_half_x_mm"],
            scale * base["finger_half_z_mm"],
            FINGER,
        ),
    ]
    for label, hole in zip(labels(base["holes"]), base["holes"], strict=True):
        x, y = 0.5 * WIDE + scale * hole["x_mm"], middle - scale * hole["z_mm"]
        inner, outer = hole["diameter_mm"], hole["outer_diameter_mm"]
        radius = 0.5 * scale * max(inner, outer)
        fill = f'fill="{FILLS[hole["kind"]]}" fill-opacity="0.35"'
        if hole["kind"] == "wires" and outer > inner:  # a channel leads from it to the front
            top = middle - scale * base["half_z_mm"]
            drawn.append(_rectangle(x, 0.5 * (y + top), 0.5 * scale * inner, 0.5 * (y - top), fill))
        drawn.append(
            f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{radius:.1f}" {fill} stroke="#1c1d1f"/>'
        )
        outward = 1.0 if hole["x_mm"] > 0 else -1.0
        away = 0.0 if radius > LABEL else outward * (radius + LABEL)
        drawn.append(_text(x + away, y + 4.0, label, 700))
    drawn += [
        _text(0.5 * WIDE, 0.5 * EDGE, "front (+z)"),
        _text(0.5 * WIDE, high - 0.35 * EDGE, "back (-z)"),
        _text(0.45 * EDGE, middle, "-x"),
        _text(WIDE - 0.45 * EDGE, middle, "+x"),
    ]
    head = f'<svg viewBox="0 0 {WIDE:.0f} {high:.0f}" role="img" aria-label="{plan_words(base)}"'
    return "\n".join([f'{head} style="{STYLE}">', *drawn, "</svg>"])


def _rectangle(x: float, y: float, half_x: float, half_y: float, look: str) -> str:
    """A rectangle around its middle."""
    place = f'x="{x - half_x:.1f}" y="{y - half_y:.1f}"'
    return f'<rect {place} width="{2 * half_x:.1f}" height="{2 * half_y:.1f}" {look}/>'


def _text(x: float, y: float, words: str, weight: int = 400) -> str:
    """Words around a place."""
    font = f'font-size="13" font-family="sans-serif" font-weight="{weight}" fill="#1c1d1f"'
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="middle" {font}>{words}</text>'
