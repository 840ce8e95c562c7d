"""The paper's words (paper_words.py), one by one, beside what was measured, and whether they hold.

A verdict is "yes", "partly" or "no" by the bounds that stand here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from fingerdesign.contact.measures import COMPLETE_SLIP
from fingerdesign.control.judge import weight_per_finger
from fingerdesign.study.paper_lifts import ROUTE_FRICTION
from fingerdesign.study.paper_rig import MEASURED_FRICTIONS, SAMPLE_NOISE, noise_of
from fingerdesign.study.paper_words import WORDS

if TYPE_CHECKING:
    from collections.abc import Iterable

    from fingerdesign.study.paper_places import Verdicts
    from fingerdesign.study.paper_relation import Relation
    from fingerdesign.study.paper_remade import Remade
    from fingerdesign.study.paper_rig import Rig

Verdict = Literal["yes", "partly", "no"]
Numbers = dict[str, float | None]

HUMAN_MARGIN = (1.2, 1.5)  # the paper's section 2.1, after Johansson
SAFE_MARGIN = 2.5  # above it the rule squeezes: a fixed force would do as well
TURNED_APART = 2.0  # change of shear angle under stick over that under slip
SHAPE_APART = 1.5  # the same of the whole shear angle
ALIKE, ALIKE_PARTLY = 0.95, 0.8  # Pearson's, at every step
RANK, RANK_PARTLY = 0.95, 0.9  # Spearman's
ERROR, ERROR_PARTLY = 0.05, 0.1  # of the largest stick length, by the other frictions' relation
GAIN, GAIN_PARTLY = 0.75, 0.25  # share of the constant answer's errors that a reading saves

_PATH_NAMES = {
    "similar": "shear in proportion to μ",
    "same": "one motion for all",
    "growing": "approach growing to the end",
}


@dataclass(frozen=True)
class Claim:
    """figure: the key of the figure that shows it; title, where, words, why: see paper_words.py.

    measured: what came out here; numbers: by name, None where one is not defined.
    """

    figure: str
    title: str
    where: str
    words: str
    measured: str
    verdict: Verdict
    why: str
    numbers: Numbers = field(default_factory=dict)


def claims_of(found: Remade) -> tuple[Claim, ...]:
    """All claims, in the order of the paper's figures."""
    made = {
        "fig02": _target,
        "fig03": _rhomboids,
        "fig07": _eight_steps,
        "likeness": _likeness,
        "fig08": _area,
        "fig08_relation": _relation,
        "each_gage": _each_gage,
        "fig10": _lifts,
        "fig12": _measurement,
    }
    claims = []
    for key, measure in made.items():
        measured, verdict, numbers = measure(found)
        said = WORDS[key]
        kept = {name: _finite(value) for name, value in numbers.items()}
        claims.append(
            Claim(key, said.title, said.where, said.words, measured, verdict, said.why, kept)
        )
    return tuple(claims)


def graded(value: float, full: float, part: float) -> Verdict:
    """From ``full`` on "yes", from ``part`` on "partly"; NaN is "no".

    >>> graded(0.96, 0.95, 0.9), graded(0.92, 0.95, 0.9), graded(float("nan"), 0.95, 0.9)
    ('yes', 'partly', 'no')
    """
    return "yes" if value >= full else "partly" if value >= part else "no"


def worst(verdicts: Iterable[Verdict]) -> Verdict:
    """The worst of some verdicts.

    >>> worst(["yes", "partly"])
    'partly'
    """
    order: list[Verdict] = ["no", "partly", "yes"]
    return min(verdicts, key=order.index)


def _target(found: Remade) -> tuple[str, Verdict, Numbers]:
    lift = next(each for each in found.lifts if each.friction == ROUTE_FRICTION)
    result = lift.ruled.result
    margin = result.safety_margin
    least = weight_per_finger(result.object_mass_g) / ROUTE_FRICTION
    peak = float(found.route.normal_force.max()) / least
    numbers = {"margin": margin, "squeeze": peak}
    if margin is None:
        return f"At μ = {ROUTE_FRICTION:g} the rule does not lift: {result.ending}.", "no", numbers
    other = "slips as a whole" if lift.free.result.gross_slip else "lifts as well"
    measured = (
        f"At μ = {ROUTE_FRICTION:g} and {result.object_mass_g:g} g the rule lifts at F_n = "
        f"{result.final_normal_force_N:.1f} N, {margin:.2f} times what F_t asks for; the same path "
        f"that never holds {other}; a squeeze that feels nothing takes {peak:.1f} times."
    )
    inside = HUMAN_MARGIN[0] <= margin <= HUMAN_MARGIN[1]
    return measured, "yes" if inside else "partly" if margin <= SAFE_MARGIN else "no", numbers


def _rhomboids(found: Remade) -> tuple[str, Verdict, Numbers]:
    turned = found.rectangles
    whole, change = (
        [turned.mean(state, status) for status in ("stick", "slip")]
        for state in ("added", "change")
    )
    measured = (
        f"Turned by the shear so far: {whole[0]:.2f} degrees on average under stick, "
        f"{whole[1]:.2f} under slip. In a short time after: {change[0]:.3f} under stick, "
        f"{change[1]:.3f} under slip."
    )
    by_shape = whole[0] > SHAPE_APART * whole[1]
    by_change = change[0] > TURNED_APART * change[1]
    numbers: Numbers = {
        "added_stick_deg": whole[0],
        "added_slip_deg": whole[1],
        "change_stick_deg": change[0],
        "change_slip_deg": change[1],
    }
    good = int(by_shape) + int(by_change)
    return measured, "yes" if good == 2 else "partly" if good else "no", numbers


def _eight_steps(found: Remade) -> tuple[str, Verdict, Numbers]:
    rows = found.increments
    width = np.array([row.contact_width_mm for row in rows])
    ratio = np.array([row.stick_ratio or 0.0 for row in rows])
    shear = np.array([row.tangential_force_N for row in rows])
    stick = width * ratio
    largest = int(np.argmax(stick)) + 1
    bound = COMPLETE_SLIP[2]
    falls = bool((np.diff(stick[largest - 1 :]) < 0.0).all() and (np.diff(shear) > 0.0).all())
    ends = bool(ratio[-1] < bound and (ratio[:-1] >= bound).all())
    how = "falls from there to the end" if falls else "does not fall at every step after"
    measured = (
        f"The contact grows to {width.max():.2f} mm; the stick length is largest at step {largest} "
        f"({stick.max():.2f} mm) and {how}; at step {len(rows)} the stick ratio is "
        f"{ratio[-1]:.2f}. F_n reaches {max(row.normal_force_N for row in rows):.2f} N, F_t "
        f"{shear.max():.2f} N."
    )
    good = int(largest == 3) + int(falls) + int(ends)
    numbers: Numbers = {"largest_at_step": float(largest), "last_stick_ratio": float(ratio[-1])}
    return measured, "yes" if good == 3 else "partly" if good else "no", numbers


def _likeness(found: Remade) -> tuple[str, Verdict, Numbers]:
    alike = found.likeness
    least, most = float(alike.correlation.min()), float(alike.correlation.max())
    face = [float(f(alike.upper_correlation)) for f in (np.min, np.max)]
    slope = alike.overall_slope
    measured = (
        f"Mean of both faces: correlation over the gages {least:.2f} to {most:.2f} at the steps, "
        f"of their changes from {float(alike.change_correlation.min()):.2f} on. Scale {slope:.2g}; "
        f"rubber itself is strained along 45 degrees by half of its shear, {0.5 / slope:,.0f} "
        f"times as much. One face alone: correlation {face[0]:.2f} to {face[1]:.2f}."
    )
    read = float(alike.read_correlation.min())
    if alike.face != "both":
        measured += f" This design's gages read the {alike.face} face alone: from {read:.2f}."
    numbers: Numbers = {"least": least, "read_least": read, "scale": slope}
    numbers["one_face_most"] = face[1]
    return measured, graded(read, ALIKE, ALIKE_PARTLY), numbers


def _area(found: Remade) -> tuple[str, Verdict, Numbers]:
    study = next(s for s in found.studies if s.friction_coefficient == found.friction)
    rank, raw = (
        float("nan") if value is None else value
        for value in (study.rank_correlation, study.rank_correlation_raw)
    )
    at = int(np.argmax(study.gage_area_mm)) + 1
    measured = (
        f"At μ = {found.friction:g} the two have a rank correlation of {_number(rank)} over the "
        f"steps ({_number(raw)} where the normal force's part is not taken out); the gage area is "
        f"largest at step {at}. Threshold: {study.threshold:.3g} microstrain/N, half of the "
        "largest response at full stick."
    )
    return measured, graded(rank, RANK, ALIKE_PARTLY), {"rank": rank, "threshold": study.threshold}


def _relation(found: Remade) -> tuple[str, Verdict, Numbers]:
    each = found.relations
    first, last = each[0].frictions[0], each[0].frictions[-1]
    words = "; ".join(_relation_words(one) for one in each)
    measured = f"μ = {first:g} to {last:g} on one model. {words[0].upper()}{words[1:]}."
    numbers: Numbers = {f"{one.path}_error": one.other_share for one in each}
    numbers |= {f"{one.path}_rank": one.pooled_rank for one in each}
    verdict = worst(
        grade
        for one in each
        for grade in (
            graded(one.pooled_rank, RANK, RANK_PARTLY),
            graded(-one.other_share, -ERROR, -ERROR_PARTLY),
        )
    )
    return measured, verdict, numbers


def _relation_words(one: Relation) -> str:
    spread = (
        f"stick lengths at equal A within {one.spread_mm:.2f} mm (median "
        f"{one.spread_median_mm:.2f}) of {one.largest_mm:.1f}"
        if np.isfinite(one.spread_mm)
        else "no A common to all"
    )
    return (
        f"{_PATH_NAMES[one.path]}: rank correlation {_number(one.pooled_rank, 3)}, {spread}, "
        f"error {100 * one.other_share:.1f} % ({100 * one.own_share:.1f} %), "
        f"before complete slip {100 * one.before_share:.1f} %"
    )


def _each_gage(found: Remade) -> tuple[str, Verdict, Numbers]:
    gages = found.places[0].reading
    every, under = (_verdicts(found, gages, touching) for touching in (False, True))
    rubber = [each for each in found.places if each.reading.startswith("rubber,")]
    skin = min(each.depth_mm for each in rubber)
    shallow = " and ".join(_right(each) for each in rubber if each.depth_mm == skin)
    measured = (
        f"One threshold for all gages, chosen at other frictions, is right in {_right(every)} for "
        f"always giving the commoner answer; of the gages under the contact in {_right(under)} "
        f"(area under the ROC curve {_number(under.auc)}). Shear strain of rubber {skin:g} mm "
        f"under the surface: {shallow}; gages lie {every.depth_mm:.2f} mm deep."
    )
    numbers: Numbers = {
        "all_right": every.right,
        "all_constant": every.constant,
        "contact_right": under.right,
        "contact_constant": under.constant,
        "contact_auc": under.auc,
    }
    grades = [graded(each.gain, GAIN, GAIN_PARTLY) for each in (every, under)]
    verdict: Verdict = "partly" if "no" in grades and len(set(grades)) > 1 else worst(grades)
    return measured, verdict, numbers


def _verdicts(found: Remade, reading: str, touching: bool) -> Verdicts:
    return next(v for v in found.places if v.reading == reading and v.touching == touching)


def _right(each: Verdicts) -> str:
    return f"{100 * each.right:.0f} % against {100 * each.constant:.0f} %"


def _lifts(found: Remade) -> tuple[str, Verdict, Numbers]:
    results = [lift.ruled.result for lift in found.lifts]
    slipped = [r.friction_coefficient for r in results if r.gross_slip]
    waiting = [r.friction_coefficient for r in results if not r.lifted and not r.gross_slip]
    margins = [r.safety_margin for r in results if r.safety_margin is not None]
    unruled = sum(lift.free.result.gross_slip for lift in found.lifts)
    trace = next(lift.ruled.trace for lift in found.lifts if lift.friction == ROUTE_FRICTION)
    begins = np.flatnonzero(np.diff(trace.hold.astype(int), prepend=0) == 1).tolist()
    held = ", ".join(f"{trace.normal_force[max(k - 1, 0)]:.1f}" for k in begins)
    parts = [
        f"complete slip at μ = {_listed(slipped)}" if slipped else "no complete slip",
        f"not lifted at μ = {_listed(waiting)}" if waiting else "",
        f"{min(margins):.1f} to {max(margins):.1f} times the least normal force" if margins else "",
    ]
    measured = (
        f"μ = {_listed([r.friction_coefficient for r in results])}: "
        f"{', '.join(part for part in parts if part)}. Of the same paths without the rule "
        f"{unruled} of {len(results)} slip as a whole."
    )
    if held:
        measured += f" At μ = {ROUTE_FRICTION:g} the slope is set to zero at F_n = {held} N."
    numbers: Numbers = {f"margin_mu_{r.friction_coefficient:g}": r.safety_margin for r in results}
    good = len(results) - len(slipped) - len(waiting)
    verdict: Verdict = (
        "yes" if good == len(results) else "partly" if 2 * good > len(results) else "no"
    )
    return measured, verdict, numbers


def _measurement(found: Remade) -> tuple[str, Verdict, Numbers]:
    mus = " and ".join(f"{mu:g}" for mu in MEASURED_FRICTIONS)
    measured = f"Lifted without slip at μ = {mus}, and the forces told apart: "
    measured += "; ".join(_rig_words(rig) for rig in found.rigs) + "."
    own = found.rigs[0]
    noisy = own.levels[-1]
    grips = own.at(noisy)
    slips = sum(each.outcome == "slipped" for each in grips)
    ratio = own.force_ratio(noisy)
    measured += (
        f" At the most noise tried, {noise_of(noisy):g} microstrain, {own.finger}: {slips} "
        f"of {len(grips)} grips slip, F_n at the lift is as {_number(ratio, 1)} to 1 at the two "
        f"frictions (least forces: {MEASURED_FRICTIONS[1] / MEASURED_FRICTIONS[0]:.0f} to 1)."
    )
    working = own.least_samples
    noise = noise_of(working[-1]) if working else None
    numbers: Numbers = {"largest_noise": noise, "force_ratio_most_noise": ratio}
    any_works = any(rig.least_samples[1:] for rig in found.rigs)
    whole = noise is not None and noise >= SAMPLE_NOISE
    return measured, "yes" if whole else "partly" if any_works else "no", numbers


def _rig_words(rig: Rig) -> str:
    working = rig.least_samples
    if not working:
        return f"{rig.finger}: not even without noise"
    if working[-1] is None:
        return f"{rig.finger}: without noise only"
    return (
        f"{rig.finger}: from {working[-1]:,} samples a step on ({noise_of(working[-1]):.2g} "
        f"microstrain), F_n as {rig.force_ratio(working[-1]):.1f} to 1"
    )


def _number(value: float, decimals: int = 2) -> str:
    return f"{value:.{decimals}f}" if np.isfinite(value) else "not defined"


def _finite(value: float | None) -> float | None:
    return None if value is None or not np.isfinite(value) else float(value)


def _listed(values: list[float]) -> str:
    return ", ".join(f"{value:g}" for value in values)
