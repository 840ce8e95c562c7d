"""
The stick area shrinks
======================

The finger is pressed, then sheared in steps until it slips completely. Each row of the picture
is one step. Slip begins at the edges and moves inward. The gages must detect this before the
last spot slips.
"""

import numpy as np
from matplotlib import pyplot
from matplotlib.colors import ListedColormap

from fingerdesign import parse_scene
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design
from fingerdesign.pipeline import run

shears = np.linspace(0.0, 0.18, 61)
rows = [[0.1, float(shear)] for shear in shears]
scene = parse_scene(f"object.friction_coefficient = 0.5\npath.increments_mm = {rows}")
contact = run(Case(load_design("maeno2000"), scene, "plane-strain")).contact

order = contact.mid_line()
figure, axes = pyplot.subplots(figsize=(7.2, 4.0), layout="constrained")
colours = ListedColormap(["#fefefd", "#0b6fb0", "#f0a36b"])  # open, stick, slip
x, status = contact.points[order, 0], contact.status[:, order]
axes.pcolormesh(x, 1e3 * shears, status, cmap=colours, vmin=0, vmax=2, shading="nearest")
axes.set_xlim(-2.6, 2.6)
axes.set_xlabel("x along the contact, mm")
axes.set_ylabel("shear of the object, µm")
axes.grid(False)
axes.text(0.0, 40, "sticks", color="white", ha="center", weight="bold")
axes.text(0.0, 165, "slips", color="#5f2a05", ha="center", weight="bold")
axes.set_title("Pressed by 0.1 mm, then sheared")
pyplot.show()
