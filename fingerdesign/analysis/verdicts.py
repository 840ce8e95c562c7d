"""Verdicts on a finger from the numbers of its result, and the fixes that the run worked out.

view = verdict_view(result)
[(each.sign, each.name, each.number, each.target) for each in view.verdicts]
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TypeVar

from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.stock import sheets_of
from fingerdesign.materials import MATERIALS
from fingerdesign.records.result import (
    MOST_FORCE,
    GageRemedy,
    GripResult,
    IncrementResult,
    LadderSummary,
    Measurability,
    MeasuredState,
    Result,
    SlipStudySummary,
)
from fingerdesign.records.verdict import SIGNS, Fix, Status, Verdict, VerdictView

# A rank correlation that counts as following the stick area: the project's own level.
GOOD_CORRELATION = 0.8
# A correlation must exceed that of the step index by so much: any steady change has the latter.
CLEARLY = 0.1
# Safety margins that people keep: Johansson and Westling 1984.
HUMAN_MARGIN = (1.2, 1.5)
NOT_JUDGED = "plates are left out of the model"
FIDELITY_WORDS = {"plane-strain": "plane strain", "3d": "3-D", "finite": "3-D, finite strain"}
_FORCES = {"normal_force": "F_n", "tangential_force": "F_t"}
QUANTITIES = {**_FORCES, "stick_ratio": "stick ratio", "gage": "gages"}  # of errors
_PRINTED = ("abs", "pla")  # A printer makes them, and nobody sells them as thin foil.
_LEAST_PLATE_MPA = 1e3  # Softer materials of the library are rubbers.
_LEAST_GAIN = 1.5  # A fix that gains less is not worth its line.
_RISING = 0.2  # Of the weight: a hand that pulls with more, as its steps end, is on its way.
_LISTED = 4  # More friction coefficients are shown as a range.
NONE_SEEN = "no stick change is seen"
_ON_PAGE = "design.toml"  # as a page names the design that lies next to it
_NO_FORCE = 1e-9  # N: rounding noise of a contact without load.
_COSTS = ", but "  # Before the verdict that a fix costs.
_Key = TypeVar("_Key", str, float)


def verdict_view(result: Result, design_file: str = _ON_PAGE) -> VerdictView:
    """Verdicts, fixes and warnings of a result; ``design_file``: of the design in commands."""
    verdicts = () if result.status == "failed" else tuple(_verdicts(result))
    failing = {each.name for each in verdicts if each.status in ("fail", "warning")}
    return VerdictView(
        name=result.design,
        fidelity=FIDELITY_WORDS[result.fidelity] + (" by auto" if result.ladder else ""),
        seconds=sum(result.timings_s.values()),
        verdicts=verdicts,
        fixes=tuple(_fixes(result, failing, design_file)),
        warnings=result.warnings,
        failure=result.failure,
    )


def _verdicts(result: Result) -> Iterator[Verdict]:
    if result.slip_studies or result.grips:
        judged = result.parameters.get("plates.model") != "none"
        for each in (slip_sensing(result.slip_studies), *grip_verdicts(result.grips)):
            yield each if judged else Verdict("note", each.name, f"not judged: {NOT_JUDGED}")
    elif result.increments:
        yield _contact(result.increments)
    if result.measurability is not None:
        yield _gage_signal(result.measurability)
    if result.ladder is not None and result.ladder.error_estimates:
        yield _accuracy(result.ladder)


def needed_correlation(study: SlipStudySummary) -> float:
    """The rank correlation that passes: good, and clearly better than that of the step index."""
    return max(GOOD_CORRELATION, (study.step_correlation or 0.0) + CLEARLY)


def follows(study: SlipStudySummary) -> bool:
    """True if the gage area follows the stick area, and clearly better than the step index."""
    found = study.rank_correlation
    return found is not None and found >= needed_correlation(study)


def best_area_share(studies: Sequence[SlipStudySummary]) -> tuple[float, float] | None:
    """The gages.area_share with which least rank correlation is missing at the worst friction
    coefficient, and how much is missing (0 or less: it passes); None without studies."""
    shares = [share for share, _ in studies[0].rank_by_share] if studies else []

    def missing(k: int) -> float:
        return max(needed_correlation(each) - (each.rank_by_share[k][1] or 0.0) for each in studies)

    found = min(((missing(k), share) for k, share in enumerate(shares)), default=None)
    return None if found is None else (found[1], found[0])


def slip_sensing(studies: Sequence[SlipStudySummary]) -> Verdict:
    """The rank correlation of gage area and stick area, at each friction coefficient."""
    found = [each for each in studies if each.rank_correlation is not None]
    if not found:
        return Verdict("note", "slip sensing", "not defined" if studies else "not studied")
    good = sum(map(follows, found))
    ranks = _span((each.rank_correlation or 0.0 for each in found), ".2f")
    status: Status = "pass" if good == len(found) else "fail"
    count = f"{good} of {len(found)} μ"
    return Verdict(status, "slip sensing", f"rank correlation {ranks}", _wanted(found), count)


def _wanted(found: Sequence[SlipStudySummary]) -> str:
    """The rank correlation that passes; where one has it and fails, that of time alone: the area
    changes so steadily that a clock is nearly as good a gage."""
    bad = [each for each in found if not follows(each)]
    steady = [each for each in bad if (each.rank_correlation or 0.0) >= GOOD_CORRELATION]
    if bad and steady == bad:
        return f"time alone has {max(each.step_correlation or 0.0 for each in bad):.2f}"
    return f"target {GOOD_CORRELATION:.2f}"


def lifts(grip: GripResult) -> bool:
    """True if a grip lifted its object without complete slip."""
    return grip.lifted and not grip.gross_slip


def grip_verdicts(grips: Sequence[GripResult]) -> Iterator[Verdict]:
    """The lift, and the force that it took over the least that holds the object by friction.

    That least force is in proportion to the weight: a force that is right for the heaviest of a
    range of masses may be far too much for the lightest. The worst of all grips counts.
    """
    if not grips:
        yield Verdict("note", "lifts", "no grip was run")
        return
    good = [each for each in grips if lifts(each)]
    yield _lift(grips, good)
    if good:
        force = _grip_force(good)
        lift = "lift" if len(good) == 1 else "lifts"
        some = f"of {len(good)} {lift}" if len(good) < len(grips) else ""
        yield replace(force, count=force.count or some)


def _lift(grips: Sequence[GripResult], good: Sequence[GripResult]) -> Verdict:
    masses = _span({grip.object_mass_g for grip in grips}, "g").replace(" ... ", "–")
    ranged = len({grip.object_mass_g for grip in grips}) > 1
    bad = [each for each in grips if not lifts(each)]
    found = f"friction μ {_listed({each.friction_coefficient for each in good})}"
    found = found if good else "at no friction μ"
    if ranged and good and bad:
        found = _not_lifted(bad)
    count = f"{len(good)} of {len(grips)} {'lifts' if ranged else 'μ'}"
    status: Status = "fail" if bad else "pass"
    return Verdict(status, f"lifts {masses} g", found, "no gross slip", count)


def _not_lifted(bad: Sequence[GripResult]) -> str:
    first = f"not {bad[0].object_mass_g:g} g at μ {bad[0].friction_coefficient:g}"
    return first + (f" and {len(bad) - 1} more" if bad[1:] else "")


def _grip_force(good: Sequence[GripResult]) -> Verdict:
    forces = [each.peak_ratio for each in good]
    margins = [each.safety_margin for each in good if each.safety_margin is not None]
    status: Status = "pass"
    count = ""
    if max(forces) >= MOST_FORCE:
        status, count = "fail", f"crushes{_of_range(good, _most_squeezed(good))}"
    elif margins and min(margins) < HUMAN_MARGIN[0]:
        thinnest = min(good, key=lambda each: each.safety_margin or math.inf)
        status, count = "warning", f"thin margin{_of_range(good, thinnest)}"
    margin = f"margin {min(margins):.1f}, " if margins else ""
    if status == "warning":  # Rounded, 1.16 and 1.199 would not seem to miss 1.2.
        margin = f"margin {math.floor(100.0 * min(margins)) / 100.0:.2f}, "
    found = f"{margin}peak {max(forces):.1f} x least"
    return Verdict(status, "grip force", found, f"target {HUMAN_MARGIN[0]:g}–{MOST_FORCE:g}", count)


def _most_squeezed(grips: Sequence[GripResult]) -> GripResult:
    return max(grips, key=lambda each: each.peak_ratio)


def _of_range(grips: Sequence[GripResult], grip: GripResult) -> str:
    """The mass of a grip, where several masses were lifted: " 50 g"."""
    several = len({each.object_mass_g for each in grips}) > 1
    return f" {grip.object_mass_g:g} g" if several else ""


def measures(state: MeasuredState, found: Measurability) -> bool:
    """True if the gages show the target's change of the stick ratio in one state."""
    return state.smallest_stick_change <= found.wanted_stick_change


def _gage_signal(found: Measurability) -> Verdict:
    good = sum(measures(each, found) for each in found.states)
    status: Status = "pass" if good == len(found.states) else "fail"
    smallest, target = found.smallest_stick_change, found.wanted_stick_change
    worst = max(found.states, key=lambda each: each.smallest_stick_change)
    masses = {two_digits(each.object_mass_g) for each in found.states}
    count = f"{good} of {len(found.states)} μ"
    if len(masses) > 1:
        count = f"at {two_digits(worst.object_mass_g)} g"
    if status == "fail":
        count = f"{two_digits(smallest / target)} x short"
    seen = smallest < 1.0  # The stick ratio itself is no greater.
    number = f"smallest stick change seen {two_digits(smallest)}" if seen else NONE_SEEN
    return Verdict(status, "gage signal", number, f"target ≤ {target:.2f}", count)


def _contact(rows: Sequence[IncrementResult]) -> Verdict:
    """The contact at the end of a scene's path: a fact, no requirement."""
    loaded = [row for row in rows if row.normal_force_N > _NO_FORCE]
    if not loaded:
        return Verdict("note", "contact", "the object never presses on the finger")
    row = loaded[-1]
    tangential = row.tangential_force_N if abs(row.tangential_force_N) > _NO_FORCE else 0.0
    forces = f"F_n {row.normal_force_N:.3g} N, F_t {tangential:.3g} N"
    return Verdict("note", "contact", f"{forces}, {100.0 * (row.stick_ratio or 0.0):.0f} % sticks")


def _accuracy(ladder: LadderSummary) -> Verdict:
    """The estimated error of the model that --fidelity auto chose."""
    quantity, worst = max(ladder.error_estimates.items(), key=lambda item: item[1])
    status: Status = "pass" if ladder.reached else "fail"
    number = f"within {two_digits(100.0 * worst)} % ({QUANTITIES.get(quantity, quantity)})"
    return Verdict(status, "accuracy", number, f"target {100.0 * ladder.tolerance:g} %")


def _fixes(result: Result, failing: set[str], design_file: str) -> Iterator[Fix]:
    """One fix or more for each verdict that fails, those of the design's keys first; but the search
    of a passing finger first where a fix costs another verdict."""
    keys = [*_key_fixes(result, failing, design_file)]
    here = "; the file is next to this page" if design_file == _ON_PAGE else ""
    command = f"fingerdesign optimise {design_file}{_permission(result)}"
    search = [Fix(command, f"searches one that passes{here}")] if failing else []
    costly = any(_COSTS in each.brings for each in keys)
    yield from (*search, *keys) if costly else (*keys, *search)


def _key_fixes(result: Result, failing: set[str], design_file: str) -> Iterator[Fix]:
    coulomb = not any(grip.friction_law for grip in result.grips)  # which forces are scaled by
    if coulomb and any(name.startswith("lifts") for name in failing):
        yield from _lift_fixes(result)
    elif coulomb and "grip force" in failing:
        yield from _force_fixes(result, design_file)
    if "slip sensing" in failing:
        yield from _share_fixes(result)
    if "gage signal" in failing and result.measurability is not None:
        yield from _gage_fixes(result.measurability, str(result.parameters.get("plates.material")))


def _permission(result: Result) -> str:
    """The option that commands need for a design with a controller of the user's own."""
    return " --allow-code" if ":" in str(result.parameters.get("grip.controller")) else ""


def _share_fixes(result: Result) -> Iterator[Fix]:
    share, missing = best_area_share(result.slip_studies) or (0.0, 1.0)
    if missing <= 0.0:
        yield Fix(f"gages.area_share = {share:g}", _passes("slip sensing"), "this model")


def _lift_fixes(result: Result) -> Iterator[Fix]:
    failing = [each for each in result.grips if not lifts(each)]
    slow = [each for each in failing if each.outcome == "steps" and _pulled(each) > _RISING]
    if slow:  # Both forces still rise: the time is short, not the controller wrong.
        late = max(slow, key=_steps_needed)
        at = f"lifts at μ {late.friction_coefficient:g}"
        rising = max(each.peak_ratio / _pulled(each) for each in slow)
        brings = at + _price(rising >= MOST_FORCE)
        yield Fix(f"grip.max_steps = {_steps_needed(late)}", brings, "forces that rise on")
    if other := [each for each in failing if each not in slow]:
        yield from _hold_fixes(result, other)


def _hold_fixes(result: Result, failing: Sequence[GripResult]) -> Iterator[Fix]:
    """A firm hold by one force, as deep as it needs; or less mass; each with its price."""
    needed, gentlest = _one_force(result.grips)
    crushes = needed >= gentlest.crushing_force_N
    at = f" at μ {gentlest.friction_coefficient:g}" if crushes else ""
    brings = _passes("lifts") + _price(crushes) + at
    yield Fix('grip.controller = "fixed_force"', brings, "Coulomb")
    yield Fix(f"grip.fixed_force.force_N = {needed:.3g}", "with the line above")
    travel = result.parameters.get("grip.max_approach_mm")
    deep = _approach(result.increments, needed)
    if deep and isinstance(travel, int | float) and 1.2 * deep > travel:
        yield Fix(f"grip.max_approach_mm = {1.2 * deep:.2g}", "with the line above")
    slips = max(failing, key=lambda each: each.holding_force_N)
    held = slips.peak_normal_force_N / (HUMAN_MARGIN[1] * slips.holding_force_N)
    light = slips.object_mass_g * held  # The force reached holds it.
    alike = slips.most_pull_N is None  # What comes later does not follow the first mass.
    lighter = alike and held < 1.0 and _too_light(result, light) <= _too_light(result)
    if _has_one_force(result) and lighter and (change := _masses(result.grips, heaviest=light)):
        yield Fix(change, f"lifts at μ {slips.friction_coefficient:g}", "Coulomb")


def _one_force(grips: Sequence[GripResult]) -> tuple[float, GripResult]:
    """The force, N, that holds every object by friction alone, and the grip it squeezes most.

    It has the most margin that people keep, or less where that would crush an object and the least
    margin does not. A twentieth is left to both ends, since a hand meets its target so well.
    """
    gentlest = min(grips, key=lambda each: each.holding_force_N)
    most = max(each.holding_force_N for each in grips)
    bears, least = gentlest.crushing_force_N / 1.05, 1.05 * HUMAN_MARGIN[0] * most
    needed = HUMAN_MARGIN[1] * most
    return (min(needed, bears) if bears >= least else needed), gentlest


def _too_light(result: Result, heaviest: float = math.inf) -> set[str]:
    """Verdicts that fail with objects of at most so many g, at the forces as they are.

    A light object bears less force, and its shear moves the gages less.
    """

    def grown(values: Iterable[tuple[float, float]]) -> float:
        """The greatest of values, which are of masses, with a lighter object."""
        return max((value * max(mass_g / heaviest, 1.0) for value, mass_g in values), default=0.0)

    forces = grown((each.peak_ratio, each.object_mass_g) for each in result.grips)
    found = {"grip force"} if forces >= MOST_FORCE else set[str]()
    if (seen := result.measurability) is not None:
        least = grown((each.smallest_stick_change, each.object_mass_g) for each in seen.states)
        found |= {"gage signal"} if least > seen.wanted_stick_change else set()
    return found


def _price(crushes: bool) -> str:
    """The verdict that a fix costs, where it does."""
    return f"{_COSTS}grip force {SIGNS['fail']}" if crushes else ""


def _pulled(grip: GripResult) -> float:
    """The part of the weight with which the hand pulls as its steps end."""
    return grip.final_tangential_force_N / weight_per_finger(grip.object_mass_g)


def _steps_needed(grip: GripResult) -> int:
    """Steps to the lift where F_t rises on as it did, with a fifth more."""
    return math.ceil(1.2 * grip.steps / _pulled(grip))


def _masses(grips: Sequence[GripResult], lightest: float = 0.0, heaviest: float = math.inf) -> str:
    """The key that lifts only masses between these; "" where none of the range is left."""
    own = [each.object_mass_g for each in grips]
    low = max(min(own), float(two_digits(lightest)))
    high = float(two_digits(min(max(own), heaviest)))
    if min(own) == max(own):
        mass = min(low, high)
        return f"grip.object_mass_g = {mass:g}" if mass < own[0] else ""
    return f"grip.object_mass_g = [{low:g}, {high:g}]" if low < high else ""


def _force_fixes(result: Result, design_file: str) -> Iterator[Fix]:
    good = [each for each in result.grips if lifts(each)]
    if any(each.crushed for each in good):
        yield from _light_fixes(result, good)
        command = f"fingerdesign study {design_file} --tune --out tuned{_permission(result)}"
        yield Fix(command, "tunes the grip, ≤ 40 min")
        return
    nearest = min(good, key=lambda each: each.safety_margin or math.inf)
    if nearest.safety_margin is not None:
        light = nearest.object_mass_g * nearest.safety_margin / HUMAN_MARGIN[0]
        bears = _too_light(result, light) <= _too_light(result)
        if _has_one_force(result) and bears and (change := _masses(good, heaviest=light)):
            yield Fix(change, _passes("grip force"), "Coulomb")


def _keeps_forces(result: Result) -> bool:
    """True where steps and preload do not follow the objects' masses, and forces with them."""
    return bool(result.parameters.get("grip.defaults") != "follow")


def _has_one_force(result: Result) -> bool:
    """True where the hand's force is the same for a lighter object: other rules press it less."""
    return _keeps_forces(result) and {each.controller for each in result.grips} == {"fixed_force"}


def _light_fixes(result: Result, good: Sequence[GripResult]) -> Iterator[Fix]:
    """A preload that a light object bears, and the lightest object that bears the force."""
    worst = _most_squeezed(good)
    deep = _approach(result.increments, worst.least_force_N)
    preload = result.parameters.get("grip.preload_mm")
    if deep is not None and isinstance(preload, int | float) and deep < preload:
        bears = f"{worst.object_mass_g:g} g is not crushed at first contact"
        yield Fix(f"grip.preload_mm = {two_digits(deep)}", bears)
    heavy = worst.object_mass_g * 1.1 * worst.peak_ratio / MOST_FORCE
    several = len({each.object_mass_g for each in good}) > 1
    if _keeps_forces(result) and several and (change := _masses(good, lightest=heavy)):
        yield Fix(change, _passes("grip force"), "at this force")


def _gage_fixes(found: Measurability, material: str) -> Iterator[Fix]:
    """Materials of the library or thinner plates that are enough; else each with what it gains,
    and a quieter amplifier."""
    needed = found.smallest_stick_change / found.wanted_stick_change
    changes = dict(_plate_change(each, needed, material) for each in found.remedies)
    gains = {key: gain for key, gain in changes.items() if key and gain >= _LEAST_GAIN}
    # A change that is not enough is left out next to one that is: it may cost another verdict.
    enough = {change: gain for change, gain in gains.items() if gain >= needed}
    for change, gain in (enough or gains).items():
        part = f"signal x {two_digits(gain)}; x {two_digits(needed)} needed"
        yield Fix(change, _passes("gage signal") if enough else part, "section model")
    if not enough:
        quiet = two_digits(found.noise_microstrain / needed)
        change = f"grip.hardware.gage_noise_microstrain = {quiet}"
        yield Fix(change, _passes("gage signal"), "quieter amplifier")


def _plate_change(remedy: GageRemedy, needed: float, material: str) -> tuple[str, float]:
    """A key of the plates with its value, and what it gains; "" where none helps."""
    if remedy.key.startswith("materials"):
        name, gain = _plate_material(remedy, needed)
        return (f'plates.material = "{name}"' if name else ""), gain
    sheet, gain = _sheet(remedy, needed, sheets_of(material))
    return (f"{remedy.key} = {sheet:g}" if sheet else ""), gain


def _gains(remedy: GageRemedy, values: Mapping[_Key, float]) -> dict[_Key, float]:
    """The gain of each value below the remedy's present one; none where the remedy gains nothing.

    A power law through the remedy: g = (value / x)^s, s = log(gain) / log(value / changed).
    """
    if not remedy.gain > 1.0:
        return {}
    slope = math.log(remedy.gain) / math.log(remedy.value / remedy.changed)
    return {key: (remedy.value / x) ** slope for key, x in values.items() if x < remedy.value}


def _plate_material(remedy: GageRemedy, needed: float) -> tuple[str, float]:
    """A material of the library for the plates and its gain; "" where none is softer.

    The stiffest that is enough is taken, else the softest; foils before what is printed.
    """
    moduli = {name: each.youngs_modulus_MPa for name, each in MATERIALS.items()}
    gains = _gains(remedy, {k: E for k, E in moduli.items() if E >= _LEAST_PLATE_MPA})
    if not remedy.enough:  # softer than the remedy's value the plate is rubber itself
        gains = {name: gain for name, gain in gains.items() if gain <= remedy.gain}
    suited = {name: gain for name, gain in gains.items() if gain >= needed}
    name = _nearest(suited or gains, min if suited else max)
    return name, gains.get(name, 1.0)


def _nearest(gains: Mapping[str, float], choose: Callable[..., str]) -> str:
    """The material of the least or the greatest gain, a foil where there is one; "" of none."""
    foils = [name for name in gains if name not in _PRINTED]
    return choose(foils or gains, key=gains.__getitem__, default="")


def _sheet(remedy: GageRemedy, needed: float, sold: Sequence[float]) -> tuple[float, float]:
    """A thickness for the plates that is sold, mm, and its gain; 0 where none helps.

    The thickest that is enough is taken, else the thinnest that is not below the remedy's.
    """
    gains = _gains(remedy, {each: each for each in sold})
    if suited := [each for each in gains if gains[each] >= needed]:
        return max(suited), gains[max(suited)]
    thin = min((each for each in gains if each >= remedy.changed), default=0.0)
    return thin, gains.get(thin, 1.0)


def _passes(name: str) -> str:
    return f"{name} {SIGNS['pass']}"


def _approach(rows: Sequence[IncrementResult], force: float) -> float | None:
    """The approach, mm, that presses with ``force`` N: F_n ~ approach^n through two increments."""
    pressing = {r.approach_mm: r.normal_force_N for r in rows if r.normal_force_N > _NO_FORCE}
    if len(pressing) < 2:
        return None
    (less, low), *_, (more, high) = sorted(pressing.items())
    power = math.log(high / low) / math.log(more / less) if less > 0.0 else 0.0
    return float(more * (force / high) ** (1.0 / power)) if power > 0.0 else None


def two_digits(value: float) -> str:
    """Two digits, never as a power of ten for usual sizes: "100", "0.048"."""
    return f"{float(f'{value:.2g}'):g}"


def _span(values: Iterable[float], form: str) -> str:
    """The least and the greatest: "0.71 ... 0.75"; one number where both read alike."""
    every = list(values)
    low, high = format(min(every), form), format(max(every), form)
    return low if low == high else f"{low} ... {high}"


def _listed(values: Iterable[float]) -> str:
    every = sorted(values)
    return _span(every, "g") if len(every) > _LISTED else " ".join(f"{each:g}" for each in every)
