"""
Friction: one model, many objects
=================================

The finger is condensed once. Every object and friction coefficient then takes milliseconds.
Here one press is sheared at six friction coefficients. All curves begin alike, because
everything sticks, and each approaches its own limit.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.sensing.model import grip_problem

problem = grip_problem(load_design("sensitive"))  # plane strain, for grips
shears = np.linspace(0.0, 0.12, 49)
path = [Motion(0.1, float(shear)) for shear in shears]

figure, (forces, sticks) = pyplot.subplots(1, 2, figsize=(9.0, 3.6), layout="constrained")
colours = pyplot.colormaps["viridis"](np.linspace(0.05, 0.85, 6))
for friction, colour in zip((0.2, 0.3, 0.4, 0.5, 0.6, 0.8), colours, strict=True):
    found = [step.measures for step in follow(problem.with_friction(friction), path)]
    label = f"friction {friction:g}"
    forces.plot(1e3 * shears, [each.tangential_force for each in found], color=colour, label=label)
    sticks.plot(1e3 * shears, [each.stick_ratio for each in found], color=colour)
forces.set_ylabel("tangential force, N")
sticks.set_ylabel("stick ratio")
for axes in (forces, sticks):
    axes.set_xlabel("shear, µm")
figure.legend(loc="outside right upper")
pyplot.show()
