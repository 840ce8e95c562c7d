"""Whether a design can exist: plates clear of the surface, the faces and each other.

One fault for one cause, with the worst value, the plates (numbered from 0, left to right) and a
computed remedy. Everything is in closed form; nothing here loads a CAD kernel.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from fingerdesign.design import clearance
from fingerdesign.design.layout import Array, PlateFrame, plate_frames
from fingerdesign.design.schema import Body, Design, Plates
from fingerdesign.errors import Fault

# Thinner skins of rubber tear when the mold is opened, and no mesh of sane size resolves them.
LEAST_CLEARANCE_MM = 0.1
# Gap between plates, in thicknesses: below it, the rubber between is thinner than half a plate.
LEAST_GAP = 0.5
LEAST_SLENDERNESS = 4.0  # length / thickness; a stubbier box is no plate and bends like no plate
LEAST_EDGE_HEIGHT_MM = 0.1  # of a dome, at its lowest corner


def design_faults(design: Design) -> list[Fault]:
    """Every fault of the geometry of a design whose keys are sound; empty when it can be built."""
    faults = _body_faults(design.body) + _mesh_faults(design)
    body_sound = not any(fault.key.startswith("body.") for fault in faults)
    if design.plates.number:
        faults += _plate_faults(design) + _gage_faults(design)
        if body_sound:
            faults += _placing_faults(design)
    return faults


def at_least(value: float) -> str:
    """Write a lower bound, rounded up to a micrometre.

    >>> at_least(0.8600000001)
    '0.861'
    """
    return f"{math.ceil(value * 1000.0 - 1e-9) / 1000.0:.10g}"


def at_most(value: float) -> str:
    """Write an upper bound, rounded down to a micrometre."""
    return f"{math.floor(value * 1000.0 + 1e-9) / 1000.0:.10g}"


def _body_faults(body: Body) -> list[Fault]:
    if body.arc_radius_mm < 0.5 * body.width_mm:
        return [
            Fault(
                "body.arc_radius_mm",
                body.arc_radius_mm,
                f"at least body.width_mm / 2 = {0.5 * body.width_mm:g}",
                f"raise it, or lower body.width_mm to at most {at_most(2 * body.arc_radius_mm)}",
            )
        ]
    if body.dome_radius_mm is not None:
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


def _mesh_faults(design: Design) -> list[Fault]:
    faults = []
    mesh = design.mesh
    if mesh.mesher == "extrude" and not design.extruded:
        why = "body.shape = 'arc' and plates.span_mm = body.depth_mm"
        faults.append(
            Fault(
                "mesh.mesher",
                mesh.mesher,
                f"tetwild where the section is not constant along z ({why})",
                "set mesh.mesher = 'tetwild'",
            )
        )
    for prefix, sizes in (("mesh", mesh), ("mesh.section", mesh.section)):
        if sizes.contact_size_mm > sizes.far_size_mm:
            faults.append(
                Fault(
                    f"{prefix}.contact_size_mm",
                    sizes.contact_size_mm,
                    f"at most {prefix}.far_size_mm = {sizes.far_size_mm:g}",
                    "lower it: far_size_mm is the largest size anywhere",
                )
            )
    return faults


def _plate_faults(design: Design) -> list[Fault]:
    plates, depth, faults = design.plates, design.body.depth_mm, []
    if plates.length_mm < LEAST_SLENDERNESS * plates.thickness_mm:
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


def _gage_faults(design: Design) -> list[Fault]:
    gages, plates, faults = design.gages, design.plates, []
    span = plates.span_mm if plates.span_mm is not None else design.body.depth_mm
    if gages.length_mm > plates.length_mm:
        faults.append(
            Fault(
                "gages.length_mm",
                gages.length_mm,
                f"at most plates.length_mm = {plates.length_mm:g}",
                f"shorten the gage or raise plates.length_mm to at least {gages.length_mm:g}",
            )
        )
    if gages.width_mm > span:
        faults.append(
            Fault(
                "gages.width_mm",
                gages.width_mm,
                f"at most the plate's span along z, {span:g}",
                f"narrow the gage or raise plates.span_mm to at least {gages.width_mm:g}",
            )
        )
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


def _placing_faults(design: Design) -> list[Fault]:
    body, plates = design.body, design.plates
    frames = plate_frames(design)
    corners = clearance.all_corners(frames)
    # Where a regular row leaves the arc's circle it has no height; the sides refuse it.
    placed = ~np.isnan(corners).any(axis=(1, 2))
    faults = _side_fault(body, plates, frames, corners)
    if not placed.all() or faults:
        return faults + _gap_fault(design, corners[placed])
    depth = body.depth_mm
    half_span = 0.5 * min(plates.span_mm if plates.span_mm is not None else depth, depth)
    faults += _cover_fault(body, plates, corners, half_span)
    faults += _base_fault(body, plates, corners)
    return faults + _gap_fault(design, corners)


def _key(plates: Plates, index: int, regular: str) -> tuple[str, object]:
    """Key and value to blame for plate ``index``: ``plates.regular``, or its own placement row."""
    if plates.placement is None:
        return f"plates.{regular}", getattr(plates, regular)
    return f"plates.placement[{index}]", list(plates.placement[index])


def _side_fault(
    body: Body, plates: Plates, frames: tuple[PlateFrame, ...], corners: Array
) -> list[Fault]:
    reach = np.abs(corners[..., 0]).max(axis=1)
    worst = int(np.argmax(reach))
    allowed = 0.5 * body.width_mm - LEAST_CLEARANCE_MM
    if reach[worst] <= allowed + 1e-9:
        return []
    centre = abs(frames[worst].x)
    key, value = _key(plates, worst, "pitch_mm" if centre else "length_mm")
    inner = allowed - (reach[worst] - centre)  # the farthest that this plate's centre may be
    remedy = f"raise body.width_mm to at least {at_least(2 * (reach[worst] + LEAST_CLEARANCE_MM))}"
    if plates.placement is not None and inner >= 0:
        remedy = f"move it to |x| <= {at_most(inner)} or {remedy}"
    elif inner > 0 and centre > 0:
        remedy = f"lower it to at most {at_most(value * inner / centre)} or {remedy}"
    bound = f"such that plates stay {LEAST_CLEARANCE_MM} mm inside |x| = {0.5 * body.width_mm:g}"
    return [Fault(key, value, f"{bound} (plate {worst} reaches {reach[worst]:.4g})", remedy)]


def _cover_fault(body: Body, plates: Plates, corners: Array, half_span: float) -> list[Fault]:
    distances = clearance.cover_clearances(body, corners, half_span)
    worst = int(np.argmin(distances))
    if distances[worst] >= LEAST_CLEARANCE_MM - 1e-9:
        return []
    key, value = _key(plates, worst, "cover_mm")
    if plates.placement is None:
        short = clearance.cover_shortfall(body, corners, half_span, LEAST_CLEARANCE_MM)
        remedy = f"raise plates.cover_mm to at least {at_least(plates.cover_mm + short)}"
    else:
        own = corners[worst : worst + 1]
        short = clearance.cover_shortfall(body, own, half_span, LEAST_CLEARANCE_MM)
        remedy = f"lower its y by at least {at_least(short)}"
    if math.isinf(short):
        remedy = "move the plates inward"
    bound = f"such that plates lie {LEAST_CLEARANCE_MM} mm below the contact surface"
    return [Fault(key, value, f"{bound} (plate {worst}: {distances[worst]:.4g})", remedy)]


def _base_fault(body: Body, plates: Plates, corners: Array) -> list[Fault]:
    heights = corners[..., 1].min(axis=1)
    worst = int(np.argmin(heights))
    short = LEAST_CLEARANCE_MM - float(heights[worst])
    if short <= 1e-9:
        return []
    key, value = _key(plates, worst, "cover_mm")
    raised = at_least(body.base_height_mm + short)
    remedy = f"raise body.base_height_mm to at least {raised}"
    if plates.placement is not None:
        remedy = f"raise its y by at least {at_least(short)}"
    elif plates.cover_mm > short:
        remedy = f"lower plates.cover_mm to at most {at_most(plates.cover_mm - short)} or {remedy}"
    bound = f"such that plates stay {LEAST_CLEARANCE_MM} mm above the base y = 0"
    return [Fault(key, value, f"{bound} (plate {worst}: {heights[worst]:.4g})", remedy)]


def _gap_fault(design: Design, corners: Array) -> list[Fault]:
    plates, gap = design.plates, clearance.least_gap(corners)
    least = LEAST_GAP * plates.thickness_mm
    if gap is None or gap.distance >= least - 1e-9:
        return []
    key, value = _key(plates, gap.second, "pitch_mm")
    near = "cross" if gap.distance == 0 else f"come within {gap.distance:.4g}"
    bound = f"such that plates stay {least:g} mm (half a thickness) apart"
    if plates.placement is None:
        remedy = _wider_pitch(design, least)
    else:
        remedy = f"move it away from plate {gap.first}"
    return [Fault(key, value, f"{bound} (plates {gap.first} and {gap.second} {near})", remedy)]


def _wider_pitch(design: Design, least: float) -> str:
    """The least pitch at which neighbours are ``least`` apart, by bisection, as a remedy."""
    plates = design.plates
    shorter = "shorten, thin or turn the plates, or lower plates.count"
    low, high = plates.pitch_mm, plates.length_mm + plates.thickness_mm + least

    def apart(pitch: float) -> bool:
        trial = design.model_copy(update={"plates": plates.model_copy(update={"pitch_mm": pitch})})
        corners = clearance.all_corners(plate_frames(trial))
        if np.isnan(corners).any():
            return False
        gap = clearance.least_gap(corners, clearance.adjacent(len(corners)))
        return gap is not None and gap.distance >= least

    def fits(pitch: float) -> bool:
        half = 0.5 * (plates.number - 1) * pitch
        angle = math.radians(plates.angle_deg)
        along, across = 0.5 * plates.length_mm, 0.5 * plates.thickness_mm
        extent = along * abs(math.cos(angle)) + across * abs(math.sin(angle))
        return half + extent <= 0.5 * design.body.width_mm - LEAST_CLEARANCE_MM

    widest = _largest(fits, 0.0, high)
    if widest <= low or not apart(widest):
        return shorter
    pitch = widest - _largest(lambda less: apart(widest - less), 0.0, widest - low)
    return f"raise plates.pitch_mm to at least {at_least(pitch)} or {shorter}"


def _largest(holds: Callable[[float], bool], low: float, high: float) -> float:
    """The largest value in [low, high] up to which ``holds``, by bisection; it holds at ``low``."""
    if holds(high):
        return high
    for _ in range(40):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
