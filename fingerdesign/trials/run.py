"""``fingerdesign study-control``: controllers over friction x weight x noise, on one design.

study = study_control(design, ("paper", "oracle_1.2"), ControlGrid.quick(), journal=...)
study.summary("paper", noise=0.5).success.rate
"""

import hashlib
import json
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import asdict, fields
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from pydantic import TypeAdapter

from fingerdesign.analysis.case import Clock, gage_array
from fingerdesign.analysis.stages import one_thread
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.metrics import MOST_FORCE, JudgedGrip
from fingerdesign.control.roster import needs_training
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.base import ResultError, closed, json_text
from fingerdesign.records.folder import RecordFolder, write_grip_csv
from fingerdesign.runtime.isolate import ProcessError
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.machine import largest_memory_MB
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.sensing.model import (
    CONTACT_SIZE_MM,
    MESHED,
    grip_problem,
    model_data,
    opposite_problem,
)
from fingerdesign.sensing.train.result import estimator_faults, training_result_for
from fingerdesign.trials.bench import GOOD_AMPLIFIER, Cell, ControlGrid, GripBench, refuse
from fingerdesign.trials.page import chart_png, control_html
from fingerdesign.trials.record import (
    CSV_FILE,
    RECORD_FILE,
    ControlStudy,
    conditions_data,
    control_data,
    grips_csv,
)
from fingerdesign.trials.tuning import Report
from fingerdesign.version import __version__, versions

Shared = TypeVar("Shared")
Job = TypeVar("Job")
Made = TypeVar("Made")

# What is done is kept, grip by grip, under all that decides it: an interrupted study goes on where
# it stopped, also with other frictions, weights, noises or controllers than before.


def key_of(cell: Cell | JudgedGrip) -> str:
    """What tells one grip of a study from another."""
    return repr((cell.controller, cell.friction, cell.mass_g, cell.noise, cell.tug))


KIND = "a control study"  # of journals
KEPT = [field.name for field in fields(JudgedGrip)]  # of a grip, in a journal


def kept_records(journal: Journal, kind: Any, what: str) -> dict[str, Any]:
    """A journal's grips, or lists of them, by key. ResultError where a record is not ``what``."""
    closed(JudgedGrip)  # all its keys, and no others
    adapter = TypeAdapter(kind)
    try:
        return {
            key: adapter.validate_json(json.dumps(record), strict=True) for key, record in journal
        }
    except ValueError as error:
        words = f"{journal.path}: not {what}; move it away, or choose another --out"
        raise ResultError(words) from error


def run_batches(
    bench: GripBench,
    batches: Iterable[Sequence[Cell]],
    journal: Journal,
    workers: int,
    report: Report = lambda message, fraction: None,
) -> dict[str, JudgedGrip]:
    """All cells' outcomes by their keys; those that the journal does not hold are run, and kept.

    workers 1: in this process. An interruption waits for the batches that are running, a second or
    two. Raises SolverError where a process died.
    """
    found = kept_records(journal, JudgedGrip, "a grip of a control study")
    total, left = 0, []
    for cells in batches:
        total += len(cells)
        if rest := [cell for cell in cells if key_of(cell) not in found]:
            left.append(rest)
    done = total - sum(map(len, left))
    for outcomes in in_processes(GripBench.run_batch, bench, left, workers):
        new = {key_of(each): each for each in outcomes}
        journal.add({key: asdict(each) for key, each in new.items()})
        found |= new
        done += len(new)
        report(f"gripping: {outcomes[0].controller}", done / total)
    return found


def in_processes(
    function: Callable[[Shared, Job], Made], shared: Shared, jobs: Sequence[Job], workers: int
) -> Iterator[Made]:
    """``function(shared, job)`` of each job as they come, in processes; workers 1: here, in order.

    Raises SolverError where a process died.
    """
    if workers <= 1 or len(jobs) <= 1:
        yield from (function(shared, job) for job in jobs)
        return
    with Pool(min(workers, len(jobs)), shared=(shared,)) as pool:
        try:
            yield from pool.as_done(lambda job: pool.call(function, job), jobs)
        except ProcessError as error:
            words = f"a process of the study ended ({error}); was there memory enough? Run it again"
            raise SolverError(f"{words}: it goes on where it stopped") from error


# Of the hardware: what the grid's noises replace.
VARIED = {"gage_noise_microstrain", "gage_noise_microvolt_per_V"}
PAGE_FILE, CHART_FILE = "control.html", "control.png"
# path_*.csv: the grips that the page draws, one each.
FOLDER = RecordFolder(
    "control study", RECORD_FILE, (RECORD_FILE, CSV_FILE, PAGE_FILE, CHART_FILE, "path_*.csv")
)


def study_control(
    design: Design,
    controllers: Sequence[str],
    grid: ControlGrid,
    journal: Path,
    *,
    estimator: GripEstimator | None = None,
    workers: int = 1,
    report: Report = lambda message, fraction: None,
    fidelity: str = "plane-strain",
) -> ControlStudy:
    """Run every grip that the file ``journal`` does not hold yet, and sum up.

    estimator: the regulator's; without one it is taught on this design, or taken from the cache.
    The journal stays: whoever has written the study's files may delete it. Raises DesignError for
    wrong input, ResultError for a journal of something else, SolverError where a process died.
    """
    names = tuple(dict.fromkeys(controllers))
    refuse(grid, names)
    clock = Clock()
    bench = grip_bench(design, names, grid, estimator, workers, report, clock, fidelity)
    digest = study_digest(design, grid, bench.estimator, fidelity)
    batches = list(grid.batches(names))
    # Drawn are the grips at a good amplifier's noise, or at the grid's nearest to it.
    noise = min(grid.noises, key=lambda noise: abs(noise - GOOD_AMPLIFIER))
    with one_thread(), Journal(journal, KIND, digest) as kept:
        with clock.stage("grips"):
            found = run_batches(bench, batches, kept, workers, report)
        report("drawing the paths", 1.0)
        with clock.stage("paths"):
            traces = tuple(_traces(bench, names, noise))
    outcomes = tuple(found[key_of(cell)] for cells in batches for cell in cells)
    whole = sum(clock.seconds.values())
    del clock.seconds["paths"]
    data = control_data(
        outcomes,
        names,
        grid,
        _warnings(bench, outcomes),
        design=design.design.name,
        digest=digest,
        model=_model_data(bench),
        hardware=design.grip.hardware.model_dump(exclude=VARIED),
        warning_stick_ratio=design.grip.warning_stick_ratio,
        seconds={**clock.seconds, "whole": whole},
        workers=workers,
        versions=versions(),
        peak_memory_MB=largest_memory_MB(),
    )
    return ControlStudy(data, outcomes, traces, noise)


def grip_bench(
    design: Design,
    names: Sequence[str],
    grid: ControlGrid,
    estimator: GripEstimator | None,
    workers: int,
    report: Report,
    clock: Clock,
    fidelity: str,
    opposed: bool = True,
) -> GripBench:
    """The model of a design, and an estimator taught on it where a controller needs one.

    estimator: one that is there already; DesignError where it was taught on another finger, or at
    another fidelity. opposed: grips may have another finger on the other side.
    """
    if estimator is not None and (faults := estimator_faults(design, estimator, fidelity)):
        raise DesignError(faults)

    def say(message: str) -> None:
        report(message, 0.0)

    with clock.stage("model"):
        problem = grip_problem(design, fidelity, report=say)
        opposite = opposite_problem(design, fidelity, report=say) if opposed else None
    with clock.stage("teaching"):
        if any(map(needs_training, names)) and estimator is None:
            estimator = training_result_for(design, problem, say, workers, fidelity).estimator
    face, plates = design.gages.face, gage_array(design)
    return GripBench(problem, face, plates, design.grip, grid, estimator, opposite)


def journal_beside(target: Path) -> Path:
    """The file that keeps the grips of an unfinished study for the folder ``target``."""
    return target.with_name(f"{target.name}.unfinished.sqlite")


def study_digest(
    design: Design, grid: ControlGrid, estimator: GripEstimator | None, fidelity: str
) -> str:
    """SHA-256 of all that decides a grip beside its cell, in hexadecimal."""
    shared = {"seed": grid.seed, "hold_s": grid.hold_s, "tug": conditions_data(grid)["tug"]}
    taught = None if estimator is None else estimator.to_json()
    model = [fidelity, CONTACT_SIZE_MM[fidelity], MESHED]
    parts = [design.digest(), __version__, shared, model, taught, KEPT, *CONTROLLERS.contents()]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def write_study(study: ControlStudy, folder: Path) -> None:
    """All products into a folder that exists; the record comes last."""
    rows = [{**asdict(each), "crushed": each.crushed} for each in study.outcomes]
    (folder / CHART_FILE).write_bytes(chart_png(study.data))
    page = control_html(study.data, rows, study.traces, study.trace_noise)
    (folder / PAGE_FILE).write_text(page, encoding="utf-8")
    (folder / CSV_FILE).write_text(grips_csv(study.outcomes), encoding="utf-8")
    for trace in study.traces:
        mu, mass = trace.friction_coefficient, trace.object_mass_g
        write_grip_csv(folder / f"path_{trace.controller}_mu{mu:g}_{mass:g}g.csv", trace)
    (folder / RECORD_FILE).write_text(json_text(study.data), encoding="utf-8")


def _traces(bench: GripBench, names: Sequence[str], noise: float) -> list[GripTrace]:
    """Grips for the page: every controller on the most, a middling and the least slippery object.

    Of a middling weight; run again, for the grid keeps no steps.
    """
    frictions, masses = sorted(bench.grid.frictions), sorted(bench.grid.masses_g)
    chosen = sorted({frictions[0], frictions[len(frictions) // 2], frictions[-1]})
    mass = masses[len(masses) // 2]
    return [
        bench.episode(Cell(name, friction, mass, noise)).trace
        for name in names
        for friction in chosen
    ]


def _model_data(bench: GripBench) -> dict[str, Any]:
    return {
        **model_data(bench.problem),
        "gages": len(bench.plates),
        "face": bench.face,
        "opposite": bench.grip.opposite,
        "preload_mm": bench.bounds.preload,
        "max_approach_mm": bench.bounds.max_approach,
        "largest_bench_force_N": float(bench.calibration(0.0).normal.normal_force[-1]),
        "preload_force_N": _preload_force(bench),
    }


def _preload_force(bench: GripBench) -> float:
    """Normal force at the preload, N, by the bench's press in equal steps."""
    forces = bench.calibration(0.0).normal.normal_force
    share = bench.bounds.preload / bench.bounds.max_approach
    return float(np.interp(share, np.linspace(0.0, 1.0, len(forces)), forces))


def _warnings(bench: GripBench, outcomes: Sequence[JudgedGrip]) -> list[str]:
    """What stands in the way of any controller on this grid, and what failed."""
    found = []
    grid, strongest = bench.grid, float(bench.calibration(0.0).normal.normal_force[-1])
    need = weight_per_finger(max(grid.masses_g)) / min(grid.frictions)
    if strongest < need:
        found.append(
            f"the heaviest, most slippery object needs {need:.1f} N, and grip.max_approach_mm = "
            f"{bench.bounds.max_approach:g} presses with {strongest:.1f} N at most: nothing can "
            "lift it"
        )
    least = weight_per_finger(min(grid.masses_g)) / max(grid.frictions)
    preload = _preload_force(bench)
    if preload >= MOST_FORCE * least:
        found.append(
            f"the lightest, roughest object may be pressed with {MOST_FORCE * least:.2f} N, and "
            f"grip.preload_mm = {bench.bounds.preload:g} presses with {preload:.2f} N already: "
            "nothing can lift it without crushing"
        )
    failed = [each for each in outcomes if each.ending == "failed"]
    if failed:
        found.append(
            f"{len(failed)} of {len(outcomes)} grips failed in the model and count as failures; "
            f"the first: {failed[0].reason}"
        )
    return found
