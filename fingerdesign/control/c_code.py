"""The regulator and its estimator as C99 for a hand's microcontroller: one file, weights and all.

    for name, text in c_files(estimator, design.grip).items():
        (folder / name).write_text(text)

Single precision, no libraries but C's own, no memory allocated. Templates are in templates/; what
they name in capitals are the numbers here, in features.py and in the regulator's file. Weights
and relations are 16-bit integers as in the estimator's file.
"""

import math
from pathlib import Path
from textwrap import fill

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fingerdesign.control import features
from fingerdesign.control.completion import in_integers
from fingerdesign.control.controllers import friction_belief, regulator
from fingerdesign.control.estimator import OUTLIER, GripEstimator, in_16_bits
from fingerdesign.control.features import LAGS, feature_count
from fingerdesign.design.grip import Grip
from fingerdesign.runtime.registry import CONTROLLERS, own_values

FILES = ("regulator.c", "regulator.h")
_TEMPLATES = Path(__file__).parent / "templates"
_MOST_DELAY = 120  # samples: more are refused as the hand is started


def constants(estimator: GripEstimator, grip: Grip) -> dict[str, float]:
    """Numbers of the templates by name: of both modules, of ``[grip]``, of the noise."""
    own = own_values(grip, CONTROLLERS.find("regulator", "grip.controller"))
    named = {**vars(features), **vars(friction_belief), **vars(regulator)}
    found = {name.strip("_"): each for name, each in named.items() if name.strip("_").isupper()}
    found |= {name.upper(): float(each) for name, each in vars(own).items()}
    found["LEAST_FRICTION"], found["MOST_FRICTION"] = found["FRICTION"]
    found["APPROACH_STEP"], found["SHEAR_STEP"] = grip.approach_step_mm, grip.shear_step_mm
    found["OUTLIER"], found["LOG_NOISE"] = OUTLIER, math.log(estimator.noise + 0.1)
    found["NOTHING"] += found["LOUDEST"] * estimator.noise
    return {name: each for name, each in found.items() if isinstance(each, float)}


def c_files(estimator: GripEstimator, grip: Grip, with_weights: bool = True) -> dict[str, str]:
    """Texts by file name, for the estimator's noise and a design's ``[grip]`` table.

    with_weights: else WEIGHTS is an array without values, to be filled by :func:`weights_of`.
    """
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
    lines += [array_text("SPREAD[][2]", band.spread), array_text("ROOT[]", band.relations.root)]
    related = in_integers(band.relations.matrix)
    lines += [fill(f"static const int16_t RELATED[] = {{{', '.join(map(str, related))}}};", 99)]
    weights, layers, first = weights_of(estimator), [], 0
    values = (
        f"] = {{{', '.join(map(str, weights.tolist()))}}}" if with_weights else f"{len(weights)}]"
    )
    const = "const " if with_weights else ""
    lines += [fill(f"static {const}int16_t WEIGHTS[{values};", 99)]
    for k, each in enumerate(band.layers):
        inputs, outputs = each.weight.shape
        scale = in_16_bits(each.weight)[1]
        lines += [array_text(f"WEIGHT_SCALE_{k}[]", scale), array_text(f"BIAS_{k}[]", each.bias)]
        layers.append(f"{{{inputs}, {outputs}, WEIGHTS + {first}, WEIGHT_SCALE_{k}, BIAS_{k}}}")
        first += inputs * outputs
    lines += [fill(f"static const layer LAYERS[] = {{{', '.join(layers)}}};", 99)]
    filled = {
        "@origin@": f"For the finger\n   {estimator.design}, {estimator.noise:g} microstrain.",
        "@sizes@": "\n".join(f"#define REGULATOR_{name} {each}" for name, each in sizes.items()),
        "@numbers@": "\n".join(lines),
    }
    return {name: filled_template(name, filled) for name in FILES}


def weights_of(estimator: GripEstimator) -> NDArray[np.int16]:
    """Weights of all layers in turn, a row of all outputs for each input."""
    return np.concatenate([in_16_bits(each.weight)[0].ravel() for each in estimator.band.layers])


def filled_template(name: str, places: dict[str, str]) -> str:
    """A file of templates/ with each place's words."""
    text = (_TEMPLATES / name).read_text("utf-8")
    for place, words in places.items():
        text = text.replace(place, words)
    return text


def _single(value: float | np.float32) -> str:
    """The shortest literal that reads back as the same single."""
    return f"{np.float32(value)!s}f"


def array_text(name: str, values: ArrayLike) -> str:
    """A constant array; of two columns where it is a table."""
    rows = np.asarray(values, dtype=np.float32)
    if rows.ndim == 1:
        words = ", ".join(map(_single, rows))
    else:
        words = ", ".join(f"{{{', '.join(map(_single, row))}}}" for row in rows)
    return fill(f"static const float {name} = {{{words}}};", 99)
