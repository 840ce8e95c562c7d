"""What control.json and grips.csv hold: every controller's summary by noise, and every grip."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field
from typing_extensions import TypedDict

from fingerdesign.control.metrics import MOST_FORCE, JudgedGrip, Share, Summary, summarise
from fingerdesign.records.base import Count, Size, closed, csv_text
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.bench import GOOD_AMPLIFIER, ControlGrid

if TYPE_CHECKING:
    from fingerdesign.records.arrays import GripTrace

RECORD_FILE, CSV_FILE = "control.json", "grips.csv"
BAND = (1.2, 1.5)  # times the least force: how people grip (Johansson and Westling 1984)

# Column of grips.csv -> field of JudgedGrip; the names of the result's grips where alike.
COLUMNS = {
    "controller": "controller",
    "friction_coefficient": "friction",
    "object_mass_g": "mass_g",
    "noise_microstrain": "noise",
    "tug_share": "tug",
    "seed": "seed",
    "success": "success",
    "lifted": "lifted",
    "gross_slip": "dropped",
    "crushed": "crushed",
    "safety_margin": "margin_at_lift",
    "peak_ratio": "peak_ratio",
    "peak_normal_force_N": "peak_normal_force_N",
    "minimum_stick_ratio": "minimum_stick_ratio",
    "slip_distance_mm": "slip_distance_mm",
    "steps": "steps",
    "reaction_steps": "reaction_steps",
    "ending": "ending",
    "reason": "reason",
}


Rate = Annotated[float, Field(ge=0.0, le=1.0)]


@closed
class ShareData(TypedDict):
    """``count`` of ``of``; low, high: Wilson's 95 % interval; null of nothing."""

    count: Count
    of: Count
    rate: Rate | None
    low: Rate | None
    high: Rate | None


@closed
class SpreadData(TypedDict):
    """Of what has the value; low, high: quartiles."""

    count: Count
    least: Size
    low: Size
    median: Size
    high: Size
    most: Size


@closed
class SummaryData(TypedDict):
    """Many grips: shares of all of them, spreads (null: no grip has the value)."""

    grips: Count
    success: ShareData
    held: ShareData
    dropped: Count
    crushed: Count
    not_lifted: Count
    failed: Count
    margin_at_lift: SpreadData | None
    peak_ratio: SpreadData | None
    peak_normal_force_N: SpreadData | None
    minimum_stick_ratio: SpreadData | None
    slip_distance_mm: SpreadData | None
    steps: SpreadData | None
    answered: ShareData
    reaction_steps: SpreadData | None


@closed
class NoiseData(SummaryData):
    """The grips at one noise."""

    noise_microstrain: Size


@closed
class ControllerData(TypedDict):
    """One controller over the whole grid."""

    controller: str
    told: Annotated[str | None, Field(description="of the object; null: nothing")]
    whole_grid: Annotated[SummaryData, Field(description="all noises, tugged grips apart")]
    by_noise: list[NoiseData]
    tugged: SummaryData | None


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


@closed
class ModelData(TypedDict):
    """What was gripped with."""

    fidelity: Literal["plane-strain"]
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

    def summary(*of: Any) -> SummaryData:
        return summary_data(_summary(outcomes, *of))

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
        },
        "conditions": conditions_data(grid),
        "hardware": facts["hardware"],
        "model": facts["model"],
        "controllers": [
            {
                "controller": name,
                "told": getattr(CONTROLLERS.get(name), "knows", None),
                "whole_grid": summary(name),
                "by_noise": [
                    {"noise_microstrain": noise, **summary(name, noise)} for noise in grid.noises
                ],
                "tugged": None if grid.tug is None else summary(name, None, True),
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


def summary_data(summary: Summary) -> SummaryData:
    """A summary as plain values: shares as {count, of, rate, low, high}, spreads as quartiles."""
    found: Any = asdict(summary)
    for name in ("success", "held", "answered"):
        share: Share = getattr(summary, name)
        low, high = share.interval or (None, None)
        found[name] |= {"rate": share.rate, "low": low, "high": high}
    kept: SummaryData = found
    return kept


def grips_csv(outcomes: Sequence[JudgedGrip]) -> str:
    """A row a grip; empty where there is no value, true and false as 1 and 0."""
    return csv_text(
        COLUMNS, ([_cell(getattr(each, name)) for name in COLUMNS.values()] for each in outcomes)
    )


def _cell(value: Any) -> Any:
    return int(value) if isinstance(value, bool) else value
