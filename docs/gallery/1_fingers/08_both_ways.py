"""
Rows along x and along z
========================

Plates of a row along x feel shear along x. A second row, whose plates span the other way, feels
shear along z, so that the finger knows in which direction it is pulled.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("both_ways")
drawing = draw_sketch(design)
