"""An analysis with the arrays that its report needs, beside the record of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from fingerdesign.analysis.caveats import caveats
from fingerdesign.analysis.path import PathStopped, contact_history, increment_result
from fingerdesign.analysis.summary import (
    mesh_summary,
    model_summary,
    not_reached,
    parameters,
    peak_memory_MB,
    result_digest,
    versions,
)
from fingerdesign.layout.frames import plate_frames
from fingerdesign.records.arrays import (
    ContactHistory,
    FieldHistory,
    GageLayout,
    GripTrace,
    SlipStudy,
)
from fingerdesign.records.result import GripResult, LadderSummary, Result, SlipStudySummary

if TYPE_CHECKING:
    from fingerdesign.analysis.case import Case, Clock
    from fingerdesign.contact.path import Step
    from fingerdesign.contact.problem import ContactProblem
    from fingerdesign.design.scene import Scene
    from fingerdesign.errors import FingerDesignError
    from fingerdesign.fem.model import FiniteElementModel
    from fingerdesign.layout.frames import PlateFrame
    from fingerdesign.layout.zone import Zone
    from fingerdesign.mesh.types import Mesh


@dataclass(frozen=True)
class Analysis:
    """A result and the arrays behind it: all that the report is made from.

    A part that was not computed is None or empty and the report leaves its figures out, saying so.
    depth_mm: the body's depth, which the picture of a plane-strain section is drawn with.
    problem: the condensed finger and its object, with the gages of the array, to ask more of.
    The result's summaries of the slip studies are made from ``slip_studies`` where it has none.
    """

    result: Result
    contact: ContactHistory | None = None
    slip_studies: tuple[SlipStudy, ...] = ()
    grip_traces: tuple[GripTrace, ...] = ()
    mesh: Mesh | None = None
    fields: FieldHistory | None = None
    plates: tuple[PlateFrame, ...] = ()
    gages: GageLayout | None = None
    depth_mm: float = 10.0
    problem: ContactProblem | None = None

    def __post_init__(self) -> None:
        if self.slip_studies and not self.result.slip_studies:
            summaries = tuple(
                SlipStudySummary(
                    friction_coefficient=study.friction_coefficient,
                    rank_correlation=study.rank_correlation,
                    rank_correlation_raw=study.rank_correlation_raw,
                    threshold_microstrain_per_N=study.threshold,
                    force_floor_N=study.force_floor_N,
                )
                for study in self.slip_studies
            )
            result = dataclasses.replace(self.result, slip_studies=summaries)
            object.__setattr__(self, "result", result)


@dataclass(frozen=True)
class Worked:
    """What an analysis has worked with: the case requested and as it was run, model, path.

    problem: the condensed finger and its object; array: the same with the gages of the array alone.
    """

    requested: Case
    case: Case
    scene: Scene
    model: FiniteElementModel
    zone: Zone
    problem: ContactProblem
    array: ContactProblem
    steps: list[Step]
    notes: list[str]
    ladder: LadderSummary | None = None


def analysis_of(
    worked: Worked,
    clock: Clock,
    slip_studies: tuple[SlipStudy, ...],
    grips: list[tuple[GripResult, GripTrace]],
    fields: FieldHistory | None,
) -> Analysis:
    """The record of what has been worked, with the arrays beside it."""
    case, design, mesh = worked.case, worked.case.design, worked.model.mesh
    warnings = caveats(case, worked.scene, worked.problem, worked.steps)
    result = Result(
        **_identity(worked.requested, clock),
        warnings=tuple(warnings) + not_reached(worked.ladder),
        model=model_summary(worked.model, case, worked.zone, worked.notes),
        mesh=mesh_summary(mesh, design),
        increments=tuple(increment_result(step, design.gages.face) for step in worked.steps),
        grips=tuple(grip for grip, _ in grips),
        ladder=worked.ladder,
    )
    return Analysis(
        result=result,
        contact=contact_history(worked.problem, worked.steps),
        slip_studies=slip_studies,
        grip_traces=tuple(trace for _, trace in grips),
        mesh=mesh,
        fields=fields,
        plates=plate_frames(design),
        gages=GageLayout(**design.gages.model_dump()) if design.plates.number else None,
        depth_mm=design.body.depth_mm,
        problem=worked.array,
    )


def failed_analysis(case: Case, error: FingerDesignError, clock: Clock) -> Analysis:
    """The record of an analysis that did not come to an end: why, and of what."""
    increments = error.increments if isinstance(error, PathStopped) else ()
    return Analysis(
        Result(**_identity(case, clock), status="failed", failure=str(error), increments=increments)
    )


def _identity(case: Case, clock: Clock) -> dict[str, Any]:
    """What every record of a case begins with: of what it is, by which code, at what cost."""
    scene = case.path_scene
    return {
        "design": case.design.design.name,
        "scene": case.scene_name or ("fundamental" if case.scene is None else "scene"),
        "digest": result_digest(case.design, scene, case.asked),
        "versions": versions(),
        "fidelity": "plane-strain" if case.fidelity == "plane-strain" else "3d",
        "seeds": {"grip": case.design.grip.seed},
        "timings_s": dict(clock.seconds),
        "peak_memory_MB": peak_memory_MB(),
        "parameters": parameters(case.design, scene),
        "assumed": case.design.assumed,
    }
