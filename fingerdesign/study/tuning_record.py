"""tuning.json: every trial of every tuned controller, and the values to take.

    {"format": ..., "design": name, "digest": ..., "seed": 0, "cells": [...], "hardware": {...},
     "controllers": {"reactive": {"best": {...}, "default": {...}, "trials": [...]}, ...}}

``values`` are keys of the design: :func:`tuned_design` sets those of all controllers at once, each
in tables of its own.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import DesignError, Fault
from fingerdesign.study.tuning import Trial, Tuning

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.study.control_grid import Cell

FORMAT = "fingerdesign tuning, 1"
RECORD_FILE = "tuning.json"


@dataclass(frozen=True)
class TuningRecord:
    """What was tuned, on what. digest: of the design before; cells: the grips, as many as the last
    round's; hardware, model: plain values that say what was gripped with."""

    design: str
    digest: str
    seed: int
    tunings: tuple[Tuning, ...]
    cells: tuple[Cell, ...]
    hardware: dict[str, Any]
    model: dict[str, Any]
    versions: dict[str, str]
    seconds: float

    def to_json(self) -> str:
        """The record as text; NaN is never written."""
        record = {
            "format": FORMAT,
            "design": self.design,
            "digest": self.digest,
            "seed": self.seed,
            "seconds": round(self.seconds, 1),
            "hardware": self.hardware,
            "model": self.model,
            "versions": self.versions,
            "cells": [
                {
                    "friction_coefficient": cell.friction,
                    "object_mass_g": cell.mass_g,
                    "noise_microstrain": cell.noise,
                }
                for cell in self.cells
            ],
            "controllers": {each.controller: _tuning_data(each) for each in self.tunings},
        }
        return json.dumps(record, indent=1, allow_nan=False) + "\n"


def _tuning_data(tuning: Tuning) -> dict[str, Any]:
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
    from fingerdesign.design.io import with_values

    return with_values(design, best_values(text, source))


def toml_lines(tunings: Sequence[Tuning]) -> str:
    """The best values as lines for a design file, above its first table.

    >>> from fingerdesign.study.tuning import Trial, Tuning
    >>> best = Trial({"grip.fixed_ratio.ratio": 0.25}, 0)
    >>> toml_lines([Tuning("fixed_ratio", 0, (), (), (best,), best, best)])
    'grip.fixed_ratio.ratio = 0.25'
    """
    values = {key: value for each in tunings for key, value in each.best.values.items()}
    return "\n".join(f"{key} = {value:g}" for key, value in values.items())


def write_record(record: TuningRecord, folder: Path) -> Path:
    """Write the record into a folder that exists; returns its path."""
    path = folder / RECORD_FILE
    path.write_text(record.to_json(), encoding="utf-8")
    return path
