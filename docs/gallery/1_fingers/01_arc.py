"""
An arc with one row of plates
=============================

The finger of the paper that began it all (Maeno, Hiromitsu, Kawai 2000): a section of rubber below
an arc, drawn straight along z, with fifteen bronze plates at 45 degrees just under the surface. The
drawing is the one that ``fingerdesign view maeno2000`` makes; nothing has been meshed for it.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("maeno2000")  # a shipped name, or a file of yours
drawing = draw_sketch(design)

print("assumed, as the paper does not say it:", ", ".join(design.assumed[:4]), "...")
