"""Whether plates lie clear of the contact surface, the base, the sides and each other.

Each fault names the worst plate (numbered from 0, left to right) and a computed remedy.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Set

import numpy as np

from fingerdesign.design import clearance
from fingerdesign.design.faults import at_least, at_most, involves
from fingerdesign.design.layout import Array, PlateFrame, plate_frames
from fingerdesign.design.schema import Body, Design, Plates
from fingerdesign.errors import Fault

# Thinner skins of rubber tear when the mold is opened, and no mesh of sane size resolves them.
LEAST_CLEARANCE_MM = 0.1
# Gap between plates, in thicknesses: below it, the rubber between is thinner than half a plate.
LEAST_GAP = 0.5
FLATTEST_MM = 1e4  # the largest body.arc_radius_mm


def placing_faults(design: Design, doubtful: Set[str] = frozenset()) -> list[Fault]:
    """Every fault of where the plates lie that involves no ``doubtful`` key.

    A body that is not sound by itself has a doubtful key. Where that is the arc's radius only, the
    row is judged on the roundest and on the flattest sound arc: what both find does not rest on it.
    """
    arc = "body.arc_radius_mm"
    if involves(doubtful, "body.dome_radius_mm") and design.body.dome_radius_mm is not None:
        # The middle section of every sound dome is the arc's; the cover is not judged (shape).
        straight = design.body.model_copy(update={"shape": "arc", "dome_radius_mm": None})
        design = design.model_copy(update={"body": straight})
        doubtful = doubtful | {"body.shape"}
    half_width = 0.5 * design.body.width_mm
    if involves(doubtful, "body.width_mm") and design.body.arc_radius_mm < half_width:
        design = design.model_copy(
            update={
                "body": design.body.model_copy(update={"width_mm": 2.0 * design.body.arc_radius_mm})
            }
        )
    if not involves(doubtful, arc):
        return _placing_faults(design, doubtful)
    found = []
    for radius in (0.5 * design.body.width_mm, FLATTEST_MM):
        body = design.body.model_copy(update={"arc_radius_mm": radius})
        trial = design.model_copy(update={"body": body})
        found.append(_placing_faults(trial, doubtful - {arc, "body"}, whole=False))
    both = {fault.key for fault in found[0]}
    return [fault for fault in found[1] if fault.key in both]


def _placing_faults(design: Design, doubtful: Set[str], whole: bool = True) -> list[Fault]:
    """The faults on the design's own arc; not ``whole``: those that are the same on any arc."""
    body, plates = design.body, design.plates
    row = {f"plates.{key}" for key in ("length_mm", "thickness_mm")}
    if plates.placement is None:
        row |= {f"plates.{key}" for key in ("count", "pitch_mm", "angle_deg")}
    else:
        row |= {"plates.placement"}
    if involves(doubtful, *row):
        return []
    regular = plates.placement is None
    arc = {f"body.{key}" for key in ("arc_radius_mm", "width_mm")}
    level = {"plates.cover_mm"} if regular else {"body.base_height_mm"}
    surface = arc | level | {"body.shape"}
    if body.shape == "dome":
        surface |= {"plates.span_mm", "body.dome_radius_mm", "body.depth_mm"}
    base = arc | {"plates.cover_mm", "body.base_height_mm"} if regular else set()
    frames = plate_frames(design)
    corners = clearance.all_corners(frames)
    # Where a regular row leaves the arc's circle it has no height; the sides refuse it.
    placed = ~np.isnan(corners).any(axis=(1, 2))
    sides_known = not involves(doubtful, "body.width_mm")
    faults = _side_fault(body, plates, frames, corners) if sides_known else []
    gaps_known = not regular or not involves(doubtful, "body.arc_radius_mm")
    if not placed.all() or faults or not whole:
        return faults + (_gap_fault(design, corners[placed]) if gaps_known else [])
    depth = body.depth_mm
    half_span = 0.5 * min(plates.span_mm if plates.span_mm is not None else depth, depth)
    if not involves(doubtful, *surface):
        faults += _cover_fault(body, plates, corners, half_span)
    if not involves(doubtful, *base):
        faults += _base_fault(body, plates, corners)
    return faults + (_gap_fault(design, corners) if gaps_known else [])


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
        raised = plates.cover_mm + short
        remedy = (
            "" if math.isinf(short) else f"raise plates.cover_mm to at least {at_least(raised)}"
        )
    else:
        own = corners[worst : worst + 1]
        short = clearance.cover_shortfall(body, own, half_span, LEAST_CLEARANCE_MM)
        remedy = "" if math.isinf(short) else f"lower its y by at least {at_least(short)}"
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
