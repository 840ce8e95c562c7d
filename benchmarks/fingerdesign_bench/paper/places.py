"""Does each gage tell whether the surface near it sticks (paper 2.2 and 2.3)?

"When the change in the shear strain at one point inside the finger reaches a certain value, then
the surface near the point sticks": a classifier with one threshold. A place is the surface straight
above a gage; the score is the change of its reading per change of tangential force, rid of the
normal force's part (control/signals.py). The threshold is the one with the fewest errors at TRAIN
friction coefficients; errors are those at the others, over all paths of paper/case.py.

Asked apart: of all gages, does the surface stick above it, or does it slip or not touch at all? Of
those under the contact alone: stick or slip? And the same of the shear strain of the finger without
plates, at the gages' places and nearer to the surface.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.control.signals import NormalCalibration, Sample, gage_readings, response
from fingerdesign_bench.paper.case import (
    FRICTIONS,
    PATHS,
    above,
    follow_rows,
    path_rows,
    surface_heights,
)

if TYPE_CHECKING:
    from fingerdesign.contact.measures import Measures
    from fingerdesign.contact.problem import ContactProblem
    from fingerdesign_bench.paper.case import PaperCase


# Is a plate's normal strain like the shear strain of a homogeneous finger (paper 3.1)?
#
# The finger and its twin without plates follow the fundamental scene. At each increment the gages'
# strains (g,) are held against the twin's engineering shear strain at the same places (g,), by
# Pearson's correlation over the places and by the slope through zero: the strain of a plate per
# shear strain of the rubber. Rubber itself, nearly incompressible and in plane strain, is strained
# along 45 degrees by half of its shear strain: a slope of 0.5. The same is asked of the increments'
# changes, on which the paper's method rests, and of a gage on the upper face alone, which feels
# bending too.


@dataclass(frozen=True)
class Likeness:
    """Plates and rubber over the scene's k increments at g places.

    x (g,) mm; membrane (k, g), upper (k, g): the mean of both faces, and the upper face,
    microstrain; shear (k, g): the twin's engineering shear strain, microstrain.
    correlation (k,): of the membrane strain with it; upper_correlation (k,); face, what the
    design's gages read, and read_correlation (k,): of that; change_correlation (k,): of the
    increments' changes.
    """

    x: Array
    membrane: Array
    upper: Array
    shear: Array
    correlation: Array
    upper_correlation: Array
    face: str
    read_correlation: Array
    change_correlation: Array

    @property
    def overall_slope(self) -> float:
        """Least squares over all increments and places."""
        return float((self.membrane * self.shear).sum() / (self.shear**2).sum())

    @property
    def overall_correlation(self) -> float:
        """Over all increments and places at once."""
        return correlation(self.membrane.ravel(), self.shear.ravel())


def likeness(case: PaperCase) -> Likeness:
    """Follow the scene with both fingers and compare."""
    plates = [step.measures.gages for step in case.steps(case.finger)]
    membrane, upper, read = (
        np.array([gage_readings(gages, face) for gages in plates])
        for face in ("both", "upper", case.face)
    )
    rubber = [step.measures.points for step in case.steps(case.twin)]
    shear = np.array([1e6 * points[: len(case.gage_x), 3] for points in rubber])
    return Likeness(
        x=case.gage_x,
        membrane=membrane,
        upper=upper,
        shear=shear,
        correlation=_each(membrane, shear),
        upper_correlation=_each(upper, shear),
        face=case.face,
        read_correlation=_each(read, shear),
        change_correlation=_each(*(np.diff(v, axis=0, prepend=0.0) for v in (membrane, shear))),
    )


def correlation(first: Array, second: Array) -> float:
    """Pearson's; NaN where one does not vary.

    >>> round(correlation(np.array([1.0, 2.0, 4.0]), np.array([-1.0, -2.0, -4.0])), 6)
    -1.0
    """
    if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return float("nan")
    return float(np.corrcoef(first, second)[0, 1])


def _each(first: Array, second: Array) -> Array:
    return np.array([correlation(a, b) for a, b in zip(first, second, strict=True)])


Reader = Callable[["Measures"], Array]

TRAIN = (0.2, 0.4, 0.6, 0.8, 1.0)
_CALIBRATION_POINTS = 16
_REACH = 1.05  # of the largest approach: friction changes F_n a little


@dataclass(frozen=True)
class Verdicts:
    """One kind of reading as a classifier, judged at the frictions that are not in TRAIN.

    reading: its name; depth_mm: of its places under the surface. threshold: microstrain/N. right:
    share of right answers; constant: share right if the more common answer were always given;
    sticking, slipping: shares right where the surface sticks, and where it does not. auc: that a
    sticking place scores higher than one that does not. by_place (g,): share right at each gage,
    NaN where it is never asked. roc (2, n): false and true positive rates over all thresholds.
    touching: places under the contact alone.
    """

    reading: str
    depth_mm: float
    touching: bool
    threshold: float
    right: float
    constant: float
    sticking: float
    slipping: float
    auc: float
    by_place: Array
    roc: Array

    @property
    def gain(self) -> float:
        """Of the errors of the constant answer, the share that the reading saves (< 0: adds)."""
        return (self.right - self.constant) / max(1.0 - self.constant, 1e-12)


@dataclass(frozen=True)
class _Samples:
    """Of one reading: score, sticks, touches (n, g) and the friction of each row."""

    score: Array
    sticks: BoolArray
    touches: BoolArray
    friction: Array


def verdicts(
    case: PaperCase, floor: float, frictions: Sequence[float] = FRICTIONS
) -> list[Verdicts]:
    """Of each kind of reading, of all places and of those under the contact.

    The gages as they are read, and a gage on the upper face alone where both are read; the shear
    strain of the finger without plates, where the gages are and at each depth. floor: N, changes of
    F_t that are too small to say anything. frictions: some of TRAIN and some others.
    """
    names = {"both": "plate, both faces", "upper": "plate, upper face"}
    names["lower"] = "plate, lower face"
    heights = surface_heights(case.design, case.gage_x)
    deep = float(np.mean(heights - case.finger.model.gage_positions[:, 1]))
    count = len(case.gage_x)

    def plate(face: str) -> Reader:
        return lambda m: gage_readings(m.gages, face)

    def rubber(block: int) -> Reader:
        return lambda m: 1e6 * m.points[block * count : (block + 1) * count, 3]

    faces = [case.face, *(["upper"] if case.face == "both" else [])]
    plates = [(names[face], deep, plate(face)) for face in faces]
    points = [("rubber, at the gages", deep, rubber(0))]
    for block, depth in enumerate(case.depths, start=1):
        points.append((f"rubber, {depth:g} mm deep", depth, rubber(block)))
    return [
        _verdicts(samples, name, depth, touching)
        for problem, kinds in ((case.finger, plates), (case.twin, points))
        for (name, depth, _), samples in zip(
            kinds,
            _samples(case, problem, [reader for *_, reader in kinds], floor, frictions),
            strict=True,
        )
        for touching in (False, True)
    ]


def _samples(
    case: PaperCase,
    problem: ContactProblem,
    readers: Sequence[Reader],
    floor: float,
    frictions: Sequence[float],
) -> list[_Samples]:
    """Scores and truths of all frictions and paths, one set a reading."""
    calibrations = _calibrations(case, problem, readers)
    scores: list[list[Array]] = [[] for _ in readers]
    sticks, touches, labels = [], [], []
    for friction in frictions:
        own = problem.with_friction(friction)
        for path in PATHS:
            before = [Sample(np.zeros(len(case.gage_x)), 0.0, 0.0) for _ in readers]
            for step in follow_rows(own, path_rows(case, path, friction)):
                m = step.measures
                now = [Sample(read(m), m.normal_force, m.tangential_force) for read in readers]
                if abs(now[0].tangential_force - before[0].tangential_force) >= floor:
                    for found, a, b, c in zip(scores, before, now, calibrations, strict=True):
                        found.append(response(a, b, c))
                    contact, stick = above(own, step, case.gage_x)
                    sticks.append(stick)
                    touches.append(contact)
                    labels.append(friction)
                before = now
    truth, contact_all = np.array(sticks), np.array(touches)
    return [_Samples(np.array(found), truth, contact_all, np.array(labels)) for found in scores]


def _calibrations(
    case: PaperCase, problem: ContactProblem, readers: Sequence[Reader]
) -> list[NormalCalibration]:
    """Readings against F_n of a pure approach, at the scene's friction."""
    steps = range(1, _CALIBRATION_POINTS + 1)
    depth = _REACH * case.approach
    rows = [(depth * k / _CALIBRATION_POINTS, 0.0) for k in steps]
    zero = np.zeros(len(case.gage_x))
    taken: list[list[Array]] = [[zero] for _ in readers]
    forces = [0.0]
    for step in follow_rows(problem, rows):
        forces.append(step.measures.normal_force)
        for values, reader in zip(taken, readers, strict=True):
            values.append(reader(step.measures))
    return [NormalCalibration(np.array(forces), np.array(values)) for values in taken]


def _verdicts(samples: _Samples, name: str, depth: float, touching: bool) -> Verdicts:
    requested = samples.touches if touching else np.ones_like(samples.touches)
    training = requested & np.isin(samples.friction, TRAIN)[:, None]
    testing = requested & ~np.isin(samples.friction, TRAIN)[:, None]
    threshold = best_threshold(samples.score[training], samples.sticks[training])
    correct = (samples.score > threshold) == samples.sticks
    truth, scores = samples.sticks[testing], samples.score[testing]
    share = _share(truth)
    requested_here = testing.sum(axis=0)
    by_place = np.where(testing, correct, False).sum(axis=0) / np.maximum(requested_here, 1)
    return Verdicts(
        reading=name,
        depth_mm=depth,
        touching=touching,
        threshold=threshold,
        right=_share(correct[testing]),
        constant=max(share, 1.0 - share),
        sticking=_share(scores[truth] > threshold),
        slipping=_share(scores[~truth] <= threshold),
        auc=area_under_curve(scores, truth),
        by_place=np.where(requested_here > 0, by_place, np.nan),
        roc=np.array(roc_curve(scores, truth)),
    )


def best_threshold(scores: Array, truth: BoolArray) -> float:
    """The threshold with the fewest errors of ``score > threshold``, midway between two scores.

    NaN without scores.

    >>> best_threshold(np.array([1.0, 2.0, 4.0, 5.0]), np.array([False, False, True, True]))
    3.0
    """
    if not len(scores):
        return float("nan")
    order = np.argsort(scores, kind="stable")
    ranked, sticks = scores[order], truth[order]
    # Errors when the k lowest are called "does not stick": sticking ones among them, and the rest.
    missed = np.concatenate([[0], np.cumsum(sticks)])
    false_alarms = int((~sticks).sum()) - np.concatenate([[0], np.cumsum(~sticks)])
    errors = missed + false_alarms
    edges = np.concatenate([[ranked[0] - 1.0], 0.5 * (ranked[1:] + ranked[:-1]), [ranked[-1] + 1]])
    apart = np.concatenate([[True], ranked[1:] > ranked[:-1], [True]])
    errors = np.where(apart, errors, len(scores) + 1)
    return float(edges[int(np.argmin(errors))])


def roc_curve(scores: Array, truth: BoolArray) -> tuple[Array, Array]:
    """False and true positive rates over all thresholds, both rising from 0 to 1."""
    order = np.argsort(-scores, kind="stable")
    hits = np.concatenate([[0.0], np.cumsum(truth[order]) / max(int(truth.sum()), 1)])
    misses = np.concatenate([[0.0], np.cumsum(~truth[order]) / max(int((~truth).sum()), 1)])
    return misses, hits


def area_under_curve(scores: Array, truth: BoolArray) -> float:
    """Area under :func:`roc_curve`; NaN where all answers are the same.

    >>> area_under_curve(np.array([1.0, 3.0, 2.0]), np.array([False, True, False]))
    1.0
    """
    if truth.all() or not truth.any():
        return float("nan")
    misses, hits = roc_curve(scores, truth)
    return float(np.trapezoid(hits, misses))


def _share(answers: BoolArray) -> float:
    return float(answers.mean()) if len(answers) else float("nan")
