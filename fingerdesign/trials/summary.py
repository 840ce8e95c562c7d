"""Many grips of a control study summed up: shares, spreads, and their warnings of slip."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace

from fingerdesign.records.base import Count, Size, closed
from fingerdesign.records.result import GripResult
from fingerdesign.records.statistics import (
    Rms,
    Share,
    Spread,
    beta_binomial_share,
    clustered_share,
    rms_of,
    share_of,
    spread_of,
)
from fingerdesign.trials.grid import Cell


@dataclass(frozen=True)
class Trial:
    """One grip of a study: its cell, the seed of its noise, and its result."""

    cell: Cell
    seed: int
    result: GripResult


def chosen_of(
    trials: Iterable[Trial], controller: str, noise: float | None = None, tugged: bool = False
) -> list[Trial]:
    """Choose a controller's grips, at one noise or at all; with or without the tug."""
    return [
        each
        for each in trials
        if each.cell.controller == controller
        and noise in (None, each.cell.noise)
        and (each.cell.tug > 0.0) == tugged
    ]


@closed
@dataclass(frozen=True)
class Foreseen:
    """Warnings of slip and reported stick ratios over many grips (control/foresight.py).

    warned: of the grips that ended in complete slip, those at whose end a warning stood; withdrawn:
    those with an earlier one alone. lead_s, lead_force_share: of standing warnings, time to
    complete slip and F_t at the warning over F_t then. falsely_alarmed: of all grips, those with a
    false warning; false_alarms: of all samples answered, those that began one (a hundred times its
    rate: per 100 steps), its interval by grips as clusters. All null where it never warns.
    stick_error: of the reported stick ratio, over all samples with F_t > 0; stick_error_of_grips:
    of each grip; null where none is reported.
    """

    warned: Share | None
    withdrawn: Count | None
    lead_s: Spread | None
    lead_force_share: Spread | None
    falsely_alarmed: Share | None
    false_alarms: Share | None
    stick_error: Rms | None
    stick_error_of_grips: Spread | None


def foreseen_of(grips: Sequence[GripResult]) -> Foreseen:
    """Sum up the warnings of these grips."""
    errors = [(each.stick_error, each.stick_error_samples) for each in grips]
    known = [(error, samples) for error, samples in errors if error is not None]
    found = Foreseen(
        warned=None,
        withdrawn=None,
        lead_s=spread_of(each.lead_s for each in grips),
        lead_force_share=spread_of(each.lead_force_share for each in grips),
        falsely_alarmed=None,
        false_alarms=None,
        stick_error=rms_of([error for error, _ in known], [samples for _, samples in known]),
        stick_error_of_grips=spread_of(error for error, _ in errors),
    )
    warning = [each for each in grips if each.false_alarms is not None]
    return _with_warnings(found, warning) if warning else found


def _with_warnings(found: Foreseen, grips: Sequence[GripResult]) -> Foreseen:
    """Add the warnings of grips whose controller may warn."""
    false = [each.false_alarms or 0 for each in grips]
    ends = [each.slip_warning for each in grips if each.slip_warning is not None]
    return replace(
        found,
        warned=share_of(ends.count("standing"), len(ends)),
        withdrawn=ends.count("withdrawn"),
        falsely_alarmed=share_of(sum(number > 0 for number in false), len(false)),
        false_alarms=clustered_share(false, [each.samples for each in grips]),
    )


@closed
@dataclass(frozen=True)
class Summary:
    """Many grips: shares of all of them, spreads (null: no grip has the value).

    fingers: drawn for them, of which success and held have their intervals; 0: the model's own, and
    the intervals are of grips. held: lifted without complete slip. dropped, crushed, not_lifted
    (though nothing slipped), failed say why others did not succeed; one that is crushed may be in
    another, too. caught: of those dropped,
    where objects have inertia, how many hung on after all. margin_at_lift, peaks, steps: of lifted
    ones; slip_distance_mm: of held ones. reaction_steps: of those tugged that answered.
    unannounced: dropped or crushed by a controller that had not reported to be unsure; null: it
    never does. unsure: of those that succeeded, how often it was as they were lifted. foreseen: its
    warnings of slip.
    """

    grips: Count
    fingers: Count
    success: Share
    held: Share
    dropped: Count
    caught: Count
    crushed: Count
    not_lifted: Count
    failed: Count
    margin_at_lift: Spread | None
    peak_ratio: Spread | None
    peak_normal_force_N: Spread | None
    minimum_stick_ratio: Spread | None
    slip_distance_mm: Spread | None
    steps: Spread | None
    answered: Share
    reaction_steps: Spread | None
    unannounced: Count | None
    unsure: Share | None
    foreseen: Foreseen


def summarise(trials: Sequence[Trial], drawn: bool = False) -> Summary:
    """Sum up these grips; the caller chooses which belong together. drawn: of drawn fingers, so
    that lifts of one finger do not count as independent."""
    fingers: dict[tuple[str, int], list[GripResult]] = {}
    for trial in trials if drawn else ():
        fingers.setdefault((trial.cell.fault, trial.cell.plant), []).append(trial.result)
    every = [each.result for each in trials]
    lifted = [each for each in every if each.lifted]
    tugged = [each.result for each in trials if each.result.lifted and each.cell.tug > 0.0]

    def count(name: str) -> int:
        return sum(bool(getattr(each, name)) for each in every)

    def share(name: str) -> Share:
        if not drawn:
            return share_of(count(name), len(every))
        own = [[getattr(each, name) for each in lifts] for lifts in fingers.values()]
        return beta_binomial_share(map(sum, own), map(len, own))

    def spread(name: str, grips: Sequence[GripResult] = every) -> Spread | None:
        return spread_of(getattr(each, name) for each in grips)

    return Summary(
        grips=len(every),
        fingers=len(fingers),
        success=share("success"),
        held=share("holds_object"),
        dropped=count("gross_slip"),
        caught=count("caught"),
        crushed=count("crushed"),
        not_lifted=sum(
            not (each.lifted or each.gross_slip or each.outcome == "failed") for each in every
        ),
        failed=sum(each.outcome == "failed" for each in every),
        margin_at_lift=spread("safety_margin"),
        peak_ratio=spread("peak_ratio", lifted),
        peak_normal_force_N=spread("peak_normal_force_N", lifted),
        minimum_stick_ratio=spread("minimum_stick_ratio"),
        slip_distance_mm=spread("slip_distance_mm", [e for e in every if e.holds_object]),
        steps=spread("steps_to_lift", lifted),
        answered=share_of(sum(each.reaction_steps is not None for each in tugged), len(tugged)),
        reaction_steps=spread("reaction_steps", tugged),
        unannounced=unannounced(every),
        unsure=unsure(every),
        foreseen=foreseen_of(every),
    )


def unannounced(grips: Sequence[GripResult]) -> int | None:
    """Grips that were dropped or crushed without a warning that the controller was unsure; None
    where it never reports to be."""
    reporting = [each for each in grips if each.unsure is not None]
    wrong = [each for each in reporting if each.crushed or each.gross_slip]
    return sum(not each.unsure for each in wrong) if reporting else None


def unsure(grips: Sequence[GripResult]) -> Share | None:
    """Share of those that succeeded at whose lift the controller was unsure."""
    well = [each for each in grips if each.success and each.unsure is not None]
    return share_of(sum(bool(each.unsure) for each in well), len(well)) if well else None


@closed
@dataclass(frozen=True)
class NoiseSummary(Summary):
    """The grips at one noise."""

    noise_microstrain: Size


@closed
@dataclass(frozen=True)
class FaultSummary(Summary):
    """The lifts with fingers of one fault; safety_margin: of those that succeeded."""

    fault: str
    safety_margin: Spread | None


def fault_summary(trials: Sequence[Trial], label: str) -> FaultSummary:
    """Sum up the lifts with fingers of one fault."""
    margins = (each.result.safety_margin for each in trials if each.result.success)
    return FaultSummary(
        **vars(summarise(trials, drawn=True)), fault=label, safety_margin=spread_of(margins)
    )
