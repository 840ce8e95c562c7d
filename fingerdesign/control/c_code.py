"""The regulator and its estimator as C99 for a hand's microcontroller: one file, weights and all.

    for name, text in c_files(estimator, design.grip).items():
        (folder / name).write_text(text)

Single precision, no libraries but C's own, no memory allocated. Templates are in templates/; what
they name in capitals are the numbers here, in estimator.py and in the regulator's file. Weights
are 16-bit integers, one scale an output:

    w = scale q,   scale = max |w| / 32767,   |error| <= scale / 2
"""

from __future__ import annotations

import math
from pathlib import Path
from textwrap import fill
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fingerdesign.arrays import Array
from fingerdesign.control import estimator as features
from fingerdesign.control.controllers import regulator
from fingerdesign.control.estimator import LAGS, GripEstimator, feature_count
from fingerdesign.runtime.registry import CONTROLLERS, own_values

if TYPE_CHECKING:
    from fingerdesign.design.grip import Grip

FILES = ("regulator.c", "regulator.h")
_TEMPLATES = Path(__file__).parent / "templates"
_MOST_DELAY = 120  # samples: more are refused as the hand is started
_LARGEST = 32767  # of 16 bits with a sign


def constants(estimator: GripEstimator, grip: Grip) -> dict[str, float]:
    """Numbers of the templates by name: of both modules, of ``[grip]``, of the noise."""
    own = own_values(grip, CONTROLLERS.find("regulator", "grip.controller"))
    named = {**vars(features), **vars(regulator)}
    found = {name.strip("_"): each for name, each in named.items() if name.strip("_").isupper()}
    found |= {name.upper(): float(each) for name, each in vars(own).items()}
    found["LEAST_FRICTION"], found["MOST_FRICTION"] = found["FRICTION"]
    found["APPROACH_STEP"], found["SHEAR_STEP"] = grip.approach_step_mm, grip.shear_step_mm
    found["LOG_NOISE"] = math.log(estimator.noise + 0.1)
    found["NOTHING"] += found["LOUDEST"] * estimator.noise
    return {name: each for name, each in found.items() if isinstance(each, float)}


def in_16_bits(weight: Array) -> tuple[NDArray[np.int16], NDArray[np.float32]]:
    """Integers of a layer's shape, and what those of each output are to be multiplied by."""
    largest = np.abs(weight).max(axis=0)
    scale = np.where(largest > 0.0, largest / _LARGEST, 1.0).astype(np.float32)
    return np.rint(weight / scale).clip(-_LARGEST, _LARGEST).astype(np.int16), scale


def c_files(estimator: GripEstimator, grip: Grip) -> dict[str, str]:
    """Texts by file name, for the estimator's noise and a design's ``[grip]`` table."""
    band, gages = estimator.band, estimator.gages
    count = feature_count(gages)
    sizes = {"GAGES": gages, "LOOKS_BACK": max(LAGS), "MOST_DELAY": _MOST_DELAY}
    sizes["SILENT"] = features.SILENT
    widest = max(count, *(len(each.bias) for each in band.layers))
    lines = [f"#define FEATURES {count}", f"#define WIDEST {widest}"]
    numbers = constants(estimator, grip)
    lines += [f"#define {name} {_single(each)}" for name, each in numbers.items()]
    for name, steps in {"LAGS": LAGS, "READINGS_AT": features.readings_at(gages)}.items():
        lines += [f"static const int {name}[] = {{{', '.join(map(str, steps))}}};"]
    lines += [array_text("CENTER[]", band.center), array_text("SCALE[]", band.scale)]
    lines += [array_text("SPREAD[][2]", band.spread)]
    layers = []
    for k, each in enumerate(band.layers):
        weight, scale = in_16_bits(each.weight)
        values = ", ".join(map(str, weight.reshape(-1).tolist()))
        lines += [fill(f"static const int16_t WEIGHT_{k}[] = {{{values}}};", 99)]
        lines += [array_text(f"WEIGHT_SCALE_{k}[]", scale), array_text(f"BIAS_{k}[]", each.bias)]
        inputs, outputs = weight.shape
        layers.append(f"{{{inputs}, {outputs}, WEIGHT_{k}, WEIGHT_SCALE_{k}, BIAS_{k}}}")
    lines += [fill(f"static const layer LAYERS[] = {{{', '.join(layers)}}};", 99)]
    filled = {
        "@origin@": f"For the finger\n   {estimator.design}, {estimator.noise:g} microstrain.",
        "@sizes@": "\n".join(f"#define REGULATOR_{name} {each}" for name, each in sizes.items()),
        "@numbers@": "\n".join(lines),
    }
    return {name: filled_template(name, filled) for name in FILES}


def filled_template(name: str, places: dict[str, str]) -> str:
    """A file of templates/ with each place's words."""
    text = (_TEMPLATES / name).read_text("utf-8")
    for place, words in places.items():
        text = text.replace(place, words)
    return text


def _single(value: float | np.float32) -> str:
    """A literal that reads back as the same single."""
    return f"{value:.8e}f"


def array_text(name: str, values: ArrayLike) -> str:
    """A constant array; of two columns where it is a table."""
    rows = np.asarray(values, dtype=np.float32)
    if rows.ndim == 1:
        words = ", ".join(map(_single, rows))
    else:
        words = ", ".join(f"{{{', '.join(map(_single, row))}}}" for row in rows)
    return fill(f"static const float {name} = {{{words}}};", 99)
