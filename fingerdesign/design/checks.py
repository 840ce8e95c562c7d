"""Whether a design can exist: plates clear of the surface, the faces and each other.

One fault for one cause, with the worst value, the plates (numbered from 0, left to right) and a
computed remedy. Everything is in closed form; nothing here loads a CAD kernel.
"""

from __future__ import annotations

from collections.abc import Set

from fingerdesign.design import clearance
from fingerdesign.design.faults import at_least, at_most, involves
from fingerdesign.design.placing import LEAST_CLEARANCE_MM, placing_faults
from fingerdesign.design.schema import Body, Design
from fingerdesign.errors import Fault

LEAST_SLENDERNESS = 4.0  # length / thickness; a stubbier box is no plate and bends like no plate
LEAST_EDGE_HEIGHT_MM = 0.1  # of a dome, at its lowest corner


Doubt = Set[str]  # dotted keys whose values are not the user's


MOST_MOVES = 5000  # a grip takes about 50


def design_faults(design: Design, doubtful: Doubt = frozenset()) -> list[Fault]:
    """Every fault of the geometry of a design whose keys are sound; empty when it can be built.

    ``doubtful``: keys that were faulty and have their default here; no fault that involves one of
    them is told.
    """
    faults = _body_faults(design.body, doubtful) + _mesh_faults(design, doubtful)
    unsound = {fault.key for fault in faults if fault.key.startswith("body.")}
    faults += _grip_faults(design, doubtful)
    if not involves(doubtful, "plates.count", "plates.placement") and design.plates.number:
        faults += _plate_faults(design, doubtful) + _gage_faults(design, doubtful)
        faults += placing_faults(design, doubtful | unsound)
    return faults


def _grip_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    """Faults of the stage's motions against each other and against the body."""
    grip = design.grip
    faults: list[Fault] = []
    if involves(doubtful, "grip.max_approach_mm", "grip.preload_mm", "grip.approach_step_mm"):
        return faults
    most = design.body.base_height_mm
    if grip.max_approach_mm > most and not involves(doubtful, "body.base_height_mm"):
        bound = f"at most body.base_height_mm = {most:g}"
        remedy = "shorten the stage's travel: the model is of small strains"
        faults.append(Fault("grip.max_approach_mm", grip.max_approach_mm, bound, remedy))
    travel = f"at most grip.max_approach_mm = {grip.max_approach_mm:g}"
    for key in ("preload_mm", "approach_step_mm"):
        value = getattr(grip, key)
        if value > grip.max_approach_mm:
            faults.append(Fault(f"grip.{key}", value, travel, "the stage could not move so far"))
    least = grip.max_approach_mm / MOST_MOVES
    if grip.approach_step_mm < least:
        bound = f"at least grip.max_approach_mm / {MOST_MOVES} = {least:g}"
        remedy = "the travel would take too many moves"
        faults.append(Fault("grip.approach_step_mm", grip.approach_step_mm, bound, remedy))
    return faults


def _body_faults(body: Body, doubtful: Doubt) -> list[Fault]:
    if involves(doubtful, "body.arc_radius_mm", "body.width_mm"):
        return []
    if body.arc_radius_mm < 0.5 * body.width_mm:
        return [
            Fault(
                "body.arc_radius_mm",
                body.arc_radius_mm,
                f"at least body.width_mm / 2 = {0.5 * body.width_mm:g}",
                f"raise it, or lower body.width_mm to at most {at_most(2 * body.arc_radius_mm)}",
            )
        ]
    others = ("shape", "dome_radius_mm", "depth_mm", "base_height_mm")
    if body.dome_radius_mm is not None and not involves(doubtful, *(f"body.{k}" for k in others)):
        least = clearance.least_dome_radius(body, LEAST_EDGE_HEIGHT_MM)
        if body.dome_radius_mm < least:
            return [
                Fault(
                    "body.dome_radius_mm",
                    body.dome_radius_mm,
                    f"such that the dome's corners stay {LEAST_EDGE_HEIGHT_MM} mm above the base",
                    f"raise it to at least {at_least(least)} or lower body.depth_mm",
                )
            ]
    return []


def _mesh_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    faults = []
    mesh = design.mesh
    shape = ("body.shape", "body.depth_mm", "plates.span_mm", "plates.count", "plates.placement")
    if involves(doubtful, "mesh.mesher", *shape):
        pass
    elif mesh.mesher == "extrude" and not design.extruded:
        why = "body.shape = 'arc' and plates.span_mm = body.depth_mm"
        faults.append(
            Fault(
                "mesh.mesher",
                mesh.mesher,
                f"tetwild where the section is not constant along z ({why})",
                "set mesh.mesher = 'tetwild'",
            )
        )
    faults += _sheet_faults(design, doubtful)
    for prefix, sizes in (("mesh", mesh), ("mesh.section", mesh.section)):
        keys = (f"{prefix}.contact_size_mm", f"{prefix}.far_size_mm")
        if sizes.contact_size_mm > sizes.far_size_mm and not involves(doubtful, *keys):
            faults.append(
                Fault(
                    f"{prefix}.contact_size_mm",
                    sizes.contact_size_mm,
                    f"at most {prefix}.far_size_mm = {sizes.far_size_mm:g}",
                    "lower it: far_size_mm is the largest size anywhere",
                )
            )
    return faults


def tetwild_faults(design: Design) -> list[Fault]:
    """What tetwild cannot mesh of a sound design: plates as sheets."""
    if design.plates.model != "sheet" or not design.plates.number:
        return []
    return [
        Fault(
            "plates.model",
            "sheet",
            "'solid' or 'none' where mesh.mesher = 'tetwild'",
            "set mesh.mesher = 'extrude' or plates.model = 'solid'",
        )
    ]


def _sheet_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    """Plates as sheets: only where the section is the same all along z."""
    plates = design.plates
    if plates.model != "sheet" or not plates.number or involves(doubtful, "plates.model"):
        return []
    faults = []
    if design.mesh.element == "P1" and not involves(doubtful, "mesh.element"):
        faults.append(
            Fault(
                "mesh.element",
                "P1",
                "'auto', 'P2' or 'mixed' for plates as sheets",
                "linear elements do not bend; leave mesh.element out",
            )
        )
    shape = ("body.shape", "body.depth_mm", "plates.span_mm")
    if not design.extruded and not involves(doubtful, *shape):
        faults.append(
            Fault(
                "plates.model",
                plates.model,
                "solid or none where the section is not constant along z (body.shape = 'arc' and "
                "plates.span_mm = body.depth_mm)",
                "set plates.model = 'solid'",
            )
        )
    return faults


def _plate_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    plates, depth, faults = design.plates, design.body.depth_mm, []
    stubby = plates.length_mm < LEAST_SLENDERNESS * plates.thickness_mm
    if stubby and not involves(doubtful, "plates.length_mm", "plates.thickness_mm"):
        least = LEAST_SLENDERNESS * plates.thickness_mm
        faults.append(
            Fault(
                "plates.length_mm",
                plates.length_mm,
                f"at least {LEAST_SLENDERNESS:g} x plates.thickness_mm = {least:g}",
                f"lengthen the plate or lower plates.thickness_mm to at most "
                f"{at_most(plates.length_mm / LEAST_SLENDERNESS)}",
            )
        )
    span, inset = plates.span_mm, depth - 2 * LEAST_CLEARANCE_MM
    if involves(doubtful, "plates.span_mm", "body.depth_mm"):
        return faults
    if span is not None and span > depth:
        faults.append(
            Fault(
                "plates.span_mm",
                span,
                f"at most body.depth_mm = {depth:g}",
                f"lower it to {depth:g} or raise body.depth_mm to {span:g}",
            )
        )
    elif span is not None and inset < span < depth:
        faults.append(
            Fault(
                "plates.span_mm",
                span,
                f"body.depth_mm = {depth:g} (full) or at most {inset:g}",
                f"a skin below {LEAST_CLEARANCE_MM} mm over the plate's ends cannot be cast",
            )
        )
    return faults


def _gage_faults(design: Design, doubtful: Doubt) -> list[Fault]:
    gages, plates, faults = design.gages, design.plates, []
    span = plates.span_mm if plates.span_mm is not None else design.body.depth_mm
    long = gages.length_mm > plates.length_mm
    if long and not involves(doubtful, "gages.length_mm", "plates.length_mm"):
        faults.append(
            Fault(
                "gages.length_mm",
                gages.length_mm,
                f"at most plates.length_mm = {plates.length_mm:g}",
                f"shorten the gage or raise plates.length_mm to at least {gages.length_mm:g}",
            )
        )
    if involves(doubtful, "gages.width_mm", "plates.span_mm", "body.depth_mm"):
        return faults
    if gages.width_mm > span:
        faults.append(
            Fault(
                "gages.width_mm",
                gages.width_mm,
                f"at most the plate's span along z, {span:g}",
                f"narrow the gage or raise plates.span_mm to at least {gages.width_mm:g}",
            )
        )
    elif involves(doubtful, "gages.z_mm"):
        pass
    elif abs(gages.z_mm) + 0.5 * gages.width_mm > 0.5 * span + 1e-9:
        reach = 0.5 * (span - gages.width_mm)
        faults.append(
            Fault(
                "gages.z_mm",
                gages.z_mm,
                f"within -{reach:g} ... {reach:g}, so that the gage lies on the plate",
                "move it toward 0, narrow the gage or raise plates.span_mm",
            )
        )
    return faults
