"""Figure 8 and its claim: does one relation of gage area and stick area serve every friction?

The gage area A is where the change of strain per change of tangential force exceeds a threshold
(analysis/slip_study.py). The paper says of its relation with the stick area that it "was almost the
same for all cases" of friction (3.1). Measured here, on each of the paths of paper/case.py:

- the rank correlation of A with the stick area, at each friction and over all of them at once;
- the spread over the frictions of the stick length at equal A, after the largest stick length (in a
  grip this is where A decides);
- the error of the stick length that is estimated from A by a rising relation learnt at the *other*
  frictions, beside that of a relation learnt at its own: what not knowing the friction costs.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.analysis.slip_study import (
    FORCE_FLOOR_N,
    FORCE_FLOOR_SHARE,
    full_stick_threshold,
    normal_calibration,
    rank_correlation,
    slip_study,
)
from fingerdesign.arrays import Array
from fingerdesign_bench.paper.case import FRICTIONS, PIECES, follow_rows, path_rows

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.control.signals import NormalCalibration
    from fingerdesign_bench.paper.case import PaperCase


_REACH = 1.05  # of the largest approach: friction changes F_n a little
_SPREAD_AT = 25  # values of A at which the spread is taken


@dataclass(frozen=True)
class Bench:
    """What all studies share: calibration, threshold (microstrain/N), and the floor (N) of an
    increment of a row cut into PIECES."""

    calibration: NormalCalibration
    threshold: float
    floor: float


@dataclass(frozen=True)
class Relation:
    """Gage area A and stick length on one path; friction, area, stick (n,), mm, pooled.

    rank (f,), pooled_rank: Spearman's. spread_mm, spread_median_mm: the largest and the median
    over A of the range of stick lengths at equal A, NaN where no A is common to all. own_share,
    other_share: error of the stick length estimated from A by the relation of its own friction, and
    by that of all others, RMS over the frictions, of the largest length; before_share: as
    other_share, complete slip left out.
    """

    path: str
    frictions: tuple[float, ...]
    friction: Array
    area: Array
    stick: Array
    rank: Array
    pooled_rank: float
    spread_mm: float
    spread_median_mm: float
    own_share: float
    other_share: float
    before_share: float

    @property
    def largest_mm(self) -> float:
        """The largest stick length of all."""
        return float(self.stick.max())


def make_bench(case: PaperCase) -> Bench:
    """Calibration and threshold at the scene's friction, as a rig would find them once."""
    problem, face = case.finger, case.face
    calibration = normal_calibration(problem, face, _REACH * case.approach)
    limit = case.friction * float(calibration.normal_force[-1])
    floor = min(FORCE_FLOOR_N, FORCE_FLOOR_SHARE * limit)
    threshold = full_stick_threshold(problem, face, case.approach, case.design.gages.area_share)
    return Bench(calibration, threshold, floor / PIECES)


def relation(
    case: PaperCase, bench: Bench, path: str, frictions: Sequence[float] = FRICTIONS
) -> Relation:
    """A against the stick length on one of the paths, at two friction coefficients or more."""
    areas, sticks = [], []
    for friction in frictions:
        problem, rows = case.finger.with_friction(friction), path_rows(case, path, friction)
        rows = rows[: sum(1 for _ in follow_rows(problem, rows))]  # up to complete slip
        given = (bench.threshold, bench.floor, bench.calibration)
        study = slip_study(problem, rows, case.face, case.gage_x, *given)
        # The increments whose change of F_t says something.
        used = np.isfinite(study.response).all(axis=1) & np.isfinite(study.stick_ratio)
        areas.append(study.gage_area_mm[used])
        sticks.append(study.stick_length_mm[used])
    ranks = [_or_nan(rank_correlation(*each)) for each in zip(areas, sticks, strict=True)]
    label = np.repeat(frictions, [len(area) for area in areas])
    area, stick = np.concatenate(areas), np.concatenate(sticks)
    spread = spread_at_equal_area(areas, sticks)
    loaded = stick > 0.0
    _, before = relation_errors(label[loaded], area[loaded], stick[loaded])
    errors = (*relation_errors(label, area, stick), before)
    return Relation(
        path,
        tuple(frictions),
        label,
        area,
        stick,
        np.array(ranks),
        _or_nan(rank_correlation(area, stick)),
        float(spread.max()) if len(spread) else float("nan"),
        float(np.median(spread)) if len(spread) else float("nan"),
        *(_rms(each) / float(stick.max()) for each in errors),
    )


def spread_at_equal_area(areas: Sequence[Array], sticks: Sequence[Array]) -> Array:
    """Range over the frictions of the stick length at equal A, while both fall, mm.

    areas, sticks: one pair a friction, in the order of its increments. At values of A that all
    have; none where they have none in common.
    """
    falling = []
    for area, stick in zip(areas, sticks, strict=True):
        after = slice(int(np.argmax(stick)), None)
        # A may wobble while the stick length falls: its running minimum is a relation.
        falling.append((np.minimum.accumulate(area[after]), stick[after]))
    low = max(float(area.min()) for area, _ in falling)
    high = min(float(area.max()) for area, _ in falling)
    if high <= low:
        return np.empty(0)
    at = np.linspace(low, high, _SPREAD_AT)
    lengths = np.array([np.interp(at, area[::-1], stick[::-1]) for area, stick in falling])
    return np.asarray(np.ptp(lengths, axis=0))


def relation_errors(label: Array, area: Array, stick: Array) -> tuple[Array, Array]:
    """RMS errors (f,) by each friction's own rising relation and by that of all others, mm.

    label (n,): the friction of each (area, stick).
    """
    own, other = [], []
    for friction in np.unique(label):
        here = label == friction
        truth = stick[here]
        own.append(_rms(_rising(area[here], truth, area[here]) - truth))
        other.append(_rms(_rising(area[~here], stick[~here], area[here]) - truth))
    return np.array(own), np.array(other)


def _rising(area: Array, stick: Array, at: Array) -> Array:
    """Values ``at`` of the rising relation that fits (area, stick) best: isotonic regression."""
    from scipy.optimize import isotonic_regression

    places, inverse, count = np.unique(area, return_inverse=True, return_counts=True)
    mean = np.bincount(inverse, stick) / count
    fitted = isotonic_regression(mean, weights=count).x
    return np.asarray(np.interp(at, places, fitted))


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def _or_nan(value: float | None) -> float:
    return float("nan") if value is None else value
