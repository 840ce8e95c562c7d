"""Content of control.json and grips.csv: every controller's summaries, and every grip."""

from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass
from operator import attrgetter
from typing import Annotated, Any, Literal

from pydantic import Field
from typing_extensions import TypedDict

from fingerdesign.control.foresight import CLEARLY
from fingerdesign.design.schema import Design
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.base import Count, Size, closed, csv_text
from fingerdesign.records.result import MOST_FORCE
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.grid import GOOD_AMPLIFIER, SEALED_SEED, ControlGrid, faults_of
from fingerdesign.trials.summary import (
    FaultSummary,
    NoiseSummary,
    Summary,
    Trial,
    chosen_of,
    fault_summary,
    summarise,
)

RECORD_FILE, CSV_FILE = "control.json", "grips.csv"
# People grip with so many times the least force (Johansson and Westling 1984).
BAND = (1.2, 1.5)
_OF_RESULT = (
    "success lifted gross_slip crushed safety_margin peak_ratio peak_normal_force_N "
    "minimum_stick_ratio slip_distance_mm steps reaction_steps unsure slip_warning lead_s "
    "lead_force_share alarms false_alarms stick_error stick_error_samples samples slid_mm caught "
    "catch_s rotation_deg ending reason"
)
# Of grips.csv, by name: the value of a trial.
COLUMNS = {
    "controller": "cell.controller",
    "friction_coefficient": "cell.friction",
    "object_mass_g": "cell.mass_g",
    "noise_microstrain": "cell.noise",
    "tug_share": "cell.tug",
    "fault": "cell.fault",
    "plant": "cell.plant",
    "seed": "seed",
    **{name: f"result.{name}" for name in _OF_RESULT.split()},
    "steps": "result.steps_to_lift",
    "ending": "result.outcome",
    "reason": "result.ending",
}


def grips_csv(trials: Iterable[Trial]) -> str:
    """A row a grip; empty where there is no value, true and false as 1 and 0."""
    rows = map(attrgetter(*COLUMNS.values()), trials)
    numbers = ([int(cell) if isinstance(cell, bool) else cell for cell in row] for row in rows)
    return csv_text(COLUMNS, numbers)


@closed
class ControllerData(TypedDict):
    """One controller over the whole grid."""

    controller: str
    told: Annotated[str | None, Field(description="of the object; null: nothing")]
    whole_grid: Annotated[Summary, Field(description="all noises, tugged grips apart")]
    by_noise: list[NoiseSummary]
    by_fault: Annotated[list[FaultSummary], Field(description="of perturbed fingers, else empty")]
    tugged: Summary | None


@closed
class PerturbedData(TypedDict):
    """Fingers drawn with faults; friction and weight of the objects lie between the axes' ends."""

    faults: Annotated[dict[str, tuple[str, ...]], Field(description="by label")]
    plants: Annotated[Count, Field(description="fingers of each label")]
    lifts_a_plant: Count
    trained_on: Annotated[str | None, Field(description="of the estimator; null: none was needed")]


@closed
class ConditionsData(TypedDict):
    """The grid's axes."""

    friction_coefficients: list[Size]
    object_masses_g: list[Size]
    noises_microstrain: Annotated[list[Size], Field(description="standard deviation of a sample")]
    seed: Count
    sealed: Annotated[bool, Field(description="the seed of published tables, run once for each")]
    hold_s: Annotated[Size, Field(description="held on after the lift")]
    tug: Annotated[dict[str, Size] | None, Field(description="null: no grip is tugged")]
    perturbed: Annotated[
        PerturbedData | None, Field(description="null: the finger of the model alone")
    ]


@closed
class CriteriaData(TypedDict):
    """Criteria of success."""

    most_force_ratio: Size
    human_margin: Annotated[list[Size], Field(min_length=2, max_length=2)]
    good_amplifier_microstrain: Size
    warning_stick_ratio: Annotated[Size, Field(description="reported below it: a warning")]
    false_alarm_stick_ratio: Annotated[Size, Field(description="true above it: a false one")]


@closed
class ModelData(TypedDict):
    """The model that gripped."""

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
class TunedTrialData(TypedDict):
    """Values of a controller's parameters, by key of the design, and what came of them."""

    values: dict[str, float]
    round: Count
    grips: Count
    success_rate: float
    held_rate: float
    mean_peak_ratio: float | None
    dropped: Count
    crushed: Count
    not_lifted: Count


@closed
class ControllerTuningData(TypedDict):
    """One controller's tuning: its ranges and rounds, every trial, the best and the default."""

    grips: Count
    ranges: list[dict[str, str | float | bool]]
    rounds: list[dict[str, Count]]
    best: TunedTrialData
    default: TunedTrialData
    trials: list[TunedTrialData]


@closed
class TuningData(TypedDict):
    """Tuning of the design before the study; cells: the grips that it was tuned on."""

    digest: Annotated[str, Field(description="of the design before it")]
    fingers: Annotated[Count, Field(description="perturbed ones; 0: the model's own alone")]
    cells: list[dict[str, Size]]
    controllers: dict[str, ControllerTuningData]


@closed
class SecondsData(TypedDict):
    """Seconds of each stage."""

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
    tuning: Annotated[TuningData | None, Field(description="null: the design's own parameters")]
    seconds: SecondsData
    workers: Count
    peak_memory_MB: Size
    warnings: list[str]
    versions: dict[str, str]


@dataclass(frozen=True)
class ControlStudy:
    """The record of one ``fingerdesign study``, as in control.json, and what it sums up.

    trials: every grip, tugged ones among them, in the order of the grid. traces: some grips step
    by step, in the order of the controllers, at ``trace_noise``. tuned: the tuned design, None for
    the design as it was given.
    """

    data: ControlData
    trials: tuple[Trial, ...]
    traces: tuple[GripTrace, ...] = ()
    trace_noise: float = GOOD_AMPLIFIER
    tuned: Design | None = None

    def summary(self, controller: str, noise: float | None = None, tugged: bool = False) -> Summary:
        """A controller's grips, at one noise or at all; with or without the tug."""
        drawn = self.data["conditions"]["perturbed"] is not None
        return summarise(chosen_of(self.trials, controller, noise, tugged), drawn)


def control_data(
    trials: Sequence[Trial],
    controllers: Iterable[str],
    grid: ControlGrid,
    warnings: Iterable[str] = (),
    **facts: Any,
) -> ControlData:
    """The record of all grips; facts: its keys that follow neither from them nor from the grid."""
    threshold = facts["warning_stick_ratio"]
    return {
        "schema_version": 1,
        "design": facts["design"],
        "digest": facts["digest"],
        "status": "ok",
        "grips": len(trials),
        "criteria": {
            "most_force_ratio": MOST_FORCE,
            "human_margin": list(BAND),
            "good_amplifier_microstrain": GOOD_AMPLIFIER,
            "warning_stick_ratio": threshold,
            "false_alarm_stick_ratio": threshold + CLEARLY,
        },
        "conditions": conditions_data(grid, facts.get("trained_on")),
        "hardware": facts["hardware"],
        "model": facts["model"],
        "controllers": [_controller_data(trials, name, grid) for name in controllers],
        "tuning": facts.get("tuning"),
        "seconds": facts["seconds"],
        "workers": facts["workers"],
        "peak_memory_MB": facts["peak_memory_MB"],
        "warnings": list(warnings),
        "versions": facts["versions"],
    }


def _controller_data(trials: Sequence[Trial], name: str, grid: ControlGrid) -> ControllerData:
    own, drawn = chosen_of(trials, name), grid.perturbed is not None
    labels = () if grid.perturbed is None else grid.perturbed.labels
    return {
        "controller": name,
        "told": getattr(CONTROLLERS.get(name), "knows", None),
        "whole_grid": summarise(own, drawn),
        "by_noise": [
            NoiseSummary(
                **vars(summarise(chosen_of(own, name, noise), drawn)), noise_microstrain=noise
            )
            for noise in grid.noises
        ],
        "by_fault": [
            fault_summary([each for each in own if each.cell.fault == label], label)
            for label in labels
        ],
        "tugged": None if grid.tug is None else summarise(chosen_of(trials, name, tugged=True)),
    }


def conditions_data(grid: ControlGrid, trained_on: str | None = None) -> ConditionsData:
    """The grid's axes as plain values."""
    tug = None if grid.tug is None else asdict(grid.tug) | {"noise_microstrain": grid.tug_noise}
    perturbed: PerturbedData | None = None
    if (own := grid.perturbed) is not None:
        perturbed = {
            "faults": {label: faults_of(label) for label in own.labels},
            "plants": own.plants,
            "lifts_a_plant": own.lifts,
            "trained_on": trained_on,
        }
    return {
        "friction_coefficients": list(grid.frictions),
        "object_masses_g": list(grid.masses_g),
        "noises_microstrain": list(grid.noises),
        "seed": grid.seed,
        "sealed": grid.seed == SEALED_SEED,
        "hold_s": grid.hold_s,
        "tug": tug,
        "perturbed": perturbed,
    }
