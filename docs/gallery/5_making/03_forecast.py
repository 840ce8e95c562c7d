"""
Forecast of a lift without a model
==================================

``fingerdesign check`` forecasts from formulas how hard and how deep a finger must be pressed.
This takes a millisecond, so a map over friction and mass is cheap.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign import with_values
from fingerdesign.analysis.forecast.lift import lifts
from fingerdesign.checks.load import load_design

frictions, masses = np.linspace(0.2, 1.0, 17), np.linspace(50.0, 1000.0, 20)
base = with_values(load_design("domed"), {"grip.defaults": "follow"})
depth = []
for mass in masses:
    keys = {
        "grip.object_mass_g": float(mass),
        "grip.friction_coefficients": [float(each) for each in frictions],
    }
    depth.append([1e3 * lift.approach_mm for lift in lifts(with_values(base, keys))])

figure, axes = pyplot.subplots(figsize=(6.6, 4.2), layout="constrained")
shown = axes.contourf(frictions, masses, depth, levels=14, cmap="viridis")
lines = axes.contour(frictions, masses, depth, levels=[100, 200, 400], colors="white")
axes.clabel(lines, fmt="%g µm")
figure.colorbar(shown, label="how deep it presses, µm")
axes.set_xlabel("friction coefficient")
axes.set_ylabel("mass of the object, g")
axes.set_title("Held with a margin of 1.5, by two domes")
pyplot.show()
