"""Ways to mesh plates: left out, cut into boxes of rubber, or resolved by fTetWild itself.

A plate that is cut in is meshed as one face, its mid-surface, of a box of rubber, the *carrier*
(slots.py).
"""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.layers import not_a_sheet
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.sizing import distances_to_plate
from fingerdesign.mesh.tetra.carriers import core_faces, outer_faces
from fingerdesign.shapes.faces import Carrier

_WIDEST = 0.22  # of the plate's length or span: on maeno2000 0.2 mm did better than 0.3
_TARGET, _LEAST = 1.5, 0.6  # times the plate's thickness: half of it is the slot's
_ENOUGH = 0.6  # of the target: then the box lies on the upper side
# The least gap between a box and its neighbours, of its thickness and of the plate's.
_FREE, _FREE_LEAST = 0.5, 0.2
_ENDS = 0.6  # of a plate's thickness: the elements at a sheet's ends
_FLUSH = 1e-6  # mm
_STEPS = 0.9 ** np.arange(32)
# Plates thicker than this share of mesh.plate_size_mm are resolved first: it costs nothing.
THICK = 0.6


def carrier_frames(frames: tuple[PlateFrame, ...], design: Design) -> tuple[PlateFrame, ...]:
    """The boxes to mesh instead of the plates ``frames``: one face of each is the mid-surface.

    Each box has its plate's length and span, and lies on the side with more room, the upper one
    where both have enough. MeshError where a plate has too little, or cannot be a sheet.
    """
    for frame in frames:
        why = not_a_sheet(frame)
        if why is not None:
            raise MeshError(f"plate {frame.index} cannot be a sheet: {why}")
    boxes = list(frames)
    for k, frame in enumerate(frames):
        least = _LEAST * frame.thickness
        target = min(design.mesh.plate_size_mm, _WIDEST * min(frame.length, frame.span))
        most = max(target, _TARGET * frame.thickness)
        near = _near(frame, [*boxes[:k], *frames[:k], *frames[k + 1 :]], 3.0 * most)
        upper, lower = (_thickest(frame, side * most, near, design) for side in (1.0, -1.0))
        thickness = lower if abs(lower) > max(abs(upper), _ENOUGH * most) else upper
        if abs(thickness) < least:
            raise MeshError(
                f"plate {frame.index} has {abs(thickness):.3g} mm of room next to it: to be meshed "
                f"as a sheet it needs {least:.3g} mm; set plates.model = 'solid'"
            )
        boxes[k] = _box(frame, thickness)
    return tuple(boxes)


def sized_frames(frames: tuple[PlateFrame, ...]) -> tuple[PlateFrame, ...]:
    """Boxes around the mid-surfaces of plates as sheets, for a mesh's size field.

    Elements at its ends have half a box's thickness: _ENDS of the plate's. On maeno2000 (fifteen
    plates 0.1 mm thick), worst error of membrane strain over five increments up to complete slip
    against a fine extruded model: 0.5: 1.2 % (192k dofs), 0.7: 1.8 % (128k), 1: 3.8 % (94k).
    """
    return tuple(replace(frame, thickness=2.0 * _ENDS * frame.thickness) for frame in frames)


def _box(frame: PlateFrame, thickness: float) -> PlateFrame:
    """The box from a plate's mid-surface to ``thickness`` (mm; < 0: on the lower side)."""
    place, y = frame.from_local(0.0, 0.5 * thickness)[0]
    return replace(frame, place=float(place), y=float(y), thickness=abs(thickness))


def _near(frame: PlateFrame, others: list[PlateFrame], reach: float) -> list[PlateFrame]:
    """Those of the others that may come within ``reach`` of a plate."""

    def size(one: PlateFrame) -> float:
        return 0.5 * float(np.linalg.norm([one.length, one.thickness, one.span]))

    def centre(one: PlateFrame) -> Array:
        return np.asarray(one.to_space(one.centre, one.middle)[0])

    return [
        one
        for one in others
        if np.linalg.norm(centre(one) - centre(frame)) < size(one) + size(frame) + reach
    ]


def _thickest(frame: PlateFrame, most: float, near: list[PlateFrame], design: Design) -> float:
    """Thickness (mm, with the sign of ``most``) of a box with room around it; 0: there is none."""
    faces = _room_faces(frame, design)
    core = [] if design.body.core is None else core_faces(design.body)
    for step in _STEPS:
        box = _box(frame, float(step * most))
        mine = _samples(box)
        gaps = [distances_to_plate(one, mine)[0].min() for one in near]
        gaps += [distances_to_plate(box, _samples(one))[0].min() for one in near]
        gaps += [np.abs(face.misfit(mine)).min() for face in faces]
        if core:
            gaps.append(np.max([face.distance(mine) for face in core], axis=0).min())
        if min(gaps, default=np.inf) >= max(_FREE * box.thickness, _FREE_LEAST * frame.thickness):
            return float(step * most)
    return 0.0


def _room_faces(frame: PlateFrame, design: Design) -> list[Carrier]:
    """The body's outer faces but those that the plate ends in."""
    ends = frame.from_local(np.array([-0.5, 0.5]) * frame.length, 0.0)
    edges = [frame.to_space(ends, across) for across in (frame.low, frame.high)]
    both = np.array([frame.low, frame.high])
    edges += [frame.to_space(np.tile(end, (2, 1)), both) for end in ends]
    outer = outer_faces(design.body, symmetric=False)
    return [face for face in outer if not any(np.abs(face.misfit(e)).max() < _FLUSH for e in edges)]


def _samples(frame: PlateFrame) -> Array:
    """Points (n, 3) in a box, its corners and edges among them."""
    along, through = np.linspace(-0.5, 0.5, 9), np.linspace(-0.5, 0.5, 3)
    across = np.linspace(frame.low, frame.high, 9)
    grid = np.meshgrid(along * frame.length, through * frame.thickness, across)
    s, v, w = (axis.ravel() for axis in grid)
    return frame.to_space(frame.from_local(s, v), w)


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
