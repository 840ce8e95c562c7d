"""
One lift by the paper's rule
============================

The hand closes and pulls at once, without knowing friction or weight. When the gage area falls,
it stops pulling until more normal force has raised the area again. A good lift reaches the
weight line and stays away from the line of complete slip.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.episode import run_episode
from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.roster import make_controller
from fingerdesign.sensing.model import grip_problem

FRICTION, MASS = 0.3, 500.0
design = load_design("sensitive")
problem, face, bounds = grip_problem(design), design.gages.face, Bounds.of(design.grip)
known = calibrate(lambda: CondensedPlant(problem, face), problem.model.gage_x, bounds)
plant = LiftPlant.of(design.grip, problem, face, FRICTION, MASS)
hand = make_controller("paper", design.grip)
trace = run_episode(plant, hand, known, bounds, FRICTION, MASS).trace

figure, axes = pyplot.subplots(figsize=(7.2, 4.2), layout="constrained")
force = np.array([0.0, 1.15 * trace.normal_force.max()])
axes.plot(force, FRICTION * force, color="#1c1d1f", ls=":", label="all of it slips")
axes.fill_between(force, FRICTION * force, FRICTION * force[1], color="#e6e8eb", lw=0.0)
axes.axhline(trace.weight_per_finger_N, color="#6c6f73", lw=0.9, label="half the weight")
axes.plot(trace.normal_force, trace.tangential_force, color="#0b6fb0", label="the lift")
held = trace.hold
axes.plot(trace.normal_force[held], trace.tangential_force[held], "o", color="#d2560a", ms=3)
axes.plot([], [], "o", color="#d2560a", ms=3, label="the rule holds")
axes.set_xlim(force)
axes.set_ylim(0.0, 1.25 * trace.weight_per_finger_N)
axes.set_xlabel("normal force of a finger, N")
axes.set_ylabel("tangential force, N")
axes.set_title(f"{MASS:.0f} g at a friction of {FRICTION:g}")
axes.legend(loc="lower right")
pyplot.show()
