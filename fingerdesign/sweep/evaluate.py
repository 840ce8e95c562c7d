"""One variant, analysed: a job in, an outcome out. What fails is an outcome that says how."""

from __future__ import annotations

import hashlib
import resource
import time
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import DesignError, FingerDesignError
from fingerdesign.identity import result_digest, versions
from fingerdesign.sweep.metrics import METRICS_VERSION
from fingerdesign.sweep.outcome import Failure, Outcome

if TYPE_CHECKING:
    from fingerdesign.case import Case
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.sweep.study_file import Choice, Cost


@dataclass(frozen=True)
class Job:
    """What is to be analysed, and what its cost is added up from.

    scene None: the fundamental case and the grips of the design's ``[grip]`` table. values: the
    studied keys, told in the outcome.
    """

    name: str
    design: Design
    cost: Cost
    values: dict[str, Choice]
    scene: Scene | None = None
    scene_name: str = "fundamental"
    fidelity: str = "plane-strain"
    tolerance: float = 0.02

    @property
    def case(self) -> Case:
        """The analysis."""
        from fingerdesign.case import Case

        scene_name = "" if self.scene is None else self.scene_name
        return Case(
            self.design,
            self.scene,
            self.fidelity,
            scene_name,
            grips=self.scene is None,
            fields=False,
            tolerance=self.tolerance,
        )

    def digest(self) -> str:
        """SHA-256 of all that decides the outcome: not of names, of the studied keys or prices.

        The design's name does not count: two studies that meet in a finger share its outcome.
        """
        from fingerdesign.design.io import with_values

        case = self.case
        plain = with_values(self.design, {"design.name": "finger"})
        decided = result_digest(plain, case.path_scene, case.asked)
        gripped = "" if self.scene is not None else "with grips"
        told = "\n".join((decided, gripped, f"metrics {METRICS_VERSION}"))
        return hashlib.sha256(told.encode()).hexdigest()

    def to_data(self) -> dict[str, Any]:
        """Plain values that a worker elsewhere makes the job from; see :meth:`from_data`."""
        return {
            "name": self.name,
            "design": self.design.model_dump(mode="json"),
            "cost": self.cost.model_dump(),
            "values": self.values,
            "scene": None if self.scene is None else self.scene.model_dump(mode="json"),
            "scene_name": self.scene_name,
            "fidelity": self.fidelity,
            "tolerance": self.tolerance,
        }

    @classmethod
    def from_data(cls, data: dict[str, Any]) -> Job:
        """The job of :meth:`to_data`."""
        from fingerdesign.design.scene import Scene
        from fingerdesign.design.schema import Design
        from fingerdesign.sweep.study_file import Cost

        scene = None if data["scene"] is None else Scene.model_validate(data["scene"])
        made = {
            "design": Design.model_validate(data["design"]),
            "cost": Cost.model_validate(data["cost"]),
            "scene": scene,
        }
        return cls(**(data | made))


def evaluate(job: Job) -> Outcome:
    """Analyse one variant in this process. A failure of the work is an outcome, never raised."""
    started, cpu = time.perf_counter(), _processor_seconds()
    try:
        found = _analysed(job)
    except DesignError as error:
        found = failed(job, Failure("refused", str(error)))
    except FingerDesignError as error:
        found = failed(job, Failure("failed", str(error)))
    used = _processor_seconds() - cpu
    return replace(
        found,
        seconds=time.perf_counter() - started,
        core_seconds=used,
        metrics={**found.metrics, "core_seconds": used} if found.status == "ok" else {},
    )


def failed(job: Job, failure: Failure) -> Outcome:
    """The outcome of a job that came to nothing."""
    return Outcome(
        digest=job.digest(),
        name=job.name,
        values=dict(job.values),
        design=job.design.model_dump(mode="json", exclude_none=True),
        scene=job.scene_name,
        fidelity=job.fidelity,
        status="failed",
        failure=failure,
        versions=versions(),
        seeds={"grip": job.design.grip.seed},
    )


def _analysed(job: Job) -> Outcome:
    from fingerdesign.pipeline import run
    from fingerdesign.sweep.measured import grips_of, metrics_of, stick_error_of, traces_of
    from fingerdesign.sweep.validity import validity_of

    analysis = run(job.case)
    result = analysis.result
    told, unheard = stick_error_of(job.case, analysis)
    return Outcome(
        digest=job.digest(),
        name=job.name,
        values=dict(job.values),
        design=job.design.model_dump(mode="json", exclude_none=True),
        scene=job.scene_name,
        fidelity=job.fidelity,
        status="ok",
        metrics={**metrics_of(job.design, job.cost, analysis), "stick_error": told},
        traces=traces_of(analysis),
        grips=grips_of(analysis),
        validity=validity_of(job, analysis),
        warnings=result.warnings + unheard,
        versions=result.versions,
        seeds=result.seeds,
        peak_memory_MB=result.peak_memory_MB,
    )


def _processor_seconds() -> float:
    """Of this process and of those that it started and that have ended."""
    own, ended = (resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN))
    return own.ru_utime + own.ru_stime + ended.ru_utime + ended.ru_stime
