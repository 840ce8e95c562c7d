"""Distance of a finger from passing its verdicts, as numbers that a search can lower.

Each part is 0 where its verdict passes with room to spare, and grows with what is missing. The
room covers the change from one mesh to another: verdicts of a coarse swept model then hold on
tetrahedra. verdicts.py decides what passes; the limits here are its own, made stricter.
"""

import math
from collections.abc import Mapping, Sequence

from fingerdesign.analysis.verdicts import HUMAN_MARGIN, lifts, needed_correlation
from fingerdesign.records.result import MOST_FORCE, GripResult, Result, SlipStudySummary

SLIP_SENSING, GAGE_SIGNAL, LIFTS, GRIP_FORCE = "slip sensing", "gage signal", "lifts", "grip force"
# Between two meshes of one finger rank correlations differ by up to 0.07, stick changes by a
# tenth, forces of a grip by a fifteenth (feeler, swept cells and tetrahedra).
_SPARE_CORRELATION = 0.05
_SPARE_SIGNAL = 0.85
_SPARE_FORCE = 1.06
_NEVER_LIFTED = 1.0  # A grip without a lift is as bad as a grip force of twice the limit.


def shortfalls(result: Result) -> dict[str, float]:
    """Shortfall of each verdict that the result judges, by its name; 0: it passes with room.

    Slip sensing: missing rank correlation at the worst friction. Gage signal and grip force: the
    base-2 logarithm of the factor that is missing. Lifts: for each grip that fails 1 and the part
    of the force that it did not reach.
    """
    found: dict[str, float] = {}
    if result.slip_studies:
        found[SLIP_SENSING] = slip_shortfall(result.slip_studies)
    if (seen := result.measurability) is not None and seen.states:
        least = _SPARE_SIGNAL * seen.wanted_stick_change
        found[GAGE_SIGNAL] = _doublings(seen.smallest_stick_change / least)
    if result.grips:
        found |= grip_shortfalls(result.grips)
    return found


def total(parts: Mapping[str, float]) -> float | None:
    """Sum of the parts; None where nothing was judged."""
    return sum(parts.values()) if parts else None


def area_correlation(studies: Sequence[SlipStudySummary]) -> float | None:
    """Least rank correlation of gage area and stick area over the friction coefficients; one that
    is not defined, since an area never changes, counts as 0. None without studies."""
    return min((each.rank_correlation or 0.0 for each in studies), default=None)


def slip_shortfall(studies: Sequence[SlipStudySummary]) -> float:
    """Missing rank correlation, the largest over the friction coefficients."""
    spare = _SPARE_CORRELATION
    missing = (needed_correlation(s) + spare - (s.rank_correlation or 0.0) for s in studies)
    return max(0.0, *missing)


def grip_shortfalls(grips: Sequence[GripResult]) -> dict[str, float]:
    """Shortfall of the lifts, and of their forces between the least and the most."""
    failing = [each for each in grips if not lifts(each)]
    good = [each for each in grips if lifts(each)]
    missing = sum(_NEVER_LIFTED + max(0.0, 1.0 - min(each.peak_ratio, 1.0)) for each in failing)
    force = 0.0
    for each in good:
        force += _doublings(each.peak_ratio * _SPARE_FORCE / MOST_FORCE)
        if each.safety_margin is not None:
            force += _doublings(HUMAN_MARGIN[0] * _SPARE_FORCE / each.safety_margin)
    return {LIFTS: missing, GRIP_FORCE: force}


def _doublings(factor: float) -> float:
    """Base-2 logarithm of a factor above 1, else 0."""
    return math.log2(factor) if factor > 1.0 else 0.0
