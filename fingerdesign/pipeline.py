"""The whole story: Design + Scene -> solid -> mesh -> reduced model -> increments -> grips.

    analysis = run(Case(design))                 # the fundamental case and the grips, in 3-D
    result = analyse(design, scene, "plane-strain")

Each arrow is a folder of the package: design, geometry, mesh, fem, contact, control. What is asked
for is case.py, what is refused refusals.py, the path load_path.py, the record's words summaries.py;
writing the folder that a user opens is outputs.py.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import AbstractContextManager
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.case import FIDELITIES, Case, Clock, fundamental_scene
from fingerdesign.caveats import caveats
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem, contact_problem
from fingerdesign.design.contact_zone import Zone, candidate_zone, greatest_approach
from fingerdesign.design.layout import plate_frames
from fingerdesign.errors import DesignError, FingerDesignError
from fingerdesign.identity import result_digest, versions
from fingerdesign.load_path import PathStopped, follow_path
from fingerdesign.records import contact_history, increment_result
from fingerdesign.refusals import refuse
from fingerdesign.results import (
    Analysis,
    FieldHistory,
    GageLayout,
    GripResult,
    GripTrace,
    Result,
    SlipStudy,
)
from fingerdesign.runtime.progress import Tell
from fingerdesign.scene_contact import object_at_touch, touch_point
from fingerdesign.summaries import (
    mesh_summary,
    model_summary,
    not_reached,
    parameters,
    peak_memory_MB,
)

if TYPE_CHECKING:
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fem.model import FiniteElementModel
    from fingerdesign.mesh.types import Mesh

__all__ = ["FIDELITIES", "Case", "Clock", "PathStopped", "analyse", "fundamental_scene", "refuse"]

STUDY_FRICTION = (0.2, 0.35, 0.5, 0.7, 1.0)  # of the fundamental case, beside the scene's own

_WIDEN = 1.4  # a candidate zone that the contact has outgrown


def analyse(design: Design, scene: Scene | None = None, fidelity: str = "3d") -> Result:
    """The record of one analysis. Raises FingerDesignError where the work fails."""
    return run(Case(design, scene, fidelity, grips=scene is None, fields=False)).result


def run(case: Case, tell: Tell = lambda message: None, clock: Clock | None = None) -> Analysis:
    """Everything between a design and its report, timed by ``clock``.

    Raises DesignError for a wrong input, another FingerDesignError where a stage fails.
    """
    scene = case.path_scene
    refuse(case, scene)
    case = with_estimator(case, tell)
    if case.fidelity in ("plane-strain", "auto") or case.design.mesh.mesher == "extrude":
        from fingerdesign.mesh.section_process import start_mesher

        start_mesher()  # loads netgen while this process loads the rest
    clock = Clock() if clock is None else clock
    zone = zone_of(case, scene)
    notes: list[str] = []
    while True:
        try:
            return _run_in_zone(case, scene, zone, clock, notes, tell)
        except ZoneExhausted as exhausted:
            if zone.fills(case.design):
                raise
            zone = zone.widened(_WIDEN, case.design)
            notes.append(f"candidate zone widened to {zone}: {exhausted}")
            tell(notes[-1])


def _run_in_zone(
    case: Case, scene: Scene, zone: Zone, clock: Clock, notes: list[str], tell: Tell
) -> Analysis:
    asked, ladder = case, None
    if case.fidelity == "auto":
        from fingerdesign.fidelity.choice import choose

        chosen = choose(case, scene, zone, clock, tell)
        case, model, ladder = chosen.case, chosen.model, chosen.summary
        mesh, zone = model.mesh, chosen.zone
        notes = [*notes, *chosen.reasons]
    else:
        tell("meshing")
        with clock.stage("mesh"):
            mesh = make_mesh(case.design, case.fidelity, zone, case.symmetric)
        tell(f"condensing {len(mesh.cells)} elements")
        model = condense(case.design, mesh, zone, scene)
        clock.add(model.timings)
    design = case.design
    rigid = object_at_touch(scene.object, design.body)
    problem = contact_problem(model.reduced, rigid, scene.object.friction_coefficient)
    tell("loading")
    with clock.stage("increments"), one_thread():
        steps = follow_path(problem, scene, design)
        heard = replace(problem, model=problem.model.with_gages(case.gage_array))
        studies = slip_studies(case, scene, heard) if case.scene is None and case.studied else ()
    grips: list[tuple[GripResult, GripTrace]] = []
    if case.runs_grips:
        tell("gripping")
        with clock.stage("grips"), one_thread():
            bare = bare_opposite(case, problem, zone, scene)
            grips = run_all_grips(design, heard, case.gage_array, bare, case.estimator)
    with clock.stage("report"):
        fields = recover_fields(model, steps) if case.fields else None
    result = Result(
        design=design.design.name,
        scene=case.scene_name or ("fundamental" if case.scene is None else "scene"),
        digest=result_digest(asked.design, scene, asked.asked),
        versions=versions(),
        fidelity="plane-strain" if case.fidelity == "plane-strain" else "3d",
        warnings=tuple(caveats(case, scene, problem, steps)) + not_reached(ladder),
        model=model_summary(model, case, zone, notes),
        mesh=mesh_summary(mesh, design),
        increments=tuple(increment_result(step, design.gages.face) for step in steps),
        grips=tuple(grip for grip, _ in grips),
        seeds={"grip": design.grip.seed},
        timings_s=dict(clock.seconds),
        peak_memory_MB=peak_memory_MB(),
        parameters=parameters(asked.design, scene),
        assumed=design.assumed,
        ladder=ladder,
    )
    return Analysis(
        result=result,
        contact=contact_history(problem, steps),
        slip_studies=tuple(studies),
        grip_traces=tuple(trace for _, trace in grips),
        mesh=mesh,
        fields=fields,
        plates=plate_frames(design),
        gages=GageLayout(**design.gages.model_dump()) if design.plates.number else None,
        depth_mm=design.body.depth_mm,
        problem=heard,
    )


def failed_result(case: Case, error: FingerDesignError, clock: Clock) -> Result:
    """The record of an analysis that did not come to an end: why, and of what."""
    scene = case.path_scene
    return Result(
        design=case.design.design.name,
        scene=case.scene_name or ("fundamental" if case.scene is None else "scene"),
        digest=result_digest(case.design, scene, case.asked),
        versions=versions(),
        fidelity="plane-strain" if case.fidelity == "plane-strain" else "3d",
        status="failed",
        failure=str(error),
        increments=error.increments if isinstance(error, PathStopped) else (),
        seeds={"grip": case.design.grip.seed},
        timings_s=dict(clock.seconds),
        peak_memory_MB=peak_memory_MB(),
        parameters=parameters(case.design, scene),
        assumed=case.design.assumed,
    )


def zone_of(case: Case, scene: Scene) -> Zone:
    """Contact candidates for the scene and, where they are run, the grips (against a plane)."""
    reach, touch = (
        greatest_approach(case.design, scene),
        touch_point(scene.object, case.design.body),
    )
    zone = candidate_zone(case.design, scene.object, reach, touch)
    if case.runs_grips:
        reach = case.design.grip.max_approach_mm
        grips = candidate_zone(case.design, scene.object, reach)
        zone = max(zone, grips, key=lambda each: each.half_width)
    return zone


def make_mesh(design: Design, fidelity: str, zone: Zone, symmetric: bool = True) -> Mesh:
    """The section for plane strain; else the finger or its half z >= 0, by the design's mesher.

    A mesh from a file is what it is: the half only where the file holds the half.
    """
    if fidelity == "plane-strain":
        from fingerdesign.mesh.section import mesh_section

        return mesh_section(design, zone.half_width)
    if design.mesh.mesher == "extrude":
        from fingerdesign.mesh.extrude import extrude

        return extrude(design, zone.half_width, symmetric)
    if design.mesh.mesher == "file":
        from fingerdesign.mesh.imported import imported_mesh

        return imported_mesh(design, symmetric)
    from fingerdesign.mesh.tetwild import tetrahedralise

    return tetrahedralise(design, zone.half_width, symmetric, zone_half_depth_mm=zone.half_depth)


def condense(design: Design, mesh: Mesh, zone: Zone, scene: Scene) -> FiniteElementModel:
    """Assemble, and condense onto the contact candidates and readouts."""
    from fingerdesign.fem.model import build_model, candidate_facets

    if not len(candidate_facets(mesh, zone.half_width, zone.half_depth)):
        raise ZoneExhausted(f"no whole contact facet lies in the candidate zone ({zone})")
    points = np.array(scene.readout.points_mm).reshape(-1, 3)
    return build_model(design, mesh, zone.half_width, points, zone.half_depth)


def one_thread() -> AbstractContextManager[object]:
    """One BLAS thread: contact solves are small, and threads that wait for each other cost far more
    than they save as soon as another process wants the cores (measured: 70 times)."""
    from threadpoolctl import threadpool_limits

    limit: AbstractContextManager[object] = threadpool_limits(limits=1, user_api="blas")
    return limit


def slip_studies(case: Case, scene: Scene, problem: ContactProblem) -> tuple[SlipStudy, ...]:
    """The gage area beside the stick area over the fundamental path, at several frictions."""
    if len(problem.model.gage_x) < 2:
        return ()
    from fingerdesign.control.slip_study import slip_studies as study

    frictions = sorted({*STUDY_FRICTION, scene.object.friction_coefficient})
    rows = [(row[0], row[1]) for row in scene.path.rows]
    return tuple(study(problem, rows, case.design.gages.face, frictions))


def bare_opposite(
    case: Case, problem: ContactProblem, zone: Zone, scene: Scene
) -> ContactProblem | None:
    """The finger opposite where it is the same one without plates; None where it is alike."""
    from fingerdesign.design.bare import without_plates

    if case.design.grip.opposite != "bare":
        return None
    other = without_plates(case.design)
    mesh = make_mesh(other, case.fidelity, zone, case.symmetric)
    model = condense(other, mesh, zone, scene).reduced
    rigid = object_at_touch(scene.object, other.body)
    return contact_problem(model, rigid, problem.friction_coefficient)


def with_estimator(case: Case, tell: Tell) -> Case:
    """The case with what its regulator grips by, taught on the design where none is given.

    Raises DesignError for an estimator of another finger.
    """
    if not case.runs_grips or case.design.grip.controller != "regulator":
        return case
    from fingerdesign.study.lessons import estimator_faults, lesson_for

    if case.estimator is None:
        return replace(case, estimator=lesson_for(case.design, tell=tell).estimator)
    if faults := estimator_faults(case.design, case.estimator):
        raise DesignError(faults)
    return case


def run_all_grips(
    design: Design,
    problem: ContactProblem,
    plates: Sequence[int],
    opposite: ContactProblem | None = None,
    estimator: GripEstimator | None = None,
) -> list[tuple[GripResult, GripTrace]]:
    """The grips of the design's ``[grip]`` table on one condensed model; ``plates`` are those whose
    gages it has, ``opposite`` the other finger where it is unlike, ``estimator`` the regulator's.
    """
    from fingerdesign.control.episode import run_grips

    grip = design.grip
    frictions, mass = grip.friction_coefficients, grip.object_mass_g
    return run_grips(problem, design, frictions, mass, plates, opposite, estimator)


def recover_fields(model: FiniteElementModel, steps: list[Step]) -> FieldHistory:
    """Displacements at the largest stick area and at the last increment under load."""
    stick = [step.measures.stick_area for step in steps]
    loaded = [k for k, step in enumerate(steps) if step.measures.normal_force > 0.0]
    chosen = tuple(sorted({int(np.argmax(stick)), loaded[-1] if loaded else len(steps) - 1}))
    forces = np.array([steps[k].increment.force for k in chosen])
    return FieldHistory(chosen, model.displacement_fields(forces))


def with_report_time(analysis: Analysis, seconds: float) -> Analysis:
    """The analysis with the time of its own report added."""
    timings = dict(analysis.result.timings_s)
    timings["report"] = timings.get("report", 0.0) + seconds
    result = replace(analysis.result, timings_s=timings, peak_memory_MB=peak_memory_MB())
    return replace(analysis, result=result)
