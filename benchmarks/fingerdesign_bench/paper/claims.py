"""The paper's words (templates/claims.txt.j2), one by one, next to what was measured: do they hold?

A verdict is "yes", "partly" or "no" by the bounds that stand here.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fingerdesign.contact.measures import COMPLETE_SLIP
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.schema import Design
from fingerdesign.records.arrays import ContactHistory, SlipStudy
from fingerdesign.records.result import IncrementResult
from fingerdesign.report.page import paragraphs
from fingerdesign_bench.paper.lifts import ROUTE_FRICTION, Lift, Route
from fingerdesign_bench.paper.measurement import MEASURED_FRICTIONS, SAMPLE_NOISE, Rig, noise_of
from fingerdesign_bench.paper.rectangles import Rectangles

TEMPLATES = Path(__file__).parent / "templates"

Verdict = Literal["yes", "partly", "no"]
Numbers = dict[str, float | None]
Measured = tuple[dict[str, Any], Verdict, Numbers]  # what the template says, and is judged by

# The figures that make a claim, in the paper's order.
CLAIMS = ("fig02", "fig03", "fig07", "fig08", "fig10", "fig12")
HUMAN_MARGIN = (1.2, 1.5)  # the paper's section 2.1, after Johansson
SAFE_MARGIN = 2.5  # above it the rule squeezes: a fixed force would do as well
TURNED_APART = 2.0  # change of shear angle under stick over that under slip
SHAPE_APART = 1.5  # the same of the whole shear angle
RANK, RANK_PARTLY = 0.95, 0.8  # Spearman's.


@dataclass(frozen=True)
class Claim:
    """figure: the key of the figure that shows it; where: the paper's section; words: the paper's.

    measured: what came out here; why: ours differ, or what they rest on; numbers: by name, None
    where one is not defined.
    """

    figure: str
    title: str
    where: str
    words: str
    measured: str
    verdict: Verdict
    why: str
    numbers: Numbers = field(default_factory=dict)


@dataclass(frozen=True)
class Remade:
    """All that the figures show.

    increments, contact: the eight steps (Figs 6, 7). studies: a slip study a friction coefficient,
    the eight steps with the shear in proportion (Fig. 8). route, lifts: Figs 2 and 10. rigs:
    Fig. 12, the design, and the same with plates of polyimide read on both faces.
    """

    design: Design
    dofs: int
    friction: float
    increments: tuple[IncrementResult, ...]
    contact: ContactHistory
    rectangles: Rectangles
    studies: tuple[SlipStudy, ...]
    lifts: tuple[Lift, ...]
    route: Route
    rigs: tuple[Rig, ...]
    seconds: float
    claims: tuple[Claim, ...] = field(default=())


def claims_of(found: Remade) -> tuple[Claim, ...]:
    """All claims, in the order of the paper's figures."""
    claims = []
    measures = (_target, _rhomboids, _eight_steps, _area, _lifts, _measurement)
    for key, measure in zip(CLAIMS, measures, strict=True):
        values, verdict, numbers = measure(found)
        title, where, words, why, measured = paragraphs(TEMPLATES / "claims.txt.j2", key, **values)
        finite = {
            name: None if value is None or not np.isfinite(value) else float(value)
            for name, value in numbers.items()
        }
        claims.append(Claim(key, title, where, words, measured, verdict, why, finite))
    return tuple(claims)


def graded(value: float, full: float, part: float) -> Verdict:
    """From ``full`` on "yes", from ``part`` on "partly"; NaN is "no".

    >>> graded(0.96, 0.95, 0.9), graded(0.92, 0.95, 0.9), graded(float("nan"), 0.95, 0.9)
    ('yes', 'partly', 'no')
    """
    return "yes" if value >= full else "partly" if value >= part else "no"


def _all_or_some(*holds: bool) -> Verdict:
    return "yes" if all(holds) else "partly" if any(holds) else "no"


def _route_lift(found: Remade) -> Lift:
    return next(each for each in found.lifts if each.friction == ROUTE_FRICTION)


def _target(found: Remade) -> Measured:
    lift = _route_lift(found)
    result = lift.ruled.result
    margin = result.safety_margin
    least = weight_per_finger(result.object_mass_g) / ROUTE_FRICTION
    peak = float(found.route.forces[0].max()) / least
    verdict: Verdict = "no"
    if margin is not None and margin <= SAFE_MARGIN:
        verdict = "yes" if HUMAN_MARGIN[0] <= margin <= HUMAN_MARGIN[1] else "partly"
    values = {"friction": ROUTE_FRICTION, "result": result, "peak": peak}
    values["slips"] = lift.free.result.gross_slip
    return values, verdict, {"margin": margin, "squeeze": peak}


def _rhomboids(found: Remade) -> Measured:
    numbers: Numbers = {
        f"{state}_{status}_deg": found.rectangles.mean(state, status)
        for state in ("added", "change")
        for status in ("stick", "slip")
    }
    angles = [float(each or 0.0) for each in numbers.values()]
    whole, change = angles[:2], angles[2:]
    apart = (whole[0] > SHAPE_APART * whole[1], change[0] > TURNED_APART * change[1])
    return {"whole": whole, "change": change}, _all_or_some(*apart), numbers


def _eight_steps(found: Remade) -> Measured:
    rows = found.increments
    width = np.array([row.contact_width_mm for row in rows])
    ratio = np.array([row.stick_ratio or 0.0 for row in rows])
    shear = np.array([row.tangential_force_N for row in rows])
    stick = width * ratio
    largest = int(np.argmax(stick)) + 1
    bound = COMPLETE_SLIP[2]
    falls = bool((np.diff(stick[largest - 1 :]) < 0.0).all() and (np.diff(shear) > 0.0).all())
    ends = bool(ratio[-1] < bound and (ratio[:-1] >= bound).all())
    numbers: Numbers = {"largest_at_step": float(largest), "last_stick_ratio": float(ratio[-1])}
    values = {"width": width, "stick": stick, "shear": shear, "largest": largest, "falls": falls}
    values |= {"normal": max(row.normal_force_N for row in rows), "last": ratio[-1]}
    return values, _all_or_some(largest == 3, falls, ends), numbers


def _area(found: Remade) -> Measured:
    study = next(s for s in found.studies if s.friction_coefficient == found.friction)
    rank, raw = (
        float("nan") if value is None else value
        for value in (study.rank_correlation, study.rank_correlation_raw)
    )
    numbers: Numbers = {"rank": rank, "threshold": study.threshold}
    at = int(np.argmax(study.gage_area_mm)) + 1
    share = found.design.gages.area_share
    values = {**numbers, "friction": found.friction, "raw": raw, "at": at, "share": share}
    return values, graded(rank, RANK, RANK_PARTLY), numbers


def _lifts(found: Remade) -> Measured:
    results = [lift.ruled.result for lift in found.lifts]
    slipped = [r.friction_coefficient for r in results if r.gross_slip]
    waiting = [r.friction_coefficient for r in results if not r.lifted and not r.gross_slip]
    trace = _route_lift(found).ruled.trace
    values = {
        "friction": ROUTE_FRICTION,
        "frictions": [r.friction_coefficient for r in results],
        "slipped": slipped,
        "waiting": waiting,
        "margins": [r.safety_margin for r in results if r.safety_margin is not None],
        "unruled": sum(lift.free.result.gross_slip for lift in found.lifts),
        "held": trace.normal_force[np.maximum(trace.hold_starts - 1, 0)].tolist(),
    }
    numbers: Numbers = {f"margin_mu_{r.friction_coefficient:g}": r.safety_margin for r in results}
    good = len(results) - len(slipped) - len(waiting)
    return values, _all_or_some(good == len(results), 2 * good > len(results)), numbers


def _measurement(found: Remade) -> Measured:
    own = found.rigs[0]
    noisy = own.levels[-1]
    grips = own.at(noisy)
    ratio = own.force_ratio(noisy)
    least = [(rig.least_samples or (None,))[-1] for rig in found.rigs]
    noise = noise_of(least[0]) if own.least_samples else None
    numbers: Numbers = {"largest_noise": noise, "force_ratio_most_noise": ratio}
    whole = noise is not None and noise >= SAMPLE_NOISE
    any_works = any(rig.least_samples[1:] for rig in found.rigs)
    values = {
        "frictions": MEASURED_FRICTIONS,
        "rigs": [(rig, n, noise_of(n)) for rig, n in zip(found.rigs, least, strict=True)],
        "most": noise_of(noisy),
        "own": own,
        "slips": sum(each.ended == "slipped" for each in grips),
        "grips": len(grips),
        "ratio": ratio,
    }
    return values, "yes" if whole else "partly" if any_works else "no", numbers
