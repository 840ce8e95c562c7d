"""
Rows along x and along z
========================

Plates of a row along x measure shear along x. A second row, whose plates span the other
direction, measures shear along z. So the direction of the shear is known.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("both_ways")
drawing = draw_sketch(design)
