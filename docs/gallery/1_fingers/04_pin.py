"""
A pin, turned about its axis
============================

A ``revolved`` body is a pin with a spherical end. Its width is its diameter. The plates are as
long along z as the circle allows.
"""

from fingerdesign.analysis.page.sketch import draw_sketch
from fingerdesign.checks.load import load_design

design = load_design("pin")
drawing = draw_sketch(design)
