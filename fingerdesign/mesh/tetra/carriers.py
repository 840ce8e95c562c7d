"""CAD faces that the nodes of a mesh are snapped to, in closed form (numpy only).

Faces that join without an edge (under 12 degrees) are one carrier: a mesher follows no edge there.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.schema import Body, Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.outline import Piece, Profile
from fingerdesign.layout.profile import profile_of
from fingerdesign.layout.surface import ContactSurface, step_carriers
from fingerdesign.shapes.faces import Carrier, Face
from fingerdesign.shapes.quadrics import Cone, Plane

_OUTSIDE = 1e-9  # mm; the planes' own rounding is far below


@dataclass(frozen=True)
class Chain(ContactSurface, Carrier):
    """Pieces of a parametric body's outline, swept as the body is; the side may be among them.

    side: number of the piece that is the straight side, not contact.
    """

    name: str
    side: int | None = None

    @property
    def flat(self) -> bool:
        top, *others = self.pieces
        flat = not others and not top.radius and top.start[0] == 0
        return self.body.straight and flat

    @property
    def boundaries(self) -> tuple[str, ...]:
        return (self.name,) if self.side is None else ("contact", "side")

    def names(self, points: Array) -> NDArray[np.str_]:
        if self.side is None:
            return super().names(points)
        return np.where(self.owner(points) == self.side, "side", "contact")


def plane(name: str, direction: tuple[float, float, float], offset: float) -> Face:
    """The flat face of points with direction . point = offset; ``direction`` is a unit vector."""
    return Face(name, Plane(np.array(direction), offset))


@dataclass(frozen=True)
class Carriers:
    """Every CAD face of a finger: ``faces``; numbers of those of the outside and of each part.

    of_part: region number -> numbers of the faces that bound that part (a plate, the core).
    """

    faces: tuple[Carrier, ...]
    outside: tuple[int, ...]
    of_part: dict[int, tuple[int, ...]]


def carriers_of(design: Design, frames: tuple[PlateFrame, ...], symmetric: bool) -> Carriers:
    """All CAD faces of a finger, or of its half z >= 0, with ``frames`` as its solid plates."""
    body = design.body
    faces: list[Carrier] = outer_faces(body, symmetric)
    outside = tuple(range(len(faces)))
    of_part: dict[int, tuple[int, ...]] = {}
    parts = [(frame.index + 1, plate_faces(frame)) for frame in frames]
    if body.core is not None:
        parts.append((design.core_region, core_faces(body)))
    for region, found in parts:
        of_part[region] = tuple(range(len(faces), len(faces) + len(found)))
        faces += found
    return Carriers(tuple(faces), outside, of_part)


def beyond(points: Array, carriers: Carriers) -> BoolArray:
    """Mask (n, carriers): points outside the base or the symmetry plane, which must lie on it.

    A body is on one side of these two whatever its shape. fTetWild may leave a node beyond the
    sharp edge between them, of which no facet is the symmetry plane's.
    """
    found = np.zeros((len(points), len(carriers.faces)), dtype=bool)
    for number in carriers.outside:
        face = carriers.faces[number]
        if face.name in ("base", "symmetry") and face.flat:
            found[:, number] = face.distance(points) > _OUTSIDE
    return found


def outer_faces(body: Body, symmetric: bool) -> list[Carrier]:
    """The CAD faces of the outside of a body, or of its half z >= 0."""
    mirror = [plane("symmetry", (0.0, 0.0, -1.0), 0.0)] if symmetric else []
    if body.step is not None:
        return [*step_carriers(body.step), *mirror]
    half_depth = 0.5 * body.depth_mm
    found: list[Carrier] = [plane("base", (0.0, -1.0, 0.0), 0.0), *mirror]
    if not body.kind.turned:
        found.append(plane("end", (0.0, 0.0, 1.0), half_depth))
        if not symmetric:
            found.append(plane("end", (0.0, 0.0, -1.0), half_depth))
    profile = profile_of(body)
    below = Piece((profile.half_width, profile.side_height), (profile.half_width, 0.0))
    for chain in Profile((*profile.pieces, below)).chains():
        if chain == (below,):
            if body.kind.turned:
                found.append(Chain(body, chain, "side", 0))
            else:
                sides = ((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
                found += [plane("side", side, profile.half_width) for side in sides]
        else:
            side = len(chain) - 1 if chain[-1] == below else None
            found.append(Chain(body, chain, "contact", side))
    return found


def plate_faces(frame: PlateFrame) -> list[Carrier]:
    """The faces of one plate: long sides, its two ends, its two faces across, its holes."""
    name, half = f"plate_{frame.index}", 0.5 * frame.length
    unit = np.array([0.0, 0.0, 1.0] if frame.along == "x" else [1.0, 0.0, 0.0])
    found: list[Carrier] = []
    for sign in (-1.0, 1.0):
        point = frame.from_local(sign * half, 0.0)[0]
        found.append(_plane(name, frame, sign * frame.tangent(sign * half), point))
    if frame.bend_radius is None:
        for sign in (-1.0, 1.0):
            point = frame.from_local(0.0, 0.5 * sign * frame.thickness)[0]
            found.append(_plane(name, frame, sign * frame.normal, point))
    else:
        centre = frame.to_space(frame.centre - frame.bend_radius * frame.normal, 0.0)[0]
        for sign in (-1.0, 1.0):  # the hollow side's solid is outside of its cylinder
            radius = frame.bend_radius + 0.5 * sign * frame.thickness
            found.append(Face(name, Cone(centre, unit, radius), sign))
    found.append(Face(name, Plane(unit, frame.high)))
    found.append(Face(name, Plane(-unit, -frame.low)))
    for hole in frame.holes:
        place = frame.to_space(frame.from_local(hole.s, 0.0), hole.w)[0]
        upright = frame.direction(frame.upward(hole.s))
        found.append(Face(name, Cone(place, upright, hole.radius), -1.0))
    return found


def core_faces(body: Body) -> list[Carrier]:
    """The six faces of the core's box."""
    core = body.core
    assert core is not None
    depth = body.core_depth_mm
    found: list[Carrier] = [
        plane("core", (0.0, -1.0, 0.0), -core.bottom_mm),
        plane("core", (0.0, 1.0, 0.0), core.bottom_mm + core.height_mm),
    ]
    for sign in (-1.0, 1.0):
        found.append(plane("core", (sign, 0.0, 0.0), 0.5 * core.width_mm))
        found.append(plane("core", (0.0, 0.0, sign), 0.5 * depth))
    return found


def in_core(body: Body, points: Array) -> BoolArray:
    """Mask (n,) of points (n, 3) that lie in the core, if there is one."""
    if body.core is None:
        return np.zeros(len(points), dtype=bool)
    away = np.stack([face.distance(points) for face in core_faces(body)])
    return np.asarray((away < 0.0).all(axis=0))


def _plane(name: str, frame: PlateFrame, outward: Array, point: Array) -> Face:
    return Face(name, Plane(frame.direction(outward), float(outward @ point)))
