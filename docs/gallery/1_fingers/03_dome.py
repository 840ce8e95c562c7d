"""
A dome
======

A dome is curved along x and along z. It touches in a spot, so it may lean a little without
contact at an edge. Its plates end inside the rubber: ``span_mm`` is less than the depth.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("domed")
drawing = draw_sketch(design)

print(f"the crest is {design.body.base_height_mm:g} mm of straight sides and the dome above them")
