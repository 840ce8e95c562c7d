"""Which region a cell lies in, which facets bound it, and which CAD face carries each facet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame
from fingerdesign.geometry.surface import ContactSurface
from fingerdesign.mesh.types import TETRA_FACETS

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
BoolArray = NDArray[np.bool_]


SMOOTH_DEG = 12.0  # over an edge of 1 mm that is 0.1 mm, ten times the mesher's envelope


@dataclass(frozen=True)
class Plane:
    """A flat CAD face: points with normal . point = offset; ``normal`` is a unit vector (3,)."""

    name: str
    normal: tuple[float, float, float]
    offset: float

    def distance(self, points: Array) -> Array:
        """Signed distance (n,), mm, of points (n, 3)."""
        return np.asarray(points @ np.array(self.normal) - self.offset)


@dataclass(frozen=True)
class Carriers:
    """The CAD faces of a finger: ``planes``, the body's first, and the curved contact surface.

    ``of_body`` numbers the body's planes and ``of_plate[k]`` those of plate k, in ``planes``; the
    contact surface has the number len(planes). ``smooth``: the contact surface runs into the sides
    without an edge (a half circle).
    """

    contact: ContactSurface
    planes: tuple[Plane, ...]
    of_body: tuple[int, ...]
    of_plate: tuple[tuple[int, ...], ...]
    smooth: bool = False

    @property
    def contact_number(self) -> int:
        return len(self.planes)

    def name(self, number: int) -> str:
        """Facet name of a carrier of the body's outside."""
        return "contact" if number == self.contact_number else self.planes[number].name

    def distances(self, points: Array, numbers: tuple[int, ...]) -> Array:
        """Signed distances (n, len(numbers)) from points (n, 3) to some carriers."""
        columns = [
            self.contact.distance(points)
            if number == self.contact_number
            else self.planes[number].distance(points)
            for number in numbers
        ]
        return np.stack(columns, axis=1)


def carriers_of(body: Body, frames: tuple[PlateFrame, ...], symmetric: bool) -> Carriers:
    """All CAD faces of a finger, or of its half z >= 0, with ``frames`` as its solid plates."""
    half_width, half_depth = 0.5 * body.width_mm, 0.5 * body.depth_mm
    planes = [
        Plane("base", (0.0, -1.0, 0.0), 0.0),
        Plane("side", (-1.0, 0.0, 0.0), half_width),
        Plane("side", (1.0, 0.0, 0.0), half_width),
        Plane("end", (0.0, 0.0, 1.0), half_depth),
        Plane("symmetry", (0.0, 0.0, -1.0), 0.0)
        if symmetric
        else Plane("end", (0.0, 0.0, -1.0), half_depth),
    ]
    of_body = tuple(range(len(planes)))
    of_plate = []
    for frame in frames:
        first = len(planes)
        name = f"plate_{frame.index}"
        centre = np.array([frame.x, frame.y])
        for direction, extent in ((frame.axis, frame.length), (frame.normal, frame.thickness)):
            for sign in (-1.0, 1.0):
                outward = sign * direction
                offset = float(outward @ centre + 0.5 * extent)
                planes.append(Plane(name, (float(outward[0]), float(outward[1]), 0.0), offset))
        planes.append(Plane(name, (0.0, 0.0, 1.0), frame.high))
        planes.append(Plane(name, (0.0, 0.0, -1.0), -frame.low))
        of_plate.append(tuple(range(first, len(planes))))
    return Carriers(
        ContactSurface.of(body), tuple(planes), of_body, tuple(of_plate), smooth_sides(body)
    )


def smooth_sides(body: Body) -> bool:
    """Whether contact surface and sides meet at less than SMOOTH_DEG: a mesher keeps no edge."""
    return bool(0.5 * body.width_mm > body.arc_radius_mm * np.cos(np.radians(SMOOTH_DEG)))


def regions_by_centroid(points: Array, tets: IntArray, frames: tuple[PlateFrame, ...]) -> IntArray:
    """0 for elastomer, k + 1 for plate k: the box that a tetrahedron's centroid lies in."""
    centroids = points[tets].mean(axis=1)
    regions = np.zeros(len(tets), dtype=np.int64)
    for k, frame in enumerate(frames):
        u, v = np.abs(frame.local(centroids)).T
        z = centroids[:, 2]
        within = (u < 0.5 * frame.length) & (v < 0.5 * frame.thickness)
        regions[within & (z > frame.low) & (z < frame.high)] = k + 1
    return regions


@dataclass(frozen=True)
class BoundaryFacets:
    """Facets that lie on CAD faces: outside, and between elastomer and plates.

    corners (f, 3); carrier (f,): number of the CAD face; outside (f,): True on the body's outside;
    cell (f,): the cell they belong to, the plate's for those between; apex (f,): the cell's fourth
    corner; misfit (f,): greatest distance of a corner to the carrier, mm
    """

    corners: IntArray
    carrier: IntArray
    outside: BoolArray
    cell: IntArray
    apex: IntArray
    misfit: Array

    def on_carriers(self, points: Array, carriers: Carriers) -> BoolArray:
        """Whether each point (n, 3) lies on each carrier, (n, carriers): by its facets.

        Where contact surface and sides run into each other, by its height: on one or the other.
        """
        contact = carriers.contact_number
        found = np.zeros((len(points), contact + 1), dtype=bool)
        for corner in range(3):
            found[self.corners[:, corner], self.carrier] = True
        if carriers.smooth:
            sides = [n for n in carriers.of_body if carriers.planes[n].name == "side"]
            either = found[:, [*sides, contact]].any(axis=1)
            above = above_sides(points, carriers)
            for side in sides:
                near = np.sign(points[:, 0]) == carriers.planes[side].normal[0]
                beside = np.abs(points[:, 0]) > 0.5 * carriers.planes[side].offset
                found[:, side] = either & near & beside & ~above
            found[:, contact] = either & above
        return found


def boundary_facets(
    points: Array, tets: IntArray, regions: IntArray, carriers: Carriers
) -> BoundaryFacets:
    """Find the facets on CAD faces, and the face that carries each: the nearest by its corners.

    Among faces equally near (at a corner of the body), the best aligned one is taken.
    """
    local = np.array(TETRA_FACETS)
    opposite = np.array([6 - sum(facet) for facet in TETRA_FACETS])
    facets = tets[:, local].reshape(-1, 3)
    apexes = tets[:, opposite].reshape(-1)
    cells = np.repeat(np.arange(len(tets)), 4)
    order = np.lexsort(np.sort(facets, axis=1).T[::-1])
    ordered = np.sort(facets[order], axis=1)
    same = np.all(ordered[1:] == ordered[:-1], axis=1)
    paired = np.zeros(len(order), dtype=bool)
    paired[:-1] |= same
    paired[1:] |= same
    lonely = order[~paired]
    first, second = order[:-1][same], order[1:][same]
    differ = regions[cells[first]] != regions[cells[second]]
    first, second = first[differ], second[differ]
    # A facet between two plates would count for the first: such plates touch, which is refused.
    chosen = np.where(regions[cells[first]] > 0, first, second)
    picked = np.concatenate([lonely, chosen])
    outside = np.arange(len(picked)) < len(lonely)
    corners, apex, cell = facets[picked], apexes[picked], cells[picked]
    corners = _outward(points, corners, apex)
    carrier = np.zeros(len(picked), dtype=np.int64)
    misfit = np.zeros(len(picked))
    body = (*carriers.of_body, carriers.contact_number)
    carrier[outside], misfit[outside] = _nearest(points, corners[outside], carriers, body)
    if carriers.smooth:  # contact facets are those that lie on that surface with all corners
        above = above_sides(points, carriers)[corners].all(axis=1)
        sides = [n for n in carriers.of_body if carriers.planes[n].name == "side"]
        either = outside & np.isin(carrier, [*sides, carriers.contact_number])
        right = points[corners, 0].mean(axis=1) > 0.0
        side = np.where(
            right, *(n for s in (1.0, -1.0) for n in sides if carriers.planes[n].normal[0] == s)
        )
        carrier[either] = np.where(above, carriers.contact_number, side)[either]
    for k, numbers in enumerate(carriers.of_plate):
        own = ~outside & (regions[cell] == k + 1)
        carrier[own], misfit[own] = _nearest(points, corners[own], carriers, numbers)
    return BoundaryFacets(corners, carrier, outside, cell, apex, misfit)


def above_sides(points: Array, carriers: Carriers) -> BoolArray:
    """Whether points (n, 3) are higher than the sides' upper edge at their z."""
    half_width = next(p.offset for p in carriers.planes if p.name == "side")
    return np.asarray(points[:, 1] > carriers.contact.height(half_width, points[:, 2]))


def _outward(points: Array, corners: IntArray, apex: IntArray) -> IntArray:
    """Turn triangles so that their normal points away from their cell's fourth corner."""
    a, b, c = (points[corners[:, i]] for i in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), points[apex] - a) > 0
    return np.asarray(np.where(inward[:, None], corners[:, [0, 2, 1]], corners))


def _nearest(
    points: Array, corners: IntArray, carriers: Carriers, numbers: tuple[int, ...]
) -> tuple[IntArray, Array]:
    if len(corners) == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    used, inverse = np.unique(corners, return_inverse=True)
    away = np.abs(carriers.distances(points[used], numbers))
    if carriers.contact_number in numbers:  # continued below its lowest point it is no face
        column = numbers.index(carriers.contact_number)
        below = carriers.contact.lowest - points[used, 1]
        away[:, column] = np.maximum(away[:, column], below)
    misfit = away[inverse.reshape(corners.shape)].max(axis=1)
    a, b, c = (points[corners[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(size, 1e-300)[:, None]
    aligned = np.empty_like(misfit)
    for column, number in enumerate(numbers):
        if number == carriers.contact_number:
            target = carriers.contact.normal((a + b + c) / 3.0)
            aligned[:, column] = np.einsum("ij,ij->i", normal, target)
        else:
            aligned[:, column] = normal @ np.array(carriers.planes[number].normal)
    # A facet as large as its misfit may lean either way: alignment decides between near rivals.
    cost = misfit + 0.25 * np.sqrt(size)[:, None] * (1.0 - aligned)
    best = cost.argmin(axis=1)
    rows = np.arange(len(best))
    return np.array(numbers, dtype=np.int64)[best], misfit[rows, best]
