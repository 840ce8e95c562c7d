"""Surfaces to look at, out of a mesh: of the body and of each plate (numpy only).

A section (plane strain) is drawn as the finger that it stands for: extruded over the body's depth.
A half model is mirrored in z = 0.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.layout import PlateFrame
from fingerdesign.mesh.types import Mesh
from fingerdesign.results import GageLayout

_LIFT = 0.02  # mm: gages lie above their faces, or the two would flicker into each other
_BENT_PIECES = 6
_OUTWARD_SIDES = ((0, 1), (1, 2), (2, 0))
_OUTWARD_FACES = ((0, 2, 1), (0, 1, 3), (0, 3, 2), (1, 2, 3))


@dataclass(frozen=True, eq=False)
class Surface:
    """Triangles in space.

    points (n, 3) mm; triangles (t, 3), looking outward; nodes (n,): the mesh node of each point.
    """

    points: Array
    triangles: IntArray
    nodes: IntArray


def surface_of(mesh: Mesh, chosen: NDArray[np.bool_], depth_mm: float) -> Surface:
    """The boundary of the chosen cells, (c,), as flat triangles between corner nodes."""
    cells = mesh.corners[chosen]
    if mesh.dimension == 2:
        return _extruded(mesh.points, cells, depth_mm)
    facets = boundary(cells)
    if mesh.symmetric:  # the cut itself is no surface of the finger
        facets = facets[np.abs(mesh.points[facets][..., 2]).max(axis=1) > 1e-6]
    nodes, triangles = np.unique(facets, return_inverse=True)
    triangles = triangles.reshape(facets.shape)
    points = mesh.points[nodes]
    if mesh.symmetric:
        mirrored = points * np.array([1.0, 1.0, -1.0])
        flipped = triangles[:, ::-1] + len(points)
        points = np.concatenate([points, mirrored])
        triangles, nodes = np.concatenate([triangles, flipped]), np.tile(nodes, 2)
    return Surface(points, triangles, nodes)


def boundary(cells: IntArray) -> IntArray:
    """Facets of one cell only, looking outward: (b, 2) of triangles, (b, 3) of tetrahedra.

    The cells must be positively oriented.
    """
    sides = _OUTWARD_SIDES if cells.shape[1] == 3 else _OUTWARD_FACES
    facets = np.concatenate([cells[:, list(side)] for side in sides])
    _, first, count = np.unique(
        np.sort(facets, axis=1), axis=0, return_index=True, return_counts=True
    )
    return np.asarray(facets[first[count == 1]])


def gage_quads(plates: tuple[PlateFrame, ...], gages: GageLayout) -> Array:
    """Corners of the gages, a hair above the plate faces that carry them: (q, 4, 3), mm.

    On a bent plate a gage is several quads, one beside the other.
    """
    sides = {"upper": (1.0,), "lower": (-1.0,)}.get(gages.face, (1.0, -1.0))
    quads = []
    for plate in plates:
        pieces = 1 if plate.bend_radius is None else _BENT_PIECES
        along = np.linspace(-0.5, 0.5, pieces + 1) * gages.length_mm
        low, high = (plate.middle + gages.z_mm + sign * 0.5 * gages.width_mm for sign in (-1, 1))
        for side in sides:
            line = plate.from_local(along, side * (0.5 * plate.thickness + _LIFT))
            near, far = plate.to_space(line, low), plate.to_space(line, high)
            quads += [[near[k], near[k + 1], far[k + 1], far[k]] for k in range(pieces)]
    return np.array(quads, dtype=float).reshape(-1, 4, 3)


def plate_boxes(plates: tuple[PlateFrame, ...]) -> Surface:
    """The plates as they are cast, from their frames alone; holes are left out."""
    points, triangles, count = [], [], 0
    for plate in plates:
        ring = plate.outline()
        n = len(ring)
        flat = np.array([[k, k + 1, n - 2 - k] for k in range(n // 2 - 1)])
        other = np.array([[k, n - 2 - k, n - 1 - k] for k in range(n // 2 - 1)])
        cap = np.concatenate([flat, other])
        k = np.arange(n)
        after = np.roll(k, -1)
        walls = np.concatenate(
            [np.stack([k, after, after + n], 1), np.stack([k, after + n, k + n], 1)]
        )
        points += [plate.to_space(ring, w) for w in (plate.low, plate.high)]
        whole = np.concatenate([cap[:, ::-1], cap + n, walls])
        if plate.along == "z":  # (z, y) against x is the other hand
            whole = whole[:, ::-1]
        triangles.append(whole + count)
        count += 2 * n
    none = np.zeros(0, dtype=np.int64)
    if not points:
        return Surface(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.int64), none)
    return Surface(np.concatenate(points), np.concatenate(triangles), np.zeros(count, dtype=int))


def region_of(mesh: Mesh, name: str) -> NDArray[np.bool_]:
    """Which cells (c,) are of the region ``name``, or of any plate: "plates"."""
    named = {number: mesh.region_name(number) for number in np.unique(mesh.regions).tolist()}
    if name == "plates":
        chosen = [number for number, said in named.items() if said.startswith("plate_")]
    else:
        chosen = [number for number, said in named.items() if said == name]
    return np.asarray(np.isin(mesh.regions, chosen))


def _extruded(points: Array, cells: IntArray, depth: float) -> Surface:
    nodes, triangles = np.unique(cells, return_inverse=True)
    triangles = triangles.reshape(cells.shape)
    flat, n = points[nodes], len(nodes)
    ends = [np.column_stack([flat, np.full(n, z)]) for z in (-0.5 * depth, 0.5 * depth)]
    a, b = boundary(triangles).T
    walls = np.concatenate([np.stack([a, b, b + n], 1), np.stack([a, b + n, a + n], 1)])
    whole = np.concatenate([triangles[:, ::-1], triangles + n, walls])
    return Surface(np.concatenate(ends), whole, np.tile(nodes, 2))
