"""
A core inside, plates bent along the surface
============================================

A stiff core replaces the bone of a finger. The plates follow the surface (``follow = "bent"``)
and lie in a zigzag (``stagger_mm``). The rubber interlocks with their holes.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("boned")
drawing = draw_sketch(design)

plates = design.plates
print(f"holes of {plates.hole_diameter_mm:g} mm, one every {plates.hole_pitch_mm:g} mm")
