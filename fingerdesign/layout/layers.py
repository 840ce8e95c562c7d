"""Whether a finger can be swept through layers: its section once, each part in its own layers.

The section is drawn with all plates and the core at once, whatever their reach along z. So they
must not lie over one another in it, even where they never meet in space.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.layout.frames import PlateFrame, plate_frames
from fingerdesign.layout.gaps import core_gaps, least_gap

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


# Which plates the finite elements cannot see as sheets (numpy only).


def not_a_sheet(frame: PlateFrame, half: bool = False) -> str | None:
    """Why a plate cannot be a sheet, as a clause that begins with "it"; None where it can.

    Sheets are flat and whole: slots with two plane faces. ``half``: in a model of the half z >= 0,
    in whose symmetry plane no mid-surface may lie.
    """
    if frame.bend_radius is not None:
        return "it is bent, and a sheet is flat"
    if frame.holes:
        return "it has holes, and a sheet is whole"
    upright = abs(np.cos(np.radians(frame.angle_deg))) < 1e-9
    if half and frame.along == "z" and upright and abs(frame.place) < 0.5 * frame.thickness:
        return "it stands in the symmetry plane z = 0, which would cut it along its mid-surface"
    return None


_LEAST_GAP = 0.5  # of the plates' thickness: what lies nearer in space is refused anyway
_NEAR_CORE_MM = 0.05


def layered(design: Design) -> bool:
    """Whether one section, swept through layers, can be meshed as it (mesher "extrude")."""
    return not_layered(design) is None


def not_layered(design: Design) -> str | None:
    """The first thing that keeps a finger from being swept through layers; None: nothing does.

    A straight body; plates along x, without holes, that end at any z; a core of any depth.
    """
    return not_sweepable(design) or lies_over(design)


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


def lies_over(design: Design) -> str | None:
    """Which plates, or plate and core, lie over one another in the section, though not in space."""
    if not design.plates.number:
        return None
    frames, core = plate_frames(design), design.body.core
    if len({(round(frame.low, 9), round(frame.high, 9)) for frame in frames}) > 1:
        swept = tuple(replace(frame, low=-1.0, high=1.0) for frame in frames)
        gap = least_gap(swept)
        if gap is not None and gap.distance < _LEAST_GAP * design.plates.thickness_mm - 1e-9:
            return f"plates {gap.first} and {gap.second} lie over one another, seen along z"
    if core is not None and core.depth_mm is not None:
        distances = core_gaps(core, 2.0 * design.body.depth_mm, frames)
        for frame, distance in zip(frames, distances, strict=True):
            if distance < _NEAR_CORE_MM:
                return f"plate {frame.index} and the core lie over one another, seen along z"
    return None
