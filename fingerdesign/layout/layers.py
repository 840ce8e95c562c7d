"""Sweeping a finger through layers: its section once, each part in its own layers.

The section is drawn with all plates and the core at once, at any reach along z. So they
must not overlap in it, even where they never meet in space.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import core_gaps, least_gap
from fingerdesign.layout.rows import plate_frames

_THIN = 0.01  # The thinnest layer, relative to the depth.
_SAME_MM = 1e-9  # Heights closer than this are one.
_LEAST_GAP = 0.5  # Relative to the plates' thickness; plates nearer in space are refused anyway.
_NEAR_CORE_MM = 0.05


def not_a_sheet(frame: PlateFrame, half: bool = False) -> str | None:
    """Explain why a plate cannot be a sheet, as a clause that begins with "it"; None if it can.

    Sheets are flat and whole: slots with two plane faces. ``half``: in a model of the half z >= 0,
    in whose symmetry plane no mid-surface may lie.
    """
    if frame.bend_radius is not None:
        return "it is bent, and a sheet is flat"
    if frame.holes:
        return "it has holes, and a sheet is whole"
    upright = abs(np.cos(np.radians(frame.angle_deg))) < 1e-9
    if half and frame.along == "z" and upright and abs(frame.place) < 0.5 * frame.thickness:
        return "it lies in the symmetry plane z = 0, which would cut it along its mid-surface"
    return None


def layered(design: Design) -> bool:
    """True if one section, swept through layers, is the finger (mesher "sweep")."""
    return not_layered(design) is None


def sweepable(design: Design) -> bool:
    """True if the finger is layered and no layer is too thin to mesh."""
    return layered(design) and _least_step(design) > _THIN * design.body.depth_mm


def not_layered(design: Design) -> str | None:
    """The first obstacle to sweeping a finger through layers; None: there is none. A straight body;
    plates along x, without holes, that end at any z; a core of any depth."""
    return not_sweepable(design) or overlaps(design)


def not_sweepable(design: Design) -> str | None:
    """The first part that no layer could hold, wherever it lies; None: there is none."""
    body, plates = design.body, design.plates
    if not body.straight:
        return f"body.shape = '{body.shape}'"
    if not plates.number:
        return None
    if plates.hole_diameter_mm is not None:
        return f"plates.hole_diameter_mm = {plates.hole_diameter_mm:g}"
    rows = plates.all_rows if plates.placement is None else (plates,)
    if any(row.along == "z" and row.count for row in rows):
        return "a row of plates along z"
    return None


def overlaps(design: Design) -> str | None:
    """Name plates, or plate and core, that overlap in the section, though not in space."""
    if not design.plates.number:
        return None
    frames, core = plate_frames(design), design.body.core
    if len({(round(frame.low, 9), round(frame.high, 9)) for frame in frames}) > 1:
        swept = tuple(replace(frame, low=-1.0, high=1.0) for frame in frames)
        gap = least_gap(swept)
        if gap is not None and gap.distance < _LEAST_GAP * design.plates.thickness_mm - 1e-9:
            return f"plates {gap.first} and {gap.second} overlap, seen along z"
    if core is not None and core.depth_mm is not None:
        distances = core_gaps(core, 2.0 * design.body.depth_mm, frames)
        for frame, distance in zip(frames, distances, strict=True):
            if distance < _NEAR_CORE_MM:
                return f"plate {frame.index} and the core overlap, seen along z"
    return None


def _least_step(design: Design) -> float:
    """Least distance along z between two heights at which plates, core or the body end, mm."""
    half = 0.5 * design.body.depth_mm
    ends = [-half, 0.0, half]
    if design.plates.model != "none":
        ends += [end for frame in plate_frames(design) for end in (frame.low, frame.high)]
    core = design.body.core
    if core is not None and core.depth_mm is not None:
        ends += [-0.5 * core.depth_mm, 0.5 * core.depth_mm]
    steps = [b - a for a, b in pairwise(sorted(ends)) if b - a > _SAME_MM]
    return min(steps)
