"""``fingerdesign study``: controllers over friction, weight and noise, or on perturbed fingers.

found = run_study(design, ("paper", "oracle_1.2"), ControlGrid.quick(), journal=...)
found.summary("paper", noise=0.5).success.rate
"""

import hashlib
import json
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, Literal

import numpy as np

from fingerdesign.analysis.case import Clock, gage_array
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.roster import needs_training
from fingerdesign.design.grip import weight_per_finger
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.base import json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.result import MOST_FORCE
from fingerdesign.records.result_files import write_grip_csv
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.machine import largest_memory_MB
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing import model
from fingerdesign.sensing.perturb.finger import refuse_faults
from fingerdesign.sensing.train.ready import estimator_of
from fingerdesign.sensing.train.result import estimator_faults
from fingerdesign.trials import lerobot, record
from fingerdesign.trials.bench import Bench, GripBench, PerturbedBench
from fingerdesign.trials.figures import chart_png
from fingerdesign.trials.grid import GOOD_AMPLIFIER, Cell, ControlGrid, faults_of, refuse, seed_of
from fingerdesign.trials.page import control_html
from fingerdesign.trials.stored import FIELDS, KIND, Report, run_batches
from fingerdesign.trials.summary import Trial
from fingerdesign.trials.tuning import (
    DESIGN_FILE,
    TuningSetting,
    tune_controllers,
    tuned_design,
    tuned_text,
    tuning_data,
)
from fingerdesign.version import __version__, versions

Fidelity = Literal["plane-strain", "3d"]
# The grid's noises take the place of these keys of the hardware.
VARIED = {"gage_noise_microstrain", "gage_noise_microvolt_per_V"}
PAGE_FILE, CHART_FILE = "control.html", "control.png"
# path_*.csv: the grips that the page draws, one each.
FOLDER = RecordFolder(
    "control study",
    record.RECORD_FILE,
    (record.RECORD_FILE, record.CSV_FILE, PAGE_FILE, CHART_FILE, DESIGN_FILE, "path_*.csv"),
)


@dataclass(frozen=True)
class StudyOptions:
    """Options of a run. workers: processes, 1: this one. tuning: None keeps the design's values.

    estimator: the regulator's; without one it is trained on this design, or taken from the cache.
    """

    estimator: GripEstimator | None = None
    workers: int = 1
    fidelity: Fidelity = "plane-strain"
    tuning: TuningSetting | None = None
    report: Report = lambda message, fraction: None


def run_study(
    design: Design,
    controllers: Sequence[str],
    grid: ControlGrid,
    journal: Path,
    options: StudyOptions = StudyOptions(),
) -> record.ControlStudy:
    """Run every grip that the file ``journal`` does not hold yet, and sum up.

    The journal stays: the caller, who has written the study's files, may delete it. Raises
    DesignError for wrong input and a journal of something else, SolverError where a process died.
    """
    names = tuple(dict.fromkeys(controllers))
    refuse(grid, names)
    _refuse_perturbed(design, grid, options.fidelity)
    Journal(journal, KIND, None).close()  # A damaged one is found before the work.
    clock, report = Clock(), options.report
    bench = _grip_bench(design, names, grid, options, clock)
    digest = _study_digest(design, grid, bench.estimator, options)
    noise = min(grid.noises, key=lambda noise: abs(noise - GOOD_AMPLIFIER))
    batches, tuning, traces = list(grid.batches(names)), None, tuple[GripTrace, ...]()
    with one_thread(), Journal(journal, KIND, digest) as stored:
        with clock.stage("grips"):
            if (setting := options.tuning) is not None:
                own = _judging(bench, design, options.fidelity)
                tuned = tune_controllers(
                    design, own, names, stored, setting, options.workers, report
                )
                tuning = tuning_data(tuned, setting, grid, design.digest())
                design = tuned_design(design, tuned)
                bench = bench.with_grip(design.grip)
            judged = _judging(bench, design, options.fidelity)
            found = run_batches(judged, batches, stored, options.workers, report, design.digest())
        if grid.perturbed is None:
            report("drawing the paths", 1.0)
            with clock.stage("paths"):
                traces = tuple(_traces(bench, names, noise))
    cells = [cell for batch in batches for cell in batch]
    trials = tuple(Trial(cell, seed_of(cell, grid.seed), found[cell]) for cell in cells)
    whole = sum(clock.seconds.values())
    clock.seconds.pop("paths", None)
    data = record.control_data(
        trials,
        names,
        grid,
        warnings_of(bench, trials),
        design=design.design.name,
        digest=digest,
        model=_model_data(bench),
        hardware=design.grip.hardware.model_dump(exclude=VARIED, exclude_none=True),
        warning_stick_ratio=design.grip.warning_stick_ratio,
        trained_on=None if bench.estimator is None else bench.estimator.design,
        tuning=tuning,
        seconds={**clock.seconds, "whole": whole},
        workers=options.workers,
        versions=versions(),
        peak_memory_MB=largest_memory_MB(),
    )
    return record.ControlStudy(data, trials, traces, noise, design if tuning else None)


def run_lifts(
    design: Design,
    controllers: Sequence[str],
    grid: ControlGrid,
    folder: Path,
    journal: Path,
    options: StudyOptions = StudyOptions(),
) -> dict[str, Any]:
    """Run every grip that the file ``journal`` does not hold yet, and write what its hand measured
    and did as a LeRobot data set.

    Raises as :func:`run_study`, and DesignError as :func:`lerobot.refuse`.
    """
    names, rate = tuple(dict.fromkeys(controllers)), design.grip.hardware.sample_rate_Hz
    lerobot.refuse(rate)
    refuse(grid, names)
    _refuse_perturbed(design, grid, options.fidelity)
    Journal(journal, lerobot.KIND, None).close()  # A damaged one is found before the work.
    bench = _grip_bench(design, names, grid, options, Clock())
    digest = _study_digest(design, grid, bench.estimator, options)
    judged, batches = _judging(bench, design, options.fidelity), list(grid.batches(names))
    with one_thread(), Journal(journal, lerobot.KIND, digest) as stored:
        return lerobot.write_lifts(
            judged, rate, batches, folder, stored, options.workers, options.report
        )


def _refuse_perturbed(design: Design, grid: ControlGrid, fidelity: Fidelity) -> None:
    """Raise DesignError where a design's finger cannot be drawn with the grid's faults."""
    if grid.perturbed is not None:
        names = {name for label in grid.perturbed.labels for name in faults_of(label)}
        refuse_faults(design, names, fidelity)
        model.gripped_case(design, fidelity)


def _grip_bench(
    design: Design, names: Sequence[str], grid: ControlGrid, options: StudyOptions, clock: Clock
) -> GripBench:
    """The model of a design, and an estimator trained on it where a controller needs one.

    DesignError where the given estimator was trained on another finger, or at another fidelity.
    """
    estimator, fidelity = options.estimator, options.fidelity
    if estimator is not None and (faults := estimator_faults(design, estimator, fidelity)):
        raise DesignError(faults)

    def say(message: str) -> None:
        options.report(message, 0.0)

    with clock.stage("model"):
        problem = model.grip_problem(design, fidelity, report=say)
        opposite = None
        if grid.perturbed is None:
            opposite = model.opposite_problem(design, fidelity, report=say)
    with clock.stage("teaching"):
        if any(map(needs_training, names)) and estimator is None:
            estimator = estimator_of(design, say, options.workers, fidelity)
    face, plates = design.gages.face, gage_array(design)
    return GripBench(problem, face, plates, design.grip, grid, estimator, opposite)


def _judging(bench: GripBench, design: Design, fidelity: Fidelity) -> Bench:
    """The bench that judges a design: the model's own, or those of the fingers that are drawn."""
    if bench.grid.perturbed is None:
        return bench
    return PerturbedBench(design, bench.grid, bench.estimator, fidelity)


def journal_beside(target: Path) -> Path:
    """The file that holds the grips of an unfinished study for the folder ``target``."""
    return target.with_name(f"{target.name}.unfinished.sqlite")


def _study_digest(
    design: Design, grid: ControlGrid, estimator: GripEstimator | None, options: StudyOptions
) -> str:
    """SHA-256 of all that decides a grip, its cell apart, in hexadecimal."""
    shared: dict[str, Any] = {
        "seed": grid.seed,
        "hold_s": grid.hold_s,
        "tug": record.conditions_data(grid)["tug"],
    }
    if grid.perturbed is not None:  # Objects are drawn between the ends of these axes.
        shared["ends"] = [(min(axis), max(axis)) for axis in (grid.frictions, grid.masses_g)]
        shared["lifts"] = grid.perturbed.lifts
    trained = None if estimator is None else estimator.to_json()
    meshed = [options.fidelity, model.CONTACT_SIZE_MM[options.fidelity], model.MESHED]
    tuning = None if options.tuning is None else asdict(options.tuning)
    parts = [design.digest(), __version__, shared, meshed, trained, FIELDS, tuning]
    text = json.dumps([*parts, *CONTROLLERS.contents()], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()


def write_study(study: record.ControlStudy, folder: Path) -> None:
    """Write all products into a folder that exists; the record comes last."""
    (folder / CHART_FILE).write_bytes(chart_png(study.data))
    (folder / PAGE_FILE).write_text(control_html(study), encoding="utf-8")
    (folder / record.CSV_FILE).write_text(record.grips_csv(study.trials), encoding="utf-8")
    for trace in study.traces:
        mu, mass = trace.friction_coefficient, trace.object_mass_g
        write_grip_csv(folder / f"path_{trace.controller}_mu{mu:g}_{mass:g}g.csv", trace)
    tuning: record.TuningData | None = study.data["tuning"]
    if study.tuned is not None and tuning is not None:
        text = tuned_text(study.tuned, tuning, study.data["conditions"]["seed"])
        (folder / DESIGN_FILE).write_text(text, encoding="utf-8")
    (folder / record.RECORD_FILE).write_text(json_text(study.data), encoding="utf-8")


def _traces(bench: GripBench, names: Sequence[str], noise: float) -> list[GripTrace]:
    """Run the page's grips: each controller on the most, a middling and the least slippery object.

    Their weight is a middling one; they are run again, for the grid stores no steps.
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
        **model.model_data(bench.problem),
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


def _warnings_of_estimator(bench: GripBench, known: GripEstimator) -> Iterator[str]:
    """Warnings of lifts in this grid that the estimator was not trained on."""
    labels = () if bench.grid.perturbed is None else bench.grid.perturbed.labels
    turns = any("off_centre" in faults_of(label) for label in labels)
    measured = bench.grip.hardware.torque_noise_Nmm is not None
    if turns and measured and not known.curves.turn_radius.any():
        yield (
            "the cell measures torque, and the estimator knows no turn radius: it takes an object "
            "that turns for one that slips; train it again by fingerdesign train --fidelity 3d"
        )
    if known.adopted_from:
        own = "fingerdesign train makes this finger's own"
        yield f"the estimator is that of {known.adopted_from}, another finger; {own}"


def warnings_of(bench: GripBench, trials: Sequence[Trial]) -> list[str]:
    """List what keeps any controller from success on this grid, and grips that failed."""
    found = []
    grid, strongest = bench.grid, float(bench.calibration(0.0).normal.normal_force[-1])
    need = weight_per_finger(max(grid.masses_g)) / min(grid.frictions)
    if strongest < need:
        found.append(
            f"the heaviest, most slippery object needs {need:.1f} N, and grip.max_approach_mm = "
            f"{bench.bounds.max_approach:g} presses with {strongest:.1f} N at most: nothing can "
            "lift it; raise that key, or study less mass (--mass-g) or more friction (--friction)"
        )
    least = weight_per_finger(min(grid.masses_g)) / max(grid.frictions)
    preload = _preload_force(bench)
    if preload >= MOST_FORCE * least:
        found.append(
            f"the lightest, roughest object may be pressed with {MOST_FORCE * least:.2f} N, and "
            f"grip.preload_mm = {bench.bounds.preload:g} presses with {preload:.2f} N already: "
            "nothing can lift it without crushing; lower that key, or study more mass (--mass-g) "
            "or less friction (--friction)"
        )
    found += [] if bench.estimator is None else _warnings_of_estimator(bench, bench.estimator)
    failed = [each.result for each in trials if each.result.outcome == "failed"]
    if failed:
        found.append(
            f"{len(failed)} of {len(trials)} grips failed in the model and count as failures; "
            f"the first: {failed[0].ending}"
        )
    return found
