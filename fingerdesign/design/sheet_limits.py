"""Which plates the finite elements cannot see as sheets (numpy only)."""

from __future__ import annotations

import numpy as np

from fingerdesign.design.layout import PlateFrame


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
