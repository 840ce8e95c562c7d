"""tuning.json: every trial of every tuned controller, and the values to take.

    {"format": ..., "design": name, "digest": ..., "seed": 0, "cells": [...], "hardware": {...},
     "controllers": {"reactive": {"best": {...}, "default": {...}, "trials": [...]}, ...}}

``values`` are keys of the design: :func:`tuned_design` sets those of all controllers at once, each
in tables of its own.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import DesignError, Fault
from fingerdesign.results import ResultError
from fingerdesign.study.tuning import Trial, Tuning

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.study.control_grid import Cell

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


class Kept:
    """Tunings of an unfinished run, a JSON line each; a file of something else is a ResultError.

    A line that was cut short is left out, and made again.
    """

    def __init__(self, path: Path, digest: str) -> None:
        self._path, self._digest = path, digest
        self.controllers: dict[str, dict[str, Any]] = {}
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
            try:
                record = json.loads(line)
                digest, name, found = record["digest"], record["controller"], record["tuning"]
            except (ValueError, KeyError, TypeError):
                continue
            if digest != self._digest:
                what = f"{path} is of another design, setting or version"
                raise ResultError(f"{what}; move it away, or choose another --out")
            self.controllers[str(name)] = found

    def add(self, controller: str, tuning: dict[str, Any]) -> None:
        """Keep a tuning, in memory and on a line of its own."""
        self._path.parent.mkdir(parents=True, exist_ok=True)
        line = {"digest": self._digest, "controller": controller, "tuning": tuning}
        with self._path.open("a", encoding="utf-8") as stream:
            stream.write("\n" + json.dumps(line, allow_nan=False) + "\n")
        self.controllers[controller] = tuning
