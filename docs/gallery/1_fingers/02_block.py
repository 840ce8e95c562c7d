"""
A block with a flat top
=======================

A flat pad touches with all of its top at once, so it is stiff, and pressure peaks at its edges.
Rounding them (``edge_radius_mm``) takes the peaks away. A stiff backing, a *core* that stands on
the base, carries it.
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
