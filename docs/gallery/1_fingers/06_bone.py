"""
A bone inside, plates bent along the surface
============================================

A stiff core takes the place of a finger's bone. These plates follow the surface (``follow =
"bent"``), lie in a zigzag (``stagger_mm``), and have holes in which the rubber interlocks.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("boned")
drawing = draw_sketch(design)

plates = design.plates
print(f"holes of {plates.hole_diameter_mm:g} mm, one every {plates.hole_pitch_mm:g} mm")
