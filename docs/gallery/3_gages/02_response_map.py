"""
Response of the gages to shear
==============================

The change of each reading per newton of tangential force, while the finger is pressed and
sheared to complete slip. Gages below the stick area respond most. The line shows the length
that sticks.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design
from fingerdesign.pipeline import run

design = load_design("maeno2000")
found = run(Case(design, fidelity="plane-strain", grips=False))  # the fundamental case
study = found.slip_studies[2]

figure, axes = pyplot.subplots(figsize=(7.6, 4.2), layout="constrained")
step = np.arange(1, len(study.stick_ratio) + 1)
shown = axes.pcolormesh(
    study.gage_x_mm, step, study.response, cmap="magma", shading="nearest", vmin=0.0
)
figure.colorbar(shown, label="response, microstrain per N")
for side in (-0.5, 0.5):
    axes.plot(side * study.stick_length_mm, step, color="#7fd4ff", lw=1.6)
axes.set_xlabel("place of the gage, mm")
axes.set_ylabel("step")
axes.grid(False)
axes.set_title(f"Friction {study.friction_coefficient:g}; blue: as long as what sticks")
pyplot.show()
