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
either: its features are NaN, and its neighbours stand in for it (estimator.py). It counts as dead
until it answers.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Self

import numpy as np

from fingerdesign.arrays import Array
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

    def pressed_at(self, normal_force: float) -> Array:
        """``pressed`` (g,) at a force; past either end the nearest."""
        return self._between(self.pressed, normal_force)

    def sticking_at(self, normal_force: float) -> Array:
        """``sticking`` (g,) at a force; past either end the nearest."""
        return self._between(self.sticking, normal_force)

    def _between(self, values: Array, normal_force: float) -> Array:
        force = self.normal_force
        now = min(max(normal_force, float(force[0])), float(force[-1]))
        k = min(max(int(force.searchsorted(now)) - 1, 0), len(force) - 2)
        share = (now - force[k]) / (force[k + 1] - force[k])
        low: Array = values[k]
        return np.asarray(low + share * (values[k + 1] - low))

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
    now = history[-1].sample
    pressed = max(now.normal_force, LEAST_FORCE)
    scale, alone = _scale(curves, pressed)
    known = np.where(_dead(history, curves, noise), np.nan, 1.0)
    last, start = len(history) - 1, _before_pull(history)
    touch = history[start].sample
    before = max(touch.normal_force, LEAST_FORCE)
    scale_then, alone_then = _scale(curves, before)
    samples = [each.sample for each in history]
    ratios = (s.tangential_force / max(s.normal_force, LEAST_FORCE) for s in samples)
    arm = _arm(samples)
    parts: list[Any] = [
        known * (now.readings - alone) / (scale * pressed),
        [math.log(pressed), now.tangential_force / pressed, math.log(noise + 0.1)],
        [max(0.0, *ratios), curves.left_by_turn(pressed, arm)],
        *(
            _changes(history[first:], curves, (scale, alone, arm), known)
            for first in (*(max(last - lag, 0) for lag in LAGS), start)
        ),
        # How the object lies, leans and bends: what a plane would not cause.
        known * (touch.readings - alone_then) / (scale_then * before),
    ]
    return np.concatenate([np.asarray(part, dtype=float) for part in parts])


def _dead(history: Sequence[Moment], curves: FingerCurves, noise: float) -> Array:
    """Which gages (g,) have answered to nothing since a moment at which they should have."""
    nothing = _NOTHING + _LOUDEST * noise
    dead = np.zeros(len(history[-1].sample.readings), dtype=bool)
    lately = np.array([each.sample.readings for each in history[-SILENT:]])
    if len(lately) < SILENT or not (np.abs(lately) < nothing).all(axis=0).any():
        return dead  # Each has answered: the past need not be searched.
    readings = np.array([each.sample.readings for each in history])
    answers = ~(np.abs(readings) < nothing)
    # Samples since each gage's last answer.
    silent = np.where(answers.any(axis=0), answers[::-1].argmax(axis=0), len(readings))
    for gage in np.flatnonzero(silent >= SILENT):
        first = len(readings) - silent[gage] + SILENT - 1
        forces = [max(each.sample.normal_force, LEAST_FORCE) for each in history[first:]]
        alone = np.interp(forces, curves.normal_force, curves.pressed[:, gage])
        dead[gage] = np.abs(alone).max() > _HEARD * nothing
    return dead


def _arm(samples: Sequence[Sample]) -> float:
    """The arm of the object's weight, mm: torque over F_t; 0 of a cell without torque."""
    if all(each.torque is None for each in samples):
        return 0.0
    force = np.array([each.tangential_force for each in samples])
    torque = np.array([each.torque or 0.0 for each in samples])
    return float(torque @ force) / (float(force @ force) + _ARM_FORCE**2)


def _scale(curves: FingerCurves, pressed: float) -> tuple[float, Array]:
    """The strongest gage's response to a shear where all sticks, microstrain/N, and the readings
    under a normal force alone."""
    strongest = float(np.abs(curves.sticking_at(pressed)).max())
    return max(strongest, _LEAST_RESPONSE), curves.pressed_at(pressed)


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
    change = change - (alone - curves.pressed_at(before.normal_force))
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
