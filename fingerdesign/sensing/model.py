"""The plane-strain model that grips are run on by the hundred: condensed once, small, and said how.

A control step costs what its Python costs below some 150 contact nodes, so the contact is meshed
for grips with :data:`CONTACT_SIZE_MM` at the crest. On ``sensitive``, against 0.05 mm, over a
lift's path at mu = 0.2, 0.5 and 0.8: forces to 1e-4, stick ratio 0.006 RMS (at most 0.034, where
the contact has a few nodes), readings 0.35 microstrain RMS; with 0.15 mm 0.009, 0.041 and 0.7. Of
16 grips by the paper's rule and 16 at a fixed ratio none ended otherwise than with 0.05 mm, in half
the time; with 0.15 mm two did. (The rule itself is touchy: one step's difference in a hold changed
the margin of one of them by 45 %, that of half of them by less than 0.02 %.)
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from fingerdesign.analysis.case import Case, fundamental_scene, gage_array
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.path import object_at_touch
from fingerdesign.analysis.stages import condense, make_mesh
from fingerdesign.checks.load import with_values, without_plates
from fingerdesign.contact.problem import ContactProblem, contact_problem
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.zone import candidate_zone

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

CONTACT_SIZE_MM = 0.1
_ROOM = 1.2  # times the zone of a pure approach: a hanging object drags the contact along


def grip_problem(
    design: Design,
    contact_size_mm: float = CONTACT_SIZE_MM,
    report: Callable[[str], None] = lambda message: None,
) -> ContactProblem:
    """The design's section against a plane, for the stage travel of its ``[grip]`` table.

    Its gages are those of the array that the slip rule reads; the friction is the bench's. The
    contact is no finer than ``contact_size_mm``. Raises DesignError where the design cannot be
    gripped with or has no section.
    """
    if design.plates.number < 2:
        remedy = "add plates: without gages there is nothing to feel"
        raise DesignError([Fault("plates.count", design.plates.number, "at least 2", remedy)])
    coarse = _coarsened(design, contact_size_mm)
    refuse(Case(coarse, fidelity="plane-strain", fields=False, go_on=True), fundamental_scene())
    return _section(coarse, gage_array(coarse), report)


def opposite_problem(
    design: Design, report: Callable[[str], None] = lambda message: None
) -> ContactProblem | None:
    """The other finger of a lift where ``grip.opposite`` is the bare one; None: a mirror image."""
    if design.grip.opposite != "bare":
        return None
    return _section(_coarsened(without_plates(design), CONTACT_SIZE_MM), (), report)


def _coarsened(design: Design, contact_size_mm: float) -> Design:
    size = max(contact_size_mm, design.mesh.section.contact_size_mm)
    return with_values(design, {"mesh.section.contact_size_mm": size})


def _section(
    design: Design, gages: tuple[int, ...], report: Callable[[str], None]
) -> ContactProblem:
    scene = fundamental_scene()
    reach = design.grip.max_approach_mm
    zone = candidate_zone(design, scene.object, reach).widened(_ROOM, design)
    report("meshing")
    mesh = make_mesh(design, "plane-strain", zone)
    report(f"condensing {len(mesh.cells)} elements")
    model = condense(design, mesh, zone, scene).reduced.with_gages(gages)
    rigid = object_at_touch(scene.object, design.body)
    return contact_problem(model, rigid, design.grip.bench_friction_coefficient)
