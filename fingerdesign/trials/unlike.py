"""Controllers on fingers that are not the one that was taught: every fault alone, and all at once.

Each plant is drawn by :mod:`fingerdesign.sensing.perturb`, is pressed and sheared on its bench as a
rig would be, and then lifts a few objects. All controllers meet the same plants and objects.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Literal

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.analysis.stages import one_thread
from fingerdesign.control.foresight import CLEARLY
from fingerdesign.control.metrics import JudgedGrip
from fingerdesign.control.plants.plant import Memory
from fingerdesign.control.roster import needs_training
from fingerdesign.errors import DesignError, Fault, FingerDesignError
from fingerdesign.records.base import Count, Size, closed, csv_text, json_text
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.statistics import Share, Spread, spread_of
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.sensing.model import CONTACT_SIZE_MM, MESHED, gripped_case
from fingerdesign.sensing.perturb.faults import ALL, FAULTS
from fingerdesign.sensing.perturb.finger import perturb, perturbed_problems, refuse_faults
from fingerdesign.sensing.train.result import estimator_faults, training_result_for
from fingerdesign.trials.bench import (
    FRICTIONS,
    GOOD_AMPLIFIER,
    MASSES_G,
    Cell,
    ControlGrid,
    GripBench,
    Tug,
    failed_grip,
    refuse,
    seed_of,
)
from fingerdesign.trials.record import COLUMNS, FORESEEN, Foreseen, grip_cells, summarise
from fingerdesign.trials.run import KEPT, in_processes, kept_records
from fingerdesign.version import __version__, versions

if TYPE_CHECKING:
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.schema import Design

RECORD_FILE, CSV_FILE = "unlike.json", "unlike.csv"
KIND = "a study of unlike fingers"  # of journals
NONE, EVERY = "none", "all"  # the model itself; every fault together


# Columns of unlike.csv after fault and plant, as of grips.csv.
_FIELDS = "controller friction mass_g success lifted dropped crushed margin_at_lift unsure ending"
_FIELDS += f" reason {FORESEEN}"
_COLUMNS = {name: field for name, field in COLUMNS.items() if field in _FIELDS.split()}


@closed
@dataclass(frozen=True)
class UnlikeSummary:
    """The lifts of one controller on the fingers of one label; safety_margin: of its successes;
    caught, unannounced, unsure, foreseen: see Summary of control.json."""

    success: Share
    gross_slip: Count
    caught: Count
    crushed: Count
    not_lifted: Count
    failed: Count
    safety_margin: Spread | None
    unannounced: Count | None
    unsure: Share | None
    foreseen: Foreseen


@closed
@dataclass(frozen=True)
class UnlikeData:
    """The content of unlike.json; summaries by label of faults, then by controller."""

    design: str
    digest: str
    fidelity: Literal["plane-strain", "3d"]
    taught_on: str | None
    noise_microstrain: Size
    warning_stick_ratio: Size
    false_alarm_stick_ratio: Size
    plants: Count
    lifts_a_plant: Count
    seed: Count
    faults: dict[str, tuple[str, ...]]
    summaries: dict[str, dict[str, UnlikeSummary]]
    versions: dict[str, str]


FOLDER = RecordFolder("study of unlike fingers", RECORD_FILE, (RECORD_FILE, CSV_FILE))
Chosen = tuple[str, tuple[str, ...]]  # a label, and the faults that it stands for
Job = tuple[str, tuple[str, ...], int]  # and the number of a plant


def chosen_faults(names: Sequence[str]) -> list[Chosen]:
    """The labels' faults; of no name none of them, every one of ALL alone, and all those at once.
    Raises DesignError for an unknown one."""
    known = {NONE: (), **{name: (name,) for name in FAULTS}, EVERY: ALL}
    wrong = [
        Fault("--fault", name, f"one of {', '.join(known)}", "correct it")
        for name in names
        if name not in known
    ]
    if wrong:
        raise DesignError(wrong)
    return [(name, known[name]) for name in dict.fromkeys(names or (NONE, *ALL, EVERY))]


@dataclass(frozen=True)
class UnlikeStudy:
    """The record, and every lift: the label of its fault, its plant's number, what came of it."""

    data: UnlikeData
    lifts: tuple[tuple[str, int, JudgedGrip], ...]


@dataclass(frozen=True)
class _Shared:
    """What every plant of a study has in common."""

    design: Design
    controllers: tuple[str, ...]
    estimator: GripEstimator | None
    fidelity: Literal["plane-strain", "3d"]
    lifts: int
    seed: int


def study_unlike(
    design: Design,
    controllers: Sequence[str],
    faults: Sequence[Chosen],
    plants: int,
    journal: Path,
    *,
    lifts: int = 4,
    seed: int = 0,
    estimator: GripEstimator | None = None,
    workers: int = 1,
    report: Callable[[str, float], None] = lambda message, fraction: None,
    fidelity: Literal["plane-strain", "3d"] = "plane-strain",
) -> UnlikeStudy:
    """Every controller on ``plants`` fingers of each of ``faults`` (a label, the faults in it).

    lifts: objects a plant, friction and weight drawn from the grid's ranges. Gages' noise is that
    of a good amplifier. The file ``journal`` keeps what is done, so that an interruption costs one
    plant. Raises DesignError for wrong input, ResultError for a journal of something else,
    SolverError where a process died.
    """
    names = tuple(dict.fromkeys(controllers))
    refuse(ControlGrid(seed=seed), names)
    refuse_faults(design, {name for _, chosen in faults for name in chosen}, fidelity)
    gripped_case(design, fidelity)
    if estimator is not None and (wrong := estimator_faults(design, estimator, fidelity)):
        raise DesignError(wrong)
    if any(map(needs_training, names)) and estimator is None:
        estimator = training_result_for(
            design, None, lambda message: report(message, 0.0), workers, fidelity
        ).estimator
    shared = _Shared(design, names, estimator, fidelity, lifts, seed)
    jobs = [(label, chosen, plant) for label, chosen in faults for plant in range(plants)]
    with one_thread(), Journal(journal, KIND, _digest(shared, faults, plants)) as kept:
        done = kept_records(kept, list[JudgedGrip], "the lifts of a study of unlike fingers")
        left = [job for job in jobs if _key(job) not in done]
        for job, found in in_processes(lift_plant, shared, left, workers):
            kept.add({_key(job): [asdict(each) for each in found]})
            done[_key(job)] = found
            report(f"gripping: {job[0]}", len(done) / len(jobs))
    every = tuple((job[0], job[2], each) for job in jobs for each in done[_key(job)])
    return UnlikeStudy(_data(shared, faults, plants, every), every)


def write_unlike(study: UnlikeStudy, folder: Path) -> None:
    """The record and every lift into a folder that exists."""
    fields = _COLUMNS.values()
    rows = ([label, plant, *grip_cells(each, fields)] for label, plant, each in study.lifts)
    table = csv_text(["fault", "plant", *_COLUMNS], rows)
    (folder / CSV_FILE).write_text(table, encoding="utf-8")
    text = json_text(study.data, indent=1)
    (folder / RECORD_FILE).write_text(text, encoding="utf-8")


def lift_plant(shared: _Shared, job: Job) -> tuple[Job, list[JudgedGrip]]:
    """All controllers on one plant; one whose model or bench fails is a failure of each."""
    _, faults, plant = job
    seed = int(np.random.SeedSequence([shared.seed, 1, plant]).generate_state(1)[0])
    rng = np.random.default_rng(seed)
    friction = rng.uniform(min(FRICTIONS), max(FRICTIONS), shared.lifts)
    mass = np.exp(rng.uniform(np.log(min(MASSES_G)), np.log(max(MASSES_G)), shared.lifts))
    cells = [
        Cell(name, round(float(mu), 4), round(float(grams), 1), GOOD_AMPLIFIER)
        for name in shared.controllers
        for mu, grams in zip(friction, mass, strict=True)
    ]
    try:
        found = perturb(shared.design, faults, seed)
        bench, held = perturbed_problems(found, shared.fidelity)
    except FingerDesignError as error:
        return job, [failed_grip(each, seed_of(each, shared.seed), str(error)) for each in cells]
    rig = GripBench(
        bench,
        found.design.gages.face,
        gage_array(found.design),
        found.design.grip,
        ControlGrid(seed=shared.seed, tug=Tug(found.tug) if found.tug else None),
        shared.estimator,
        held=held,
    )
    return job, [rig.run_cell(replace(each, tug=found.tug), Memory()) for each in cells]


def _key(job: Job) -> str:
    return f"{job[0]} {job[2]}"


def _digest(shared: _Shared, faults: Sequence[Chosen], plants: int) -> str:
    taught = None if shared.estimator is None else shared.estimator.to_json()
    plain = [shared.design.digest(), shared.controllers, shared.fidelity, shared.lifts, shared.seed]
    model = [CONTACT_SIZE_MM[shared.fidelity], MESHED, __version__]
    text = json.dumps([*plain, *model, taught, list(faults), plants, KEPT, *CONTROLLERS.contents()])
    return hashlib.sha256(text.encode()).hexdigest()


def _data(
    shared: _Shared,
    faults: Sequence[Chosen],
    plants: int,
    lifts: Sequence[tuple[str, int, JudgedGrip]],
) -> UnlikeData:
    """Shares with Wilson's intervals, spreads of the margin at the lift."""
    summaries = {
        label: {
            name: _summary([x for of, _, x in lifts if (of, x.controller) == (label, name)])
            for name in shared.controllers
        }
        for label, _ in faults
    }
    return UnlikeData(
        design=shared.design.design.name,
        digest=shared.design.digest(),
        fidelity=shared.fidelity,
        taught_on=None if shared.estimator is None else shared.estimator.design,
        noise_microstrain=GOOD_AMPLIFIER,
        warning_stick_ratio=shared.design.grip.warning_stick_ratio,
        false_alarm_stick_ratio=shared.design.grip.warning_stick_ratio + CLEARLY,
        plants=plants,
        lifts_a_plant=shared.lifts,
        seed=shared.seed,
        faults=dict(faults),
        summaries=summaries,
        versions=versions(),
    )


def _summary(lifts: Sequence[JudgedGrip]) -> UnlikeSummary:
    every = summarise(lifts)
    return UnlikeSummary(
        success=every.success,
        gross_slip=every.dropped,
        caught=every.caught,
        crushed=every.crushed,
        not_lifted=every.not_lifted,
        failed=every.failed,
        safety_margin=spread_of(each.margin_at_lift for each in lifts if each.success),
        unannounced=every.unannounced,
        unsure=every.unsure,
        foreseen=every.foreseen,
    )
