"""The whole story: Design + Scene -> solid -> mesh -> reduced model -> increments -> grips.

    analysis = run(Case(design))                 # the fundamental case and the grips, in 3-D
    result = analyse(design, scene, "plane-strain")

Each arrow is a folder of the package: design, geometry, mesh, fem, contact, control. What is asked
for is case.py, what is refused refusals.py, the path load_path.py, the record's words summaries.py;
writing the folder that a user opens is outputs.py.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.case import FIDELITIES, Case, Clock, fundamental_scene
from fingerdesign.analysis.caveats import caveats
from fingerdesign.analysis.folder import write_outputs, write_solid
from fingerdesign.analysis.forecast.forecast import forecast_case
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.path import PathStopped, contact_history, follow_path, increment_result
from fingerdesign.analysis.stages import (
    bare_opposite,
    condense,
    make_mesh,
    one_thread,
    recover_fields,
    run_all_grips,
    slip_studies,
    zone_of,
)
from fingerdesign.analysis.summary import (
    failed_result,
    mesh_summary,
    model_summary,
    not_reached,
    parameters,
    peak_memory_MB,
    result_digest,
    versions,
)
from fingerdesign.analysis.touch import object_at_touch
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.problem import contact_problem
from fingerdesign.errors import DesignError, FingerDesignError, SolverError
from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.records.folder import result_folder
from fingerdesign.records.result import (
    GageLayout,
    GripResult,
    GripTrace,
    Result,
)
from fingerdesign.runtime.progress import Tell
from fingerdesign.sensing.lessons import with_estimator

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design

__all__ = ["FIDELITIES", "Case", "Clock", "PathStopped", "analyse", "fundamental_scene", "refuse"]


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
        from fingerdesign.mesh.section.process import start_mesher

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
        from fingerdesign.analysis.fidelity.choice import choose

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


def analyse_into(case: Case, out: Path, tell: Tell = lambda message: None) -> Result:
    """Run a case and write OUT/NAME; a failure of the work is written as a failed result.

    Raises DesignError for wrong input (nothing is written) and ResultError where the folder cannot
    be written. ``result.status`` says how the work ended.
    """
    refuse(case, case.scene or fundamental_scene())
    if case.fidelity != "auto":  # which models that will take is not known yet
        tell(f"forecast: {forecast_case(case)}")
    target = out / case.design.design.name
    clock = Clock()
    with result_folder(target) as folder:
        try:
            tell("building the solid")
            with clock.stage("geometry"):
                write_solid(case.design, folder)
            analysis = run(case, tell, clock)
        except DesignError:
            raise
        except FingerDesignError as error:
            analysis = Analysis(failed_result(case, error, clock))
        except MemoryError:
            short = SolverError("not enough memory for this model; coarsen the mesh")
            analysis = Analysis(failed_result(case, short, clock))
        tell("writing the report")
        analysis = write_outputs(analysis, folder)
    return analysis.result
