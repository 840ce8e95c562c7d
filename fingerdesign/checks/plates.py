"""Faults of plates and gages by themselves: slender, bent gently, perforated clear of the gage."""

from collections.abc import Iterator

import numpy as np

from fingerdesign.design.faults import at_least, at_most
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.leads import leads_width
from fingerdesign.layout.row_keys import PlateRow, plate_rows

LEAST_SLENDERNESS = 4.0  # Length / thickness; a stubbier box does not bend like a plate.
LEAST_BEND = 4.0  # Bend radius / thickness; below it the strain across the plate is not linear.
MOST_BEND_DEG = 90.0  # From end to end of a bent plate.
LEAST_METAL_MM = 0.1  # Metal that a hole leaves at its sides.
_LEAST_SLOPE = 0.03  # Product of sin(2 angle) of a pair: 5 degrees either way.


def plate_faults(design: Design) -> list[Fault]:
    """Find every fault of the plates' own shape, one a key."""
    faults: dict[str, Fault] = {}
    for row in plate_rows(design):
        for fault in (*_slender(row), *_bent(row), *_holes(design, row)):
            faults.setdefault(fault.key, fault)
    return list(faults.values())


def _slender(row: PlateRow) -> list[Fault]:
    length, thickness = row.table.length_mm, row.table.thickness_mm
    least = LEAST_SLENDERNESS * thickness
    if length >= least:
        return []
    bound = f"at least {LEAST_SLENDERNESS:g} x plates.thickness_mm = {least:g}"
    thinner = at_most(length / LEAST_SLENDERNESS)
    remedy = f"lengthen the plate or lower plates.thickness_mm to at most {thinner}"
    return [Fault(row.key("length_mm"), length, bound, remedy)]


def _bent(row: PlateRow) -> list[Fault]:
    """Find a bent plate at an angle to the surface, or bent to a radius that no plate can take."""
    table = row.table
    if not table.layout.bends:
        return []
    if table.angle_deg != 0.0:
        bound = "0 where plates.follow = 'bent': a bent plate lies along the surface"
        remedy = "set it to 0, or plates.follow = 'turned'"
        return [Fault(row.key("angle_deg"), table.angle_deg, bound, remedy)]
    radii = [frame.bend_radius for frame in row.frames if frame.bend_radius is not None]
    if not radii:
        return []
    least = max(LEAST_BEND * table.thickness_mm, table.length_mm / np.radians(MOST_BEND_DEG))
    sharpest = min(radii)
    if sharpest >= least - 1e-9:
        return []
    bound = (
        f"such that plates are bent to a radius of {least:.4g} mm at least "
        f"({LEAST_BEND:g} thicknesses, {MOST_BEND_DEG:g} degrees in all; now {sharpest:.4g})"
    )
    lowered = table.cover_mm - (least - sharpest)
    remedy = f"lower it to at most {at_most(lowered)}" if lowered > 0.01 else "shorten the plates"
    return [Fault(row.key("cover_mm"), table.cover_mm, bound, remedy)]


def _holes(design: Design, row: PlateRow) -> list[Fault]:
    """Find holes that leave no metal at the long sides, between each other, or below the gage."""
    table, gages = row.table, design.gages
    diameter, pitch = table.hole_diameter_mm, table.hole_pitch_mm
    if diameter is None:
        return []
    if diameter > table.length_mm - 2.0 * LEAST_METAL_MM + 1e-9:
        most = table.length_mm - 2.0 * LEAST_METAL_MM
        bound = f"at most {row.key('length_mm')} less {2.0 * LEAST_METAL_MM:g} = {most:g}"
        remedy = f"metal is left on both sides of a hole; raise {row.key('length_mm')} or lower it"
        return [Fault("plates.hole_diameter_mm", diameter, bound, remedy)]
    if pitch < diameter + LEAST_METAL_MM - 1e-9:
        least = diameter + LEAST_METAL_MM
        bound = f"at least plates.hole_diameter_mm + {LEAST_METAL_MM:g} = {least:g}"
        return [Fault("plates.hole_pitch_mm", pitch, bound, "holes would run into each other")]
    frame = row.frames[0]
    if not frame.holes:
        widest = 2.0 * (0.5 * frame.span - 1.5 * diameter)
        span = f"the span of {frame.span:g}"
        bound = f"such that holes fit into {span}: a hole's diameter from its ends"
        remedy = "lower plates.hole_diameter_mm or leave it out"
        if widest >= diameter + LEAST_METAL_MM:
            remedy = f"lower it to at most {at_most(widest)}"
        return [Fault("plates.hole_pitch_mm", pitch, bound, remedy)]
    away = min(abs(hole.w - frame.middle - gages.z_mm) for hole in frame.holes)
    apart = 0.5 * (diameter + gages.width_mm)
    if away >= apart - 1e-9:
        return []
    bound = f"such that no hole lies under the gage (a hole {away:.4g} mm from its middle)"
    least = 2.0 * (apart + abs(gages.z_mm))
    remedy = f"raise it to at least {at_least(least)} or narrow the gage"
    if least > frame.span - 3.0 * diameter or gages.z_mm:
        remedy = "narrow the gage or make the holes smaller"
        remedy += ", or set gages.z_mm = 0" if gages.z_mm else ""
    return [Fault("plates.hole_pitch_mm", pitch, bound, remedy)]


def gage_faults(design: Design) -> list[Fault]:
    """Find gages longer or wider than the plates that carry them, and bridges that cannot be."""
    gages, rows = design.gages, plate_rows(design)
    faults = []
    row = min(rows, key=lambda each: each.table.length_mm)
    key, length = row.key("length_mm"), row.table.length_mm
    if gages.length_mm > length:
        remedy = f"shorten the gage or raise {key} to at least {gages.length_mm:g}"
        bound = f"at most {key} = {length:g}"
        faults.append(Fault("gages.length_mm", gages.length_mm, bound, remedy))
    row = min(rows, key=lambda each: each.frames[0].span)
    span, key = row.frames[0].span, row.key("span_mm")
    across = "z" if row.table.along == "x" else "x"
    if gages.width_mm > span:
        bound = f"at most the plate's span along {across}, {span:g}"
        remedy = f"narrow the gage or raise {key} to at least {gages.width_mm:g}"
        faults.append(Fault("gages.width_mm", gages.width_mm, bound, remedy))
    elif abs(gages.z_mm) + 0.5 * gages.width_mm > 0.5 * span + 1e-9:
        reach = 0.5 * (span - gages.width_mm)
        bound = f"within -{reach:g} ... {reach:g}, so that the gage lies on the plate"
        remedy = f"move it toward 0, narrow the gage or raise {key}"
        faults.append(Fault("gages.z_mm", gages.z_mm, bound, remedy))
    return [*faults, *_lead_faults(design), *_bridge_faults(design), *_pair_faults(design)]


def _lead_faults(design: Design) -> list[Fault]:
    """Find leads that are wider than the plate that carries them."""
    leads, row = design.gages.leads, min(plate_rows(design), key=lambda row: row.table.length_mm)
    if leads is None:
        return []
    wide, length = leads_width(design.gages, leads), row.table.length_mm
    if wide <= length:
        return []
    size = "diameter_mm" if leads.kind == "wire" else "width_mm"
    bound = (
        f"such that {design.gages.lead_count} leads of a plate, {wide:.4g} mm next to each other, "
        f"lie on {row.key('length_mm')} = {length:g}"
    )
    remedy = f"lower it to at most {at_most(getattr(leads, size) * length / wide)}, or their number"
    return [Fault(f"gages.leads.{size}", getattr(leads, size), bound, remedy)]


def _bridge_faults(design: Design) -> list[Fault]:
    """Find a bridge that the grids cannot make."""
    gages = design.gages
    found = list(gages.bridges(design.material_of("plates").poissons_ratio))
    if gages.bridge is None or gages.bridge in found:
        return []
    faces = "both faces" if gages.faces == 2 else "one face"
    bound = f"{' or '.join(map(repr, found))} for {gages.grid} grids on {faces}"
    remedy = f"leave it out for '{found[-1]}'"
    if gages.faces == 1 and gages.bridge != "quarter":
        remedy += ", or set gages.face = 'both'"
    return [Fault("gages.bridge", gages.bridge, bound, remedy)]


def _pair_faults(design: Design) -> Iterator[Fault]:
    """Find two plates of one bridge that do not lie at opposite angles in one row."""
    if design.gages.grid != "double_axial":
        return
    for row in plate_rows(design):
        first, last = row.frames[0].index, row.frames[-1].index
        if len(row.frames) % 2:
            bound = f"'axial' or 'tee' for a row of {len(row.frames)} plates ({first} to {last})"
            remedy = f"give the row an even number of plates ({row.key('count')})"
            yield Fault("gages.grid", "double_axial", bound, remedy)
        for one, two in zip(row.frames[::2], row.frames[1::2], strict=False):
            slopes = np.sin(np.radians([2.0 * one.angle_deg, 2.0 * two.angle_deg]))
            if slopes[0] * slopes[1] > -_LEAST_SLOPE:
                angles = f"{one.angle_deg:.4g} and {two.angle_deg:.4g} degrees"
                bound = f"'axial' or 'tee' for plates {one.index} and {two.index} at {angles}"
                remedy = "give a pair opposite angles: plates.alternate = true, or plates.placement"
                yield Fault("gages.grid", "double_axial", bound, remedy)
                break
