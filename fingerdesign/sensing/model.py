"""The model that grips are run on by the hundred: condensed once, small, and said how.

A control step costs what its Python costs below some 150 contact nodes, so the contact is meshed
for grips with :data:`CONTACT_SIZE_MM` at the crest. On ``sensitive``, against 0.05 mm, over a
lift's path at mu = 0.2, 0.5 and 0.8: forces to 1e-4, stick ratio 0.006 RMS (at most 0.034, where
the contact has a few nodes), readings 0.35 microstrain RMS; with 0.15 mm 0.009, 0.041 and 0.7. Of
16 grips by the paper's rule and 16 at a fixed ratio none ended otherwise than with 0.05 mm, in half
the time; with 0.15 mm two did. (The rule itself is touchy: one step's difference in a hold changed
the margin of one of them by 45 %, that of half of them by less than 0.02 %.)

In 3-D a finger that can be swept through layers is, :data:`LAYERS` of them at most in half its
depth. Readings need them: on ``maeno2000``, pressed and sheared, the largest error of a reading
against twelve layers is 10 % with four, 4.6 with five, 2.5 with six (1.8 % with four on the softer
plates of ``sensitive``, whose forces keep to 0.4 % and stick ratio to 0.065).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.forecast.limits import refuse
from fingerdesign.analysis.path import object_at_touch
from fingerdesign.analysis.stages import condense, make_mesh
from fingerdesign.checks.load import with_values, without_plates
from fingerdesign.contact.problem import ContactProblem, contact_problem
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.zone import candidate_zone

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

CONTACT_SIZE_MM = {"plane-strain": 0.1, "3d": 0.4}
LAYERS = 6
FIDELITIES = tuple(CONTACT_SIZE_MM)
_ROOM = 1.2  # times the zone of a pure approach: a hanging object drags the contact along


def grip_problem(
    design: Design,
    fidelity: str = "plane-strain",
    contact_size_mm: float | None = None,
    report: Callable[[str], None] = lambda message: None,
) -> ContactProblem:
    """The design against a plane, for the stage travel of its ``[grip]`` table.

    Its gages are those of the array that the slip rule reads; the friction is the bench's. The
    contact is no finer than ``contact_size_mm``, by default :data:`CONTACT_SIZE_MM`. Raises
    DesignError where the design cannot be gripped with or, in plane strain, has no section.
    """
    if design.plates.number < 2:
        remedy = "add plates: without gages there is nothing to feel"
        raise DesignError([Fault("plates.count", design.plates.number, "at least 2", remedy)])
    case = _case(design, fidelity, contact_size_mm)
    refuse(case, fundamental_scene())
    return _condensed(case, case.gage_array, report)


def opposite_problem(
    design: Design,
    fidelity: str = "plane-strain",
    report: Callable[[str], None] = lambda message: None,
) -> ContactProblem | None:
    """The other finger of a lift where ``grip.opposite`` is the bare one; None: a mirror image."""
    if design.grip.opposite != "bare":
        return None
    return _condensed(_case(without_plates(design), fidelity), (), report)


def model_data(problem: ContactProblem) -> dict[str, Any]:
    """What records say of a model that was gripped with."""
    fidelity = "plane-strain" if problem.model.dimension == 2 else "3d"
    return {
        "fidelity": fidelity,
        "contact_size_mm": CONTACT_SIZE_MM[fidelity],
        "contact_nodes": problem.model.nodes,
    }


def _case(design: Design, fidelity: str, contact_size_mm: float | None = None) -> Case:
    """The design as it is gripped with: coarser, and swept through layers where it can be."""
    size = CONTACT_SIZE_MM.get(fidelity, 0.0) if contact_size_mm is None else contact_size_mm
    table = design.mesh if fidelity == "3d" else design.mesh.section
    size = max(size, table.contact_size_mm)
    coarse: dict[str, object] = {"mesh.section.contact_size_mm": size}
    if fidelity == "3d":
        coarse = {"mesh.contact_size_mm": size}
        coarse["mesh.layers"] = min(LAYERS, design.mesh.layers)
        if design.mesh.mesher == "tetwild":
            coarse["mesh.mesher"] = "auto"
    return Case(with_values(design, coarse), None, fidelity, fields=False, go_on=True)


def _condensed(case: Case, gages: tuple[int, ...], report: Callable[[str], None]) -> ContactProblem:
    design, scene = case.design, fundamental_scene()
    reach = design.grip.max_approach_mm
    zone = candidate_zone(design, scene.object, reach).widened(_ROOM, design)
    report("meshing")
    mesh = make_mesh(design, case.fidelity, zone, case.symmetric)
    report(f"condensing {len(mesh.cells)} elements")
    model = condense(design, mesh, zone, scene).reduced.with_gages(gages)
    rigid = object_at_touch(scene.object, design.body)
    return contact_problem(model, rigid, design.grip.bench_friction_coefficient)
