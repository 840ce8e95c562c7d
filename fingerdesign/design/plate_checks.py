"""Whether plates can exist by themselves: slender, bent gently, perforated clear of their gage."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from fingerdesign.design.faults import at_least, at_most, involves
from fingerdesign.design.plate_rows import PlateRow, plate_rows, surface_keys
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault

LEAST_SLENDERNESS = 4.0  # length / thickness; a stubbier box is no plate and bends like no plate
LEAST_BEND = 4.0  # bend radius / thickness: below it the strain across the plate is no plate's
MOST_BEND_DEG = 90.0  # from end to end of a bent plate
LEAST_METAL_MM = 0.1  # beside a hole


def plate_faults(design: Design, doubtful: Set[str]) -> list[Fault]:
    """Every fault of the plates' own shape, one a key."""
    faults: dict[str, Fault] = {}
    for row in plate_rows(design):
        for fault in (
            *_slender(row, doubtful),
            *_bent(design, row, doubtful),
            *_holes(design, row, doubtful),
        ):
            faults.setdefault(fault.key, fault)
    return list(faults.values())


def _slender(row: PlateRow, doubtful: Set[str]) -> list[Fault]:
    length, thickness = row.table.length_mm, row.table.thickness_mm
    keys = (*row.keys("length_mm"), "plates.thickness_mm")
    least = LEAST_SLENDERNESS * thickness
    if length >= least or involves(doubtful, *keys):
        return []
    bound = f"at least {LEAST_SLENDERNESS:g} x plates.thickness_mm = {least:g}"
    thinner = at_most(length / LEAST_SLENDERNESS)
    remedy = f"lengthen the plate or lower plates.thickness_mm to at most {thinner}"
    return [Fault(row.key("length_mm"), length, bound, remedy)]


def _bent(design: Design, row: PlateRow, doubtful: Set[str]) -> list[Fault]:
    """A bent plate lies along the surface, and is bent to a radius that a plate can take."""
    table, rests = row.table, row.where | surface_keys(design.body)
    if table.follow != "bent" or involves(doubtful, *row.keys("follow", "angle_deg")):
        return []
    if table.angle_deg != 0.0:
        bound = "0 where plates.follow = 'bent': a bent plate lies along the surface"
        remedy = "set it to 0, or plates.follow = 'turned'"
        return [Fault(row.key("angle_deg"), table.angle_deg, bound, remedy)]
    radii = [frame.bend_radius for frame in row.frames if frame.bend_radius is not None]
    if not radii or involves(doubtful, *rests):
        return []
    least = max(LEAST_BEND * table.thickness_mm, table.length_mm / np.radians(MOST_BEND_DEG))
    sharpest = min(radii)
    if sharpest >= least - 1e-9:
        return []
    key, cover = row.key("cover_mm"), table.cover_mm
    bound = (
        f"such that plates are bent to a radius of {least:.4g} mm at least "
        f"({LEAST_BEND:g} thicknesses, {MOST_BEND_DEG:g} degrees in all; now {sharpest:.4g})"
    )
    lowered = cover - (least - sharpest)
    remedy = f"lower it to at most {at_most(lowered)}" if lowered > 0.01 else "shorten the plates"
    return [Fault(key, cover, bound, remedy)]


def _holes(design: Design, row: PlateRow, doubtful: Set[str]) -> list[Fault]:
    """Holes leave metal at the plate's long sides, between each other, and below the gage."""
    table, gages = row.table, design.gages
    diameter, pitch = table.hole_diameter_mm, table.hole_pitch_mm
    keys = {"plates.hole_diameter_mm", "plates.hole_pitch_mm", *row.keys("length_mm", "span_mm")}
    if diameter is None or involves(doubtful, *keys):
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
        bound = (
            f"such that holes fit into the span of {frame.span:g}: a hole's diameter from its ends"
        )
        remedy = "lower plates.hole_diameter_mm or leave it out"
        if widest >= diameter + LEAST_METAL_MM:
            remedy = f"lower it to at most {at_most(widest)}"
        return [Fault("plates.hole_pitch_mm", pitch, bound, remedy)]
    if involves(doubtful, "gages.width_mm", "gages.z_mm", *row.spanned):
        return []
    away = min(abs(hole.w - frame.middle - gages.z_mm) for hole in frame.holes)
    wanted = 0.5 * (diameter + gages.width_mm)
    if away >= wanted - 1e-9:
        return []
    bound = f"such that no hole lies under the gage (a hole {away:.4g} mm from its middle)"
    least = 2.0 * (wanted + abs(gages.z_mm))
    remedy = f"raise it to at least {at_least(least)} or narrow the gage"
    if least > frame.span - 3.0 * diameter or gages.z_mm:
        remedy = "narrow the gage, make the holes smaller, or set gages.z_mm = 0"
    return [Fault("plates.hole_pitch_mm", pitch, bound, remedy)]


def gage_faults(design: Design, doubtful: Set[str]) -> list[Fault]:
    """Gages longer or wider than the plates that carry them."""
    gages, rows = design.gages, plate_rows(design)
    faults = []
    row = min(rows, key=lambda each: each.table.length_mm)
    key, length = row.key("length_mm"), row.table.length_mm
    rests = {name for each in rows for name in each.keys("length_mm")}
    if gages.length_mm > length and not involves(doubtful, "gages.length_mm", *rests):
        remedy = f"shorten the gage or raise {key} to at least {gages.length_mm:g}"
        bound = f"at most {key} = {length:g}"
        faults.append(Fault("gages.length_mm", gages.length_mm, bound, remedy))
    row = min(rows, key=lambda each: each.frames[0].span)
    span, key = row.frames[0].span, row.key("span_mm")
    rests = {name for each in rows for name in each.spanned}
    if involves(doubtful, "gages.width_mm", *rests):
        return faults
    across = "z" if row.table.along == "x" else "x"
    if gages.width_mm > span:
        bound = f"at most the plate's span along {across}, {span:g}"
        remedy = f"narrow the gage or raise {key} to at least {gages.width_mm:g}"
        faults.append(Fault("gages.width_mm", gages.width_mm, bound, remedy))
    elif abs(gages.z_mm) + 0.5 * gages.width_mm > 0.5 * span + 1e-9 and not involves(
        doubtful, "gages.z_mm"
    ):
        reach = 0.5 * (span - gages.width_mm)
        bound = f"within -{reach:g} ... {reach:g}, so that the gage lies on the plate"
        remedy = f"move it toward 0, narrow the gage or raise {key}"
        faults.append(Fault("gages.z_mm", gages.z_mm, bound, remedy))
    return faults
