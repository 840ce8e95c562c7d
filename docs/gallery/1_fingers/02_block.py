"""
A block with a flat top
=======================

The whole top of a flat pad touches at once, so the pad is stiff and pressure has peaks at its
edges. Rounded edges (``edge_radius_mm``) remove the peaks. A stiff backing, a *core* at the
base, supports the pad.
"""

from fingerdesign import parse_design
from fingerdesign.analysis.page.sketch import draw_sketch

design = parse_design("""
[design]
name = "pad"

[body]
shape = "block"
width_mm = 16.0
depth_mm = 10.0
edge_radius_mm = 2.0
core = { width_mm = 16.0, height_mm = 2.0, material = "aluminium" }

[plates]
count = 7
cover_mm = 1.4
""")
drawing = draw_sketch(design)
