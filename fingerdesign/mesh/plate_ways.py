"""How plates get into a tetrahedral mesh: left out, cut into it, or resolved by fTetWild itself.

Cut: each plate's mid-surface is meshed as one face of a box of rubber (slot_carriers.py), opened to
the plate's thickness (slots.py), and left as a slot for a sheet or filled with a layer of prisms
for a solid (slot_fill.py). No element of the plate's thickness is asked of fTetWild, and across the
thickness the mesh is regular. Measured on maeno2000 against a fine extruded mesh: plates cut in,
readings within 1.2 to 1.8 % on 130k to 190k dofs; resolved, 10 to 14 % on 230k.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.design.sheet_limits import not_a_sheet
from fingerdesign.errors import MeshError
from fingerdesign.mesh.slots import carrier_frames, sized_frames

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

# Plates thicker than this share of mesh.plate_size_mm are resolved first: it costs nothing.
THICK = 0.6


@dataclass(frozen=True)
class PlateWay:
    """The boxes that fTetWild meshes for the plates, those that the sizes go by, what happens next.

    cut: ``meshed`` are carriers, to be cut open at the plates' mid-surfaces; filled: the slots are
    filled as solid plates.
    """

    meshed: tuple[PlateFrame, ...]
    sized: tuple[PlateFrame, ...]
    cut: bool = False
    filled: bool = False

    @property
    def name(self) -> str:
        """For notes and complaints."""
        if not self.meshed:
            return "no plates"
        return "plates cut in" if self.cut else "plates resolved"


def plate_ways(design: Design, symmetric: bool) -> tuple[PlateWay, ...]:
    """The ways to try, the best first. MeshError where plates as sheets have none."""
    frames = plate_frames(design) if design.plates.model != "none" else ()
    resolved = PlateWay(frames, frames)
    if not frames:
        return (resolved,)
    if design.plates.model == "sheet":
        return (_cut(design, frames, filled=False),)
    if any(not_a_sheet(frame, symmetric) for frame in frames):
        return (resolved,)
    try:
        cut = _cut(design, frames, filled=True)
    except MeshError:  # too little room for a carrier: plates lie close
        return (resolved,)
    thick = design.plates.thickness_mm > THICK * design.mesh.plate_size_mm
    return (resolved, cut) if thick else (cut, resolved)


def _cut(design: Design, frames: tuple[PlateFrame, ...], filled: bool) -> PlateWay:
    return PlateWay(carrier_frames(frames, design), sized_frames(frames), True, filled)
