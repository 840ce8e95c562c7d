"""
What a rig learns on the bench
==============================

Before it grips, a rig presses its finger without shear, shears it a little at some depths, and
slides. It stores the readings for each normal force, which are subtracted in a grip, and the
stiffness of the finger.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.sensing.model import grip_problem

design = load_design("sensitive")
problem, face, bounds = grip_problem(design), design.gages.face, Bounds.of(design.grip)
known = calibrate(lambda: CondensedPlant(problem, face), problem.model.gage_x, bounds)

figure, (left, right) = pyplot.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
colours = pyplot.colormaps["coolwarm"](np.linspace(0.0, 1.0, len(known.gage_x)))
for gage, colour in enumerate(colours):
    left.plot(known.normal.normal_force, known.normal.readings[:, gage], color=colour, lw=1.2)
left.set_xlabel("normal force, N")
left.set_ylabel("reading, microstrain")
left.set_title("pressed without shear")
right.bar(known.gage_x, known.full_stick, width=0.55, color=colours)
right.set_xlabel("place of the gage, mm")
right.set_ylabel("microstrain per N of shear")
right.set_title("sheared a little, all sticks")
pyplot.show()
