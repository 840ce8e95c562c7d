"""An analysis: its record, and the arrays that its report needs."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.analysis.case import Case, Clock, result_digest
from fingerdesign.analysis.fidelity.choice import Choice
from fingerdesign.analysis.finite_path import finite_faults, pressure_note
from fingerdesign.analysis.path import (
    PathStopped,
    closed_nodes,
    contact_history,
    deepest,
    increment_result,
)
from fingerdesign.analysis.stages import recover_fields
from fingerdesign.analysis.work import Followed, Lifted, Work
from fingerdesign.arrays import Array, BoolArray
from fingerdesign.contact.measures import Measures, completely_slips, measure
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.contact.uniqueness import other_solutions
from fingerdesign.design.keys import leaves
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design, Gages
from fingerdesign.design.step import portable
from fingerdesign.errors import DesignError, SolverError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.fitting import misfit_words
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import mirrors_in_z, plate_frames
from fingerdesign.mesh.files.imported import import_words
from fingerdesign.mesh.quality import assess
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.arrays import ContactHistory, FieldHistory, GripTrace, SlipStudy
from fingerdesign.records.base import values_of
from fingerdesign.records.result import (
    MeshSummary,
    ModelSummary,
    Result,
    SlipStudySummary,
)
from fingerdesign.reduced import ReducedModel
from fingerdesign.report.page import paragraphs, sentences
from fingerdesign.runtime.machine import largest_memory_MB
from fingerdesign.version import versions

TEMPLATES = Path(__file__).parent / "templates"
CAVEATS, MODEL = TEMPLATES / "caveats.toml", TEMPLATES / "model.txt.j2"
ELEMENT_WORDS = {"P1": "P1", "P2": "P2", "mixed": "P2 displacement, P1 pressure"}
SMALL_STRAIN = 0.1  # approach over height where the paper's linearity has gone by any measure
ENOUGH_NODES = {2: 10, 3: 40}  # in contact: about five facets across half of it
# Searched for other answers above it: on the shipped finger none was found even at 5.
_UNUSUAL_FRICTION = 1.0
_LOCKING = 0.4  # Poisson's ratio from which linear elements are too stiff to be believed
_SPOTS = {"revolved": "the turned body", "dome": "the domed body"}  # that a section makes lines of

Facts = dict[str, dict[str, Any]]  # a caveat's name: the values of its sentence


def caveats(
    chosen: Choice, scene: Scene, problem: ContactProblem, steps: list[Step]
) -> tuple[str, ...]:
    """Facts that a reader must know before believing the numbers, a sentence each."""
    case, ladder = chosen.case, chosen.summary
    found = _of_path(case, problem, steps) | of_choices(case, scene)
    if not problem.law.is_coulomb:
        found["other_law"] = {"law": str(problem.law)}
    if others := _other_answers(problem, steps):
        texts = (f"F_n {o.normal_force:.3g}, F_t {o.tangential_force:.3g} N" for o in others)
        friction = problem.mean_friction(steps[-1].increment.multiplier[:, 0])
        found["other_answers"] = {"friction": friction, "others": "; ".join(texts)}
    if ladder is not None and not ladder.reached:
        quantity, worst = max(ladder.error_estimates.items(), key=lambda item: item[1])
        words = {"quantity": quantity.replace("_", " "), "percent": 100.0 * worst}
        found["not_reached"] = {"ladder": ladder, **words}
    return tuple(paragraphs(CAVEATS, macro, **values)[0] for macro, values in found.items())


def _of_path(case: Case, problem: ContactProblem, steps: list[Step]) -> Facts:
    """Facts of the path that the model is not made for."""
    design, model, found = case.design, problem.model, Facts()
    if case.scene is None and not case.gage_array:
        found["no_row" if design.plates.number else "no_plates"] = {}
    if case.fidelity != "finite" and strained(design, steps):
        approach = deepest(steps)
        share = approach / float(crest_height(design.body))
        refused = finite_faults(design, case.path_scene)
        remedy = refused[0].remedy if refused else "take --fidelity finite"
        found["large_strain"] = {"deepest": approach, "share": share, "remedy": remedy}
    found |= _of_contact(design, model, steps)
    last = steps[-1].measures
    if case.scene is None and not completely_slips(last, model.dimension):
        found["still_sticks"] = {"percent": 100.0 * (last.stick_ratio or 0.0)}
    return found


def _of_contact(design: Design, model: ReducedModel, steps: list[Step]) -> Facts:
    """Facts of the nodes in contact: at the edge, none though pressed, few."""
    found, closed = Facts(), closed_nodes(steps)
    if closed[:, _at_side(design, model.points)].any():
        found["edge"] = {}
    touched = closed.any(axis=1)
    first = int(np.argmax(touched)) if touched.any() else len(steps)
    pressed = [k for k in range(first) if steps[k].increment.motion.approach > 0.0]
    if pressed:
        rows = f"{len(pressed)} row{'s' * (len(pressed) > 1)}"
        found["not_felt"] = {"rows": rows, "first": pressed[0] + 1}
    most = int(closed.sum(axis=1).max())
    if 0 < most < ENOUGH_NODES[model.dimension]:
        table = "mesh.section" if model.dimension == 2 else "mesh"
        found["few_nodes"] = {"most": most, "table": table}
    return found


def strained(design: Design, steps: list[Step]) -> bool:
    """True if a finger is pressed deeper than small strains bear."""
    return deepest(steps) > SMALL_STRAIN * float(crest_height(design.body))


def too_deep(case: Case, scene: Scene, steps: list[Step]) -> bool:
    """True if a finger in 3-D is pressed too deep for small strains, and finite ones are known."""
    deep = case.fidelity == "3d" and strained(case.design, steps)
    return deep and not finite_faults(case.design, scene)


def _at_side(design: Design, points: Array) -> BoolArray:
    """Which contact nodes lie on the edge between contact surface and sides."""
    away = np.abs(points[:, 0])
    if design.body.kind.turned and points.shape[1] == 3:
        away = np.hypot(points[:, 0], points[:, 2])
    return np.asarray(away >= 0.5 * design.body.width_mm - 1e-6)


def of_choices(case: Case, scene: Scene) -> Facts:
    """Keys of the design and the scene that may not mean, or not do, what their writer thinks."""
    design, found = case.design, Facts()
    ratio = design.material_of("body").poissons_ratio
    if design.mesh.element == "P1" and ratio >= _LOCKING:
        found["locking"] = {"nu": ratio}
    if design.plates.model == "none" and design.plates.number:
        found["left_out"] = {}
    if case.fidelity == "plane-strain":
        found |= _of_section(design)
    if scene.path.control == "force" and scene.path.increments_mm:
        found["read_as_forces"] = {}
    if case.fidelity == "finite" and (note := pressure_note(design, scene)):
        found["near_dead_pressure"] = {"note": note}
    if words := misfit_words(design):
        found["gage_does_not_fit"] = {"words": words}
    return found | _of_estimator(case)


def _of_estimator(case: Case) -> Facts:
    """That the grips use an estimator which was trained on another finger."""
    trained_on = "" if case.estimator is None else case.estimator.adopted_from
    return {"other_estimator": {"trained_on": trained_on}} if trained_on else {}


def _of_section(design: Design) -> Facts:
    """Parts of the finger that end within its depth, where a section makes them endless."""
    body = design.body
    if design.extruded or (design.plates.model == "none" and body.core is None and body.straight):
        return {}
    spot = _SPOTS.get(body.shape)
    return {"broken_section": {}} if spot is None else {"turned_section": {"body": spot}}


def _other_answers(problem: ContactProblem, steps: list[Step]) -> list[Measures]:
    """Other solutions of the last increment, where friction is unusually high."""
    last, before = steps[-1].increment, steps[-1].before
    if problem.mean_friction(last.multiplier[:, 0]) <= _UNUSUAL_FRICTION or before is None:
        return []
    others = other_solutions(problem, before, last.motion, last, starts=2)
    return [measure(problem, other) for other in others]


@dataclass(frozen=True)
class Analysis:
    """A result and the arrays behind it: all that the report is made from.

    A part that was not computed is None or empty and the report leaves its figures out, saying so.
    depth_mm: the body's depth, which the picture of a plane-strain section is drawn with.
    problem: the condensed finger and its object, with the gages of the array, to ask more of.
    """

    result: Result
    contact: ContactHistory | None = None
    slip_studies: tuple[SlipStudy, ...] = ()
    grip_traces: tuple[GripTrace, ...] = ()
    mesh: Mesh | None = None
    fields: FieldHistory | None = None
    plates: tuple[PlateFrame, ...] = ()
    gages: Gages | None = None
    depth_mm: float = 10.0
    problem: ContactProblem | None = None


def analysis_of(work: Work, followed: Followed, lifted: Lifted) -> Analysis:
    """The record of a case that was worked, with its arrays."""
    chosen, problem, steps = followed.chosen, followed.problem, followed.steps
    case, design, mesh = chosen.case, chosen.case.design, chosen.model.mesh
    with work.clock.stage("report"):
        fields = recover_fields(chosen.model, steps) if case.fields else None
    error = lifted.mesh_error
    result = Result(
        **_identity(work.requested, work.clock, chosen.case.fidelity),
        warnings=caveats(chosen, work.scene, problem, steps),
        model=model_summary(chosen),
        mesh=mesh_summary(mesh, design),
        increments=tuple(increment_result(step, design.gages.face) for step in steps),
        grips=tuple(grip for grip, _ in lifted.grips),
        slip_studies=tuple(study_summary(study) for study in lifted.studies),
        ladder=chosen.summary,
        measurability=lifted.measurable,
        path_error=followed.error,
        mesh_error=None if isinstance(error, str) else error,
        mesh_error_absent=error if isinstance(error, str) else "",
    )
    return Analysis(
        result=result,
        contact=contact_history(problem, steps),
        slip_studies=lifted.studies,
        grip_traces=tuple(trace for _, trace in lifted.grips),
        mesh=mesh,
        fields=fields,
        plates=plate_frames(design),
        gages=design.gages if design.plates.number else None,
        depth_mm=design.body.depth_mm,
        problem=followed.array,
    )


def failed_analysis(case: Case, error: Exception, clock: Clock) -> Analysis:
    """The record of an analysis that did not come to an end: why, and of what.

    Raises a DesignError again: a wrong input makes no record.
    """
    if isinstance(error, DesignError):
        raise error
    if isinstance(error, MemoryError):
        error = SolverError("not enough memory for this model; coarsen the mesh")
    increments = error.increments if isinstance(error, PathStopped) else ()
    return Analysis(
        Result(**_identity(case, clock), status="failed", failure=str(error), increments=increments)
    )


def _identity(case: Case, clock: Clock, chosen: str = "") -> dict[str, Any]:
    """First values of every record: of what it is, by which code, at what cost; chosen:
    the fidelity it was worked at, where it was."""
    scene, fidelity = case.path_scene, chosen or case.fidelity
    return {
        "design": case.design.design.name,
        "scene": case.scene_name or ("fundamental" if case.scene is None else "scene"),
        "digest": result_digest(case.design, scene, case.requested),
        "versions": versions(),
        "fidelity": "3d" if fidelity == "auto" else fidelity,
        "seeds": {"grip": case.design.grip.seed},
        "timings_s": dict(clock.seconds),
        "peak_memory_MB": largest_memory_MB(),
        "parameters": parameters(case.design, scene),
        "assumed": case.design.assumed,
    }


def model_summary(chosen: Choice) -> ModelSummary:
    """Summary of the model, and a sentence for each choice."""
    model, design = chosen.model, chosen.case.design
    mesh = model.mesh
    mixed = model.element == "mixed" and design.mesh.element == "auto"
    reasons = sentences(MODEL, "reasons", chosen, mixed, mirrors_in_z(design))
    return ModelSummary(
        dimension=2 if mesh.dimension == 2 else 3,
        element=f"{ELEMENT_WORDS[model.element]} {mesh.kind.words}, P1 contact tractions",
        dofs=model.dofs,
        contact_nodes=model.reduced.nodes,
        symmetry=mesh.symmetric,
        reasons=(*reasons, *import_words(mesh), *chosen.notes),
    )


def mesh_summary(mesh: Mesh, design: Design) -> MeshSummary:
    """The mesh's quality in a few numbers."""
    report = assess(mesh, design)
    solid = design.plates.number and design.plates.model == "solid"
    own = {"worst_plate_volume_error": report.worst_plate_volume_error if solid else None}
    return MeshSummary(**values_of(MeshSummary, report, mesh, elements=len(mesh.cells), **own))


def study_summary(study: SlipStudy) -> SlipStudySummary:
    """Summary of a slip study in a result."""
    touching = np.isfinite(study.stick_ratio)
    responding = np.logical_or.accumulate(study.gage_area_mm > 0.0)
    own = {
        "threshold_microstrain_per_N": study.threshold,
        "gage_area_mm": _range(study.gage_area_mm[responding]),
        "stick_length_mm": _range(study.stick_length_mm[touching]),
        "points": len(study.stick_ratio),
    }
    return SlipStudySummary(**values_of(SlipStudySummary, study, **own))


def _range(values: Array) -> tuple[float, float]:
    return (float(values.min()), float(values.max())) if len(values) else (0.0, 0.0)


def parameters(design: Design, scene: Scene) -> dict[str, object]:
    """The keys of design and scene (``scene.``) in dotted form, for tables and comparison."""
    own = design.model_dump(mode="json", exclude={"assumed"})
    given = own | {"scene": scene.model_dump(mode="json")}
    return portable(dict(leaves(given)))
