"""The paper's words (paper_words.py), one by one, beside what was measured, and whether they hold.

A verdict is "yes", "partly" or "no" by the bounds that stand here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal, NamedTuple

import numpy as np

from fingerdesign.contact.measures import COMPLETE_SLIP
from fingerdesign.control.judge import weight_per_finger
from fingerdesign.paper.lifts import MEASURED_FRICTIONS, ROUTE_FRICTION, SAMPLE_NOISE, noise_of

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.paper.lifts import Lift, Rig, Route
    from fingerdesign.paper.places import Likeness, Verdicts
    from fingerdesign.paper.rectangles import Rectangles
    from fingerdesign.paper.relation import Relation
    from fingerdesign.records.arrays import ContactHistory, SlipStudy
    from fingerdesign.records.result import IncrementResult

if TYPE_CHECKING:
    from collections.abc import Iterable

    from fingerdesign.paper.lifts import Rig
    from fingerdesign.paper.places import Verdicts
    from fingerdesign.paper.relation import Relation


# What the paper says, in short, where; and why ours differs, or what it rests on.


class Words(NamedTuple):
    """title: of the claim; where: the paper's section; words: the paper's; why: ours."""

    title: str
    where: str
    words: str
    why: str


def _one_line(title: str, where: str, words: str, why: str) -> Words:
    return Words(title, where, " ".join(words.split()), " ".join(why.split()))


WORDS = {
    "fig02": _one_line(
        "The route to the target",
        "2.1",
        """Normal and tangential force grow together until the object lifts at (mg/2μ, mg/2); people
        apply 1.2 to 1.5 times the least normal force.""",
        """The rule holds once the stick area has begun to fall; each hold raises F_n by a fixed
        step, and where in such a step the weight is reached is chance. So the margin varies from
        object to object (Fig. 10); nothing in the rule aims at a margin.""",
    ),
    "fig03": _one_line(
        "Rhomboids under stick",
        "2.2, 2.3",
        """Under shear the rectangles below the sticking surface are rhomboids, those below the
        slipping surface are not; so the change of shear strain over a short time tells stick from
        slip.""",
        """The shape itself does not tell: a slipping surface still carries μ times the pressure,
        which is largest just beside the stick zone, and the rubber below is sheared by it. What
        slip ends is the growth of that shear; close to the border the neighbours' shear reaches in
        as far as a rectangle is high. So the change over a short time (2.3) tells, the shape as
        drawn (2.2) does not.""",
    ),
    "fig07": _one_line(
        "Eight steps to complete slip",
        "3.1",
        """Open area decreases with the normal force, stick area decreases as the tangential force
        grows, from both edges; at the eighth step all slips. Stick area is large around step
        three.""",
        """The paper gives no displacements: the eight steps are those of the shipped scene, made so
        that the eighth slips on the paper's finger. The edges slip a little already when pressed
        alone: rubber that is pressed wants to spread.""",
    ),
    "likeness": _one_line(
        "Plates feel what rubber would shear",
        "3.1",
        """The normal strain of the plates' gages is similar to the shear strain of a homogeneous
        finger.""",
        """Similar in shape, by no means in size: a stiff plate hardly lets itself be strained. And
        only where both faces are read: one gage on one face feels the plate bend, which tells
        nothing of the shear. The paper does not say on which face its gages are.""",
    ),
    "fig08": _one_line(
        "The gage area follows the stick area",
        "3.1",
        """The change of the area where the change of strain per tangential force exceeds 40 is
        similar to that of the stick area; both are large around step three.""",
        """The paper's 40 has no unit and belongs to gages that we do not know: were it microstrain
        per newton, they would answer far more strongly than bronze plates do here. While F_n grows
        too, its own strain must be taken out first, which the paper does not mention.""",
    ),
    "fig08_relation": _one_line(
        "One relation for every friction",
        "3.1",
        """The relation of stick area and strain change was almost the same for all friction
        coefficients: it tells the stick area independent of the friction.""",
        """The error is that of the stick length estimated from A by the relation of the other
        frictions, RMS over the largest stick length; in brackets by the friction's own. Until
        complete slip the claim holds. Where the approach grows to the end, as in a grip, it fails
        at complete slip itself: F_t then changes with F_n alone, and A, made from that change, is
        as large as with half of the contact sticking. At μ = 0.2 the edges slip already under the
        press.""",
    ),
    "each_gage": _one_line(
        "Each gage tells of the surface near it",
        "2.3",
        """When the change of the shear strain at a point reaches a certain value, the surface near
        the point sticks; if not, it slips.""",
        """It is the depth. Close under the surface the rule nearly holds; as deep as the gages are,
        under a contact of a few millimetres, each feels the traction of all the surface around it,
        and so does rubber without plates there. One gage tells whether it lies near the contact,
        hardly more; what follows the stick area is the pattern of all gages, the area A. Thinner
        cover or a wider contact would sharpen it.""",
    ),
    "fig10": _one_line(
        "Lifts at unknown friction",
        "3.2",
        """For every friction coefficient the forces are controlled without complete slip; at μ =
        0.3 the slope is set to zero at F_n = 1.5 and 4.7.""",
        """The forces at which the rule holds follow from the finger, the steps and the curve, which
        the paper does not give. Our object is heavier than the paper's largest forces would lift,
        so that low friction is a test.""",
    ),
    "fig12": _one_line(
        "The measurement",
        "4.2",
        """Measured at μ = 0.3 and 0.6: controlled without complete slip and without excessive
        normal force.""",
        """Stiff plates answer by about one microstrain per newton, a good amplifier's noise is half
        a microstrain. Noise makes A fall by chance, and the rule hold: that is mostly safe, but the
        force at the lift then tells nothing of the friction. The paper's rig worked, so its gages
        presumably answered more strongly than bronze plates of this finger do. Softer plates
        answer more: polyimide, read on both faces, is drawn beside.""",
    ),
}


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
    measured = f"Lifted without slip at μ = {mus}, and the forces distinguished: "
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


@dataclass(frozen=True)
class Remade:
    """All that the figures show.

    increments, contact: the eight steps (Figs 6, 7). studies: a slip study a friction coefficient,
    the eight steps with the shear in proportion (Fig. 8); relations: one a path, rows cut finer.
    route, lifts: Figs 2 and 10. rigs: Fig. 12, the design and, where it is not that already, the
    same with plates of polyimide read on both faces.
    """

    design: Design
    dofs: int
    friction: float
    increments: tuple[IncrementResult, ...]
    contact: ContactHistory
    rectangles: Rectangles
    likeness: Likeness
    studies: tuple[SlipStudy, ...]
    relations: tuple[Relation, ...]
    places: tuple[Verdicts, ...]
    lifts: tuple[Lift, ...]
    route: Route
    rigs: tuple[Rig, ...]
    seconds: float
    claims: tuple[Claim, ...] = field(default=())
