"""
Which angle should plates have?
===============================

The same finger with plates at six angles, pressed and sheared a little. Level and upright
plates respond with opposite signs at the two ends of the row and hardly in the middle. From 30
degrees on all plates respond with one sign.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign import analyse, parse_scene, with_values
from fingerdesign.checks.load import load_design

base = with_values(load_design("sensitive"), {"plates.cover_mm": 0.9})
scene = parse_scene("""
object.friction_coefficient = 0.8
path.increments_mm = [[0.1, 0.0], [0.1, 0.02]]
""")

figure, axes = pyplot.subplots(figsize=(7.2, 4.0), layout="constrained")
angles = (0.0, 15.0, 30.0, 45.0, 60.0, 90.0)
colours = pyplot.colormaps["viridis"](np.linspace(0.0, 0.9, len(angles)))
for angle, colour in zip(angles, colours, strict=True):
    design = with_values(base, {"plates.angle_deg": angle, "plates.pitch_mm": 1.0})
    pressed, sheared = analyse(design, scene, "plane-strain").increments
    force = sheared.tangential_force_N - pressed.tangential_force_N
    pairs = zip(pressed.gages, sheared.gages, strict=True)
    answers = [(after.membrane - before.membrane) / force for before, after in pairs]
    place = np.arange(len(answers)) - 0.5 * (len(answers) - 1)
    axes.plot(place, answers, "o-", color=colour, ms=3.5, label=f"{angle:g}°")
axes.axhline(0.0, color="#6c6f73", lw=0.8)
axes.set_xlabel("place of the plate, mm")
axes.set_ylabel("membrane strain per N of shear, microstrain")
axes.legend(title="angle", loc="upper left", bbox_to_anchor=(1.0, 1.0))
pyplot.show()
