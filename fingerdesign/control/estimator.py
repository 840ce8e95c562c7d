"""Estimator of the stick ratio and the friction utilisation, from gages and forces.

    estimator = GripEstimator.from_json(text)
    reported = estimator.estimate(history)     # reported.stick_ratio, .friction_utilisation

A small network, trained on a design's own model (sensing/train) and evaluated here with numpy
alone, so that a rig can carry its JSON. It is never given friction or weight. The utilisation is

    F_t / (mu F_n),   its inverse the safety margin,

the one thing that partial slip reveals of friction. Its relation to the stick ratio depends on the
path of the forces (loaded along a straight line a contact sticks at any margin), so the network is
handed the recent path as well as the present: gages over F_n, and the change of gages and forces
over the last steps. From both, what F_n alone would cause is taken out first, and they are reported
in parts of what a shear causes where all sticks (:class:`FingerCurves`): without that, errors on
the same 1250 grips were a sixth larger. So is what the forces rise by beyond what the moves cause
where all sticks: on fingers other than the trained one, that takes a tenth off the errors. What
has changed since the first pull, and the largest F_t / F_n so far, below which no friction can be,
take off another sixth. Last comes what the object does to the gages before it is pulled: it may
lean, or be round.

An object whose centre of mass is an arm a off the middle turns, and gives way: of the stiffness

    1 / (1 + (a / r)^2)     r: the finger's turn radius at this depth (contact/turning.py)

is left, which would look like slip. A cell that measures the torque M about the normal shows the
arm, of all moments so far, a = sum M F_t / (sum F_t^2 + f^2), f = 0.02 N. What is left of the
stiffness enters what is expected of the moves, and is a feature of its own: at a given friction
the object slips the sooner, the less is left.

Its file holds weights as 16-bit integers, one scale an output:

    w = scale q,   scale = max |w| / 32767,   |error| <= scale / 2

A gage that has fallen silent, whose cable has come off, say, gives no information on its past
either: its features are left out, and the network takes the mean of its training for them.
"""

from __future__ import annotations

import json
import math
from base64 import b64decode, b64encode
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.former_estimator import (
    AGAIN,
    NAME,
    PRESENT,
    FormerEstimatorError,
    present_record,
)
from fingerdesign.control.signals import Sample
from fingerdesign.errors import FingerDesignError

if TYPE_CHECKING:
    from fingerdesign.control.calibration import Calibration

FORMAT = f"{NAME}{PRESENT}"
LAGS = (1, 4, 12)  # steps back
LEAST_FORCE = 0.05  # N: below it there is hardly a contact
_LEAST_MOTION = 1e-4  # mm
_LEAST_CHANGE = 0.02  # N: A force cell does not resolve smaller changes.
_ARM_FORCE = 0.02  # N: f of the module; tangential forces below it say little of the arm.
_NORMAL_SHARE = 0.3  # of F_n's change counts as much as F_t's
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
_LEAST_RESPONSE = 1e-6  # microstrain/N
# A gage is dead where so many samples in a row are nearly nothing, and the finger pressed alone
# would cause so many times as much. Of good gages, of objects that lean, 0.4 % seem so for a time.
SILENT = 3
_NOTHING = 10.0  # microstrain: what drift and warmth may read
_LOUDEST = 4.0  # of the noise's standard deviation
_HEARD = 3.0
_MOST_NOISE = 1000.0  # microstrain; more than any amplifier has
# The largest and least numbers of single precision, in which a microcontroller computes.
_MOST_SINGLE, _LEAST_SINGLE = float(np.finfo(np.float32).max), float(np.finfo(np.float32).tiny)
_LARGEST = 32767  # of 16 bits with a sign
OUTLIER = 5.0  # standard deviations of the features: The network was never trained farther out.


class EstimatorError(FingerDesignError):
    """An estimator's file is not one, or is of another finger."""


@dataclass(frozen=True)
class Moment:
    """A sample and the move (mm) that led to it."""

    sample: Sample
    dx: float
    dy: float


@dataclass(frozen=True)
class FingerCurves:
    """Curves of a finger on its bench, by F_n, as its rig measures it (control/calibration.py).

    normal_force (c,) N rising from 0; pressed (c, g) microstrain under it alone; sticking (c, g)
    microstrain per N of F_t, signed, for a small shear where nothing slips; approach (c,) mm, of
    the press; stiffness (c,) dF_t/dx of the small shear, N/mm; turn_radius (c,) mm, of the
    model, for no bench measures it; 0: it is not known, and no torque counts.
    """

    normal_force: Array
    pressed: Array
    sticking: Array
    approach: Array
    stiffness: Array
    turn_radius: Array

    @staticmethod
    def of(calibration: Calibration) -> FingerCurves:
        """Those of a rig's finger; past the depths at which it was sheared, the nearest one's."""
        normal, sticking = calibration.normal, calibration.sticking
        force, sheared = normal.normal_force, sticking.normal_force
        near = np.clip(force, sheared[0], sheared[-1])
        return FingerCurves(
            force,
            normal.readings,
            np.array([sticking.at(each) for each in near]),
            calibration.approach,
            np.interp(near, sheared, calibration.stiffness),
            np.zeros_like(force),
        )

    def turning_as(self, model: FingerCurves) -> FingerCurves:
        """The same with a model's turn radius, which depends on the depth alone."""
        radius = np.interp(self.approach, model.approach, model.turn_radius)
        return replace(self, turn_radius=radius)

    def at(self, normal_force: float) -> tuple[Array, Array]:
        """``pressed`` and ``sticking`` (g,) at a force; past either end the nearest."""
        force = self.normal_force
        now = min(max(normal_force, float(force[0])), float(force[-1]))
        k = min(max(int(force.searchsorted(now)) - 1, 0), len(force) - 2)
        share = (now - force[k]) / (force[k + 1] - force[k])

        def between(values: Array) -> Array:
            low: Array = values[k]
            return np.asarray(low + share * (values[k + 1] - low))

        return between(self.pressed), between(self.sticking)

    def expected(
        self, normal_force: float, dx: float, dy: float, arm: float = 0.0
    ) -> tuple[float, float]:
        """Rise of F_n and F_t, N, where moves on from a force and nothing slips. arm (mm): of the
        object's weight."""
        force = self.normal_force
        depth = float(np.interp(normal_force, force, self.approach)) + dy
        after = float(np.interp(depth, self.approach, force))
        middle = 0.5 * (normal_force + after)
        stiffness = float(np.interp(middle, force, self.stiffness))
        return after - normal_force, stiffness * self.left_by_turn(middle, arm) * dx

    def left_by_turn(self, normal_force: float, arm: float) -> float:
        """Share of the stiffness that an object leaves with its weight an arm (mm) off the middle;
        1 where the turn radius is not known."""
        radius = float(np.interp(normal_force, self.normal_force, self.turn_radius))
        return 1.0 / (1.0 + (arm / radius) ** 2) if radius > 0.0 else 1.0


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

    Rectified linear layers on features less ``center``, over ``scale`` (features,). spread (k, 2):
    upper edges of the predicted error, rising, and the standard deviation of the
    utilisation below each.
    """

    most_noise: float
    center: Array
    scale: Array
    layers: tuple[Layer, ...]
    spread: Array

    def evaluate(self, rows: Array) -> Array:
        """Raw outputs (n, 3), stick ratio, utilisation and its predicted error, of features
        (n, f); NaN: one left out."""
        return outputs_of(self.layers, standardised(rows, self.center, self.scale))


@dataclass(frozen=True)
class GripEstimator:
    """See the module. design: key of its training; noise: of a gage's sample, microstrain,
    stated by the rig; bands: rising in noise."""

    design: str
    curves: FingerCurves
    noise: float
    bands: tuple[Band, ...]

    def at_noise(self, noise: float) -> GripEstimator:
        """The same for a rig with another noise, microstrain: it was trained on all."""
        return replace(self, noise=noise)

    def on_rig(self, calibration: Calibration) -> GripEstimator:
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
                    "layers": [_layer_data(each) for each in band.layers],
                    "spread": _plain(band.spread),
                }
                for band in self.bands
            ],
        }
        return json.dumps(record, allow_nan=False) + "\n"

    @staticmethod
    def from_json(text: str) -> GripEstimator:
        """Read what :meth:`to_json` wrote, here or in a version with a former format
        (former_estimator.py). Raises EstimatorError for anything else."""
        try:
            record = present_record(json.loads(text))
            if tuple(record["lags"]) != LAGS:
                raise EstimatorError(f"its lags are not {LAGS}: {AGAIN}")
            curves = record["curves"]
            found = GripEstimator(
                record["design"],
                FingerCurves(*(_array(curves[key]) for key in _CURVES)),
                float(record["noise_microstrain"]),
                tuple(_band(each) for each in record["bands"]),
            )
            wrong = _faults(found)
        except EstimatorError:
            raise
        except FormerEstimatorError as error:
            raise EstimatorError(str(error)) from error
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
        tuple(Layer(_weight(each), _array(each["bias"])) for each in record["layers"]),
        _array(record["spread"]),
    )


def in_16_bits(weight: Array) -> tuple[NDArray[np.int16], NDArray[np.float32]]:
    """Integers of a layer's shape, and what those of each output are to be multiplied by."""
    largest = np.abs(weight).max(axis=0)
    scale = np.where(largest > 0.0, largest / _LARGEST, 1.0).astype(np.float32)
    return np.rint(weight / scale).clip(-_LARGEST, _LARGEST).astype(np.int16), scale


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
    """Rows (n, f) in standard deviations, held within the outliers' bound; 0 where one is NaN."""
    values = np.clip((rows - center) / scale, -OUTLIER, OUTLIER)
    return np.where(np.isnan(values), 0.0, values)


def feature_count(gages: int) -> int:
    """Number of features of ``gages`` readings."""
    return 2 * gages + 5 + (len(LAGS) + 1) * (gages + 7)


def readings_at(gages: int) -> list[int]:
    """Places at which ``gages`` features of a kind begin that are the gages' own."""
    changes = [gages + 5 + k * (gages + 7) for k in range(len(LAGS) + 1)]
    return [0, *changes, feature_count(gages) - gages]


def features(history: Sequence[Moment], curves: FingerCurves, noise: float) -> Array:
    """Features (f,) of the last moment: the present, the changes over the last steps and since the
    first pull, the touch. NaN: of gages that are dead."""
    now = history[-1].sample
    pressed = max(now.normal_force, LEAST_FORCE)
    scale, alone = _scale(curves, pressed)
    known = np.where(_dead(history, alone, noise), np.nan, 1.0)
    last, start = len(history) - 1, _before_pull(history)
    touch = history[start].sample
    before = max(touch.normal_force, LEAST_FORCE)
    scale_then, alone_then = _scale(curves, before)
    arm = _arm(history)
    parts: list[Any] = [
        known * (now.readings - alone) / (scale * pressed),
        [math.log(pressed), now.tangential_force / pressed, math.log(noise + 0.1)],
        [max(0.0, *(_ratio(each.sample) for each in history)), curves.left_by_turn(pressed, arm)],
        *(
            _changes(history[first:], curves, (scale, alone, arm), known)
            for first in (*(max(last - lag, 0) for lag in LAGS), start)
        ),
        # How the object lies, leans and bends: what a plane would not cause.
        known * (touch.readings - alone_then) / (scale_then * before),
    ]
    return np.concatenate([np.asarray(part, dtype=float) for part in parts])


def _dead(history: Sequence[Moment], alone: Array, noise: float) -> Array:
    """Which gages (g,) answer to nothing; alone (g,): what a press alone would cause now."""
    last = history[-SILENT:]
    nothing = _NOTHING + _LOUDEST * noise
    if len(last) < SILENT:
        return np.zeros(len(alone), dtype=bool)
    most = np.abs([each.sample.readings for each in last]).max(axis=0)
    return np.asarray((most < nothing) & (np.abs(alone) > _HEARD * nothing))


def _ratio(sample: Sample) -> float:
    """F_t / F_n: the friction coefficient is at least the largest that there was."""
    return sample.tangential_force / max(sample.normal_force, LEAST_FORCE)


def _arm(history: Sequence[Moment]) -> float:
    """The arm of the object's weight, mm: torque over F_t; 0 of a cell without torque."""
    samples = [each.sample for each in history]
    force = np.array([each.tangential_force for each in samples])
    torque = np.array([each.torque or 0.0 for each in samples])
    return float(torque @ force) / (float(force @ force) + _ARM_FORCE**2)


def _scale(curves: FingerCurves, pressed: float) -> tuple[float, Array]:
    """The strongest gage's response to a shear where all sticks, microstrain/N, and the readings
    under a normal force alone."""
    alone, sticking = curves.at(pressed)
    return max(float(np.abs(sticking).max()), _LEAST_RESPONSE), alone


def _before_pull(history: Sequence[Moment]) -> int:
    """The last moment before the first pull; without one the last of all."""
    pulled = next((k for k, each in enumerate(history) if each.dx != 0.0), len(history))
    return max(pulled - 1, 0)


def _changes(
    history: Sequence[Moment], curves: FingerCurves, last: tuple[float, Array, float], known: Array
) -> Array:
    """Changes from the first to the last of these moments: gages, then seven of the forces and
    moves. last: :func:`_scale` of the last moment, and the arm so far."""
    scale, alone, arm = last
    before, now, moved = history[0].sample, history[-1].sample, history[1:]
    dx, dy = sum(each.dx for each in moved), sum(each.dy for each in moved)
    rising, pulling = curves.expected(before.normal_force, dx, dy, arm)
    along = sum(abs(each.dx) for each in moved)
    way = max(along + sum(abs(each.dy) for each in moved), _LEAST_MOTION)
    rise = now.normal_force - before.normal_force
    pull = now.tangential_force - before.tangential_force
    size = abs(pull) + _NORMAL_SHARE * abs(rise) + _LEAST_CHANGE
    pressed = max(now.normal_force, LEAST_FORCE)
    change = now.readings - before.readings
    change = change - (alone - curves.at(before.normal_force)[0])
    forces = [
        rise / size,
        pull / size,
        (rise - rising) / size,
        (pull - pulling) / size,
        dx / way,
        math.log(way),
        math.log(size / pressed),
    ]
    return np.concatenate([known * change / (scale * size), forces])


def _array(values: Any) -> Array:
    found = np.array(values, dtype=float)
    if not np.isfinite(found).all():
        raise ValueError("a number is not finite")
    return found


def _plain(values: Array) -> Any:
    short = [float(f"{value:.6g}") for value in values.reshape(-1)]
    return np.asarray(short).reshape(values.shape).tolist()
