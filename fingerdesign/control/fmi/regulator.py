"""The regulator in C as a functional mock-up unit.

    (folder / FILE).write_bytes(fmu(estimator, design.grip))

Sources are fmu.c, fmi2.c, regulator.c and regulator.h; the weights are a resource, which library
and sources share, as weights do not compress. One step of the unit is one sample of the hand. The
finger's curves are constants; the delay, the stiffness and the cross-talk are parameters.
"""

import numpy as np

from fingerdesign.control.c_code import array_text, c_files, filled_template, weights_of
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.fmi.pack import Unit, Variable
from fingerdesign.design.grip import Grip

MODEL = "regulator"
FILE = f"{MODEL}.fmu"


def fmu(estimator: GripEstimator, grip: Grip) -> bytes:
    """The unit of an estimator and a design's ``[grip]`` table."""
    curves, period = estimator.curves, 1.0 / grip.hardware.sample_rate_Hz
    stiffness = repr(float(np.interp(grip.preload_mm, curves.approach, curves.stiffness)))
    tables = {"FORCE": curves.normal_force, "PRESSED": curves.pressed.ravel()}
    tables |= {"STICKING": curves.sticking.ravel(), "APPROACH": curves.approach}
    tables |= {"STIFFNESS": curves.stiffness, "TURN_RADIUS": curves.turn_radius}
    places = {
        "@period@": repr(period),
        "@points@": str(len(curves.normal_force)),
        "@stiffness@": stiffness,
        "@curves@": "\n".join(array_text(f"CURVE_{k}[]", v) for k, v in tables.items()),
    }
    # High bytes, then low ones: together they compress worse.
    weights = weights_of(estimator).astype(">i2").view(np.uint8).reshape(-1, 2).T.tobytes()
    sources = {name: filled_template(name, places) for name in ("fmu.c", "fmi2.c")}
    sources |= c_files(estimator, grip, with_weights=False)
    words = f"grip regulator for the finger {estimator.design}"
    unit = Unit(MODEL, words, _variables(estimator.gages, stiffness), period)
    return unit.packed(sources, {"weights.bin": weights}, ("-Os", "-s", "-fvisibility=hidden"))


def _variables(gages: int, stiffness: str) -> list[Variable]:
    """In the order of fmu.c."""
    friction = "coefficient of friction; 0 before anything is known"
    return [
        *(Variable(f"reading[{k + 1}]", "input", "of a gage", "microstrain") for k in range(gages)),
        Variable("normal_force", "input", "F_n", "N"),
        Variable("tangential_force", "input", "F_t", "N"),
        Variable("torque", "input", "about the contact's normal; 0 where unknown", "N.mm"),
        Variable("dx", "output", "next move of the hand, away from the support", "mm"),
        Variable("dy", "output", "next move of each finger, closing", "mm"),
        Variable("stick_ratio", "output", "stick area over contact area"),
        Variable("used", "output", "F_t over friction times F_n"),
        Variable("friction", "output", friction),
        Variable("stiffness", "parameter", "dF_t/dx at the preload", "N/mm", start=stiffness),
        Variable("cross_talk", "parameter", "measured as F_t of each newton of F_n"),
        Variable("delay", "parameter", "samples from a move until it is measured", "", "Integer"),
        Variable("lifted", "input", "the object has left its support", "", "Boolean", "false"),
        Variable("unsure", "output", "too little is known", "", "Boolean"),
        Variable("missed", "output", "a sample held no number", "", "Boolean"),
    ]
