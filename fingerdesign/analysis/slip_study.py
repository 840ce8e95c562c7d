"""The fundamental case: the gage area A and the true stick area (paper 3.1, Figs 6-8).

Eight increments of approach and shear end in complete slip. Each gives a response d_i of every gage
(signals.py), an area A where d_i exceeds a threshold, and the true stick area; Spearman's rank
correlation shows how well A orders the states of contact, which is all that a controller needs.

The friction coefficient changes neither the model nor, nearly, the relation: by the similarity of
partial slip (Cattaneo 1938, Mindlin 1949; Ciavarella, J. Appl. Mech. 65 (1998) 998) the same
approach with the shear in proportion to mu runs through the same stick areas. So other friction
coefficients are studied with :func:`scaled_rows`, and each ends in complete slip.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import Increment, solve_increment
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.control.signals import (
    NormalCalibration,
    Sample,
    gage_readings,
    length_over,
    line_of,
    response,
)
from fingerdesign.design.gages import AREA_SHARE
from fingerdesign.design.grip import FORCE_NOISE_N
from fingerdesign.errors import SolverError
from fingerdesign.records.arrays import SlipStudy

Rows = Sequence[tuple[float, float]]  # cumulative (approach, shear), mm

_SEEN = 3.0  # A change of F_t counts from so many standard deviations of the force cell.
# An increment whose F_t changes by less than this fraction of what its shear would cause at full
# stick is complete slip. There F_t is flat, gages go on changing, and their quotient rises without
# bound: on maeno2000 in 3-D three such increments of 32 turned 0.97 into 0.48. Eight fingers, cut
# by four and by eight: 0.05 lets one such increment in, 0.25 takes stick in some.
_RESISTS = 0.1
# Shares of the strongest response that a gage area can count from, tried next to a design's own.
# The response to F_t is known, so that each costs no increment.
_SHARES = tuple(k / 20.0 for k in range(6, 17))
# Areas are sums over nodes. Those that differ by less of their range differ by rounding alone,
# which another processor does otherwise.
_EQUAL = 1e-9
_CALIBRATION_REACH = 1.05  # of the rows' largest approach: friction changes F_n a little
# Steps of the press that calibrates; a hand records hundreds. While the finger is still pressed,
# F_t is small and straight lines between few steps cost rank: of film_tees at a friction of 0.2,
# 64 increments of the path, 0.91 with 16 steps, 0.94 with 32, 0.984 with 64, 0.982 with 128.
_PRESSES = 64


def normal_calibration(
    problem: ContactProblem, face: str, max_approach: float, points: int = _PRESSES
) -> NormalCalibration:
    """Readings against the normal force of a pure approach from touch to ``max_approach`` (mm).

    ``points`` equal steps and the unloaded start, with straight lines between them. The friction is
    the problem's: a hand calibrates once, on one object, and uses that for all others. Raises
    SolverError where an increment has no accepted answer or the normal force does not grow.
    """
    motions = [Motion(max_approach * k / points, 0.0) for k in range(1, points + 1)]
    forces, readings = [0.0], [np.zeros(len(problem.model.gage_readout) // 2)]
    for step in follow(problem, motions):
        forces.append(step.measures.normal_force)
        readings.append(gage_readings(step.measures.gages, face))
    if not (np.diff(forces) > 0.0).all():
        raise SolverError("a pure approach does not raise the normal force: no calibration")
    return NormalCalibration(np.array(forces), np.array(readings))


@dataclass(frozen=True)
class HandKnowledge:
    """Knowledge that a hand has of its finger when it makes the gage area.

    calibration  of the face that is read; the friction of the rows need not be the calibration's
    threshold    microstrain/N
    floor        N, the least change of F_t that the force cell shows
    stiffness    N/mm, of F_t to shear at full stick
    share        of the largest response at full stick that the threshold is
    """

    calibration: NormalCalibration
    threshold: float
    floor: float
    stiffness: float = 0.0
    share: float = AREA_SHARE


def full_stick_response(problem: ContactProblem, face: str, approach: float) -> Array:
    """Response (g,), microstrain/N, to a first shear at ``approach`` (mm) with no slip anywhere.

    The touching nodes of a pure approach are moved together by a little shear: linear, without
    friction in it. It is what a hand measures on a rough object. Raises SolverError without
    contact.
    """
    return np.abs(stick_response(problem, _pressed(problem, approach), face))


def stick_response(problem: ContactProblem, pressed: Increment, face: str) -> Array:
    """Change of readings (g,) per N of F_t, signed, where the touching nodes are moved together."""
    force = _stick_force(problem, pressed)
    strain = problem.model.gage_strain(force)
    return np.asarray(gage_readings(strain, face) / problem.model.total_force(force)[0])


def full_stick_stiffness(problem: ContactProblem, approach: float) -> float:
    """F_t per shear, N/mm, with no slip anywhere, as in :func:`full_stick_response`."""
    force = _stick_force(problem, _pressed(problem, approach))
    return float(problem.model.total_force(force)[0])


def _pressed(problem: ContactProblem, approach: float) -> Increment:
    pressed = solve_increment(problem, ContactState.untouched(problem), Motion(approach, 0.0))
    if not (pressed.multiplier[:, 0] > 0.0).any():
        raise SolverError(f"an approach of {approach:g} mm makes no contact: no response to shear")
    return pressed


def _stick_force(problem: ContactProblem, pressed: Increment) -> Array:
    """Nodal forces of a shear of 1 mm, N, where the touching nodes are moved together."""
    closed = np.flatnonzero(pressed.multiplier[:, 0] > 0.0)
    m, dim = problem.shape
    no_slip = np.zeros((m, dim - 1))
    change = problem.offset(Motion(0.0, 1.0), no_slip) - problem.offset(Motion(0.0, 0.0), no_slip)
    index = (closed[:, None] * dim + np.arange(dim)).reshape(-1)
    multiplier = np.zeros(m * dim)
    multiplier[index] = np.linalg.solve(
        problem.compliance[np.ix_(index, index)], -change.reshape(-1)[index]
    )
    return problem.to_global(multiplier.reshape(m, dim))


def full_stick_threshold(
    problem: ContactProblem, face: str, approach: float, share: float = AREA_SHARE
) -> float:
    """``share`` of the largest full-stick response at ``approach``, microstrain/N.

    0 for a finger without gages, whose area is 0 at any threshold.
    """
    return share * float(full_stick_response(problem, face, approach).max(initial=0.0))


def scaled_rows(rows: Rows, factor: float) -> list[tuple[float, float]]:
    """The same approach and ``factor`` times the shear: factor = mu / mu of the scene."""
    return [(approach, factor * shear) for approach, shear in rows]


def refined_rows(rows: Rows, pieces: int) -> list[tuple[float, float]]:
    """Each row, from touch on, cut into ``pieces`` equal increments.

    >>> refined_rows([(0.2, 0.0), (0.2, 0.1)], 2)
    [(0.1, 0.0), (0.2, 0.0), (0.2, 0.05), (0.2, 0.1)]
    """
    cut = []
    for (a, s), (next_a, next_s) in pairwise([(0.0, 0.0), *rows]):
        for part in range(1, pieces + 1):
            share = part / pieces
            cut.append((a + share * (next_a - a), s + share * (next_s - s)))
    return cut


def slip_studies(
    problem: ContactProblem,
    rows: Rows,
    face: str,
    friction_coefficients: Sequence[float],
    pieces: int = 1,
    share: float = AREA_SHARE,
    force_noise: float = FORCE_NOISE_N,
) -> tuple[SlipStudy, ...]:
    """The study at several friction coefficients of one model.

    rows are those of the problem's own friction coefficient, others get theirs from
    :func:`scaled_rows`. All share one calibration and one threshold, found at the problem's
    friction. ``pieces`` cuts every row finer, so that the correlation rests on more increments.
    ``share``: of the largest response at full stick, what a place must exceed to count to the gage
    area. ``force_noise``: standard deviation of one sample of the force cell, N; a response is made
    from a change of F_t of at least three of them.
    """
    most = max(approach for approach, _ in rows)
    calibration = normal_calibration(problem, face, _CALIBRATION_REACH * most)
    threshold = full_stick_threshold(problem, face, most, share)
    stiffness = full_stick_stiffness(problem, most)
    known = HandKnowledge(calibration, threshold, _SEEN * force_noise, stiffness, share)

    def study(friction: float) -> SlipStudy:
        path = refined_rows(scaled_rows(rows, friction / problem.friction_coefficient), pieces)
        return slip_study(problem.with_friction(friction), path, face, problem.model.gage_x, known)

    return tuple(map(study, friction_coefficients))


def slip_study(
    problem: ContactProblem, rows: Rows, face: str, gage_x: Array, known: HandKnowledge
) -> SlipStudy:
    """Follow ``rows`` from touch and compare the gage area with the true stick area.

    rows    cumulative (approach, shear), mm; cut finer with :func:`refined_rows`
    gage_x  (g,) plate centres, mm, in the order of the model's gages; those of rows along z (NaN)
            are left out: they tell nothing of a length along x

    A response is made over the change since the last increment whose F_t differs by the floor, as
    the paper's controller makes it. A is held where there is none and in complete slip, which a
    hand recognises by the stiffness that it knows; it is 0 before any response.

    The rank correlations are over the increments with contact, from the first that has a response
    on, and are of A with the stick *area* (in plane strain its length times the depth), not with
    the ratio. The area of an increment is where it sticks all through it: the status it ends with.
    """
    order = line_of(gage_x)
    steps = [step.measures for step in follow(problem, [Motion(*row) for row in rows])]
    samples = [
        Sample(gage_readings(s.gages, face)[order], s.normal_force, s.tangential_force)
        for s in steps
    ]
    normal, tangential = np.array([(s.normal_force, s.tangential_force) for s in samples]).T
    first = _first_samples(tangential, [row[1] for row in rows], known)
    calibration = known.calibration
    ordered = NormalCalibration(calibration.normal_force, calibration.readings[:, order])
    raw, clean = _responses(samples, first), _responses(samples, first, ordered)
    x = np.asarray(gage_x, dtype=float)[order]
    area_raw = gage_areas(x, raw, known.threshold)
    area = gage_areas(x, clean, known.threshold)
    measured = [(s.stick_area, s.contact_area, s.stick_width, s.stick_ratio) for s in steps]
    stick, contact, width, ratio = np.array(measured, dtype=float).T  # a ratio that is None is NaN
    reported = np.logical_or.accumulate([index is not None for index in first])
    used = reported & (contact > 0.0)
    steady = rank_correlation(np.flatnonzero(used).astype(float), stick[used])
    others = {each: gage_areas(x, clean, each / known.share * known.threshold) for each in _SHARES}
    return SlipStudy(
        friction_coefficient=problem.friction_coefficient,
        stick_ratio=ratio,
        stick_length_mm=width,
        gage_area_raw_mm=area_raw,
        gage_area_mm=area,
        gage_x_mm=x,
        response_raw=raw,
        response=clean,
        threshold=known.threshold,
        rank_correlation_raw=rank_correlation(area_raw[used], stick[used]),
        rank_correlation=rank_correlation(area[used], stick[used]),
        tangential_force=tangential,
        normal_force=normal,
        force_floor_N=known.floor,
        step_correlation=None if steady is None else abs(steady),
        rank_by_share=tuple(
            (share, rank_correlation(each[used], stick[used])) for share, each in others.items()
        ),
    )


def _first_samples(
    tangential: Array, shear: Sequence[float], known: HandKnowledge
) -> list[int | None]:
    """Index of the last increment before each whose F_t differs by the floor; -1: at rest.

    None without one, and in complete slip.
    """
    forces, travel = np.array([0.0, *tangential]), np.array([0.0, *shear])
    found: list[int | None] = []
    for k in range(1, len(forces)):
        far = np.flatnonzero(np.abs(forces[:k] - forces[k]) >= known.floor)
        at_full_stick = known.stiffness * abs(travel[k] - travel[k - 1])
        resists = abs(forces[k] - forces[k - 1]) >= _RESISTS * at_full_stick
        found.append(int(far[-1]) - 1 if resists and len(far) else None)
    return found


def _responses(
    samples: Sequence[Sample],
    first: Sequence[int | None],
    calibration: NormalCalibration | None = None,
) -> Array:
    """Responses (k, g) of each sample to the change since its first; NaN without one."""
    rest = Sample(np.zeros(len(samples[0].readings)), 0.0, 0.0)
    found = np.full((len(samples), len(rest.readings)), np.nan)
    for k, index in enumerate(first):
        if index is not None:
            before = samples[index] if index >= 0 else rest
            found[k] = response(before, samples[k], calibration)
    return found


def rank_correlation(first: Array, second: Array) -> float | None:
    """Spearman's rank correlation, ties given their mean rank; None where one never changes.

    >>> rank_correlation(np.array([1.0, 2.0, 3.0]), np.array([10.0, 30.0, 20.0]))
    0.5
    """
    if len(first) < 2 or np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return None
    a, b = _mean_ranks(first), _mean_ranks(second)
    a, b = a - a.mean(), b - b.mean()
    return float(a @ b / np.sqrt((a @ a) * (b @ b)))


def _mean_ranks(values: Array) -> Array:
    """Ranks from 1, values that only rounding tells apart sharing the mean of theirs."""
    order = np.argsort(values)
    jumps = np.diff(values[order]) > _EQUAL * np.ptp(values)
    group = np.empty(len(values), dtype=int)
    group[order] = np.concatenate([[0], np.cumsum(jumps)])
    count = np.bincount(group)
    return np.asarray((np.cumsum(count) - 0.5 * (count - 1))[group])


def gage_areas(x: Array, responses: Array, threshold: float) -> Array:
    """The area A (k,), mm, after each of k increments with responses (k, g); held where NaN."""
    areas, held = [], 0.0
    for values in responses:
        if np.isfinite(values).all():
            held = length_over(x, values, threshold)
        areas.append(held)
    return np.array(areas)
