"""
A tug at a lifted object
========================

Two fingers lift an object from its support, and then something pulls at it. The controller
holds the ratio of its forces, so it closes as the load rises. The chart shows how much sticks
meanwhile.
"""

from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.episode import run_episode
from fingerdesign.control.plants.lift import Disturbance, LiftPlant
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.roster import make_controller
from fingerdesign.sensing.model import grip_problem

FRICTION, MASS = 0.4, 300.0
design = load_design("sensitive")
problem, face, bounds = grip_problem(design), design.gages.face, Bounds.of(design.grip)
known = calibrate(lambda: CondensedPlant(problem, face), problem.model.gage_x, bounds)
tug = Disturbance(40, 0.9, 30)  # 40 steps after the lift, 0.9 N, for 30 steps
plant = LiftPlant(problem.with_friction(FRICTION), face, MASS, disturbances=[tug])
hand = make_controller("fixed_ratio", design.grip)
trace = run_episode(plant, hand, known, bounds, FRICTION, MASS, after_lift=110).trace

figure, (forces, stick) = pyplot.subplots(
    2, 1, figsize=(7.6, 4.8), sharex=True, height_ratios=(2.0, 1.0), layout="constrained"
)
forces.plot(trace.normal_force, color="#0b6fb0", label="normal force")
forces.plot(trace.tangential_force, color="#d2560a", label="tangential force")
forces.plot(trace.limit, color="#1c1d1f", ls=":", label="what friction carries")
stick.plot(trace.stick_ratio, color="#0a8f6b")
for axes in (forces, stick):
    axes.axvspan(trace.lift_step + 40, trace.lift_step + 70, color="#e6e8eb", lw=0.0)
    axes.axvline(trace.lift_step, color="#6c6f73", lw=0.8)
forces.set_ylabel("a finger, N")
forces.legend(loc="upper left")
stick.set_ylim(0.0, 1.0)
stick.set_ylabel("stick ratio")
stick.set_xlabel("control step (line: lifted; grey: the tug)")
pyplot.show()
