"""``fingerdesign study-control``: controllers over friction x weight x noise, on one design.

study = study_control(design, ("paper", "oracle_1.2"), ControlGrid.quick(), journal=...)
study.summary("paper", noise=0.5).success.rate
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.case import gage_array
from fingerdesign.control.hardware import Hardware
from fingerdesign.control.metrics import Outcome
from fingerdesign.control.roster import NAMES
from fingerdesign.errors import DesignError, Fault
from fingerdesign.identity import versions
from fingerdesign.pipeline import one_thread
from fingerdesign.record_folder import RecordFolder
from fingerdesign.study.control_bench import GripBench
from fingerdesign.study.control_grid import GOOD_AMPLIFIER, Cell, ControlGrid
from fingerdesign.study.control_record import (
    CSV_FILE,
    RECORD_FILE,
    ControlStudy,
    conditions_data,
    write_csv,
)
from fingerdesign.study.control_runs import Journal, Tell, key_of, run_lots
from fingerdesign.study.grip_model import CONTACT_SIZE_MM, grip_problem, opposite_problem
from fingerdesign.study.lessons import estimator_faults, lesson_for

if TYPE_CHECKING:
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.schema import Design
    from fingerdesign.result_arrays import GripTrace

VARIED = "gage_noise_microstrain"  # of the hardware: what the grid's noises replace
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
    contact_size_mm: float = CONTACT_SIZE_MM,
    tell: Tell = lambda message, fraction: None,
) -> ControlStudy:
    """Run every grip that ``journal`` (JSON lines) does not hold yet, and sum up.

    estimator: the regulator's; without one it is taught on this design, or taken from the cache.
    The journal stays: whoever has written the study's files may delete it. Raises DesignError for
    wrong input, ResultError for a journal of something else, SolverError where a process died.
    """
    names = tuple(dict.fromkeys(controllers))
    _refuse(names, grid)
    faults = [] if estimator is None else estimator_faults(design, estimator)
    if faults:
        raise DesignError(faults)
    start = time.perf_counter()

    def say(message: str) -> None:
        tell(message, 0.0)

    problem = grip_problem(design, contact_size_mm, say)
    opposite = opposite_problem(design, contact_size_mm, say)
    modelled = time.perf_counter()
    if "regulator" in names and estimator is None:
        estimator = lesson_for(design, problem, say, workers).estimator
    taught = time.perf_counter()
    hardware, plates = hardware_of(design), gage_array(design)
    face = design.gages.face
    bench = GripBench(problem, face, plates, design.grip, hardware, grid, estimator, opposite)
    digest = study_digest(design, grid, estimator, contact_size_mm)
    kept = Journal(journal, digest)
    lots = list(grid.lots(names))
    with one_thread():
        run_lots(bench, lots, kept, workers, tell)
        gripped = time.perf_counter()
        tell("drawing the paths", 1.0)
        noise = shown_noise(grid)
        traces = tuple(_traces(bench, names, noise))
    outcomes = [kept.outcomes[key_of(cell)] for lot in lots for cell in lot.cells]
    done = time.perf_counter()
    from fingerdesign.summaries import peak_memory_MB

    return ControlStudy(
        design=design.design.name,
        digest=digest,
        controllers=names,
        grid=grid,
        outcomes=tuple(outcomes),
        model=_model_data(bench, contact_size_mm),
        hardware={name: value for name, value in asdict(hardware).items() if name != VARIED},
        traces=traces,
        trace_noise=noise,
        seconds={
            "model": modelled - start,
            "teaching": taught - modelled,
            "grips": gripped - taught,
            "whole": done - start,
        },
        workers=workers,
        versions=versions(),
        peak_memory_MB=peak_memory_MB(),
        warnings=tuple(_warnings(bench, outcomes)),
    )


def hardware_of(design: Design) -> Hardware:
    """The rig of the design's ``[grip.hardware]`` table; its gage noise is the grid's to vary."""
    return Hardware(**design.grip.hardware.model_dump())


def journal_beside(target: Path) -> Path:
    """The JSON-lines file that keeps the grips of an unfinished study for the folder ``target``."""
    return target.with_name(f"{target.name}.unfinished.jsonl")


def shown_noise(grid: ControlGrid) -> float:
    """The noise whose grips are drawn: a good amplifier's, or the grid's nearest to it."""
    return min(grid.noises, key=lambda noise: abs(noise - GOOD_AMPLIFIER))


def study_digest(
    design: Design, grid: ControlGrid, estimator: GripEstimator | None, contact_size_mm: float
) -> str:
    """SHA-256 of all that decides a grip beside its cell, in hexadecimal."""
    from fingerdesign import __version__

    conditions = conditions_data(grid)
    shared = {key: conditions[key] for key in ("seed", "hold_s", "tug")}
    taught = None if estimator is None else estimator.to_json()
    parts = [design.digest(), __version__, shared, contact_size_mm, taught]
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()


def write_study(study: ControlStudy, folder: Path) -> None:
    """All products into a folder that exists; the record comes last."""
    from fingerdesign.report.control_html import control_html
    from fingerdesign.report.figures_control import chart_png
    from fingerdesign.result_folder import write_grip_csv

    rows = [{**asdict(each), "crushed": each.crushed} for each in study.outcomes]
    data = study.data()
    (folder / CHART_FILE).write_bytes(chart_png(data))
    (folder / PAGE_FILE).write_text(
        control_html(data, rows, study.traces, study.trace_noise), encoding="utf-8"
    )
    write_csv(folder / CSV_FILE, study.outcomes)
    for trace in study.traces:
        mu, mass = trace.friction_coefficient, trace.object_mass_g
        write_grip_csv(folder / f"path_{trace.controller}_mu{mu:g}_{mass:g}g.csv", trace)
    (folder / RECORD_FILE).write_text(study.to_json(), encoding="utf-8")


def _refuse(names: Sequence[str], grid: ControlGrid) -> None:
    from difflib import get_close_matches

    faults = grid.faults()
    for name in names:
        if name not in NAMES:
            near = get_close_matches(name, NAMES, 1, 0.5)
            remedy = f"did you mean {near[0]}?" if near else "choose one of them"
            faults.append(Fault("--controller", name, f"one of {', '.join(NAMES)}", remedy))
    if faults:
        raise DesignError(faults)


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


def _model_data(bench: GripBench, contact_size_mm: float) -> dict[str, Any]:
    return {
        "fidelity": "plane-strain",
        "contact_size_mm": contact_size_mm,
        "contact_nodes": bench.problem.model.nodes,
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


def _warnings(bench: GripBench, outcomes: Sequence[Outcome]) -> list[str]:
    """What stands in the way of any controller on this grid, and what failed."""
    from fingerdesign.control.judge import weight_per_finger
    from fingerdesign.control.metrics import MOST_FORCE

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
