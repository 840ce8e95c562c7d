"""CAD faces that the nodes of a mesh are snapped to, in closed form (numpy only).

Faces that join without an edge (under 12 degrees) are one carrier: a mesher keeps no edge there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.profile import Piece, Profile, profile_of
from fingerdesign.layout.surface import ContactSurface, step_carriers

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body, Design


class Carrier(Protocol):
    """A CAD face, or several that join smoothly; points (n, 3) in mm."""

    @property
    def name(self) -> str:
        """The boundary it stands for: "base", "contact", "side", "end", "symmetry", a part's."""

    @property
    def flat(self) -> bool:
        """Whether it is plane: straight mid-nodes lie on it already."""

    @property
    def boundaries(self) -> tuple[str, ...]:
        """The boundaries that its faces belong to: more than its name where they join smoothly."""

    def names(self, points: Array) -> NDArray[np.str_]:
        """The boundary (n,) that each point's nearest face belongs to."""

    def distance(self, points: Array) -> Array:
        """Signed distance (n,), positive outside of the solid that it bounds."""

    def normal(self, points: Array) -> Array:
        """Outward unit normals (n, 3) at the nearest points."""

    def misfit(self, points: Array) -> Array:
        """Distance (n,) to the face as trimmed, not continued beyond its edges."""


@dataclass(frozen=True)
class Plane:
    """A flat CAD face: points with normal . point = offset; ``normal`` is a unit vector (3,)."""

    name: str
    vector: tuple[float, float, float]
    offset: float
    flat: bool = True

    @property
    def boundaries(self) -> tuple[str, ...]:
        return (self.name,)

    def names(self, points: Array) -> NDArray[np.str_]:
        return np.full(len(points), self.name)

    def distance(self, points: Array) -> Array:
        return np.asarray(points @ np.array(self.vector) - self.offset)

    def normal(self, points: Array) -> Array:
        return np.tile(np.array(self.vector), (len(points), 1))

    def misfit(self, points: Array) -> Array:
        return np.abs(self.distance(points))


@dataclass(frozen=True)
class Cylinder:
    """A cylinder about the line through ``origin`` along ``axis``; ``outward`` False: the solid is
    outside of it (a hole, or the hollow side of a bent plate)."""

    name: str
    origin: tuple[float, float, float]
    axis: tuple[float, float, float]
    radius: float
    outward: bool = True
    flat: bool = False

    @property
    def boundaries(self) -> tuple[str, ...]:
        return (self.name,)

    def names(self, points: Array) -> NDArray[np.str_]:
        return np.full(len(points), self.name)

    def distance(self, points: Array) -> Array:
        away = np.linalg.norm(self._radial(points), axis=1) - self.radius
        return np.asarray(away if self.outward else -away)

    def normal(self, points: Array) -> Array:
        radial = self._radial(points)
        radial /= np.maximum(np.linalg.norm(radial, axis=1), 1e-300)[:, None]
        return radial if self.outward else -radial

    def misfit(self, points: Array) -> Array:
        return np.abs(self.distance(points))

    def _radial(self, points: Array) -> Array:
        offset = points - np.array(self.origin)
        axis = np.array(self.axis)
        return np.asarray(offset - np.outer(offset @ axis, axis))


@dataclass(frozen=True)
class Chain:
    """Pieces of a parametric body's outline, swept as the body is; the side may be among them."""

    name: str
    surface: ContactSurface
    side: int | None = None  # number of the piece that is the straight side, not contact
    flat: bool = False

    def distance(self, points: Array) -> Array:
        return self.surface.distance(points)

    def normal(self, points: Array) -> Array:
        return self.surface.normal(points)

    def misfit(self, points: Array) -> Array:
        return self.surface.misfit(points)

    @property
    def boundaries(self) -> tuple[str, ...]:
        return (self.name,) if self.side is None else ("contact", "side")

    def names(self, points: Array) -> NDArray[np.str_]:
        if self.side is None:
            return np.full(len(points), self.name)
        return np.where(self.surface.owner(points) == self.side, "side", "contact")


@dataclass(frozen=True)
class Carriers:
    """Every CAD face of a finger: ``faces``; numbers of those of the outside and of each part.

    of_part: region number -> numbers of the faces that bound that part (a plate, the core).
    """

    faces: tuple[Carrier, ...]
    outside: tuple[int, ...]
    of_part: dict[int, tuple[int, ...]]

    def outer_names(self) -> tuple[str, ...]:
        """Names of boundaries that the outside has."""
        names = {name for number in self.outside for name in self.faces[number].boundaries}
        return tuple(sorted(names))


def carriers_of(
    design: Design, frames: tuple[PlateFrame, ...], symmetric: bool, core: bool = True
) -> Carriers:
    """All CAD faces of a finger, or of its half z >= 0, with ``frames`` as its solid plates."""
    body = design.body
    faces: list[Carrier] = list(_outside(body, symmetric))
    outside = tuple(range(len(faces)))
    of_part: dict[int, tuple[int, ...]] = {}
    parts = [(frame.index + 1, plate_faces(frame)) for frame in frames]
    if core and body.core is not None:
        parts.append((design.core_region, core_faces(body)))
    for region, found in parts:
        of_part[region] = tuple(range(len(faces), len(faces) + len(found)))
        faces += found
    return Carriers(tuple(faces), outside, of_part)


def _outside(body: Body, symmetric: bool) -> list[Carrier]:
    mirror = [Plane("symmetry", (0.0, 0.0, -1.0), 0.0)] if symmetric else []
    if body.step is not None:
        return [*step_carriers(body.step), *mirror]
    half_depth = 0.5 * body.depth_mm
    found: list[Carrier] = [Plane("base", (0.0, -1.0, 0.0), 0.0), *mirror]
    if not body.kind.turned:
        found.append(Plane("end", (0.0, 0.0, 1.0), half_depth))
        if not symmetric:
            found.append(Plane("end", (0.0, 0.0, -1.0), half_depth))
    profile = profile_of(body)
    below = Piece((profile.half_width, profile.side_height), (profile.half_width, 0.0))
    for chain in Profile((*profile.pieces, below)).chains():
        surface = ContactSurface(body, chain)
        if chain == (below,):
            if body.kind.turned:
                found.append(Chain("side", surface, 0))
            else:
                sides = ((-1.0, 0.0, 0.0), (1.0, 0.0, 0.0))
                found += [Plane("side", side, profile.half_width) for side in sides]
        else:
            side = len(chain) - 1 if chain[-1] == below else None
            flat = (
                body.straight and len(chain) == 1 and not chain[0].radius and chain[0].start[0] == 0
            )
            found.append(Chain("contact", surface, side, flat))
    return found


def plate_faces(frame: PlateFrame) -> list[Carrier]:
    """The faces of one plate: long sides, its two ends, its two faces across, its holes."""
    name, half = f"plate_{frame.index}", 0.5 * frame.length
    found: list[Carrier] = []
    for sign in (-1.0, 1.0):
        point = frame.from_local(sign * half, 0.0)[0]
        found.append(_plane(name, frame, sign * frame.tangent(sign * half), point))
    if frame.bend_radius is None:
        for sign in (-1.0, 1.0):
            point = frame.from_local(0.0, 0.5 * sign * frame.thickness)[0]
            found.append(_plane(name, frame, sign * frame.normal, point))
    else:
        centre = _triple(frame.to_space(frame.centre - frame.bend_radius * frame.normal, 0.0)[0])
        across = (0.0, 0.0, 1.0) if frame.along == "x" else (1.0, 0.0, 0.0)
        for sign in (-1.0, 1.0):
            radius = frame.bend_radius + 0.5 * sign * frame.thickness
            found.append(Cylinder(name, centre, across, radius, sign > 0))
    unit = np.array([0.0, 0.0, 1.0] if frame.along == "x" else [1.0, 0.0, 0.0])
    found.append(Plane(name, _triple(unit), frame.high))
    found.append(Plane(name, _triple(-unit), -frame.low))
    for hole in frame.holes:
        place = frame.to_space(frame.from_local(hole.s, 0.0), hole.w)[0]
        upright = _triple(frame.direction(_normal_at(frame, hole.s)))
        found.append(Cylinder(name, _triple(place), upright, hole.radius, False))
    return found


def core_faces(body: Body) -> list[Carrier]:
    """The six faces of the core's box."""
    core = body.core
    assert core is not None
    depth = core.depth_mm if core.depth_mm is not None else body.depth_mm
    found: list[Carrier] = [
        Plane("core", (0.0, -1.0, 0.0), -core.bottom_mm),
        Plane("core", (0.0, 1.0, 0.0), core.bottom_mm + core.height_mm),
    ]
    for sign in (-1.0, 1.0):
        found.append(Plane("core", (sign, 0.0, 0.0), 0.5 * core.width_mm))
        found.append(Plane("core", (0.0, 0.0, sign), 0.5 * depth))
    return found


def in_core(body: Body, points: Array) -> BoolArray:
    """Whether points (n, 3) lie in the core; none where there is none."""
    if body.core is None:
        return np.zeros(len(points), dtype=bool)
    away = np.stack([face.distance(points) for face in core_faces(body)])
    return np.asarray((away < 0.0).all(axis=0))


def _plane(name: str, frame: PlateFrame, outward: Array, point: Array) -> Plane:
    return Plane(name, _triple(frame.direction(outward)), float(outward @ point))


def _normal_at(frame: PlateFrame, s: float) -> Array:
    tangent = frame.tangent(s)
    return np.array([-tangent[1], tangent[0]])


def _triple(vector: Array) -> tuple[float, float, float]:
    return float(vector[0]), float(vector[1]), float(vector[2])
