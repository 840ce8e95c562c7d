"""Surfaces of a finger from its mesh, of its gages, and of the part of them that touches.

A section (plane strain) is extruded over the body's depth; a half model is mirrored in z = 0.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Gages
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import below_middle
from fingerdesign.mesh.cells import PRISM
from fingerdesign.mesh.types import Mesh, in_tetrahedra
from fingerdesign.records.arrays import OPEN, ContactHistory

# mm: gages and contact are drawn so far above their faces; on them, both surfaces would flicker.
LIFT = 0.02
_MIRROR = np.array([1.0, 1.0, -1.0])
_BENT_PIECES = 6  # A gage on a bent plate is so many flat pieces.
# Facets of a positively oriented cell, by the dimension.
_OUTWARD = {2: ((0, 1), (1, 2), (2, 0)), 3: ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))}


def gage_quads(plates: tuple[PlateFrame, ...], gages: Gages) -> Array:
    """Corners of the gages, a hair above the plate faces that carry them: (q, 4, 3), mm.

    On a bent plate a gage is several quads in a row.
    """
    quads = []
    for plate in plates:
        pieces = 1 if plate.bend_radius is None else _BENT_PIECES
        along = np.linspace(-0.5, 0.5, pieces + 1) * gages.length_mm
        low, high = (plate.middle + gages.z_mm + sign * 0.5 * gages.width_mm for sign in (-1, 1))
        for side in gages.sides:
            line = plate.from_local(along, side * (0.5 * plate.thickness + LIFT))
            near, far = plate.to_space(line, low), plate.to_space(line, high)
            quads += [[near[k], near[k + 1], far[k + 1], far[k]] for k in range(pieces)]
    return np.array(quads, dtype=float).reshape(-1, 4, 3)


@dataclass(frozen=True)
class Surface:
    """The surface of the whole finger, or of a part of it, and of what of it lies at z <= 0.

    points (n, 3), mm; nodes (n,): of the mesh, mirrored (n,) in z where ``mirrored``.
    whole, half: triangles (t, 3) outward; ``half`` is closed by the section at z = 0.
    """

    points: Array
    nodes: IntArray
    mirrored: BoolArray
    whole: IntArray
    half: IntArray

    def moved(self, displacement: Array) -> Array:
        """The points moved by the displacement (nodes, dim), mm, of the mesh's nodes."""
        own = np.zeros_like(self.points)
        own[:, : displacement.shape[1]] = displacement[self.nodes]
        own[self.mirrored, 2] *= -1.0
        return np.asarray(self.points + own)


def surface_of(mesh: Mesh, depth: float, chosen: BoolArray | None = None) -> Surface:
    """The surface of the mesh's chosen cells, by their corner nodes; squares are cut in two."""
    if mesh.kind is PRISM:
        chosen, mesh = None if chosen is None else chosen.repeat(3), in_tetrahedra(mesh)
    facets = skin(mesh, mesh.corners if chosen is None else mesh.corners[chosen])
    nodes, own = np.unique(facets, return_inverse=True)
    own, flat = own.reshape(facets.shape), mesh.points[nodes]
    n, none = len(flat), np.zeros(len(flat), dtype=bool)
    if mesh.dimension == 2:
        points = in_layers(flat, depth)
        cap, far, near = _cap(flat, own), wall(own, n), wall(own, n) + n
        half = np.concatenate([cap[:, ::-1], far, cap + n])
        whole = np.concatenate([cap[:, ::-1], far, near, cap + 2 * n])
        return Surface(points, np.tile(nodes, 3), np.tile(none, 3), whole, half)
    if mesh.symmetric:
        cut = (np.abs(flat[own][..., 2]) < 1e-9).all(axis=1)  # no surface of the whole finger
        points = np.concatenate([flat, flat * _MIRROR])
        whole = np.concatenate([own[~cut], own[~cut][:, ::-1] + n])
        return Surface(points, np.tile(nodes, 2), np.arange(2 * n) >= n, whole, own[:, ::-1] + n)
    below, half = below_middle(flat, own)
    more = np.zeros(len(below), dtype=int)
    points, nodes = np.concatenate([flat, below]), np.concatenate([nodes, more])
    return Surface(points, nodes, nodes < 0, own, half + n if len(half) else own)


def skin(mesh: Mesh, cells: IntArray) -> IntArray:
    """The facets (f, dim) of one of the cells alone, outward, by their corner nodes.

    Those of slots, in which plates lie as sheets, are left out.
    """
    powers = len(mesh.points) ** np.arange(mesh.dimension)

    def keys(facets: IntArray) -> IntArray:
        found: IntArray = np.sort(facets[:, : mesh.dimension], axis=1) @ powers
        return found

    facets = np.concatenate([cells[:, part] for part in _OUTWARD[mesh.dimension]])
    _, first, uses = np.unique(keys(facets), return_index=True, return_counts=True)
    outer = facets[first[uses == 1]]
    slots = [keys(each) for name, each in mesh.facets.items() if name.startswith("plate_")]
    return np.asarray(outer[~np.isin(keys(outer), np.concatenate(slots))] if slots else outer)


def in_layers(flat: Array, depth: float) -> Array:
    """Points (n, 2) of a section at its back, in its middle and at its front: (3 n, 3)."""
    planes = (-0.5 * depth, 0.0, 0.5 * depth)
    return np.concatenate([np.column_stack([flat, np.full(len(flat), z)]) for z in planes])


def wall(ends: IntArray, count: int) -> IntArray:
    """Triangles over lines (f, 2) between a layer of ``count`` points and the next."""
    a, b = ends.T
    return np.concatenate([np.stack([a, b, b + count], 1), np.stack([a, b + count, a + count], 1)])


def _cap(points: Array, edges: IntArray) -> IntArray:
    """Triangles over the inside of closed outlines: points (n, 2), edges (f, 2)."""
    from scipy.spatial import Delaunay

    found = Delaunay(points).simplices
    x, y = points[found].mean(axis=1).T[..., None]
    (xa, ya), (xb, yb) = points[edges[:, 0]].T, points[edges[:, 1]].T
    between = (ya > y) != (yb > y)  # a line to the left crosses an outline an odd number of times
    crossed = between & (x < xa + (y - ya) * (xb - xa) / np.where(between, yb - ya, 1.0))
    found = found[crossed.sum(axis=1) % 2 == 1]
    a, b, c = np.moveaxis(points[found], 1, 0)
    turned = np.linalg.det(np.stack([b - a, c - a], axis=1)) < 0.0
    return np.asarray(np.where(turned[:, None], found[:, ::-1], found))


@dataclass(frozen=True)
class Patch:
    """Points (n, 3), a hair above the surface, and triangles (t, 3) of all that is ever in contact.

    owner (n,): the contact point at each. The first ``half`` triangles lie at z <= 0.
    """

    points: Array
    triangles: IntArray
    owner: IntArray
    half: int

    def apart(self) -> tuple[Array, IntArray, IntArray]:
        """Cut between the contact points: points, triangles, and the owner of each triangle.

        A triangle's corner keeps two triangles, to the middles of its edges and to its own.
        """
        corner = self.points[self.triangles]
        middle, between = corner.mean(axis=1, keepdims=True), 0.5 * (corner + corner[:, [1, 2, 0]])
        points = np.concatenate([corner, between, middle], axis=1).reshape(-1, 3)
        six = np.array([[0, 3, 6], [0, 6, 5], [1, 4, 6], [1, 6, 3], [2, 5, 6], [2, 6, 4]])
        triangles = (7 * np.arange(len(corner))[:, None, None] + six).reshape(-1, 3)
        return points, triangles, self.owner[self.triangles].repeat(2, axis=1).ravel()


def patch_of(contact: ContactHistory, depth: float) -> Patch:
    """The patch of a contact: strips over the depth of a section, both halves of a half model."""
    touched = (contact.status != OPEN).any(axis=0)
    facets, m = contact.facets[touched[contact.facets].any(axis=1)], len(contact.points)
    copies, points = 1, contact.points
    if contact.dimension == 2:
        far, near = wall(facets, m), wall(facets, m) + m
        copies, points = 3, in_layers(points, depth)
    elif contact.symmetric:
        far, near, copies = facets + m, facets, 2
        points = np.concatenate([points, points * _MIRROR])
    else:
        behind = points[facets][..., 2].mean(axis=1) <= 0.0
        far, near = facets[behind], facets[~behind]
    used, triangles = np.unique(np.concatenate([far, near]), return_inverse=True)
    owner = np.tile(np.arange(m), copies)[used]
    return Patch(points[used] + [0.0, LIFT, 0.0], triangles.reshape(-1, 3), owner, len(far))
