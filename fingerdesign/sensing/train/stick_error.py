"""The error of the stick ratio from a finger's gages: one number, quickly, to compare designs by.

    stick_error(problem, face, max_approach, SensorErrors(0.5), seed)       # 0.14 on `sensitive`

A few seeded grips press and pull on the condensed model, each with its own friction coefficient. A
small learner (ridge regression on random rectified sums of the features; Rahimi and Recht, "Random
features for large-scale kernel machines", NIPS 2007) is trained on the stick ratio from gages and
forces and tested on other grips of the same finger, at other friction coefficients. It uses one
instant, neither the past nor the hand's moves, so it errs more than the network of validate/gages,
which takes fifty times as long. Gages without information give 0.23, about the standard deviation
of the stick ratio itself (docs/explanation/gages.md compares the two). Another seed moves all
designs together by some 0.02; designs of one study share theirs. numpy only.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np

from fingerdesign.analysis.detection import REFERENCE_NOISE, amplifier_noise
from fingerdesign.analysis.slip_study import normal_calibration
from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.control.signals import NormalCalibration, gage_readings
from fingerdesign.design.gages import METAL_FACTOR
from fingerdesign.design.grip import FORCE_NOISE_N, HardwareTable
from fingerdesign.errors import SolverError
from fingerdesign.sensing.train.paths import FRICTIONS
from fingerdesign.sensing.train.samples import GAIN_STD

GRIPS, FOLDS = 18, 9
_DEPTHS = (0.07, 0.9)  # Grips begin and end to pull at these fractions of the greatest approach.
_PRESSES, _PULLS = 2, 8
_PULL_END = 1.05  # A grip would end its pull at this fraction of the friction limit.
_CLIMB = 0.6  # This fraction of the grips presses on while it pulls.
_REPLICATES = 8  # Each instant is sampled so often, each time with other noise.
_SUMS, _GAIN, _EDGE = 96, 0.7, 2.0
_RIDGE = 1e-2
_OUTLIER = 5.0  # Features are cut off at so many standard deviations.
_LEAST_FORCE_N = 0.02
_SLIPPED = 0.01  # A grip ends below this stick ratio.
_CALIBRATION_POINTS = 8


@dataclass(frozen=True)
class SensorErrors:
    """Errors of readings: noise of a sample (microstrain), of a force (N); std of gains."""

    noise: float = REFERENCE_NOISE
    force_noise_N: float = FORCE_NOISE_N
    gain_std: float = GAIN_STD

    @classmethod
    def of(cls, hardware: HardwareTable, gage_factor: float = METAL_FACTOR) -> Self:
        """The errors of ``[grip.hardware]``; a good amplifier's where that table has none."""
        noise, force = amplifier_noise(hardware, gage_factor), hardware.force_noise_N
        return cls(noise, force or FORCE_NOISE_N, hardware.gain_spread or GAIN_STD)


@dataclass(frozen=True)
class Instants:
    """Grips, instant by instant: readings (n, g) microstrain, forces (n, 2) N (normal, tangential),
    stick ratio (n,), and the number (n,) of the grip."""

    readings: Array
    forces: Array
    stick: Array
    grip: IntArray


def stick_error(
    problem: ContactProblem,
    face: str,
    max_approach: float,
    errors: SensorErrors | None = None,
    seed: int = 0,
) -> float:
    """RMS error of the stick ratio on other grips, and frictions, of the same finger.

    problem: a finger and an object, with the gages that are sampled; max_approach: mm, of the
    grips. Raises SolverError where the finger has no gages, or too few grips make contact.
    """
    found = instants(problem, face, max_approach, seed)
    calibration = normal_calibration(problem, face, max_approach, _CALIBRATION_POINTS)
    return sampled_error(found, calibration, errors or SensorErrors(), seed)


def instants(problem: ContactProblem, face: str, max_approach: float, seed: int = 0) -> Instants:
    """Make the grips of a seed, without noise, each with its own friction."""
    if not len(problem.model.gage_x):
        raise SolverError("no gages: nothing depends on the stick ratio")
    rng = np.random.default_rng([seed, 0])
    # A Latin hypercube distributes few grips over frictions, loads and ways of pulling.
    shares = (rng.permuted(np.tile(np.arange(GRIPS), (4, 1)), axis=1) + 0.5) / GRIPS
    least, most = np.log(FRICTIONS)
    rows = []
    for number, (friction, *way) in enumerate(shares.T):
        other = problem.with_friction(float(np.exp(least + friction * (most - least))))
        rows += [(*row, number) for row in _grip(other, face, max_approach, *way)]
    if len({row[3] for row in rows}) < FOLDS:
        raise SolverError(f"only {len(rows)} instants of contact: too few to learn from")
    readings, forces, stick, grip = (np.array(column) for column in zip(*rows, strict=True))
    return Instants(readings, forces, stick, grip)


def sampled_error(
    found: Instants, calibration: NormalCalibration, errors: SensorErrors, seed: int = 0
) -> float:
    """Sample the grips; the error by cross-validation: each grip is tested with a learner that was
    trained on others. calibration: readings of a pure approach, the zero of the features."""
    rng = np.random.default_rng([seed, 2])
    sampled = [_features(found, calibration, errors, rng) for _ in range(_REPLICATES)]
    inputs = np.concatenate(sampled)
    truths = np.tile(found.stick, _REPLICATES)
    fold = np.tile(found.grip % FOLDS, _REPLICATES)
    weight = rng.standard_normal((inputs.shape[1], _SUMS)) * _GAIN / np.sqrt(inputs.shape[1])
    edge = rng.uniform(-_EDGE, _EDGE, _SUMS)
    off = np.concatenate([_off(inputs, truths, fold == k, weight, edge) for k in range(FOLDS)])
    return float(np.sqrt((off**2).mean()))


def _off(inputs: Array, truths: Array, tested: BoolArray, weight: Array, edge: Array) -> Array:
    """Errors on the tested rows of a learner that was trained on the others."""
    training = inputs[~tested]
    center, scale = training.mean(axis=0), np.maximum(training.std(axis=0), 1e-9)
    rows = np.clip((inputs - center) / scale, -_OUTLIER, _OUTLIER)
    sums = np.hstack([rows, np.maximum(rows @ weight + edge, 0.0), np.ones((len(rows), 1))])
    known = sums[~tested]
    gram = known.T @ known / len(known)
    gram[np.diag_indices_from(gram)] += _RIDGE
    answer = np.linalg.solve(gram, known.T @ truths[~tested] / len(known))
    return np.asarray(np.clip(sums[tested] @ answer, 0.0, 1.0) - truths[tested])


def _features(
    found: Instants, calibration: NormalCalibration, errors: SensorErrors, rng: np.random.Generator
) -> Array:
    """Features (n, g + 2) as a rig has them: readings beyond those of pressing alone, per normal
    force; the ratio of the forces; the logarithm of the normal force."""
    n, g = found.readings.shape
    gains = 1.0 + errors.gain_std * rng.standard_normal((int(found.grip.max()) + 1, g))
    readings = gains[found.grip] * found.readings + errors.noise * rng.standard_normal((n, g))
    forces = found.forces + errors.force_noise_N * rng.standard_normal((n, 2))
    normal = np.maximum(forces[:, 0], _LEAST_FORCE_N)
    known = calibration.normal_force
    alone = np.column_stack([np.interp(normal, known, each) for each in calibration.readings.T])
    beyond = (readings - alone) / normal[:, None]
    return np.column_stack([beyond, forces[:, 1] / normal, np.log(normal)])


def _grip(
    problem: ContactProblem, face: str, max_approach: float, begin: float, end: float, climb: float
) -> Iterator[tuple[Array, tuple[float, float], float]]:
    """Readings, forces, stick ratio from the first pull on, until it slips or no answer is found.

    begin, end: 0 to 1, the depths of the first and the last pull, in any order; climb: 0 to 1, a
    grip over ``_CLIMB`` stays at the first depth.
    """
    least, most = np.log(_DEPTHS)
    low, high = (max_approach * np.exp(least + s * (most - least)) for s in sorted((begin, end)))
    if climb > _CLIMB:
        high = low
    mu = problem.friction_coefficient
    state, workspace = ContactState.untouched(problem), Workspace()
    now, shear, slope = None, 0.0, 0.0
    for k in range(1 - _PRESSES, _PULLS + 1):
        approach = low * (k + _PRESSES) / _PRESSES
        if k > 0 and now is not None:
            approach = low + (high - low) * k / _PULLS
            pressing = 1.5 * now.normal_force / low
            target = _PULL_END * k / _PULLS * mu * now.normal_force
            way = (target - now.tangential_force) / max(slope, 0.2 * pressing)
            shear += max(way, 1e-3 * low)
        try:
            increment = solve_increment(
                problem, state, Motion(approach, shear), workspace, try_slow_methods=False
            )
        except SolverError:  # The earlier instants are valid, also where the candidates end.
            return
        before, moved = now, shear - state.motion.shear
        now, state = measure(problem, increment), increment.state
        if k <= 0 or before is None:
            continue
        slope = (now.tangential_force - before.tangential_force) / moved
        if now.stick_ratio is None:
            return
        forces = now.normal_force, now.tangential_force
        yield gage_readings(now.gages, face), forces, now.stick_ratio
        if now.stick_ratio < _SLIPPED:
            return
