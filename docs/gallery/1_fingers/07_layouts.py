"""
Four layouts of a row: level, turned, bent, placed one by one
=============================================================

The same seven plates under the same arc. *Level* plates have one angle to the base. *Turned*
plates have one angle to the surface above them. *Bent* plates also bend with the surface.
Centres and angles may also be given plate by plate.
"""

from fingerdesign import parse_design
from fingerdesign.analysis.page.sketch import draw_sketch

SEVEN = "count = 7, pitch_mm = 1.9"
ROW = "length_mm = 1.6, cover_mm = 1.2"
PLACES = "[[-4, 12, 30], [-2, 14, 0], [0, 13, 90], [3, 13, -45]]"
LAYOUTS = {
    "level": f"plates = {{ {SEVEN}, angle_deg = 20.0, {ROW} }}",
    "turned": f'plates = {{ {SEVEN}, angle_deg = 20.0, follow = "turned", {ROW} }}',
    "bent": f'plates = {{ {SEVEN}, angle_deg = 0.0, follow = "bent", {ROW} }}',
    "placed": f"plates = {{ placement = {PLACES}, {ROW} }}",
}
drawings = [
    draw_sketch(parse_design(f'design.name = "{name}"\nbody.arc_radius_mm = 12.0\n{text}'))
    for name, text in LAYOUTS.items()
]
