"""Grips that nobody made: what came of one, and its path."""

from dataclasses import replace

import numpy as np

from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.result import GripResult
from fingerdesign.trials.grid import Cell
from fingerdesign.trials.summary import Trial


def grip(peak_ratio=1.4, **changes):
    """A grip of 100 g at 0.3 that succeeds, but for ``changes``; the peak by its ratio."""
    good = {
        "controller": "regulator",
        "friction_coefficient": 0.3,
        "object_mass_g": 100.0,
        "lifted": True,
        "gross_slip": False,
        "final_normal_force_N": 2.0,
        "final_tangential_force_N": 0.5,
        "safety_margin": 1.3,
        "minimum_stick_ratio": 0.5,
        "peak_normal_force_N": 0.0,
        "slip_distance_mm": 0.0,
        "steps": 30,
        "steps_to_lift": 30,
        "outcome": "lifted",
        "ending": "a sentence",
    }
    made = GripResult(**good | changes)
    return replace(made, peak_normal_force_N=peak_ratio * made.least_force_N)


def trial(cell=None, **changes):
    """The grip of a cell, with the noise's seed 0."""
    cell = cell or Cell("regulator", 0.3, 100.0, 0.0)
    own = {"controller": cell.controller, "friction_coefficient": cell.friction}
    return Trial(cell, 0, grip(**own, object_mass_g=cell.mass_g, **changes))


def path_of(normal, tangential, approach, friction, mass_g, lift=None, controller="fixed_force"):
    """The trace (k,) of a grip that never holds and has two gages."""
    k = len(normal)
    same = dict.fromkeys(("shear", "stick_ratio", "gage_area_mm", "dx", "dy"), np.full(k, 0.6))
    return GripTrace(
        controller,
        friction,
        mass_g,
        **same,
        approach=np.asarray(approach, dtype=float),
        normal_force=np.asarray(normal, dtype=float),
        tangential_force=np.asarray(tangential, dtype=float),
        hold=np.zeros(k, dtype=bool),
        gage_readings=np.zeros((k, 2)),
        lift_step=lift,
    )
