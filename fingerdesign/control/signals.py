"""The gages' measure of sticking: the paper's area A, made of plain arrays (numpy only).

Between two instants gage i responds to the tangential force with (paper 2.3, 3.1)

    d_i = |delta e_i / delta F_t|          microstrain/N

The normal force strains the gages far more than the tangential one, so where both move, what
delta F_n alone would cause is taken out first with a normal-only calibration e_i(F_n):

    delta e_i = e_i(now) - e_i(before) - (calibrated(F_n now) - calibrated(F_n before))

A is the length of plate positions, linear between gages, where d_i is over a threshold.
"""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array, IntArray

FACES = {"upper": (1.0, 0.0), "lower": (0.0, 1.0), "both": (0.5, 0.5)}


def gage_readings(gages: Array, face: str) -> Array:
    """Readings of the gages (g,), microstrain, of strains (g, 2) at the upper and lower faces."""
    return np.asarray(1e6 * gages @ np.array(FACES[face]))


def reading_readout(gage_readout: Array, face: str) -> Array:
    """Readings (g, n), microstrain, per contact force, of strains (2 g, n) at both faces."""
    pairs = gage_readout.reshape(-1, 2, gage_readout.shape[1])
    return gage_readings(pairs.transpose(0, 2, 1), face)


@dataclass(frozen=True)
class NormalCalibration:
    """Readings under normal load alone: normal_force (c,) N rising, readings (c, g) microstrain."""

    normal_force: Array
    readings: Array

    def at(self, normal_force: float) -> Array:
        """Readings (g,) at ``normal_force``; past either end the last slope goes on."""
        force, readings = self.normal_force, self.readings
        k = min(max(int(np.searchsorted(force, normal_force)) - 1, 0), len(force) - 2)
        share = (normal_force - force[k]) / (force[k + 1] - force[k])
        return np.asarray(readings[k] + share * (readings[k + 1] - readings[k]))


@dataclass(frozen=True)
class Sample:
    """A hand's measurements at one instant: readings (g,) microstrain, its own two forces in N.

    lifted: the object has left its support, which a hand sees by its rising. torque: about +y
    through the contact's middle, N mm; None of a cell that does not measure it.
    """

    readings: Array
    normal_force: float
    tangential_force: float
    lifted: bool = False
    torque: float | None = None


@dataclass(frozen=True)
class Calibration:
    """A finger as its rig knows it; gages in the order of the readings.

    gage_x (g,) mm, NaN in a row along z; normal: readings under F_n alone; full_stick (g,)
    microstrain/N: response to a small shear where all sticks; tangential_stiffness: dF_t/dx then,
    N/mm. sticking: the like responses with their signs by F_n, at a few depths; stiffness (k,)
    dF_t/dx there. approach (c,) mm, of the press. delay: samples from a move until it is measured.
    cross_talk: F_t measured of each newton of F_n.
    """

    gage_x: Array
    normal: NormalCalibration
    full_stick: Array
    tangential_stiffness: float
    sticking: NormalCalibration
    stiffness: Array
    approach: Array
    delay: int = 0
    cross_talk: float = 0.0

    def corrected(self, sample: Sample) -> Sample:
        """Return a sample without the cross-talk of F_n in its F_t."""
        pulled = sample.tangential_force - self.cross_talk * sample.normal_force
        return replace(sample, tangential_force=pulled)

    @property
    def scale(self) -> float:
        """The strongest gage's response at full stick, microstrain/N."""
        return float(self.full_stick.max())


def response(before: Sample, now: Sample, calibration: NormalCalibration | None = None) -> Array:
    """d_i (g,) between two samples, microstrain/N; NaN where F_t has not changed at all.

    Without a calibration it is the raw response.
    """
    change = now.readings - before.readings
    if calibration is not None:
        change = change - (calibration.at(now.normal_force) - calibration.at(before.normal_force))
    force = now.tangential_force - before.tangential_force
    return np.abs(change / force) if force != 0.0 else np.full(len(change), np.nan)


def line_of(gage_x: Array) -> IntArray:
    """The gages that have a place along x, in its order; others tell nothing of a length in x.

    >>> line_of(np.array([1.0, np.nan, -1.0]))
    array([2, 0])
    """
    order = np.argsort(gage_x, kind="stable")
    return order[np.isfinite(gage_x[order])]


def length_over(positions: Array, values: Array, threshold: float) -> float:
    """Length where ``values``, linear between rising ``positions``, exceed ``threshold``.

    >>> length_over(np.array([0.0, 1.0, 2.0]), np.array([0.0, 2.0, 0.0]), 1.0)
    1.0
    """
    excess = np.asarray(values, dtype=float) - threshold
    left, right = excess[:-1], excess[1:]
    both = (left > 0.0) & (right > 0.0)
    one = (left > 0.0) != (right > 0.0)
    rise = np.where(one, np.abs(right - left), 1.0)
    share = np.where(both, 1.0, np.where(one, np.maximum(left, right) / rise, 0.0))
    return float(np.diff(positions) @ share)


def gage_area(
    gage_x: Array,
    responses: Array,
    threshold: float,
    held: float,
    force_change: float,
    floor: float,
) -> float:
    """The area A (mm): ``held`` where |delta F_t| is under ``floor`` and d_i means nothing."""
    if abs(force_change) < floor or not np.isfinite(responses).all():
        return held
    return length_over(gage_x, responses, threshold)
