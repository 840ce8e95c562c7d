"""Bars bonded to plates: leads along them, the gages' own stiffness, as springs of mean strains.

A piece of a bar of stiffness E A (N) and length l on a plate's face has the energy E A l e^2 / 2, e
the plate's mean strain along it there: the row of a gage of that place (readout.gage_rows), so that
solid plates, sheets and any mesh are served alike.

    leads   e across the plate's axis (along z), in PIECES from the gage's edge to the plate's front
            end, half on each face; in a half model (z >= 0) both ends have them: at most what one
            end does
    gages   e along the axis, one piece as long and wide as the carrier, on each face that has one
"""

from collections.abc import Iterator, Sequence

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.fem.readout import gage_rows
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.types import Mesh

PIECES = 6
_SHORT = 0.05  # of a plate's span: a shorter way from the gage to the end is none


def bar_stiffness(design: Design, mesh: Mesh, frames: Sequence[PlateFrame]) -> sp.csr_matrix | None:
    """Upper triangle (n dim, n dim), N/mm, of all leads and gages on plates; None without any, and
    in plane strain, where nothing strains along z and a gage is narrower than the section."""
    if mesh.dimension == 2 or design.plates.model == "none" or not frames:
        return None
    bars = [*_leads(design, mesh, frames), *_gages(design, mesh, frames)]
    if not bars:
        return None
    rows, springs = zip(*bars, strict=True)
    every = sp.vstack(rows, format="csr")
    weighted = sp.diags_array(np.concatenate(springs)) @ every
    total = sp.triu(every.T @ weighted, format="csr")
    total.sort_indices()
    return total


def _leads(
    design: Design, mesh: Mesh, frames: Sequence[PlateFrame]
) -> Iterator[tuple[sp.csr_matrix, Array]]:
    """Rows of the strain along z and their springs, N mm, plate by plate."""
    gages = design.gages
    if gages.leads is None or gages.lead_count == 0 or gages.leads.stiffness == 0.0:
        return
    whole = gages.lead_count * gages.leads.stiffness
    for frame in frames:
        start, end = gages.z_mm + 0.5 * gages.width_mm, 0.5 * frame.span
        if end - start < _SHORT * frame.span:
            continue
        width = (end - start) / PIECES
        for k in range(PIECES):
            place = {"z_mm": start + (k + 0.5) * width, "width_mm": width, "grid": "axial"}
            piece = gages.model_copy(update=place)
            yield gage_rows(mesh, [frame], piece, (0.0, 1.0)), np.full(2, 0.5 * whole * width)


def _gages(
    design: Design, mesh: Mesh, frames: Sequence[PlateFrame]
) -> Iterator[tuple[sp.csr_matrix, Array]]:
    """Rows of the strain along the plates under gages of ``gages.kind``, and their springs."""
    gages, type_ = design.gages, design.gage_type
    if type_ is None or type_.stiffness == 0.0:
        return
    length, width = type_.carrier(gages.length_mm, gages.width_mm)
    for frame in frames:
        long, wide = min(length, frame.length), min(width, frame.span - 2.0 * abs(gages.z_mm))
        piece = gages.model_copy(update={"length_mm": long, "width_mm": wide, "grid": "axial"})
        on = np.array([float(side in gages.sides) for side in (1.0, -1.0)])
        yield gage_rows(mesh, [frame], piece, (1.0, 0.0)), on * type_.stiffness * wide * long
