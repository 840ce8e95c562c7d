"""Features: what an estimator knows of a grip so far, and the finger's curves that they need.

    row = features(history, curves, noise)     # history: the moments from the first touch on

How the friction utilisation goes with the stick ratio depends on the path of the forces: loaded
along a straight line a contact sticks at any margin. So the features hold the recent path as well
as the present: gages over F_n, and the change of gages and forces over the last steps. From both,
what F_n alone would cause is taken out first, and they are reported in parts of what a shear causes
where all sticks (:class:`FingerCurves`): without that, errors on the same 1250 grips were a sixth
larger. So is what the forces rise by beyond what the moves cause where all sticks: on fingers other
than the trained one, that takes a tenth off the errors. What has changed since the first pull, and
the largest F_t / F_n so far, below which no friction can be, take off another sixth. Last comes
what the object does to the gages before it is pulled: it may lean, or be round.

An object whose centre of mass is an arm a off the middle turns, and gives way: of the stiffness

    1 / (1 + (a / r)^2)     r: the finger's turn radius at this depth (contact/turning.py)

is left, which would look like slip. A cell that measures the torque M about the normal shows the
arm, of all moments so far, a = sum M F_t / (sum F_t^2 + f^2), f = 0.02 N. What is left of the
stiffness enters what is expected of the moves, and is a feature of its own: at a given friction
the object slips the sooner, the less is left.

A gage that has fallen silent, whose cable has come off, say, gives no information on its past
either: its features are NaN, and all others complete them (completion.py). It counts as dead until
it answers.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.control.signals import Calibration, Sample

LAGS = (1, 4, 12)  # steps back
LEAST_FORCE = 0.05  # N: below it there is hardly a contact
_LEAST_MOTION = 1e-4  # mm
_LEAST_CHANGE = 0.02  # N: A force cell does not resolve smaller changes.
_ARM_FORCE = 0.02  # N: f of the module; tangential forces below it say little of the arm.
_NORMAL_SHARE = 0.3  # of F_n's change counts as much as F_t's
_LEAST_RESPONSE = 1e-6  # microstrain/N
# A gage is dead where so many samples in a row are nearly nothing, and the finger pressed alone
# would cause so many times as much. Of good gages, of objects that lean, 0.4 % seem so for a time;
# of samples of good gages in lifts with all faults 2.6 %, as readings pass through zero. To ask
# besides that they fell at once, or do not follow the forces, finds as many dead ones and 0.5 % of
# the good; an estimator that is trained so lifts no more.
SILENT = 3
_NOTHING = 10.0  # microstrain: what drift and warmth may read
_LOUDEST = 4.0  # of the noise's standard deviation
_HEARD = 3.0


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

    @classmethod
    def of(cls, calibration: Calibration) -> Self:
        """Those of a rig's finger; past the depths at which it was sheared, the nearest one's."""
        normal, sticking = calibration.normal, calibration.sticking
        force, sheared = normal.normal_force, sticking.normal_force
        near = np.clip(force, sheared[0], sheared[-1])
        return cls(
            force,
            normal.readings,
            np.array([sticking.at(each) for each in near]),
            calibration.approach,
            np.interp(near, sheared, calibration.stiffness),
            np.zeros_like(force),
        )

    def turning_as(self, model: Self) -> Self:
        """The same with a model's turn radius, which depends on the depth alone."""
        radius = np.interp(self.approach, model.approach, model.turn_radius)
        return replace(self, turn_radius=radius)

    def pressed_at(self, normal_force: Array | float) -> Array:
        """``pressed`` (..., g) at forces (...); past either end the nearest."""
        return self._between(self.pressed, normal_force)

    def sticking_at(self, normal_force: Array | float) -> Array:
        """``sticking`` (..., g) at forces (...); past either end the nearest."""
        return self._between(self.sticking, normal_force)

    def _between(self, values: Array, normal_force: Array | float) -> Array:
        force = self.normal_force
        now = np.minimum(np.maximum(normal_force, force[0]), force[-1])
        k = np.maximum(force.searchsorted(now) - 1, 0)
        share = (now - force[k]) / (force[k + 1] - force[k])
        low: Array = values[k]
        return np.asarray(low + share[..., None] * (values[k + 1] - low))

    def expected(
        self, normal_force: Array, dx: Array, dy: Array, arm: Array | float = 0.0
    ) -> tuple[Array, Array]:
        """Rises of F_n and F_t, N, (...) where moves (...) on from forces (...) and nothing slips.
        arm (mm): of the object's weight."""
        force = self.normal_force
        depth = np.interp(normal_force, force, self.approach) + dy
        after = np.interp(depth, self.approach, force)
        middle = 0.5 * (normal_force + after)
        stiffness = np.interp(middle, force, self.stiffness)
        return after - normal_force, stiffness * self.left_by_turn(middle, arm) * dx

    def left_by_turn(self, normal_force: Array | float, arm: Array | float) -> Array:
        """Share (...) of the stiffness that an object leaves with its weight an arm (mm) off the
        middle; 1 where the turn radius is not known."""
        radius = np.interp(normal_force, self.normal_force, self.turn_radius)
        known = radius > 0.0
        return np.where(known, 1.0 / (1.0 + (arm / np.where(known, radius, 1.0)) ** 2), 1.0)


def feature_count(gages: int) -> int:
    """Number of features of ``gages`` readings."""
    return 2 * gages + 5 + (len(LAGS) + 1) * (gages + 7)


def gages_of(count: int) -> int:
    """Number of gages whose features are ``count``."""
    return (count - feature_count(0)) // (feature_count(1) - feature_count(0))


def readings_at(gages: int) -> list[int]:
    """Places at which ``gages`` features of a kind begin that are the gages' own."""
    changes = [gages + 5 + k * (gages + 7) for k in range(len(LAGS) + 1)]
    return [0, *changes, feature_count(gages) - gages]


def features(history: Sequence[Moment], curves: FingerCurves, noise: float) -> Array:
    """Features (f,) of the last moment: the present, the changes over the last steps and since the
    first pull, the touch. NaN: of gages that are dead."""
    row: Array = feature_rows(history, curves, noise, np.array([len(history) - 1]))[0]
    return row


def feature_rows(
    history: Sequence[Moment], curves: FingerCurves, noise: float, rows: IntArray
) -> Array:
    """Features (r, f) of the moments ``rows`` (r,) of a history: those that each had as its last
    moment."""
    path = _Path.of(history)
    normal, pressed, pull = path.normal[rows], path.pressed[rows], path.tangential[rows]
    scale, alone = _scale(curves, pressed)
    known = np.where(_dead(path, curves, noise, rows), np.nan, 1.0)
    largest = np.maximum.accumulate(path.tangential / path.pressed)[rows]
    arm, start = path.arms[rows], path.before_pull(rows)
    scale_then, alone_then = _scale(curves, path.pressed[start])
    touch = (path.readings[start] - alone_then) / (scale_then * path.pressed[start])[:, None]
    now = [np.log(pressed), pull / pressed, np.full(len(rows), math.log(noise + 0.1))]
    now += [np.maximum(largest, 0.0), curves.left_by_turn(pressed, arm)]
    # The changes of all spans at once: first (s, r), what follows (s, r) or (s, r, g).
    first = np.array([*(np.maximum(rows - lag, 0) for lag in LAGS), start])
    dx, dy, along, across = (path.ways[rows] - path.ways[first]).transpose(2, 0, 1)
    rising, pulling = curves.expected(path.normal[first], dx, dy, arm)
    way = np.maximum(along + across, _LEAST_MOTION)
    rise, more = normal - path.normal[first], pull - path.tangential[first]
    size = np.abs(more) + _NORMAL_SHARE * np.abs(rise) + _LEAST_CHANGE
    change = path.readings[rows] - path.readings[first]
    change -= alone - curves.pressed_at(path.normal[first])
    shares = [rise / size, more / size, (rise - rising) / size, (more - pulling) / size]
    shares += [dx / way, np.log(way), np.log(size / pressed)]
    gages = known * change / (scale * size)[..., None]
    changes = np.concatenate([gages, np.array(shares).transpose(1, 2, 0)], axis=2)
    return np.concatenate(
        [
            known * (path.readings[rows] - alone) / (scale * pressed)[:, None],
            np.array(now).T,
            changes.transpose(1, 0, 2).reshape(len(rows), len(first) * changes.shape[2]),
            # How the object lies, leans and bends: what a plane would not cause.
            known * touch,
        ],
        axis=1,
    )


@dataclass(frozen=True)
class _Path:
    """Moments as arrays: readings (n, g); forces and arms of the object's weight (n,), mm, as each
    moment and those before show it; ways (n, 4), sums of dx, dy, |dx|, |dy|."""

    readings: Array
    normal: Array
    pressed: Array
    tangential: Array
    arms: Array
    ways: Array

    @classmethod
    def of(cls, history: Sequence[Moment]) -> Self:
        samples = [each.sample for each in history]
        readings = np.array([each.readings for each in samples])
        forces = [(s.normal_force, s.tangential_force, s.torque or 0.0) for s in samples]
        normal, pull, torque = np.array(forces).T
        # Torque over F_t; 0 of a cell without torque.
        arms = np.cumsum(torque * pull) / (np.cumsum(pull * pull) + _ARM_FORCE**2)
        moves = np.array([(each.dx, each.dy, abs(each.dx), abs(each.dy)) for each in history])
        return cls(readings, normal, np.maximum(normal, LEAST_FORCE), pull, arms, moves.cumsum(0))

    def before_pull(self, rows: IntArray) -> IntArray:
        """The last moment before the first pull; without one until a row the row itself."""
        pulled = self.ways[:, 2] > 0.0
        first = int(pulled.argmax()) if pulled.any() else len(pulled)
        return np.where(rows < first, rows, max(first - 1, 0))


def _dead(path: _Path, curves: FingerCurves, noise: float, rows: IntArray) -> BoolArray:
    """Which gages (r, g) have answered to nothing since a moment at which they should have."""
    nothing = _NOTHING + _LOUDEST * noise
    answers = ~(np.abs(path.readings) < nothing)
    numbers = np.arange(len(answers))[:, None]
    answered = np.maximum.accumulate(np.where(answers, numbers, -1), axis=0)[rows]
    dead = np.zeros(answered.shape, dtype=bool)
    for k, gage in np.argwhere(rows[:, None] - answered >= SILENT):
        forces = path.pressed[answered[k, gage] + SILENT : rows[k] + 1]
        alone = np.interp(forces, curves.normal_force, curves.pressed[:, gage])
        dead[k, gage] = np.abs(alone).max() > _HEARD * nothing
    return dead


def _scale(curves: FingerCurves, pressed: Array) -> tuple[Array, Array]:
    """The strongest gage's response (...) to a shear where all sticks, microstrain/N, and the
    readings (..., g) under normal forces (...) alone."""
    strongest = np.abs(curves.sticking_at(pressed)).max(axis=-1)
    return np.maximum(strongest, _LEAST_RESPONSE), curves.pressed_at(pressed)
