"""Estimator files of former formats, brought to the present one without training (numpy only).

A network goes on as it is: features that it was not trained on get the weight 0.

    format  what the next one added                                     brought here
    1, 2    approach and stiffness of the finger's curves               no: files hold neither
    3       the largest F_t / F_n so far, changes since the first pull  yes
    4       a predicted error of the utilisation                        yes
    5       the share of the stiffness that a turn leaves               yes, without a turn radius
    6       a mark of gages that are dead, which is not used any more   yes
    7       how features go together, which completes a dead gage's     yes, of its neighbours

In format 4 and before, the standard deviation is known by the utilisation itself, so that is copied
as the third output.
"""

from base64 import b64decode, b64encode
from typing import Any

import numpy as np

from fingerdesign.control.completion import Relations
from fingerdesign.errors import EstimatorError

NAME = "fingerdesign grip estimator, "
PRESENT = 8
OLDEST = 3
_LAGS, _FORCES = 3, 7  # Steps back, and features of each that are not the gages' own.
_NO_CURVES = "it holds neither approach nor stiffness of the finger"
AGAIN = "train it again: fingerdesign train DESIGN"


def present_record(record: dict[str, Any]) -> dict[str, Any]:
    """The record in the present format, the same one where it is.

    Raises EstimatorError for formats that are not known or hold too little; KeyError,
    TypeError or ValueError for what is no record of its format.
    """
    name, _, number = str(record["format"]).rpartition(" ")
    if f"{name} " != NAME or not number.isdecimal() or not 1 <= int(number) <= PRESENT:
        raise EstimatorError(
            f"its format is not '{NAME}{OLDEST}' to '{PRESENT}': read it with the version that "
            f"wrote it, or {AGAIN}"
        )
    if int(number) < OLDEST:
        raise EstimatorError(f"its format is {number}, and {_NO_CURVES}: {AGAIN}")
    bands = record["bands"]
    gages = len(record["curves"]["pressed_microstrain"][0])
    if int(number) < 4:  # the largest F_t / F_n, and the changes since the first pull
        ratio, since = gages + 3, gages + 3 + _LAGS * (gages + _FORCES)
        bands = [_with_rows(band, [ratio, *[since] * (gages + _FORCES)]) for band in bands]
    if int(number) < 5:
        bands = [_with_error(band) for band in bands]
    if int(number) < 6:  # the share of the stiffness that a turn leaves
        bands = [_with_rows(band, [gages + 4]) for band in bands]
        unknown = [0.0] * len(record["curves"]["approach_mm"])
        record = record | {"curves": record["curves"] | {"turn_radius_mm": unknown}}
    if int(number) < 8:
        bands = _with_neighbours(bands, gages)
    return record | {"format": f"{NAME}{PRESENT}", "bands": bands}


def _with_rows(band: dict[str, Any], places: list[int]) -> dict[str, Any]:
    """Add features before these places, with no weight."""
    first, *later = band["layers"]
    center = np.insert(np.array(band["center"], dtype=float), places, 0.0)
    scale = np.insert(np.array(band["scale"], dtype=float), places, 1.0)
    if "weight" in first:
        weight = np.insert(np.array(first["weight"], dtype=float), places, 0.0, axis=0)
        own = {"weight": weight.tolist()}
    else:
        coded = np.frombuffer(b64decode(first["weight_base64"], validate=True), "<i2")
        rows = np.insert(coded.reshape(-1, len(first["weight_scale"])), places, 0, axis=0)
        own = {"weight_base64": b64encode(rows.tobytes()).decode("ascii")}
    layers = [first | own, *later]
    return band | {"layers": layers, "center": center.tolist(), "scale": scale.tolist()}


def _with_error(band: dict[str, Any]) -> dict[str, Any]:
    """Add a third output, by which the standard deviation is looked up: the utilisation."""
    *before, last = band["layers"]
    weight, bias = np.array(last["weight"], dtype=float), [*last["bias"], last["bias"][1]]
    weight = np.column_stack([weight, weight[:, 1]])
    return band | {"layers": [*before, {"weight": weight.tolist(), "bias": bias}]}


def _with_neighbours(bands: list[dict[str, Any]], gages: int) -> list[dict[str, Any]]:
    """Add relations by which half the sum of both neighbours stands in for a dead gage."""
    own = Relations.of_neighbours(gages).to_record()
    return [band | {"relations": own} for band in bands]
