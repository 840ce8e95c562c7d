"""The stages between a design and what was found: zone, mesh, condensed model, grips, fields."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from threading import Thread
from typing import TypeVar

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.path import problem_at_touch, touch_point
from fingerdesign.analysis.slip_study import slip_studies as study
from fingerdesign.analysis.verdicts import grip_verdicts
from fingerdesign.checks.load import without_plates
from fingerdesign.contact.gross_slip import coefficient_under
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.path import Step
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.contact.solver.kernel import kernel
from fingerdesign.control.calibration import LEAST_GAGES
from fingerdesign.control.episode import run_episodes
from fingerdesign.control.plants.rig import Rig
from fingerdesign.control.signals import line_of
from fingerdesign.design.grip import FORCE_NOISE_N, weight_per_finger
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.fem.factor import load_solver
from fingerdesign.fem.model import FiniteElementModel, build_model, candidate_facets
from fingerdesign.layout.zone import Zone, candidate_zone, greatest_approach
from fingerdesign.mesh.make import mesh_finger
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import Mesh
from fingerdesign.records.arrays import FieldHistory, GripTrace, SlipStudy
from fingerdesign.records.result import GripResult

Made = TypeVar("Made")
_WIDEN = 1.4  # a candidate zone that the contact has outgrown
_PIECES = 4  # of each row of the path
STUDY_FRICTION = (0.2, 0.35, 0.5, 0.7, 1.0)  # Besides the scene's own, in the fundamental case.


def zone_of(case: Case, scene: Scene) -> Zone:
    """The contact candidates for the scene and, where they are run, the grips (against a plane)."""
    design = case.design
    touch = touch_point(scene.object, design.body)
    zone = candidate_zone(design, scene.object, greatest_approach(design, scene), touch)
    inner = zone.half_width
    if case.runs_grips:
        grips = candidate_zone(design, scene.object, design.grip.max_approach_mm)
        zone = max(zone, grips, key=lambda each: each.half_width)
    return replace(zone, inner=inner)


def in_wide_zone(
    design: Design,
    zone: Zone,
    work: Callable[[Zone], Made],
    note: Callable[[str], None] = lambda message: None,
) -> Made:
    """The outcome of ``work`` in the zone, or in a wider one where the contact outgrows it."""
    while True:
        try:
            return work(zone)
        except ZoneExhausted as exhausted:
            zone = widened(design, zone, exhausted)
            note(f"candidate zone widened to {zone}: {exhausted}")


def widened(design: Design, zone: Zone, exhausted: ZoneExhausted) -> Zone:
    """A wider zone than the one that the contact has outgrown; raises ``exhausted`` where that one
    fills the finger."""
    if zone.fills(design):
        raise exhausted
    return zone.widened(_WIDEN, design)


def make_mesh(design: Design, fidelity: str, zone: Zone, symmetric: bool = True) -> Mesh:
    """The section for plane strain; else the finger or its half z >= 0, by the design's mesher.

    A mesh from a file is what it is: the half only where the file holds the half.
    """
    for needed in (load_solver, kernel):  # while the mesher works in its process
        Thread(target=needed, daemon=True).start()
    if fidelity == "plane-strain":
        return mesh_section(design, zone.half_width)
    return mesh_finger(design, zone, symmetric)


def condense(design: Design, mesh: Mesh, zone: Zone, scene: Scene) -> FiniteElementModel:
    """Assemble, and condense onto the contact candidates and readouts, or take the cached model."""
    if not len(candidate_facets(mesh, zone.half_width, zone.half_depth)):
        raise ZoneExhausted(f"no whole contact facet lies in the candidate zone ({zone})")
    points = np.array(scene.readout.points_mm).reshape(-1, 3)
    return build_model(design, mesh, zone.half_width, points, zone.half_depth, store=True)


def slip_studies(case: Case, scene: Scene, problem: ContactProblem) -> tuple[SlipStudy, ...]:
    """The gage area and the stick area at several frictions, where the path is the fundamental.

    Each row is cut into four: with eight points a few large steps decide a rank correlation.
    """
    wanted = case.scene is None and case.studied
    wanted &= problem.law.is_coulomb  # the study scales its path by the friction coefficient
    if not wanted or len(line_of(problem.model.gage_x)) < LEAST_GAGES:
        return ()
    frictions = sorted({*STUDY_FRICTION, scene.object.friction_coefficient})
    rows = [(row[0], row[1]) for row in scene.path.rows]
    gages = case.design.gages
    noise = case.design.grip.hardware.force_noise_N or FORCE_NOISE_N
    return tuple(study(problem, rows, gages.face, frictions, _PIECES, gages.area_share, noise))


def rig_of(case: Case, zone: Zone, scene: Scene, array: ContactProblem) -> Rig:
    """The rig of a case's grips."""
    bare = None
    if case.runs_grips and case.design.grip.opposite == "bare":
        other = without_plates(case.design)  # the finger opposite
        mesh = make_mesh(other, case.fidelity, zone, case.symmetric)
        model = condense(other, mesh, zone, scene).reduced
        bare = problem_at_touch(model, scene.object, other.body)
    return Rig.of(array, case.design, case.gage_array, bare)


def run_grips(case: Case, rig: Rig) -> list[tuple[GripResult, GripTrace]]:
    """A grip of each mass at each friction of ``[grip]``, where the case runs them, lightest first.

    Of a range the ends are lifted. Only where both pass their verdicts the middle can change these,
    and is lifted too.
    """
    if not case.runs_grips:
        return []
    grip = case.design.grip

    def lift(mass_g: float) -> list[tuple[GripResult, GripTrace]]:
        frictions = frictions_of(case, rig.problem, mass_g)
        episodes = run_episodes(rig, frictions, mass_g, case.estimator, case.for_page)
        return [(episode.result, episode.trace) for episode in episodes]

    found = [each for mass in grip.masses_g for each in lift(mass)]
    passing = {verdict.status for verdict in grip_verdicts([each for each, _ in found])} == {"pass"}
    if passing and grip.middle_g is not None:
        found += lift(grip.middle_g)
    return sorted(found, key=lambda each: each[0].object_mass_g)


def frictions_of(case: Case, array: ContactProblem, mass_g: float) -> Sequence[float]:
    """Friction coefficients of the grips of a mass: those of ``[grip]``, or that of the surface."""
    if case.surface is None:
        return case.design.grip.friction_coefficients
    return (coefficient_under(array, weight_per_finger(mass_g)),)


def recover_fields(model: FiniteElementModel, steps: list[Step]) -> FieldHistory:
    """Displacements at the largest stick area and at the last increment under load."""
    stick = [step.measures.stick_area for step in steps]
    loaded = [k for k, step in enumerate(steps) if step.measures.normal_force > 0.0]
    chosen = tuple(sorted({int(np.argmax(stick)), loaded[-1] if loaded else len(steps) - 1}))
    known = [moved for k in chosen if (moved := steps[k].displacement) is not None]
    if known:
        return FieldHistory(chosen, np.array(known))
    forces = np.array([steps[k].increment.force for k in chosen])
    return FieldHistory(chosen, model.displacement_fields(forces))
