"""
Four controllers, one object
============================

The ``paper`` controller uses the gage area. *Reactive* grips harder when it detects slip.
*Fixed ratio* pulls in proportion to the normal force. Only the *oracle* knows friction and
weight. All lift 300 g at a friction coefficient of 0.5.
"""

from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.episode import run_episode
from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.roster import make_controller
from fingerdesign.sensing.model import grip_problem

FRICTION, MASS = 0.5, 300.0
design = load_design("sensitive")
problem, face, bounds = grip_problem(design), design.gages.face, Bounds.of(design.grip)
known = calibrate(lambda: CondensedPlant(problem, face), problem.model.gage_x, bounds)

figure, axes = pyplot.subplots(figsize=(7.2, 4.2), layout="constrained")
axes.plot([0.0, 8.0], [0.0, 8.0 * FRICTION], color="#1c1d1f", ls=":", label="all of it slips")
looks = {
    "paper": "#0b6fb0",
    "reactive": "#d2560a",
    "fixed_ratio": "#0a8f6b",
    "oracle_1.2": "#b0569a",
}
for name, colour in looks.items():
    hand = make_controller(name, design.grip, friction=FRICTION, mass_g=MASS)
    plant = LiftPlant.of(design.grip, problem, face, FRICTION, MASS)
    episode = run_episode(plant, hand, known, bounds, FRICTION, MASS)
    trace, margin = episode.trace, episode.result.safety_margin
    ends = "slips" if margin is None else f"lifts, margin {margin:.2f}"
    label = f"{name.replace('_', ' ')}: {ends}"
    axes.plot(trace.normal_force, trace.tangential_force, color=colour, label=label)
    axes.plot(trace.normal_force[-1], trace.tangential_force[-1], "o", color=colour)
axes.axhline(trace.weight_per_finger_N, color="#6c6f73", lw=0.9)
axes.set_xlim(0.0, 7.0)
axes.set_ylim(0.0, 1.9)
axes.set_xlabel("normal force of a finger, N")
axes.set_ylabel("tangential force, N")
axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
pyplot.show()
