"""
Gages that are noisy, drift, warm up and fail
=============================================

Imperfect hardware can be added to any plant. Here a finger is pressed and held. There are noise
of 0.5 microstrain, drift, gages that warm by 4 microstrain after first contact, and one that
fails.
"""

import numpy as np
from matplotlib import pyplot

from fingerdesign.checks.load import load_design
from fingerdesign.control.plants.hardware import Hardware, ImperfectPlant
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.sensing.model import grip_problem

design = load_design("sensitive")
problem = grip_problem(design)
hardware = Hardware(
    gage_noise_microstrain=0.5,
    drift_microstrain_per_s=0.5,
    warming_microstrain=4.0,
    warming_time_s=0.5,
    dying_gages=(4,),
    dying_after_s=0.9,
)
moves = [(0.0, 0.001)] * 20 + [(0.0, 0.0)] * 180  # press by 20 µm, then hold
plants = [
    CondensedPlant(problem, design.gages.face),
    ImperfectPlant(CondensedPlant(problem, design.gages.face), hardware, np.random.default_rng(1)),
]
true, measured = (np.array([plant.move(*move).readings for move in moves]) for plant in plants)

figure, axes = pyplot.subplots(figsize=(7.2, 4.0), layout="constrained")
time = np.arange(len(moves)) / hardware.sample_rate_Hz
for gage, colour in ((1, "#0a8f6b"), (4, "#d2560a"), (7, "#0b6fb0"), (10, "#b0569a")):
    axes.plot(time, measured[:, gage], color=colour, lw=0.8, label=f"gage {gage}")
    axes.plot(time, true[:, gage], color=colour, ls="--", lw=1.4)
axes.set_xlabel("time, s")
axes.set_ylabel("reading, microstrain")
axes.set_title("Dashed: the model's own readings")
axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
pyplot.show()
