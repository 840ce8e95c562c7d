"""One variant, analysed: a job in, an outcome out. What fails is an outcome that says how."""

import hashlib
import time
from dataclasses import dataclass, replace
from typing import Any, Literal, Self

from pydantic import TypeAdapter

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.case import Case, result_digest
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design, load_controller
from fingerdesign.errors import DesignError, FingerDesignError
from fingerdesign.mesh.section.netgen import start_mesher
from fingerdesign.records.outcome import Failure, FailureKind, Outcome, Validity, bounded
from fingerdesign.runtime.machine import forget_peak_memory, peak_memory_MB, processor_seconds
from fingerdesign.runtime.registry import allow_code, is_reference
from fingerdesign.search.run import measured
from fingerdesign.search.study.file import Cost
from fingerdesign.search.study.metrics import METRICS_VERSION, ON_REQUEST, PLACEMENT, SPREAD
from fingerdesign.search.study.values import Choice
from fingerdesign.sensing.model import EVEN_LAYERS, FIDELITIES, layers_for_many, meshed_for_grips
from fingerdesign.validate.plane_strain import plane_strain_error
from fingerdesign.version import versions

Part = Literal["all", "sensing", "hand"]
EVALUATE = "fingerdesign.search.run.evaluate:evaluated"


def validity_of(case: Case, analysis: Analysis) -> Validity:
    """The forecast of plane strain's error, and what the ladder estimated of the mesh's.

    A sentence says why there is none, of either.
    """
    sentences, plane = list[str](), None
    if analysis.result.model is not None and analysis.result.model.dimension == 2:
        try:
            estimate = plane_strain_error(case.design, case.path_scene)
        except DesignError as error:
            sentences.append(f"no forecast of plane strain's error: {error}")
        else:
            plane = estimate.errors["normal_force"]
            sentences.append(estimate.words)
    mesh = measured.mesh_validity(analysis.result)
    if analysis.result.ladder is None:
        sentences.append("no estimate of the mesh's own error: fidelity 'auto' estimates it")
    return Validity(plane, mesh.mesh_error, (*sentences, *mesh.sentences))


@dataclass(frozen=True)
class Job:
    """An analysis to run, and the prices of its cost.

    scene None: the fundamental case and the grips of the design's ``[grip]`` table. values: the
    studied keys, reported in the outcome. study_keys: keys that the study sets; they are unchanged;
    other sizes of the mesh are those that grips are studied with (sensing/model.py). part: what is
    judged; "sensing": gages without grips, "hand": grips without gages, neither with a stick error.
    on_request: further metrics, of the mold's tolerances (metrics.ON_REQUEST).
    """

    name: str
    design: Design
    cost: Cost
    values: dict[str, Choice]
    scene: Scene | None = None
    scene_name: str = "fundamental"
    fidelity: str = "plane-strain"
    tolerance: float = 0.02
    study_keys: tuple[str, ...] = ()
    part: Part = "all"
    on_request: tuple[str, ...] = ()

    @property
    def case(self) -> Case:
        scene_name = "" if self.scene is None else self.scene_name
        design = self.design
        if self.fidelity in FIDELITIES:
            # Coarser contact in plane strain moves the peak ratio of maeno2000 by up to a fourth.
            size = 0.0 if self.fidelity == "plane-strain" else None
            layers = layers_for_many(design) if self.part == "all" else EVEN_LAYERS
            design = meshed_for_grips(design, self.fidelity, size, self.study_keys, layers)
        return Case(
            design,
            self.scene,
            self.fidelity,
            scene_name,
            grips=self.scene is None and self.part != "sensing",
            fields=False,
            tolerance=self.tolerance,
            studied=self.part != "hand",
            for_page=False,
        )

    def digest(self) -> str:
        """SHA-256 of all that decides the outcome: not of names, of the studied keys or prices.

        The design's name does not count: two studies that meet in a finger share its outcome.
        """
        case = self.case
        decided = result_digest(_nameless(case.design), case.path_scene, case.requested)
        gripped = "" if self.scene is not None else "with grips"
        mold = self.design.mold.model_dump_json() if self.on_request else ""
        parts = (decided, gripped, self.part, f"metrics {METRICS_VERSION}", mold, *self.on_request)
        reported = "\n".join(parts)
        return hashlib.sha256(reported.encode()).hexdigest()

    def to_data(self) -> dict[str, Any]:
        """Plain values that a worker elsewhere makes the job from; see :meth:`from_data`."""
        found: dict[str, Any] = TypeAdapter(Job).dump_python(self, mode="json")
        return found

    @classmethod
    def from_data(cls, data: dict[str, Any]) -> Self:
        """Make the job of :meth:`to_data`. Its sender has judged the design, so that the class of
        its controller may be imported here."""
        name = data.get("design", {}).get("grip", {}).get("controller")
        if is_reference(name):
            allow_code(name)
        load_controller(data.get("design"))
        return TypeAdapter(cls).validate_python(data)

    @property
    def own(self) -> dict[str, Any]:
        """Facts of the job in its outcome that the digest leaves out."""
        return {
            "name": self.name,
            "values": dict(self.values),
            "design": self.design.model_dump(mode="json", exclude_none=True),
            "scene": self.scene_name,
            "fidelity": self.fidelity,
            "seeds": dict.fromkeys(("grip", "stick_error"), self.design.grip.seed),
        }


def load() -> None:
    """Load what an analysis loads, and the mesher's process: two seconds, once for many jobs."""
    start_mesher()


def evaluated(data: dict[str, Any]) -> str:
    """The outcome of a job in a line of JSON; ``data`` as of :meth:`Job.to_data`."""
    return evaluate(Job.from_data(data)).to_json()


def evaluate(job: Job) -> Outcome:
    """Analyse one variant in this process. A failure of the work is an outcome, never raised.

    What is no failure of the work, a fault of this program, is raised.
    """
    forget_peak_memory()
    started, used = time.perf_counter(), processor_seconds()
    try:
        found = _analysed(job)
    except DesignError as error:
        found = failed(job, Failure(_refusal(job), str(error)))
    except FingerDesignError as error:
        found = failed(job, Failure("failed", str(error)))
    except MemoryError as error:
        found = failed(job, Failure("memory", f"this process got no more memory: {error}"))
    used = processor_seconds() - used
    return replace(
        found,
        seconds=time.perf_counter() - started,
        core_seconds=used,
        peak_memory_MB=peak_memory_MB(),
        metrics={**found.metrics, "core_seconds": used} if found.status == "ok" else {},
    )


def relabelled(outcome: Outcome, job: Job) -> Outcome:
    """The outcome with what the job's digest leaves out: its own names, values and prices.

    An outcome may have been computed for another study that met the same finger. Raises ValueError
    for an outcome of another finger.
    """
    if outcome.digest != job.digest():
        raise ValueError(f"{outcome.name} is not an outcome of {job.name}: their digests differ")
    metrics = outcome.metrics
    if "cost" in metrics:
        cost = measured.own_metrics(job.design, job.cost)["cost"]
        metrics = metrics | finite_metrics({"cost": cost})[0]
    return replace(outcome, **job.own, metrics=metrics)


def failed(job: Job, failure: Failure) -> Outcome:
    try:
        digest = job.digest()
    except DesignError as error:  # a file that it names is gone: nothing to keep it by
        digest = hashlib.sha256(f"{job.name}\n{error}".encode()).hexdigest()
    return Outcome(digest=digest, **job.own, status="failed", failure=failure, versions=versions())


def _analysed(job: Job) -> Outcome:
    from fingerdesign.pipeline import run
    from fingerdesign.search.run.hand import lifted

    # Nameless, since another study's job may be given the outcome: its sentences name no design.
    case = job.case
    case = replace(case, design=_nameless(case.design))
    analysis = lifted(case) if job.part == "hand" else run(case)
    result = analysis.result
    reported, unheard = measured.stick_error_of(case, analysis) if job.part == "all" else (None, ())
    validity = validity_of(case, analysis)
    made, unmade = made_metrics(job)
    metrics, endless = finite_metrics(
        {
            **measured.metrics_of(job.design, job.cost, analysis),
            "stick_error": reported,
            "plane_strain_error": validity.plane_strain_error,
            **made,
        }
    )
    return Outcome(
        digest=job.digest(),
        **job.own,
        status="ok",
        metrics=metrics,
        traces=measured.traces_of(analysis),
        grips=measured.grips_of(analysis),
        validity=validity,
        warnings=result.warnings + unheard + unmade + endless,
        versions=result.versions,
    )


def made_metrics(job: Job) -> tuple[dict[str, float | None], tuple[str, ...]]:
    """The metrics of fingers as made, None where the job does not name them; why there are none."""
    found: dict[str, float | None] = dict.fromkeys(ON_REQUEST)
    if not job.on_request:
        return found, ()
    from fingerdesign.search.run.as_made import placement_of, spread_of

    reported: tuple[str, ...] = ()
    if PLACEMENT in job.on_request:
        found[PLACEMENT], reported = placement_of(job.design)
    if {*SPREAD} & {*job.on_request}:
        scattered, why = spread_of(job.case.design, job.scene)
        found, reported = found | scattered, reported + why
    return found, reported


def finite_metrics(
    metrics: dict[str, float | None],
) -> tuple[dict[str, float | None], tuple[str, ...]]:
    """The metrics, None in the place of what is no finite number; and a warning of each such."""
    endless = [name for name, value in metrics.items() if not bounded(value)]
    reported = tuple(f"no {name}: its value is no finite number" for name in endless)
    return metrics | dict.fromkeys(endless), reported


def _nameless(design: Design) -> Design:
    """The design without what decides no number: its name, and which values its source gave."""
    meta = design.design.model_copy(update={"name": "finger"})
    return design.model_copy(update={"design": meta, "assumed": ()})


def _refusal(job: Job) -> FailureKind:
    """The kind of a refusal: "memory" where a machine with more of it would not refuse."""
    from fingerdesign.analysis.forecast.limits import memory_faults, refuse

    if job.fidelity == "auto":
        return "refused"  # the ladder ends where memory does, and says so
    try:
        refuse(replace(job.case, go_on=True), job.case.path_scene)
        return "memory" if memory_faults(job.case) else "refused"
    except DesignError:
        return "refused"
