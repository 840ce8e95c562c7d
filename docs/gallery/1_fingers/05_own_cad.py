"""
A body of your own CAD
======================

A CadQuery function becomes a finger. The program finds base and contact surface by direction
and height. A design file does the same with a STEP file (``body.shape = "step"``).
"""

import cadquery

from fingerdesign import parse_design, with_body
from fingerdesign.analysis.page.sketch import draw_sketch


def fingertip() -> cadquery.Workplane:
    """12 mm wide, 9 mm high, 8 mm deep, its upper edges rounded."""
    return cadquery.Workplane("XZ").rect(12.0, 9.0).extrude(-8.0).faces(">Y").edges().fillet(2.5)


rows = "count = 5, pitch_mm = 1.0, length_mm = 1.0, span_mm = 3.0, cover_mm = 1.5"
plain = parse_design(f'design.name = "tip"\nplates = {{ {rows} }}\ngages.length_mm = 0.6')
design = with_body(plain, fingertip, contact_above_mm=5.0)
drawing = draw_sketch(design)

print(f"found in the CAD: {design.body.width_mm:g} mm wide, {design.body.depth_mm:g} mm deep")
