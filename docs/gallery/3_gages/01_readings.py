"""
Gage readings along a path
==========================

The readings of fifteen gages while the finger is pressed by 0.1 mm and then sheared. The press
strains all gages. Shear raises some readings and lowers others. The curves bend where the
contact above them begins to slip.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.control.signals import gage_readings
from fingerdesign.sensing.model import grip_problem

design = load_design("sensitive")
problem = grip_problem(design).with_friction(0.5)
pressed = [Motion(float(approach), 0.0) for approach in np.linspace(0.005, 0.1, 20)]
sheared = [Motion(0.1, float(shear)) for shear in np.linspace(0.005, 0.15, 30)]
steps = list(follow(problem, pressed + sheared))
readings = np.array([gage_readings(step.measures.gages, design.gages.face) for step in steps])

figure, axes = pyplot.subplots(figsize=(8.0, 4.2), layout="constrained")
colours = pyplot.colormaps["coolwarm"](np.linspace(0.0, 1.0, readings.shape[1]))
for gage, colour in enumerate(colours):
    axes.plot(np.arange(1, len(steps) + 1), readings[:, gage], color=colour, lw=1.3)
    axes.text(len(steps) + 0.6, readings[-1, gage], f"{gage}", color=colour, fontsize=7)
axes.axvline(len(pressed), color="#6c6f73", ls=":", lw=1.0)
axes.text(len(pressed) - 0.5, readings.max(), "pressed", ha="right", va="top")
axes.text(len(pressed) + 0.5, readings.max(), "sheared", va="top")
axes.set_xlabel("step of 5 µm")
axes.set_ylabel("reading, microstrain")
axes.set_title("Blue: gages on the left; red: on the right")
pyplot.show()
