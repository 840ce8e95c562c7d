"""
An arc with one row of plates
=============================

The finger of the paper (Maeno, Hiromitsu, Kawai 2000): a rubber section below an arc, straight
along z. Fifteen bronze plates at 45 degrees lie just below the surface. ``fingerdesign view
maeno2000`` makes the same drawing. Nothing is meshed.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("maeno2000")  # a shipped name, or a file of yours
drawing = draw_sketch(design)

print("assumed, as the paper does not say it:", ", ".join(design.assumed[:4]), "...")
