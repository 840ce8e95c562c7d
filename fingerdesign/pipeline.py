"""The whole story: Design + Scene -> solid -> mesh -> reduced model -> increments -> grips.

    analysis = run(Case(design))                 # the fundamental case and the grips, in 3-D
    result = analyse(design, scene, "plane-strain")

Each arrow is a folder of the package: design, geometry, mesh, fem, contact, control. Writing the
folder that a user opens is outputs.py.
"""

from __future__ import annotations

import resource
import time
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.caveats import caveats
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.design.checks import tetwild_faults
from fingerdesign.design.contact_zone import Zone, candidate_zone, greatest_approach
from fingerdesign.design.layout import crest_height, plate_frames
from fingerdesign.design.scene_checks import MOST_MOTION, scene_faults
from fingerdesign.errors import DesignError, Fault, FingerDesignError, SolverError
from fingerdesign.identity import result_digest, versions
from fingerdesign.records import contact_history, increment_result
from fingerdesign.results import (
    Analysis,
    FieldHistory,
    GageLayout,
    GripResult,
    GripTrace,
    IncrementResult,
    MeshSummary,
    ModelSummary,
    Result,
    SlipStudy,
)
from fingerdesign.scene_contact import object_at_touch, steps_sideways, targets, touch_point

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.fem.model import FiniteElementModel
    from fingerdesign.mesh.types import Mesh

Tell = Callable[[str], None]
ELEMENT_WORDS = {"P1": "P1", "P2": "P2", "mixed": "P2 displacement, P1 pressure"}
FIDELITIES = ("plane-strain", "3d")
STUDY_FRICTION = (0.2, 0.35, 0.5, 0.7, 1.0)  # of the fundamental case, beside the scene's own

_WIDEN = 1.4  # a candidate zone that the contact has outgrown


@dataclass(frozen=True)
class Case:
    """What is to be analysed. ``scene`` None: the fundamental case, its study and the grips."""

    design: Design
    scene: Scene | None = None
    fidelity: str = "3d"
    scene_name: str = ""
    grips: bool = True
    fields: bool = True


@dataclass
class Clock:
    """Seconds by stage."""

    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        try:
            yield
        finally:
            elapsed = time.perf_counter() - start
            self.seconds[name] = self.seconds.get(name, 0.0) + elapsed


def analyse(design: Design, scene: Scene | None = None, fidelity: str = "3d") -> Result:
    """The record of one analysis. Raises FingerDesignError where the work fails."""
    return run(Case(design, scene, fidelity, grips=scene is None, fields=False)).result


def run(case: Case, tell: Tell = lambda message: None, clock: Clock | None = None) -> Analysis:
    """Everything between a design and its report, timed by ``clock``.

    Raises DesignError for a wrong input, another FingerDesignError where a stage fails.
    """
    scene = case.scene or fundamental_scene()
    refuse(case, scene)
    if case.fidelity == "plane-strain" or case.design.mesh.mesher == "extrude":
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
    design = case.design
    symmetric = design.mirrors_in_z and scene.mirrors_in_z
    tell("meshing")
    with clock.stage("mesh"):
        mesh = make_mesh(design, case.fidelity, zone, symmetric)
    tell(f"condensing {len(mesh.cells)} elements")
    model = condense(design, mesh, zone, scene)
    for stage, seconds in model.timings.items():
        clock.seconds[stage] = clock.seconds.get(stage, 0.0) + seconds
    rigid = object_at_touch(scene.object, design.body)
    problem = contact_problem(model.reduced, rigid, scene.object.friction_coefficient)
    tell("loading")
    with clock.stage("increments"), one_thread():
        steps = _follow(problem, scene, design)
        studies = slip_studies(case, scene, problem) if case.scene is None else ()
    grips: list[tuple[GripResult, GripTrace]] = []
    if case.grips and case.scene is None and design.plates.number:
        tell("gripping")
        with clock.stage("grips"), one_thread():
            grips = run_all_grips(design, problem)
    with clock.stage("report"):
        fields = recover_fields(model, steps) if case.fields else None
    result = Result(
        design=design.design.name,
        scene=case.scene_name or ("fundamental" if case.scene is None else "scene"),
        digest=result_digest(design, scene, case.fidelity),
        versions=versions(),
        fidelity="plane-strain" if case.fidelity == "plane-strain" else "3d",
        warnings=tuple(caveats(case, scene, problem, steps)),
        model=model_summary(model, case, zone, notes),
        mesh=mesh_summary(mesh, design),
        increments=tuple(increment_result(step, design.gages.face) for step in steps),
        grips=tuple(grip for grip, _ in grips),
        seeds={"grip": design.grip.seed},
        timings_s=dict(clock.seconds),
        peak_memory_MB=peak_memory_MB(),
        parameters=parameters(design, scene),
        assumed=design.assumed,
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
    )


class PathStopped(SolverError):
    """A row of the path has no accepted answer; ``increments`` holds those before it."""

    def __init__(self, message: str, increments: tuple[IncrementResult, ...]) -> None:
        super().__init__(message)
        self.increments = increments


def _refuse_far(motion: Motion, most: float) -> None:
    """Motions that forces led to are held to what prescribed ones are."""
    if max(abs(motion.approach), abs(motion.shear)) > most:
        raise SolverError(
            f"the forces lead to {motion}: more than {most:.4g} mm, half of the finger's height, "
            "where strains are small no more; ask for less force"
        )


def _follow(problem: ContactProblem, scene: Scene, design: Design) -> list[Step]:
    path, steps, face = scene.path, list[Step](), design.gages.face
    most = MOST_MOTION * crest_height(design.body)
    try:
        for step in follow(problem, targets(path), substeps=path.substeps):
            _refuse_far(step.increment.motion, most)
            steps.append(step)
    except ZoneExhausted:
        raise
    except SolverError as error:
        where = f"row {len(steps) + 1} of {len(path.rows)} ({path.key}[{len(steps)}])"
        solved = tuple(increment_result(step, face) for step in steps)
        raise PathStopped(f"{where}: {error}", solved) from error
    return steps


def failed_result(case: Case, error: FingerDesignError, clock: Clock) -> Result:
    """The record of an analysis that did not come to an end: why, and of what."""
    scene = case.scene or fundamental_scene()
    return Result(
        design=case.design.design.name,
        scene=case.scene_name or ("fundamental" if case.scene is None else "scene"),
        digest=result_digest(case.design, scene, case.fidelity),
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


def fundamental_scene() -> Scene:
    """The shipped scene of paper 3.1."""
    from fingerdesign.design.io import parse_scene
    from fingerdesign.design.starter import shipped_scene_text

    return parse_scene(shipped_scene_text("fundamental"), "fundamental")


def zone_of(case: Case, scene: Scene) -> Zone:
    """Contact candidates for the scene and, where they are run, the grips (against a plane)."""
    reach, touch = (
        greatest_approach(case.design, scene),
        touch_point(scene.object, case.design.body),
    )
    zone = candidate_zone(case.design, scene.object, reach, touch)
    if case.scene is None and case.grips and case.design.plates.number:
        reach = case.design.grip.max_approach_mm
        grips = candidate_zone(case.design, scene.object, reach)
        zone = max(zone, grips, key=lambda each: each.half_width)
    return zone


def make_mesh(design: Design, fidelity: str, zone: Zone, symmetric: bool = True) -> Mesh:
    """The section for plane strain; else the finger or its half z >= 0, by the design's mesher."""
    if fidelity == "plane-strain":
        from fingerdesign.mesh.section import mesh_section

        return mesh_section(design, zone.half_width)
    if design.mesh.mesher == "extrude":
        from fingerdesign.mesh.extrude import extrude

        return extrude(design, zone.half_width, symmetric)
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


def run_all_grips(design: Design, problem: ContactProblem) -> list[tuple[GripResult, GripTrace]]:
    """The grips of the design's ``[grip]`` table on one condensed model."""
    from fingerdesign.control.episode import run_grips

    return run_grips(problem, design, design.grip.friction_coefficients, design.grip.object_mass_g)


def recover_fields(model: FiniteElementModel, steps: list[Step]) -> FieldHistory:
    """Displacements at the largest stick area and at the last increment under load."""
    stick = [step.measures.stick_area for step in steps]
    loaded = [k for k, step in enumerate(steps) if step.measures.normal_force > 0.0]
    chosen = tuple(sorted({int(np.argmax(stick)), loaded[-1] if loaded else len(steps) - 1}))
    forces = np.array([steps[k].increment.force for k in chosen])
    return FieldHistory(chosen, model.displacement_fields(forces))


PLATE_WORDS = {
    "sheet": "plates are sheets: structural elements in slots of the rubber's mesh",
    "none": "plates are left out: gages read the rubber's strain where the plates would be",
}


def model_summary(
    model: FiniteElementModel, case: Case, zone: Zone, notes: list[str]
) -> ModelSummary:
    """What was modelled, and a sentence for each choice."""
    mesh = model.mesh
    kind = "triangles" if mesh.dimension == 2 else "tetrahedra"
    reasons = [f"contact candidates: {zone}, from the scene's greatest approach"]
    if mesh.dimension == 2:
        reasons.append("plane strain was asked for: one section, forces times the depth")
    elif mesh.symmetric:
        reasons.append("half of the finger: body, plates, object and path mirror in z = 0")
    else:
        reasons.append("the whole finger: object or path does not mirror in z = 0")
    if model.element == "mixed" and case.design.mesh.element == "auto":
        nu = case.design.material_of("body").poissons_ratio
        reasons.append(f"mixed element: at a Poisson's ratio of {nu:g} it is the most accurate")
    if case.design.plates.number and case.design.plates.model != "solid":
        reasons.append(PLATE_WORDS[case.design.plates.model])
    return ModelSummary(
        dimension=2 if mesh.dimension == 2 else 3,
        element=f"{ELEMENT_WORDS[model.element]} {kind}, P1 contact tractions",
        dofs=model.dofs,
        contact_nodes=model.reduced.nodes,
        symmetry=mesh.symmetric,
        reasons=(*reasons, *notes),
    )


def mesh_summary(mesh: Mesh, design: Design) -> MeshSummary:
    """The mesh's quality in a few numbers."""
    from fingerdesign.mesh.quality import assess

    report = assess(mesh, design)
    has_plates = design.plates.number and design.plates.model == "solid"
    return MeshSummary(
        mesher=mesh.mesher,
        elements=len(mesh.cells),
        min_dihedral_deg=report.min_dihedral_deg,
        body_volume_error=report.body_volume_error,
        worst_plate_volume_error=report.worst_plate_volume_error if has_plates else None,
    )


def parameters(design: Design, scene: Scene) -> dict[str, object]:
    """The keys of design and scene (``scene.``) in dotted form, for tables and comparison."""
    flat: dict[str, object] = {}

    def walk(prefix: str, value: object) -> None:
        if isinstance(value, dict):
            for key, inner in value.items():
                walk(f"{prefix}.{key}" if prefix else key, inner)
        else:
            flat[prefix] = value

    walk("", design.model_dump(mode="json", exclude={"assumed"}))
    walk("scene", scene.model_dump(mode="json"))
    return flat


def peak_memory_MB() -> float:
    """Largest resident memory of this process or of one that it started, so far."""
    own = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    started = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss
    return max(own, started) / 1024.0


def with_report_time(analysis: Analysis, seconds: float) -> Analysis:
    """The analysis with the time of its own report added."""
    timings = dict(analysis.result.timings_s)
    timings["report"] = timings.get("report", 0.0) + seconds
    result = replace(analysis.result, timings_s=timings, peak_memory_MB=peak_memory_MB())
    return replace(analysis, result=result)


def refuse(case: Case, scene: Scene) -> None:
    """Raise DesignError with every fault that design, scene and fidelity have together."""
    faults = list(scene_faults(scene, case.design))
    if case.fidelity not in FIDELITIES:
        faults.append(
            Fault("--fidelity", case.fidelity, f"one of {', '.join(FIDELITIES)}", "choose one")
        )
    if case.fidelity == "3d" and case.design.mesh.mesher == "extrude" and not case.design.extruded:
        faults.append(
            Fault(
                "mesh.mesher",
                "extrude",
                "'tetwild' for a finger whose section changes along z",
                "set mesh.mesher = 'tetwild'",
            )
        )
    if case.fidelity == "3d" and case.design.mesh.mesher == "tetwild":
        faults += tetwild_faults(case.design)
    if case.fidelity == "plane-strain" and steps_sideways(scene):
        faults.append(
            Fault(
                "--fidelity",
                case.fidelity,
                "'3d' for a scene that is not the same in every section",
                "take 3d: a sphere, a turned object or one along x, shear_z and twist need it",
            )
        )
    if faults:
        raise DesignError(faults)
