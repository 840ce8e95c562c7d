"""Regions of cells, the facets that bound them, and the CAD face that carries each facet."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.cells import facet_keys, same_keys, tetra_facets
from fingerdesign.mesh.tetra.carriers import Carriers
from fingerdesign.shapes.quadrics import dot


def enclosed(points: Array, vertices: Array, triangles: IntArray) -> BoolArray:
    """Mask (n,) of points (n, 3) inside the closed surface of triangles (t, 3), wound outward.

    There its signed distance is negative (VTK). MeshError for an open one: signs would be wrong.
    """
    import pyvista

    surface = pyvista.PolyData.from_regular_faces(vertices, triangles)
    if surface.n_open_edges:
        raise MeshError(f"the outside is not closed: {surface.n_open_edges} edges are open")
    found = pyvista.PolyData(points).compute_implicit_distance(surface)
    return np.asarray(found["implicit_distance"] < 0.0)


def regions_by_centroid(points: Array, tets: IntArray, frames: tuple[PlateFrame, ...]) -> IntArray:
    """0 for elastomer, k + 1 for plate k: the plate that holds a tetrahedron's centroid."""
    centroids = points[tets].mean(axis=1)
    regions = np.zeros(len(tets), dtype=np.int64)
    for frame in frames:
        regions[frame.holds(centroids)] = frame.index + 1
    return regions


@dataclass(frozen=True)
class BoundaryFacets:
    """Facets that lie on CAD faces: outside, and between elastomer and parts.

    corners (f, 3); carrier (f,): number of the CAD face; outside (f,): True on the body's outside;
    cell (f,): the cell they belong to, the part's for those between; name (f,): the boundary's, of
    outer facets; misfit (f,): greatest distance of a corner to the carrier, mm
    """

    corners: IntArray
    carrier: IntArray
    outside: BoolArray
    cell: IntArray
    name: NDArray[np.str_]
    misfit: Array

    def on_carriers(self, nodes: int, carriers: Carriers) -> BoolArray:
        """Mask (n, carriers) of the carriers that each node lies on, by its facets."""
        found = np.zeros((nodes, len(carriers.faces)), dtype=bool)
        for corner in range(3):
            found[self.corners[:, corner], self.carrier] = True
        return found


def carried_facets(
    points: Array, tets: IntArray, regions: IntArray, carriers: Carriers, slot_facets: IntArray
) -> BoundaryFacets:
    """Find the facets on CAD faces, and the face that carries each: the nearest by its corners.

    Among faces equally near (at a corner of the body), the best aligned one is taken.
    slot_facets (f, 3): corners of facets to leave out (slots of sheets).
    """
    facets, apexes, cells = tetra_facets(tets)
    keys = facet_keys(facets, len(points))
    first, second = same_keys(keys)
    alone = np.ones(len(keys), dtype=bool)
    alone[first] = alone[second] = False
    lonely = np.flatnonzero(alone)
    lonely = lonely[np.argsort(keys[lonely], kind="stable")]
    if len(slot_facets):
        lonely = lonely[~np.isin(keys[lonely], facet_keys(slot_facets, len(points)))]
    differ = regions[cells[first]] != regions[cells[second]]
    first, second = first[differ], second[differ]
    # A facet between two parts would count for the higher: such parts touch, which is refused.
    chosen = np.where(regions[cells[first]] > regions[cells[second]], first, second)
    picked = np.concatenate([lonely, chosen])
    outside = np.arange(len(picked)) < len(lonely)
    corners, cell = facets[picked], cells[picked]
    a, b, c = (points[corners[:, k]] for k in range(3))
    inward = dot(np.cross(b - a, c - a), points[apexes[picked]] - a) > 0.0
    corners = np.where(inward[:, None], corners[:, [0, 2, 1]], corners)
    carrier = np.zeros(len(picked), dtype=np.int64)
    misfit = np.zeros(len(picked))
    parts = [(outside, carriers.outside)]
    for region, numbers in carriers.of_part.items():
        parts.append((~outside & (regions[cell] == region), numbers))
    for own, numbers in parts:
        carrier[own], misfit[own] = _nearest(points, corners[own], carriers, numbers)
    names = boundary_names(points, corners, carrier, carriers)
    return BoundaryFacets(corners, carrier, outside, cell, names, misfit)


def boundary_names(
    points: Array, corners: IntArray, carrier: IntArray, carriers: Carriers
) -> NDArray[np.str_]:
    """The boundary's name of each facet (f,).

    On a carrier of several boundaries, which join without an edge, the contact's facets are those
    with all corners on it, the others their middle's: there points must lie on their faces, for
    micrometres inside the nearer one is chance.
    """
    names = np.array([face.name for face in carriers.faces])[carrier]
    for number, face in enumerate(carriers.faces):
        rest = [name for name in face.boundaries if name != "contact"]
        if len(face.boundaries) == 1:
            continue
        rows = np.flatnonzero(carrier == number)
        used, inverse = np.unique(corners[rows], return_inverse=True)
        touching = (face.names(points[used]) == "contact")[inverse.reshape(-1, 3)].all(axis=1)
        middle = face.names(points[corners[rows]].mean(axis=1))
        middle = np.where(middle == "contact", rest[0], middle)
        names[rows] = np.where(touching, "contact", middle)
    return names


def _nearest(
    points: Array, corners: IntArray, carriers: Carriers, numbers: tuple[int, ...]
) -> tuple[IntArray, Array]:
    if len(corners) == 0:
        return np.zeros(0, dtype=np.int64), np.zeros(0)
    used, inverse = np.unique(corners, return_inverse=True)
    inverse = inverse.reshape(corners.shape)
    faces = [carriers.faces[number] for number in numbers]
    a, b, c = (points[corners[:, i]] for i in range(3))
    normal = np.cross(b - a, c - a)
    size = np.linalg.norm(normal, axis=1)
    normal /= np.maximum(size, 1e-300)[:, None]
    middle = (a + b + c) / 3.0
    misfit = np.stack([face.misfit(points[used])[inverse].max(axis=1) for face in faces], axis=1)
    aligned = np.stack([dot(normal, face.normal(middle)) for face in faces], axis=1)
    # A facet as large as its misfit may lean either way: alignment decides between near rivals.
    cost = misfit + 0.25 * np.sqrt(size)[:, None] * (1.0 - aligned)
    best = cost.argmin(axis=1)
    rows = np.arange(len(best))
    return np.array(numbers, dtype=np.int64)[best], misfit[rows, best]
