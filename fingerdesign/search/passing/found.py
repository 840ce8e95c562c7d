"""Result of a search for a passing finger: its candidates, the best, why none passes."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from fingerdesign.analysis.detection import WANTED_STICK_CHANGE
from fingerdesign.analysis.shortfall import GAGE_SIGNAL, LIFTS, SLIP_SENSING
from fingerdesign.analysis.verdicts import GOOD_CORRELATION, NONE_SEEN, two_digits, verdict_view
from fingerdesign.design.schema import Design
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.result import Result
from fingerdesign.records.verdict import Status, Verdict, VerdictView
from fingerdesign.search.optimise.optimise import Tried
from fingerdesign.search.passing.front import Front, front_of
from fingerdesign.search.passing.hands import NO_HAND, WIDEST_STEPS, Hand, shortfall_of
from fingerdesign.search.passing.space import Space

# A hand that has half of the room between two meshes (log2(1.06), see shortfall.py) is good enough
# for a whole analysis: other fingers would take longer to try. So are gages of a round body, which
# are analysed on tetrahedra already.
SPARED = 0.04


@dataclass(frozen=True)
class Candidate:
    """A finger with its hand: the design, what its trial found, and what the whole analysis found.

    hand: NO_HAND before one was searched. result: None where the hand was not good enough for one.
    """

    design: Design
    sensed: Outcome
    hand: Hand = NO_HAND
    result: Result | None = None

    @property
    def view(self) -> VerdictView:
        """The verdicts of the whole analysis; before it, those on the gages by the trial."""
        if self.result is not None:
            return verdict_view(self.result)
        verdicts = tuple(_of_trial(self.sensed))
        name, seconds = self.design.design.name, self.sensed.seconds or 0.0
        return VerdictView(name, "trial in 3-D", seconds, verdicts)

    @property
    def failing(self) -> tuple[str, ...]:
        """Names of the verdicts that do not pass in the whole analysis."""
        if self.result is None:
            return ()
        if self.view.failure:
            return ("the analysis failed",)
        judged = [each for each in self.view.verdicts if each.status != "note"]
        if not judged:
            return ("nothing was judged",)
        return tuple(each.name for each in judged if each.status != "pass")

    @property
    def passes(self) -> bool:
        """True if the whole analysis was made and every verdict passes."""
        return self.result is not None and not self.failing


@dataclass(frozen=True)
class Found:
    """Result of the search: all trials, all candidates, the one to take (None: no finger at all).

    conflict: why none passes, in a sentence; "" where one does. castable: a mold of the best can be
    planned. unready: what keeps the best from being a sensor as cast, and what helps.
    """

    space: Space
    tried: tuple[Tried, ...]
    candidates: tuple[Candidate, ...] = ()
    best: Candidate | None = None
    conflict: str = ""
    castable: bool = True
    unready: str = ""

    @property
    def front(self) -> Front:
        """The two goals of the gages over all trials."""
        outcomes = (each.outcomes[0] for each in self.tried)
        return front_of(each for each in outcomes if each.status == "ok")

    @property
    def passes(self) -> bool:
        """True if a finger passes."""
        return self.best is not None and self.best.passes

    @property
    def given_up(self) -> str:
        """A sentence on what was given up; "" where nothing was."""
        keys = self.space.given_up
        if not keys:
            return ""
        names, options = " and ".join(keys), " ".join(f"--keep {key}" for key in keys)
        return (
            f"No finger was found that passes with your {names}, so this was given up. {options} "
            "searches further with it."
        )

    @property
    def note(self) -> str:
        """Sentences of warning; "" where the hand is steady and the finger can be cast."""
        if self.best is None or not self.passes:
            return ""
        sensitive = (
            f"The hand is sensitive: with steps up to {100.0 * (WIDEST_STEPS - 1.0):.0f} % shorter "
            "or longer, some lift of this model slips or presses too hard."
        )
        no_mold = "No mold can be planned for this finger: `fingerdesign mold` says why."
        words = ("" if self.best.hand.steady else sensitive, "" if self.castable else no_mold)
        return " ".join(filter(None, (*words, self.unready)))


class SearchStopped(KeyboardInterrupt):
    """A search was interrupted; ``found``: what it has until then."""

    def __init__(self, found: Found) -> None:
        super().__init__()
        count = len(found.tried)
        words = f"Stopped after {count} trials."
        if count:
            why = found.conflict or "Until then no goal excluded another: the search can go on."
            words += f" {why}"
        self.found = found if found.passes else replace(found, conflict=words)


def order_of(outcome: Outcome) -> tuple[float, float]:
    """Less is better: of outcomes that lack nothing, the one with the most room comes first."""
    return shortfall_of(outcome), -(outcome.metrics.get("area_correlation") or 0.0)


def _of_trial(sensed: Outcome) -> Iterator[Verdict]:
    """Verdicts on the gages by a trial's metrics; the hand is still to be searched."""
    area, change = map(sensed.metrics.get, ("area_correlation", "smallest_stick_change"))
    if area is not None:
        status: Status = "pass" if area >= GOOD_CORRELATION else "fail"
        target = f"target {GOOD_CORRELATION:.2f}"
        yield Verdict(status, SLIP_SENSING, f"rank correlation {area:.2f}", target)
    if change is not None:
        status = "pass" if change <= WANTED_STICK_CHANGE else "fail"
        target = f"target ≤ {WANTED_STICK_CHANGE:.2f}"
        number = f"smallest stick change seen {two_digits(change)}" if change < 1.0 else NONE_SEEN
        yield Verdict(status, GAGE_SIGNAL, number, target)
    yield Verdict("note", LIFTS, "hand not searched yet")


def conflicts_of(found: Found) -> Iterator[str]:
    """Goals that exclude each other over all trials, in sentences."""
    front = found.front
    if all(each.outcomes[0].status != "ok" for each in found.tried):
        yield "No trial could be analysed."
        return
    if front.trials and not front.follows:
        yield (
            f"Slip sensing fails in all {len(front.trials)} trials: the greatest rank correlation "
            f"is {max(area for area, _ in front.trials):.2f}, {GOOD_CORRELATION:g} is needed."
        )
    if front.trials and not front.responds:
        yield (
            f"The gage signal fails in all {len(front.trials)} trials: the smallest stick change "
            f"seen is {min(change for _, change in front.trials):.2g}, {WANTED_STICK_CHANGE:g} is "
            "needed."
        )
    if front.excludes:
        yield front.sentence()
    on_arc = sum(each.hand is NO_HAND for each in found.candidates)
    if on_arc:
        yield f"The gages of {on_arc} fingers are good on an arc of the section, not on the body."
    names = sorted({name for each in found.candidates for name in each.failing})
    gripped = len(found.candidates) - on_arc
    if names:
        yield f"On the finger's own mesh these verdicts fail: {', '.join(names)}."
    elif waiting := sum(each.hand.shortfall <= SPARED for each in found.candidates):
        yield f"Fingers with good gages and a good hand, not yet analysed as a whole: {waiting}."
    elif gripped:
        yield (
            f"Fingers with good gages: {gripped}. No hand that was tried lifts one of them at "
            "every friction with a force between the limits."
        )
    # With feeler a steady hand was found in 26 tries, with 0.5 microstrain of noise not in 110.
    if gripped and found.space.base.grip.hardware.gage_noise_microstrain:
        yield (
            "The hand is the paper's rule. The noise in grip.hardware can make it fire at a wrong "
            "time: take less noise, or train the regulator (`fingerdesign train`)."
        )


def castable(design: Design) -> bool:
    """True if a mold of the finger can be planned."""
    from fingerdesign.mold.plan.planning import plan_mold  # Molds are loaded where they are needed.
    from fingerdesign.mold.plan.refusals import MoldRefused

    try:
        plan_mold(design)
    except MoldRefused:
        return False
    return True


def unready(design: Design) -> str:
    """Reasons why a finger that can be cast is no sensor, as ``fingerdesign mold`` judges it, and
    lines of a design that mend it; "" where it is ready. What its leads do is left to ``mold``: two
    models more in 3-D."""
    from fingerdesign.layout.fitting import gage_fit
    from fingerdesign.mold.plan.planning import plan_mold
    from fingerdesign.mold.ready import placement_with_fixes, sensor_of

    placement = placement_with_fixes(design, plan_mold(design))
    no_effect = {"reason": None, "reading_error": 0.0}
    found = sensor_of(design, gage_fit(design), placement, no_effect)
    if found["ready"]:
        return ""
    lines = ", ".join(found["fix"])
    helps = f"add {lines}" if lines else "`fingerdesign mold` says more"
    return f"As cast it is no sensor yet: {'; '.join(found['reasons'])}. Remedy: {helps}."
