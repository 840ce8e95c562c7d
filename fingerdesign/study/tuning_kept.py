"""What an unfinished tuning has done, a JSON line each: judged trials and finished controllers.

The procedure is seeded, so a run that is begun anew asks for the same trials: those that stand here
are taken from here, and it goes on in the middle of a round.

    kept = Kept(path, digest)
    tune(..., judge=kept.judge(judge, told))
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

from fingerdesign.control.metrics import Outcome
from fingerdesign.results import ResultError
from fingerdesign.study.control_grid import Cell
from fingerdesign.study.tuning import Judge, Values
from fingerdesign.study.tuning_grips import Asked, BenchJudge

Told = Callable[[int, int], None]  # grips judged of those asked for at once


class Kept:
    """The journal of a run with ``digest``; a file of something else is a ResultError.

    A line that was cut short is left out, and made again. controllers: finished tunings by name.
    """

    def __init__(self, path: Path, digest: str) -> None:
        self._path, self._digest = path, digest
        self.controllers: dict[str, dict[str, Any]] = {}
        self._judged: dict[str, list[Outcome]] = {}
        for line in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
            try:
                record = json.loads(line)
                own = record["digest"] == digest
                if own and "trial" in record:
                    found = [Outcome(**each) for each in record["outcomes"]]
                    self._judged[str(record["trial"])] = found
                elif own:
                    self.controllers[str(record["controller"])] = record["tuning"]
            except (ValueError, KeyError, TypeError):
                continue
            if not own:
                what = f"{path} is of another design, setting or version"
                raise ResultError(f"{what}; move it away, or choose another --out")

    @property
    def grips(self) -> int:
        """How many grips of trials are kept."""
        return sum(len(each) for each in self._judged.values())

    def add(self, controller: str, tuning: dict[str, Any]) -> None:
        """Keep a finished tuning."""
        self._write({"controller": controller, "tuning": tuning})
        self.controllers[controller] = tuning

    def add_trial(self, values: Values, cells: Sequence[Cell], outcomes: list[Outcome]) -> None:
        """Keep what came of a trial's grips."""
        key = _key(values, cells)
        self._write({"trial": key, "outcomes": [asdict(each) for each in outcomes]})
        self._judged[key] = outcomes

    def judge(self, judge: BenchJudge, told: Told = lambda done, of: None) -> Judge:
        """A judge that recalls what is kept and keeps, trial by trial, what ``judge`` makes."""

        def judged(asked: Asked) -> list[list[Outcome]]:
            of = sum(len(cells) for _, cells in asked)
            left = [each for each in asked if _key(*each) not in self._judged]
            done = of - sum(len(cells) for _, cells in left)
            told(done, of)

            def made(k: int, outcomes: list[Outcome]) -> None:
                nonlocal done
                self.add_trial(*left[k], outcomes)
                done += len(outcomes)
                told(done, of)

            if left:
                judge(left, made)
            return [self._judged[_key(*each)] for each in asked]

        return judged

    def _write(self, record: dict[str, Any]) -> None:
        self._path.parent.mkdir(parents=True, exist_ok=True)
        line = json.dumps({"digest": self._digest, **record}, allow_nan=False)
        with self._path.open("a", encoding="utf-8") as stream:
            stream.write("\n" + line + "\n")


def _key(values: Values, cells: Sequence[Cell]) -> str:
    """Of a trial's values and grips; a cell names its controller."""
    told = [sorted(values.items()), [asdict(each) for each in cells]]
    return hashlib.sha256(json.dumps(told).encode()).hexdigest()[:24]
