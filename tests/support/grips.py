"""Grips that nobody made: what came of one, and its path."""

import numpy as np

from fingerdesign.control.metrics import JudgedGrip
from fingerdesign.records.arrays import GripTrace


def judged(**changes):
    """A grip of 100 g at 0.3 that succeeds, but for ``changes``."""
    good = {
        "controller": "regulator",
        "friction": 0.3,
        "mass_g": 100.0,
        "noise": 0.0,
        "seed": 0,
        "lifted": True,
        "dropped": False,
        "slip_distance_mm": 0.0,
        "margin_at_lift": 1.3,
        "peak_normal_force_N": 2.0,
        "peak_ratio": 1.4,
        "minimum_stick_ratio": 0.5,
        "steps": 30,
        "ending": "lifted",
        "reason": "a sentence",
    }
    return JudgedGrip(**good | changes)


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
