"""What control.json and grips.csv hold: every controller's summary by noise, and every grip."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field
from typing_extensions import TypedDict

from fingerdesign.control.foresight import CLEARLY
from fingerdesign.control.metrics import MOST_FORCE, JudgedGrip
from fingerdesign.records.base import Count, Size, closed, csv_text
from fingerdesign.records.statistics import (
    Rms,
    Share,
    Spread,
    clustered_share,
    rms_of,
    share_of,
    spread_of,
)
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.bench import GOOD_AMPLIFIER, ControlGrid

if TYPE_CHECKING:
    from fingerdesign.records.arrays import GripTrace

RECORD_FILE, CSV_FILE = "control.json", "grips.csv"
BAND = (1.2, 1.5)  # times the least force: how people grip (Johansson and Westling 1984)

# Columns of grips.csv are fields of JudgedGrip, by the names of the result's grips where alike.
_FIELDS = "controller friction mass_g noise tug seed success lifted dropped crushed margin_at_lift"
_FIELDS += " peak_ratio peak_normal_force_N minimum_stick_ratio slip_distance_mm steps"
_FIELDS += " reaction_steps unsure"
FORESEEN = "slip_warning lead_s lead_force_share alarms false_alarms stick_error"
FORESEEN += " stick_error_samples samples"  # what is judged of warnings and reports
_FIELDS += f" {FORESEEN} slid_mm caught catch_s ending reason"
_NAMES = {
    "friction": "friction_coefficient",
    "mass_g": "object_mass_g",
    "noise": "noise_microstrain",
    "tug": "tug_share",
    "dropped": "gross_slip",
    "margin_at_lift": "safety_margin",
}
COLUMNS = {_NAMES.get(field, field): field for field in _FIELDS.split()}


@closed
@dataclass(frozen=True)
class Foreseen:
    """What a controller said of slip over many grips (control/foresight.py says what each is).

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


def foreseen_of(grips: Sequence[JudgedGrip]) -> Foreseen:
    """What these grips amount to."""
    false = [(each, each.false_alarms) for each in grips if each.false_alarms is not None]
    ends = [each.slip_warning for each, _ in false if each.slip_warning is not None]
    errors = [each for each in grips if each.stick_error is not None]
    return Foreseen(
        warned=share_of(ends.count("standing"), len(ends)) if false else None,
        withdrawn=ends.count("withdrawn") if false else None,
        lead_s=spread_of(each.lead_s for each in grips),
        lead_force_share=spread_of(each.lead_force_share for each in grips),
        falsely_alarmed=share_of(sum(n > 0 for _, n in false), len(false)) if false else None,
        false_alarms=clustered_share([n for _, n in false], [each.samples for each, _ in false])
        if false
        else None,
        stick_error=rms_of(
            [each.stick_error or 0.0 for each in errors],
            [each.stick_error_samples for each in errors],
        ),
        stick_error_of_grips=spread_of(each.stick_error for each in grips),
    )


@closed
@dataclass(frozen=True)
class Summary:
    """Many grips: shares of all of them, spreads (null: no grip has the value).

    held: lifted without complete slip. dropped, crushed, not_lifted, failed say why others did not
    succeed; a grip may be in more than one. caught: of those dropped, where objects have inertia,
    how many hung on after all. margin_at_lift, peaks, steps: of lifted ones;
    slip_distance_mm: of held ones. reaction_steps: of those tugged that answered. unannounced:
    dropped or crushed by a controller that had not said before that it was unsure; null: it never
    says. unsure: of those that succeeded, how often it was as they were lifted. foreseen: what it
    said of slip.
    """

    grips: Count
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


def summarise(outcomes: Sequence[JudgedGrip]) -> Summary:
    """What these grips amount to; the caller chooses which belong together."""
    lifted = [each for each in outcomes if each.lifted]
    tugged = [each for each in lifted if each.tug > 0.0]
    count = len(outcomes)
    return Summary(
        grips=count,
        success=share_of(sum(each.success for each in outcomes), count),
        held=share_of(sum(each.held for each in outcomes), count),
        dropped=sum(each.dropped for each in outcomes),
        caught=sum(each.caught is True for each in outcomes),
        crushed=sum(each.crushed for each in outcomes),
        not_lifted=count - len(lifted),
        failed=sum(each.ending == "failed" for each in outcomes),
        margin_at_lift=spread_of(each.margin_at_lift for each in outcomes),
        peak_ratio=spread_of(each.peak_ratio for each in lifted),
        peak_normal_force_N=spread_of(each.peak_normal_force_N for each in lifted),
        minimum_stick_ratio=spread_of(each.minimum_stick_ratio for each in outcomes),
        slip_distance_mm=spread_of(each.slip_distance_mm for each in outcomes if each.held),
        steps=spread_of(each.steps for each in lifted),
        answered=share_of(sum(each.reaction_steps is not None for each in tugged), len(tugged)),
        reaction_steps=spread_of(each.reaction_steps for each in tugged),
        unannounced=unannounced(outcomes),
        unsure=unsure(outcomes),
        foreseen=foreseen_of(outcomes),
    )


def unannounced(grips: Sequence[JudgedGrip]) -> int | None:
    """Grips that were dropped or crushed, and nothing was said; None where nothing is ever said."""
    telling = [each for each in grips if each.unsure is not None]
    wrong = [each for each in telling if each.crushed or each.ending in ("complete slip", "caught")]
    return sum(not each.unsure for each in wrong) if telling else None


def unsure(grips: Sequence[JudgedGrip]) -> Share | None:
    """Of those that succeeded the share at whose lift the controller was unsure."""
    well = [each for each in grips if each.success and each.unsure is not None]
    return share_of(sum(bool(each.unsure) for each in well), len(well)) if well else None


@closed
@dataclass(frozen=True)
class NoiseSummary(Summary):
    """The grips at one noise."""

    noise_microstrain: Size


@closed
class ControllerData(TypedDict):
    """One controller over the whole grid."""

    controller: str
    told: Annotated[str | None, Field(description="of the object; null: nothing")]
    whole_grid: Annotated[Summary, Field(description="all noises, tugged grips apart")]
    by_noise: list[NoiseSummary]
    tugged: Summary | None


@closed
class ConditionsData(TypedDict):
    """The grid's axes."""

    friction_coefficients: list[Size]
    object_masses_g: list[Size]
    noises_microstrain: Annotated[list[Size], Field(description="standard deviation of a sample")]
    seed: Count
    hold_s: Annotated[Size, Field(description="held on after the lift")]
    tug: Annotated[dict[str, Size] | None, Field(description="null: no grip is tugged")]


@closed
class CriteriaData(TypedDict):
    """What success is."""

    most_force_ratio: Size
    human_margin: Annotated[list[Size], Field(min_length=2, max_length=2)]
    good_amplifier_microstrain: Size
    warning_stick_ratio: Annotated[Size, Field(description="reported below it: a warning")]
    false_alarm_stick_ratio: Annotated[Size, Field(description="true above it: a false one")]


@closed
class ModelData(TypedDict):
    """What was gripped with."""

    fidelity: Literal["plane-strain", "3d"]
    contact_nodes: Count
    gages: Count
    face: Literal["upper", "lower", "both"]
    opposite: Literal["mirror", "bare"]
    contact_size_mm: Size
    preload_mm: Size
    max_approach_mm: Size
    largest_bench_force_N: Annotated[Size, Field(description="at max_approach_mm, without shear")]
    preload_force_N: Size


@closed
class SecondsData(TypedDict):
    """Where the time went."""

    model: Size
    teaching: Size
    grips: Size
    whole: Size


@closed
class ControlData(TypedDict):
    """The content of control.json."""

    schema_version: Literal[1]
    design: str
    digest: str
    status: Literal["ok"]
    grips: Count
    criteria: CriteriaData
    conditions: ConditionsData
    hardware: Annotated[
        dict[str, Size | list[Count]], Field(description="its keys are those of [grip.hardware]")
    ]
    model: ModelData
    controllers: list[ControllerData]
    seconds: SecondsData
    workers: Count
    peak_memory_MB: Size
    warnings: list[str]
    versions: dict[str, str]


@dataclass(frozen=True)
class ControlStudy:
    """The record of one ``fingerdesign study-control``, as in control.json, and what it sums up.

    outcomes: every grip, tugged ones among them, in the order of the grid. traces: some grips step
    by step, in the order of the controllers, at ``trace_noise``.
    """

    data: ControlData
    outcomes: tuple[JudgedGrip, ...]
    traces: tuple[GripTrace, ...] = ()
    trace_noise: float = GOOD_AMPLIFIER

    def summary(self, controller: str, noise: float | None = None, tugged: bool = False) -> Summary:
        """A controller's grips, at one noise or at all; with or without the tug."""
        return _summary(self.outcomes, controller, noise, tugged)


def control_data(
    outcomes: Sequence[JudgedGrip],
    controllers: Iterable[str],
    grid: ControlGrid,
    warnings: Iterable[str] = (),
    **facts: Any,
) -> ControlData:
    """The record of all grips; facts: its keys that neither they nor the grid tell."""

    return {
        "schema_version": 1,
        "design": facts["design"],
        "digest": facts["digest"],
        "status": "ok",
        "grips": len(outcomes),
        "criteria": {
            "most_force_ratio": MOST_FORCE,
            "human_margin": list(BAND),
            "good_amplifier_microstrain": GOOD_AMPLIFIER,
            "warning_stick_ratio": facts["warning_stick_ratio"],
            "false_alarm_stick_ratio": facts["warning_stick_ratio"] + CLEARLY,
        },
        "conditions": conditions_data(grid),
        "hardware": facts["hardware"],
        "model": facts["model"],
        "controllers": [
            {
                "controller": name,
                "told": getattr(CONTROLLERS.get(name), "knows", None),
                "whole_grid": _summary(outcomes, name),
                "by_noise": [
                    NoiseSummary(**vars(_summary(outcomes, name, noise)), noise_microstrain=noise)
                    for noise in grid.noises
                ],
                "tugged": None if grid.tug is None else _summary(outcomes, name, None, True),
            }
            for name in controllers
        ],
        "seconds": facts["seconds"],
        "workers": facts["workers"],
        "peak_memory_MB": facts["peak_memory_MB"],
        "warnings": list(warnings),
        "versions": facts["versions"],
    }


def conditions_data(grid: ControlGrid) -> ConditionsData:
    """The grid's axes as plain values."""
    tug = None if grid.tug is None else asdict(grid.tug) | {"noise_microstrain": grid.tug_noise}
    return {
        "friction_coefficients": list(grid.frictions),
        "object_masses_g": list(grid.masses_g),
        "noises_microstrain": list(grid.noises),
        "seed": grid.seed,
        "hold_s": grid.hold_s,
        "tug": tug,
    }


def _summary(
    outcomes: Iterable[JudgedGrip],
    controller: str,
    noise: float | None = None,
    tugged: bool = False,
) -> Summary:
    return summarise(
        [
            each
            for each in outcomes
            if each.controller == controller
            and noise in (None, each.noise)
            and (each.tug > 0.0) == tugged
        ]
    )


def grips_csv(outcomes: Sequence[JudgedGrip]) -> str:
    """A row a grip; empty where there is no value, true and false as 1 and 0."""
    return csv_text(COLUMNS, (grip_cells(each, COLUMNS.values()) for each in outcomes))


def grip_cells(grip: JudgedGrip, names: Iterable[str]) -> list[Any]:
    """Attributes of a grip as cells: true and false as 1 and 0."""
    values = (getattr(grip, name) for name in names)
    return [int(value) if isinstance(value, bool) else value for value in values]
