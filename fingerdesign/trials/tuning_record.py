"""tuning.json: every trial of every tuned controller, and the values to take.

    {"format": ..., "design": name, "digest": ..., "seed": 0, "cells": [...], "hardware": {...},
     "controllers": {"reactive": {"best": {...}, "default": {...}, "trials": [...]}, ...}}

``values`` are keys of the design: :func:`tuned_design` sets those of all controllers at once, each
in tables of its own.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

from fingerdesign.checks.load import with_values
from fingerdesign.errors import DesignError, Fault
from fingerdesign.trials.tuning import Trial, Tuning

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.trials.grid import Cell

FORMAT = "fingerdesign tuning, 1"
RECORD_FILE = "tuning.json"


@dataclass(frozen=True)
class TuningRecord:
    """What was tuned, on what.

    digest: of all that decides it. cells: the grips, as many as the last round's. hardware, model:
    plain values that say what was gripped with. controllers: by name, see :func:`tuning_data`.
    """

    design: str
    digest: str
    seed: int
    cells: tuple[Cell, ...]
    hardware: dict[str, Any]
    model: dict[str, Any]
    controllers: dict[str, dict[str, Any]]
    versions: dict[str, str]
    seconds: float

    def data(self) -> dict[str, Any]:
        """The record as plain values."""
        cells = [
            {
                "friction_coefficient": cell.friction,
                "object_mass_g": cell.mass_g,
                "noise_microstrain": cell.noise,
            }
            for cell in self.cells
        ]
        own = {key: value for key, value in vars(self).items() if key != "cells"}
        return {"format": FORMAT, **own, "seconds": round(self.seconds, 1), "cells": cells}

    def to_json(self) -> str:
        """The record as text; NaN is never written."""
        return json.dumps(self.data(), indent=1, allow_nan=False) + "\n"


def tuning_data(tuning: Tuning) -> dict[str, Any]:
    """A tuning as plain values: its ranges and rounds, every trial, the best and the default."""
    return {
        "grips": tuning.grips,
        "ranges": [asdict(each) for each in tuning.ranges],
        "rounds": [asdict(each) for each in tuning.budget],
        "best": trial_data(tuning.best),
        "default": trial_data(tuning.default),
        "trials": [trial_data(each) for each in tuning.trials],
    }


def trial_data(trial: Trial) -> dict[str, Any]:
    """A trial as plain values; why its other grips failed is counted."""
    outcomes = trial.outcomes
    return {
        "values": trial.values,
        "round": trial.round,
        "grips": len(outcomes),
        "success_rate": trial.success,
        "held_rate": sum(each.held for each in outcomes) / max(len(outcomes), 1),
        "mean_peak_ratio": trial.mean_peak_ratio,
        "dropped": sum(each.dropped for each in outcomes),
        "crushed": sum(each.crushed for each in outcomes),
        "not_lifted": sum(not each.lifted for each in outcomes),
    }


def best_values(text: str, source: str = RECORD_FILE) -> dict[str, float]:
    """The best values of all controllers of a record, by key of the design.

    Where two controllers share a key (the oracles do) the last one's stands. Raises DesignError for
    a text that is no such record.
    """
    values: dict[str, float] = {}
    try:
        record = json.loads(text)
        if record["format"] != FORMAT:
            raise ValueError(f"its format is {record['format']!r}")
        for tuned in record["controllers"].values():
            for key, value in tuned["best"]["values"].items():
                values[str(key)] = float(value)
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        fault = Fault("--tuning", source, f"a record of {FORMAT!r}", f"choose another: {error!r}")
        raise DesignError([fault]) from error
    return values


def tuned_design(design: Design, text: str, source: str = RECORD_FILE) -> Design:
    """The design with the best values of a record, checked like a file.

    Raises DesignError for a record that is none or holds what the design refuses.
    """
    return with_values(design, best_values(text, source))


def tuned_comment(record: TuningRecord) -> str:
    """Comment lines for the head of a tuned design: by what, on what, how well."""
    frictions = [cell.friction for cell in record.cells]
    masses = [cell.mass_g for cell in record.cells]
    noises = ", ".join(f"{noise:g}" for noise in sorted({cell.noise for cell in record.cells}))
    lines = [
        f"{record.design}, its controllers tuned by `fingerdesign tune` "
        f"{record.versions.get('fingerdesign', '')} (seed {record.seed}).",
        f"On {len(record.cells)} grips: friction {min(frictions):.2g} to {max(frictions):.2g}, "
        f"{min(masses):.0f} to {max(masses):.0f} g, gage noise {noises} microstrain.",
        *(_reported(name, found) for name, found in record.controllers.items()),
        "Another set of grips gives other rates: judge it with `fingerdesign study-control`.",
    ]
    return "".join(f"# {line}\n" for line in lines) + "\n"


def _reported(name: str, found: dict[str, Any]) -> str:
    best, default = found["best"], found["default"]
    peak = best["mean_peak_ratio"]
    reported = "" if peak is None else f", mean peak {peak:.2f} times the least force"
    return (
        f"{name}: success {100 * best['success_rate']:.0f} % (before: "
        f"{100 * default['success_rate']:.0f} %), held {100 * best['held_rate']:.0f} %{reported}"
    )
