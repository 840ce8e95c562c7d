"""``fingerdesign tune``: every controller of a design tuned alike, and the design that comes of it.

record = tune_controllers(design, ("paper", "reactive"), journal)
tuned = tuned_design(design, record.to_json())
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.case import gage_array
from fingerdesign.control.roster import NAMES
from fingerdesign.errors import DesignError, Fault
from fingerdesign.identity import versions
from fingerdesign.study.control_bench import GripBench
from fingerdesign.study.control_grid import GOOD_AMPLIFIER, ControlGrid
from fingerdesign.study.control_study import hardware_of
from fingerdesign.study.grip_model import CONTACT_SIZE_MM, grip_problem
from fingerdesign.study.tuning import BUDGET, RANGES, Round, Tell, tune
from fingerdesign.study.tuning_grips import bench_judge, tuning_cells
from fingerdesign.study.tuning_kept import Kept
from fingerdesign.study.tuning_record import RECORD_FILE, TuningRecord, tuning_data

if TYPE_CHECKING:
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.schema import Design

DESIGN_FILE = "tuned.toml"


def tune_controllers(
    design: Design,
    controllers: Sequence[str],
    journal: Path,
    *,
    estimator: GripEstimator | None = None,
    noises: Sequence[float] = (GOOD_AMPLIFIER,),
    seed: int = 0,
    budget: Sequence[Round] = BUDGET,
    workers: int = 1,
    contact_size_mm: float = CONTACT_SIZE_MM,
    tell: Tell = lambda message, fraction: None,
) -> TuningRecord:
    """Tune those controllers that ``journal`` (JSON lines) does not hold yet, trial by trial.

    estimator: the regulator's; without one it is taught on this design, or taken from the cache.
    noises: of the gages in the tuning grips, microstrain, in turn. The journal stays: whoever has
    written the record may delete it. Raises DesignError for wrong input, ResultError for a journal
    of something else, SolverError where a process died.
    """
    names = tuple(dict.fromkeys(controllers))
    _refuse(names, noises, seed)
    start = time.perf_counter()
    problem = grip_problem(design, contact_size_mm, lambda message: tell(message, 0.0))
    if "regulator" in names and estimator is None:
        from fingerdesign.study.lessons import lesson_for

        lesson = lesson_for(
            design,
            problem=problem,
            tell=lambda message: tell(message, 0.0),
            workers=workers,
        )
        estimator = lesson.estimator
    hardware = hardware_of(design)
    grid = replace(ControlGrid(seed=seed), tug=None)
    plates = gage_array(design)
    bench = GripBench(problem, design.gages.face, plates, design.grip, hardware, grid, estimator)
    rounds = [asdict(each) for each in budget]
    taught = None if estimator is None else estimator.to_json()
    parts = [design.digest(), versions()["fingerdesign"], rounds, [*noises], seed, contact_size_mm]
    digest = hashlib.sha256(json.dumps([*parts, taught]).encode()).hexdigest()
    kept = Kept(journal, digest)
    if kept.grips:
        tell(f"going on: {kept.grips} grips were made before", 0.0)
    left = [name for name in names if name not in kept.controllers]
    from fingerdesign.pipeline import one_thread

    with one_thread(), bench_judge(bench, workers) as judge:
        for number, name in enumerate(left):
            progress = _Progress(tell, number, len(left), len(budget))
            found = tune(
                name,
                default_values(design, name),
                tuning_cells(name, budget[-1].grips, seed, noises),
                kept.judge(judge, progress.grips),
                budget=budget,
                seed=seed,
                tell=progress.round,
            )
            kept.add(name, tuning_data(found))
    varied = "gage_noise_microstrain"
    return TuningRecord(
        design=design.design.name,
        digest=digest,
        seed=seed,
        cells=tuple(tuning_cells("", budget[-1].grips, seed, noises)),
        hardware={key: value for key, value in asdict(hardware).items() if key != varied},
        model={
            "fidelity": "plane-strain",
            "contact_size_mm": contact_size_mm,
            "contact_nodes": problem.model.nodes,
            "gages": len(plates),
            "preload_mm": design.grip.preload_mm,
            "max_approach_mm": design.grip.max_approach_mm,
            "max_steps": design.grip.max_steps,
        },
        controllers={name: kept.controllers[name] for name in names},
        versions=versions(),
        seconds=time.perf_counter() - start,
    )


def default_values(design: Design, controller: str) -> dict[str, float]:
    """A design's own values of the parameters that a controller is tuned in."""
    found = {}
    for each in RANGES[controller]:
        value: Any = design
        for name in each.key.split("."):
            value = getattr(value, name)
        found[each.key] = float(value)
    return found


def write_tuning(record: TuningRecord, design: Design, folder: Path) -> None:
    """tuning.json and the tuned design, into a folder that exists; the record comes last.

    The design's first comment says by what it was tuned, on what and how well.
    """
    from fingerdesign.design.io import dump_design
    from fingerdesign.study.tuning_record import tuned_comment, tuned_design

    text = record.to_json()
    tuned = tuned_comment(record) + dump_design(tuned_design(design, text))
    (folder / DESIGN_FILE).write_text(tuned, encoding="utf-8")
    (folder / RECORD_FILE).write_text(text, encoding="utf-8")


class _Progress:
    """What is told while controller ``number`` of ``of`` is tuned."""

    def __init__(self, tell: Tell, number: int, of: int, rounds: int) -> None:
        self._tell, self._number, self._of, self._rounds = tell, number, of, rounds
        self._message, self._share = "", 0.0

    def round(self, message: str, share: float) -> None:
        """A round begins."""
        self._message, self._share = message, share

    def grips(self, done: int, of: int) -> None:
        """So many of the round's grips are made."""
        share = self._share + done / of / self._rounds
        message = f"{self._message}, {done} of {of} grips"
        self._tell(message, (self._number + share) / self._of)


def _refuse(names: Sequence[str], noises: Sequence[float], seed: int) -> None:
    from difflib import get_close_matches

    faults = ControlGrid(noises=tuple(noises), seed=seed).faults()
    for name in names:
        if name not in NAMES:
            near = get_close_matches(name, NAMES, 1, 0.5)
            remedy = f"did you mean {near[0]}?" if near else "choose one of them"
            faults.append(Fault("--controller", name, f"one of {', '.join(NAMES)}", remedy))
    if faults:
        raise DesignError(faults)
