"""What the numbers come to, in plain words: the first thing that a reader of the report sees."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np

from fingerdesign.analysis.page.words import read_plates_text
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.result import GripResult, IncrementResult, Result
from fingerdesign.report.numbers import NOISE, cleaned, under_load

# How the object is moved, in words, and what of that the figures' words may rest on.

PATH = "scene.path."
MOST_PHASES = 6  # in one sentence; a longer path is described by its ranges
_MOTIONS = (("approach", "mm"), ("shear", "mm"), ("shear along z", "mm"), ("twist", "degrees"))
_FORCES = (("normal force", "N"), ("tangential force", "N"))
_ASIDE = 0.01  # of the normal force, and of it times the contact's width: less is the mesh's


def force_controlled(result: Result) -> bool:
    """Whether the path's rows are forces."""
    return bool(result.parameters.get(f"{PATH}control") == "force")


def motion_text(result: Result) -> str:
    """The path in a sentence or two; empty where the result does not hold it."""
    keys = result.parameters
    rows = keys.get(f"{PATH}increments_N") or keys.get(f"{PATH}increments_mm") or []
    if not rows:
        return ""
    forced = force_controlled(result)
    names = _FORCES if forced else _MOTIONS
    table = np.array([[*row, *[0.0] * (len(names) - len(row))] for row in rows], dtype=float)
    phases = _phases(table)
    if len(phases) <= MOST_PHASES:
        reported = ", ".join(_phase(columns, table[last], names) for columns, last in phases)
    else:
        reported = ", ".join(
            f"{name} from {low:g} to {high:g} {unit}"
            for (name, unit), low, high in zip(names, table.min(0), table.max(0), strict=True)
            if low or high
        )
    words = "Its forces are prescribed" if forced else "Its motion is prescribed"
    words += f": {reported or 'none'}"
    substeps = keys.get(f"{PATH}substeps") or 1
    if substeps != 1:
        words += f", each row in {substeps} equal increments"
    return f"{words}; the motions were found." if forced else f"{words}."


def model_text(result: Result) -> str:
    """How much of the finger the model holds, in a sentence; empty without a model."""
    if result.model is None:
        return ""
    if result.model.dimension == 2:
        return "The model is one section of the finger; forces are those over its whole depth."
    if result.model.symmetry:
        return "The model is the half z ≥ 0 of the finger, mirrored; forces are the whole finger's."
    return "The model is the whole finger."


def leaves_section(found: Sequence[IncrementResult]) -> bool:
    """Whether anything is moved, or pushed, out of the plane of the section."""
    if any(row.shear_z_mm or row.twist_deg for row in found):
        return True
    most = max((abs(row.normal_force_N) for row in found), default=0.0)
    width = max((row.contact_width_mm for row in found), default=0.0)
    force = max((abs(row.force_z_N) for row in found), default=0.0)
    moment = max((abs(row.twist_moment_Nmm) for row in found), default=0.0)
    return force > _ASIDE * max(most, NOISE) or moment > _ASIDE * max(most * width, NOISE)


def slip_grows_with_shear(found: Sequence[IncrementResult]) -> bool:
    """Whether the stick ratio falls from its largest to its last as the tangential force grows."""
    loaded = under_load(found)
    if len(loaded) < 2 or loaded != list(range(loaded[0], len(found))) or leaves_section(found):
        return False
    rows = [found[place] for place in loaded]
    ratio = np.array([row.stick_ratio or 0.0 for row in rows])
    force = np.abs(cleaned(row.tangential_force_N for row in rows))
    start = len(ratio) - 1 - int(ratio[::-1].argmax())  # the last of the largest
    falls = bool((np.diff(ratio[start:]) <= 0).all()) and ratio[-1] < ratio[start]
    return falls and bool((np.diff(force[start:]) >= -1e-6 * force.max()).all())


def _phases(table: np.ndarray) -> list[tuple[tuple[int, ...], int]]:
    """Stretches in which the same columns move the same way: the columns, the last row."""
    steps = np.diff(table, axis=0, prepend=np.zeros((1, table.shape[1])))
    phases: list[tuple[tuple[int, ...], int]] = []
    before: Any = None
    for number, step in enumerate(steps):
        way = tuple(np.sign(step).tolist())
        columns = tuple(np.flatnonzero(step).tolist())
        if not columns:
            continue
        if way == before:
            phases[-1] = (columns, number)
        else:
            phases.append((columns, number))
        before = way
    return phases


def _phase(columns: tuple[int, ...], row: np.ndarray, names: Sequence[tuple[str, str]]) -> str:
    return " with ".join(f"{names[c][0]} to {row[c]:g} {names[c][1]}" for c in columns)


GOOD_CORRELATION = 0.8  # the level that the project set for "the gage area follows the stick area"
UNDEFINED = "too little force or the area never changes"
NOT_JUDGED = (
    "Not judged: plates are left out (plates.model = none), so the readings that slip study and "
    "rule rest on are not a gage's."
)
HUMAN_MARGIN = (1.2, 1.5)  # Johansson and Westling 1984, as the paper quotes them (2.1)


@dataclass(frozen=True)
class Finding:
    """One question, its answer and the numbers behind it."""

    answer: Literal["yes", "no", "partly", "open"]
    question: str
    detail: str


def findings(result: Result, traces: Sequence[GripTrace] = ()) -> list[Finding]:
    """The report's verdict. What was not computed is answered "open", not left out.

    ``traces``: of the grips, where they are at hand: they tell what was lifted without the rule.
    """
    if result.status == "failed":
        return [
            Finding("no", "Did the analysis succeed?", f"It failed: {result.failure}"),
        ]
    if result.increments and not result.slip_studies and not result.grips:
        return [_touches(result)]
    found = [_follows(result), _lifts(result.grips), *_needed(result.grips, traces)]
    if result.parameters.get("plates.model") == "none":
        return [Finding("open", each.question, NOT_JUDGED) for each in found]
    return found


def _touches(result: Result) -> Finding:
    """What the contact did, where neither slip study nor grips tell more."""
    question = "Does the contact hold at the end of the path?"
    found = result.increments
    loaded = under_load(found)
    bare = not found[0].gages
    rest = (
        "The finger has no plates, so it has no gages: neither slip study nor grips."
        if bare
        else "Slip study and grips belong to a run without --scene."
    )
    if not loaded:
        return Finding("open", question, f"The object never presses on the finger. {rest}")
    row = found[loaded[-1]]
    most = max(abs(row.normal_force_N), 1e-9)
    where = "" if loaded[-1] == len(found) - 1 else ", the last under load"
    forces = f"F_n = {row.normal_force_N:.3g} N, F_t = {_plain(row.tangential_force_N, most)} N"
    if leaves_section(found):
        forces += (
            f", F_z = {_plain(row.force_z_N, most)} N, twist moment "
            f"{_plain(row.twist_moment_Nmm, most)} N mm"
        )
    ratio = row.stick_ratio or 0.0
    answer: Literal["yes", "no", "partly"] = (
        "no" if not row.stick_nodes else "partly" if row.slip_nodes else "yes"
    )
    words = {
        "yes": "all of the contact sticks",
        "partly": f"{ratio:.0%} of the contact area sticks, the rest slips",
        "no": "the contact slips completely",
    }[answer]
    detail = (
        f"At increment {loaded[-1] + 1} of {len(found)}{where}, {words}: {forces}, "
        f"{row.contact_width_mm:.3g} mm wide, peak pressure {row.peak_pressure_MPa:.3g} MPa. {rest}"
    )
    return Finding(answer, question, detail)


def _plain(value: float, scale: float) -> str:
    return f"{0.0 if abs(value) < 1e-6 * scale else value:.3g}"


def _follows(result: Result) -> Finding:
    question = "Does the gage area follow the stick area?"
    studies = result.slip_studies
    if not studies:
        rows = result.increments
        bare = bool(rows) and not rows[0].gages
        why = (
            "The finger has no plates, so it has no gages." if bare else "It was not studied here."
        )
        return Finding("open", question, why)
    defined = [s.rank_correlation for s in studies if s.rank_correlation is not None]
    good = [value for value in defined if value >= GOOD_CORRELATION]
    values = "; ".join(
        f"{_correlation(s.rank_correlation)} at μ = {s.friction_coefficient:g} "
        f"(raw {_correlation(s.rank_correlation_raw)})"
        for s in studies
    )
    answer: Literal["yes", "no", "partly", "open"] = (
        "open"
        if not defined
        else "yes"
        if len(good) == len(defined)
        else "partly"
        if good
        else "no"
    )
    where = " where it is defined" if len(defined) < len(studies) else ""
    words = {
        "yes": f"It does at every friction coefficient that was tried{where}",
        "partly": f"It does at {len(good)} of {len(defined)} friction coefficients{where}",
        "no": f"It does not at any friction coefficient that was tried{where}",
        "open": "The correlation is not defined at any friction coefficient that was tried",
    }[answer]
    why = f" Not defined: {UNDEFINED}." if where else ""
    return Finding(
        answer,
        question,
        f"{words}.{read_plates_text(result.parameters)} Rank correlation of the compensated gage "
        f"area with the stick area: "
        f"{values}.{why} At least {GOOD_CORRELATION:g} counts as following. The gage area is where "
        f"the response is over {studies[0].threshold_microstrain_per_N:.3g} microstrain/N, half of "
        "this finger's largest response at full stick.",
    )


def _lifts(grips: tuple[GripResult, ...]) -> Finding:
    question = "Is the object lifted without complete slip?"
    if not grips:
        return Finding("open", question, "No grip was run.")
    good = [grip for grip in grips if grip.lifted and not grip.gross_slip]
    bad = [
        f"μ = {grip.friction_coefficient:g}, {grip.object_mass_g:g} g "
        f"({_ended(grip)}; {grip.steps} steps)"
        for grip in grips
        if grip not in good
    ]
    margins = [grip.safety_margin for grip in good if grip.safety_margin is not None]
    words = f"{len(good)} of {len(grips)} grips lift it."
    if bad:
        words += f" Not so: {'; '.join(bad)}."
    if margins:
        low, high = min(margins), max(margins)
        span = f"{low:.2f}" if len(margins) == 1 else f"{low:.2f} to {high:.2f}"
        words += (
            f" Safety margin at lift (1: about to slip): {span}; people keep {HUMAN_MARGIN[0]:g} "
            f"to {HUMAN_MARGIN[1]:g}."
        )
    answer: Literal["yes", "no", "partly"] = "yes" if not bad else "partly" if good else "no"
    return Finding(answer, question, words)


def _needed(grips: tuple[GripResult, ...], traces: Sequence[GripTrace]) -> list[Finding]:
    """Whether the rule earned its keep: the same grip without it."""
    tried = [grip for grip in grips if grip.slips_without_rule is not None]
    if not tried:
        return []
    slipping = [grip for grip in tried if grip.slips_without_rule]
    held = [grip for grip in tried if grip.holds > 0]
    needed = [grip for grip in slipping if not grip.gross_slip and grip.holds > 0]
    vain = [grip for grip in slipping if grip.gross_slip]
    harmed = [grip for grip in tried if grip.gross_slip and not grip.slips_without_rule]
    words = (
        f"Without the rule {len(slipping)} of {len(tried)} grips slip completely"
        + (f" (μ = {_listed(slipping)})" if slipping else "")
        + f"; the rule held in {len(held)}"
        + (f" (μ = {_listed(held)})." if held else ".")
    )
    if vain:
        words += (
            f" The rule did not help at μ = {_listed(vain)}: the grip slips completely with it too."
        )
    if harmed:
        words += f" At μ = {_listed(harmed)} the grip slips completely only with the rule."
    lifting = {
        (trace.friction_coefficient, trace.object_mass_g)
        for trace in traces
        if trace.without_rule is not None and trace.without_rule.lift_step is not None
    }
    unlifted = [grip for grip in tried if not grip.lifted and not grip.slips_without_rule]
    stopped = [
        grip for grip in unlifted if (grip.friction_coefficient, grip.object_mass_g) in lifting
    ]
    unsure = [] if traces else [grip for grip in unlifted if not grip.gross_slip]
    if stopped:
        words += f" At μ = {_listed(stopped)} the rule stopped a lift that succeeds without it."
    if unsure:
        words += (
            f" At μ = {_listed(unsure)} the object is not lifted with the rule, though without it "
            "nothing slips completely."
        )
    answer: Literal["yes", "no", "partly"] = (
        "no" if not needed else "partly" if vain or harmed or stopped or unsure else "yes"
    )
    return [Finding(answer, "Was the rule needed?", words)]


def _ended(grip: GripResult) -> str:
    if grip.gross_slip:
        return "slips completely" + (" though lifted" if grip.lifted else "")
    return "not lifted"


def _listed(grips: list[GripResult]) -> str:
    return ", ".join(f"{grip.friction_coefficient:g}" for grip in grips)


def _correlation(value: float | None) -> str:
    return "not defined" if value is None else f"{value:.2f}"
