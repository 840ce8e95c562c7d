"""Estimator of the stick ratio and the friction utilisation, from gages and forces.

    estimator = GripEstimator.from_json(text)
    reported = estimator.estimate(history)     # reported.stick_ratio, .friction_utilisation

A small network, trained on a design's own model (sensing/train) and evaluated here with numpy
alone, so that a rig can carry its JSON. It is never given friction or weight. The utilisation is

    F_t / (mu F_n),   its inverse the safety margin,

the one thing that partial slip reveals of friction. Its inputs are those of control/features.py.

Its file holds weights as 16-bit integers, one scale an output:

    w = scale q,   scale = max |w| / 32767,   |error| <= scale / 2

The features of a gage that is dead are completed from all others (control/completion.py).
"""

import json
from base64 import b64decode, b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.completion import LARGEST, Relations
from fingerdesign.control.features import LAGS, FingerCurves, Moment, feature_count, features
from fingerdesign.control.former_estimator import AGAIN, NAME, PRESENT, present_record
from fingerdesign.control.signals import Calibration
from fingerdesign.errors import EstimatorError

FORMAT = f"{NAME}{PRESENT}"
_NO_FILE = "it is not a file that `fingerdesign train` wrote"
_INVALID = (ArithmeticError, AttributeError, LookupError, RecursionError, TypeError, ValueError)
_CURVES = {  # key of the file: field of FingerCurves
    "normal_force_N": "normal_force",
    "pressed_microstrain": "pressed",
    "sticking_microstrain_per_N": "sticking",
    "approach_mm": "approach",
    "stiffness_N_per_mm": "stiffness",
    "turn_radius_mm": "turn_radius",
}
_MOST_NOISE = 1000.0  # microstrain; more than any amplifier has
# The largest and least numbers of single precision, in which a microcontroller computes.
_MOST_SINGLE, _LEAST_SINGLE = float(np.finfo(np.float32).max), float(np.finfo(np.float32).tiny)
OUTLIER = 5.0  # standard deviations of the features: The network was never trained farther out.


@dataclass(frozen=True)
class Estimated:
    """Stick area / contact area, and F_t / (mu F_n), both within 0 and 1.

    std: standard deviation that the utilisation was found to have on held-out grips (sensing/train:
    of other fingers, where many are trained on) at moments with the same predicted error.
    """

    stick_ratio: float
    friction_utilisation: float
    std: float


@dataclass(frozen=True)
class Layer:
    """weight (inputs, outputs), bias (outputs,)."""

    weight: Array
    bias: Array


@dataclass(frozen=True)
class Band:
    """A network for gages with a noise of up to ``most_noise`` microstrain a sample.

    Rectified linear layers on features less ``center``, over ``scale`` (features,). relations: of
    these, for gages that are dead. spread (k, 2): upper edges of the predicted error, rising, and
    the standard deviation of the utilisation below each.
    """

    most_noise: float
    center: Array
    scale: Array
    relations: Relations
    layers: tuple[Layer, ...]
    spread: Array

    def evaluate(self, rows: Array) -> Array:
        """Raw outputs (n, 3), stick ratio, utilisation and its predicted error, of features
        (n, f); NaN: of a dead gage."""
        known = standardised(rows, self.center, self.scale)
        return outputs_of(self.layers, completed(known, self.relations))


@dataclass(frozen=True)
class GripEstimator:
    """See the module. design: key of its training; noise: of a gage's sample, microstrain,
    stated by the rig; bands: rising in noise; adopted_from: name of the finger that it was trained
    on, where another one grips with it."""

    design: str
    curves: FingerCurves
    noise: float
    bands: tuple[Band, ...]
    adopted_from: str = ""

    def at_noise(self, noise: float) -> Self:
        """The same for a rig with another noise, microstrain: it was trained on all."""
        return replace(self, noise=noise)

    def on_rig(self, calibration: Calibration) -> Self:
        """The same for a rig that knows its own finger, whatever gains, moduli and places came out
        as."""
        return replace(self, curves=FingerCurves.of(calibration).turning_as(self.curves))

    @property
    def gages(self) -> int:
        """Number of readings that it takes."""
        return int(self.curves.pressed.shape[1])

    @property
    def band(self) -> Band:
        """The network for its noise; the last one where it is louder than all."""
        return next((b for b in self.bands if self.noise <= b.most_noise), self.bands[-1])

    def estimate(self, history: Sequence[Moment]) -> Estimated:
        """Estimate from the grip so far; ``history`` from the first touch on, not empty."""
        band = self.band
        found = band.evaluate(features(history, self.curves, self.noise)[None])[0]
        used = float(min(max(found[1], 0.0), 1.0))
        row = min(int(np.searchsorted(band.spread[:, 0], found[2])), len(band.spread) - 1)
        return Estimated(float(min(max(found[0], 0.0), 1.0)), used, float(band.spread[row, 1]))

    def to_json(self) -> str:
        """The estimator as text, for a rig."""
        record = {
            "format": FORMAT,
            "design": self.design,
            "gages": self.gages,
            "curves": {key: _plain(getattr(self.curves, own)) for key, own in _CURVES.items()},
            "noise_microstrain": self.noise,
            "lags": list(LAGS),
            "bands": [
                {
                    "most_noise_microstrain": band.most_noise,
                    "center": _plain(band.center),
                    "scale": _plain(band.scale),
                    "relations": band.relations.to_record(),
                    "layers": [_layer_data(each) for each in band.layers],
                    "spread": _plain(band.spread),
                }
                for band in self.bands
            ],
        }
        return json.dumps(record, allow_nan=False) + "\n"

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read what :meth:`to_json` wrote, here or in a version with a former format
        (former_estimator.py). Raises EstimatorError for anything else."""
        try:
            record = present_record(json.loads(text))
            if tuple(record["lags"]) != LAGS:
                raise EstimatorError(f"its lags are not {LAGS}: {AGAIN}")
            curves = record["curves"]
            found = cls(
                record["design"],
                FingerCurves(*(_array(curves[key]) for key in _CURVES)),
                float(record["noise_microstrain"]),
                tuple(_band(each) for each in record["bands"]),
            )
            wrong = _faults(found)
        except EstimatorError:
            raise
        except _INVALID as error:
            raise EstimatorError(f"{_NO_FILE} ({type(error).__name__})") from error
        if wrong:
            raise EstimatorError(f"{_NO_FILE}: {wrong[0]}")
        return found


def _faults(found: GripEstimator) -> list[str]:
    """Faults of an estimator's numbers, in words."""
    wrong = []
    if not isinstance(found.design, str):
        wrong.append("design is no text")
    if not 0.0 <= found.noise <= _MOST_NOISE:
        wrong.append(f"the noise is not a number from 0 to {_MOST_NOISE:g} microstrain")
    if any(np.abs(each).max(initial=0.0) > _MOST_SINGLE for each in vars(found.curves).values()):
        return [*wrong, "the curves' numbers do not fit single precision"]
    wrong += _curve_faults(found.curves, found.gages)
    limits = np.array([band.most_noise for band in found.bands])
    if not len(limits) or not np.isfinite(limits).all() or not (np.diff(limits) > 0.0).all():
        wrong.append("the bands' noises do not rise")
    count = feature_count(found.gages)
    return [*wrong, *filter(None, (_band_fault(band, count) for band in found.bands))]


def _curve_faults(curves: FingerCurves, gages: int) -> Iterator[str]:
    force, points = curves.normal_force, len(curves.normal_force)
    rising = np.diff(force.astype(np.float32)) > 0.0
    if points < 2 or force.ndim != 1 or not (force[0] >= 0.0 and rising.all()):
        yield "the curves' normal forces do not rise from 0 or more"
    if not curves.pressed.shape == curves.sticking.shape == (points, gages):
        yield "the curves are not of one shape"
    of_depth = (curves.approach, curves.stiffness, curves.turn_radius)
    if not all(each.shape == (points,) for each in of_depth):
        yield "the curves are not of one shape"
    elif (curves.turn_radius < 0.0).any():
        yield "a turn radius is below 0"
    elif (np.diff(curves.approach) < 0.0).any() or (curves.stiffness < _LEAST_SINGLE).any():
        yield "the curves' approaches fall, or a stiffness is not above 0"
    if not curves.sticking.any():
        yield "no gage responds where all sticks"


def _band_fault(band: Band, features: int) -> str:
    """Find the first fault of a band's numbers; "" without one."""
    if band.center.shape != (features,) or band.scale.shape != (features,):
        return f"a band is not of {features} features"
    if not (band.scale >= _LEAST_SINGLE).all():
        return "a feature's scale is not above 0 in single precision"
    if wrong := band.relations.fault(features):
        return wrong
    if not _most(band) <= _MOST_SINGLE:
        return "a network's numbers do not fit single precision"
    if band.spread.ndim != 2 or band.spread.shape[1] != 2 or not (band.spread > 0.0).all():
        return "a spread is not a table of two columns above 0"
    outputs = band.evaluate(np.zeros((1, features)))
    return "" if outputs.shape == (1, 3) else "a network does not give three numbers"


def _most(band: Band) -> float:
    """No number of a band, nor any that it computes from features, is larger than this."""
    own = [np.abs(each).max(initial=0.0) for each in (band.center, band.scale, band.spread)]
    reached = np.full(len(band.center), OUTLIER)
    with np.errstate(over="ignore", invalid="ignore"):
        for layer in band.layers:
            reached = reached @ np.abs(layer.weight) + np.abs(layer.bias)
            own.append(reached.max(initial=0.0))
    return float(np.max(own))  # NaN if one is


def _band(record: dict[str, Any]) -> Band:
    return Band(
        float(record["most_noise_microstrain"]),
        _array(record["center"]),
        _array(record["scale"]),
        Relations.from_record(record["relations"]),
        tuple(Layer(_weight(each), _array(each["bias"])) for each in record["layers"]),
        _array(record["spread"]),
    )


def in_16_bits(weight: Array) -> tuple[NDArray[np.int16], NDArray[np.float32]]:
    """Integers of a layer's shape, and what those of each output are to be multiplied by."""
    largest = np.abs(weight).max(axis=0)
    scale = np.where(largest > 0.0, largest / LARGEST, 1.0).astype(np.float32)
    return np.rint(weight / scale).clip(-LARGEST, LARGEST).astype(np.int16), scale


def _layer_data(layer: Layer) -> dict[str, Any]:
    integers, scale = in_16_bits(layer.weight)
    coded = b64encode(integers.astype("<i2").tobytes()).decode("ascii")
    # Nine digits give a single back exactly.
    scales = [float(f"{value:.9g}") for value in scale.tolist()]
    return {"weight_base64": coded, "weight_scale": scales, "bias": _plain(layer.bias)}


def _weight(record: dict[str, Any]) -> Array:
    """A layer's weights (inputs, outputs); files of earlier versions hold them in full."""
    if "weight" in record:
        return _array(record["weight"])
    scale = _array(record["weight_scale"])
    integers = np.frombuffer(b64decode(record["weight_base64"], validate=True), "<i2")
    return np.asarray(scale * integers.reshape(-1, len(scale)))


def outputs_of(layers: Sequence[Layer], rows: ArrayLike) -> Array:
    """A network's outputs (n, o), of standardised rows (n, f)."""
    values = np.asarray(rows)
    for layer in layers[:-1]:
        values = np.maximum(values @ layer.weight + layer.bias, 0.0)
    return np.asarray(values @ layers[-1].weight + layers[-1].bias)


def standardised(rows: Array, center: Array, scale: Array) -> Array:
    """Rows (n, f) of features in standard deviations, within the outliers' bound; NaN stays."""
    return np.asarray(np.clip((rows - center) / scale, -OUTLIER, OUTLIER))


def completed(rows: Array, relations: Relations) -> Array:
    """Standardised rows with the features of dead gages, within the outliers' bound."""
    if not np.isnan(rows).any():
        return rows
    return np.asarray(np.clip(relations.completed(rows), -OUTLIER, OUTLIER))


def _array(values: Any) -> Array:
    found = np.array(values, dtype=float)
    if not np.isfinite(found).all():
        raise ValueError("a number is not finite")
    return found


def _plain(values: Array) -> Any:
    short = [float(f"{value:.6g}") for value in values.reshape(-1)]
    return np.asarray(short).reshape(values.shape).tolist()
