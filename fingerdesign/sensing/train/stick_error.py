"""How well a finger's gages tell its stick ratio: one number, quickly, to compare designs by.

    stick_error(problem, face, max_approach, Listening(0.5), seed)       # 0.14 on `sensitive`

A few seeded grips press and pull on the condensed model, each with a friction coefficient of its
own. A small learner (ridge regression on random rectified sums of the features; Rahimi and Recht,
"Random features for large-scale kernel machines", NIPS 2007) is taught the stick ratio from gages
and forces and judged on other grips of the same finger, on frictions unknown to it. It hears one
instant, with neither the past nor the hand's moves, so it errs more than the network of
validate/gages/study.py, which takes fifty times as long. Where gages say nothing it errs by 0.23,
about the spread of the stick ratio itself.
(docs/explanation/gages.md compares the two.) Another seed moves all designs together by some
0.02; designs of one study share theirs. numpy only.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from fingerdesign.analysis.detection import REFERENCE_NOISE, amplifier_noise
from fingerdesign.analysis.slip_study import normal_calibration
from fingerdesign.arrays import Array
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.control.signals import NormalCalibration, gage_readings
from fingerdesign.design.grip import HardwareTable
from fingerdesign.errors import SolverError

FORCE_NOISE_N, GAIN_SPREAD = 0.005, 0.01  # as sensing/train/estimator.py has them
FRICTIONS = (0.15, 1.0)
GRIPS, FOLDS = 18, 9
_PRESSED = (0.07, 0.9)  # of the greatest approach, where a grip begins and ends to pull
_PRESSES, _PULLS = 2, 8
_USED = 1.05  # of the friction limit, where a grip would end to pull
_CLIMB = 0.6  # of the grips go on pressing while they pull
_HEARINGS = 8  # of each instant, each with noise of its own
_SUMS, _GAIN, _EDGE = 96, 0.7, 2.0
_RIDGE = 1e-2
_OUTLIER = 5.0  # standard deviations
_LEAST_FORCE_N = 0.02
_SLIPPED = 0.01  # stick ratio
_PRESSED_POINTS = 8


@dataclass(frozen=True)
class Listening:
    """What readings suffer: noise of a sample (microstrain), of a force (N); spread of gains."""

    noise: float = REFERENCE_NOISE
    force_noise_N: float = FORCE_NOISE_N
    gain_spread: float = GAIN_SPREAD

    @classmethod
    def of(cls, hardware: HardwareTable) -> Self:
        """As ``[grip.hardware]`` says; what it leaves perfect is that of a good amplifier."""
        return cls(
            amplifier_noise(hardware),
            hardware.force_noise_N or FORCE_NOISE_N,
            hardware.gain_spread or GAIN_SPREAD,
        )


@dataclass(frozen=True)
class Instants:
    """Grips, instant by instant: readings (n, g) microstrain, forces (n, 2) N (normal, tangential),
    stick ratio (n,), and the number (n,) of the grip."""

    readings: Array
    forces: Array
    stick: Array
    grip: NDArray[np.int64]


def stick_error(
    problem: ContactProblem,
    face: str,
    max_approach: float,
    listening: Listening | None = None,
    seed: int = 0,
) -> float:
    """RMS error of the stick ratio on other grips, and frictions, of the same finger.

    problem: a finger and an object, with the gages that are sampled; max_approach: mm, of the
    grips. Raises SolverError where the finger has no gages, or no grips worth the name are found.
    """
    found = instants(problem, face, max_approach, seed)
    calibration = normal_calibration(problem, face, max_approach, _PRESSED_POINTS)
    return sampled_error(found, calibration, listening or Listening(), seed)


def instants(problem: ContactProblem, face: str, max_approach: float, seed: int = 0) -> Instants:
    """The grips of a seed, without noise, each with a friction of its own."""
    if not len(problem.model.gage_x):
        raise SolverError("no gages: nothing tells the stick ratio")
    rng = np.random.default_rng([seed, 0])
    # A Latin hypercube: few grips, spread over frictions, loads and ways of pulling.
    shares = (rng.permuted(np.tile(np.arange(GRIPS), (4, 1)), axis=1) + 0.5) / GRIPS
    least, most = np.log(FRICTIONS)
    rows = []
    for number, (friction, *way) in enumerate(shares.T):
        other = problem.with_friction(float(np.exp(least + friction * (most - least))))
        rows += [(*row, number) for row in _grip(other, face, max_approach, *way)]
    if len({row[3] for row in rows}) < FOLDS:
        raise SolverError(f"only {len(rows)} instants of contact: nothing can be taught")
    readings, forces, stick, grip = (np.array(column) for column in zip(*rows, strict=True))
    return Instants(readings, forces, stick, grip)


def sampled_error(
    found: Instants, calibration: NormalCalibration, listening: Listening, seed: int = 0
) -> float:
    """The error on grips sampled so, by cross-validation: each grip is judged by a learner that was
    taught on others. calibration: readings of a pure approach, which features are counted from."""
    rng = np.random.default_rng([seed, 2])
    grips = np.unique(found.grip)
    sampled = [_features(found, calibration, listening, rng, grips) for _ in range(_HEARINGS)]
    inputs = np.concatenate(sampled)
    truths = np.tile(found.stick, _HEARINGS)
    fold = np.tile(found.grip % FOLDS, _HEARINGS)
    weight = rng.standard_normal((inputs.shape[1], _SUMS)) * _GAIN / np.sqrt(inputs.shape[1])
    edge = rng.uniform(-_EDGE, _EDGE, _SUMS)
    off = np.concatenate([_off(inputs, truths, fold == k, weight, edge) for k in range(FOLDS)])
    return float(np.sqrt((off**2).mean()))


def _off(
    inputs: Array, truths: Array, judged: NDArray[np.bool_], weight: Array, edge: Array
) -> Array:
    """What a learner taught on the others says wrong of the judged."""
    taught = inputs[~judged]
    center, scale = taught.mean(axis=0), np.maximum(taught.std(axis=0), 1e-9)
    rows = np.clip((inputs - center) / scale, -_OUTLIER, _OUTLIER)
    made = np.hstack([rows, np.maximum(rows @ weight + edge, 0.0), np.ones((len(rows), 1))])
    known = made[~judged]
    gram = known.T @ known / len(known)
    gram[np.diag_indices_from(gram)] += _RIDGE
    answer = np.linalg.solve(gram, known.T @ truths[~judged] / len(known))
    return np.asarray(np.clip(made[judged] @ answer, 0.0, 1.0) - truths[judged])


def _features(
    found: Instants,
    calibration: NormalCalibration,
    listening: Listening,
    rng: np.random.Generator,
    grips: NDArray[np.int64],
) -> Array:
    """Features (n, g + 2) as a rig has them: readings beyond those of pressing alone, per normal
    force; the ratio of the forces; the logarithm of the normal force."""
    n, g = found.readings.shape
    gains = np.ones((int(grips.max()) + 1, g))
    gains += listening.gain_spread * rng.standard_normal(gains.shape)
    readings = gains[found.grip] * found.readings
    readings = readings + listening.noise * rng.standard_normal((n, g))
    forces = found.forces + listening.force_noise_N * rng.standard_normal((n, 2))
    normal = np.maximum(forces[:, 0], _LEAST_FORCE_N)
    alone = np.stack(
        [np.interp(normal, calibration.normal_force, each) for each in calibration.readings.T], 1
    )
    return np.column_stack(
        [(readings - alone) / normal[:, None], forces[:, 1] / normal, np.log(normal)]
    )


def _grip(
    problem: ContactProblem,
    face: str,
    max_approach: float,
    begin: float,
    end: float,
    climb: float,
) -> Iterator[tuple[Array, tuple[float, float], float]]:
    """Readings, forces, stick ratio from the first pull on, until it slips or no answer is found.

    begin, end: 0 to 1, how deep the object is when it is first and last pulled, whichever is less
    first; climb: 0 to 1, over ``_CLIMB``: it stays at the first depth.
    """
    least, most = np.log(_PRESSED)
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
            first = 1.5 * now.normal_force / low  # N/mm: a finger's least stiffness against shear
            aim = _USED * k / _PULLS * mu * now.normal_force
            way = (aim - now.tangential_force) / max(slope, 0.2 * first)
            shear += max(way, 1e-3 * low)
        try:
            increment = solve_increment(
                problem, state, Motion(approach, shear), workspace, try_slow_methods=False
            )
        except SolverError:  # also where the candidates end; the instants before it stand
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
