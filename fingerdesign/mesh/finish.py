"""From fTetWild's tetrahedra to a finger's mesh: inside, tagged, snapped, quadratic, named."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame
from fingerdesign.errors import MeshError
from fingerdesign.geometry.surface import ContactSurface
from fingerdesign.mesh.boundary import (
    BoundaryFacets,
    Carriers,
    boundary_facets,
    carriers_of,
    regions_by_centroid,
)
from fingerdesign.mesh.snap import (
    curve_contact,
    quadratic_facets,
    snap_to_carriers,
    tet_volumes,
)
from fingerdesign.mesh.types import Mesh, quadratic

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


def finish(
    body: Body, frames: tuple[PlateFrame, ...], points: Array, tets: IntArray, symmetric: bool
) -> Mesh:
    """Keep what is inside, tag it, snap it to the CAD faces, make it quadratic, name its facets.

    points (n, 3) and tets (t, 4) fill more than the body; ``frames``: its solid plates. MeshError
    where snapping would invert a tetrahedron or a face of the body has no facet.
    """
    points, tets = _inside(body, points, tets, symmetric)
    regions = regions_by_centroid(points, tets, frames)
    carriers = carriers_of(body, frames, symmetric)
    found = boundary_facets(points, tets, regions, carriers)
    on_carriers = found.on_carriers(points, carriers)
    points = snap_to_carriers(points, on_carriers, carriers)
    volumes = tet_volumes(points, tets)
    if volumes.min() <= 0.0:
        raise MeshError(
            f"snapping to the CAD faces inverted {int((volumes <= 0).sum())} tetrahedra"
        )
    nodes, cells = quadratic(points, tets)
    facets = _named_facets(found, carriers, cells, len(nodes))
    for name in ("base", "contact", "side", "end", *(["symmetry"] if symmetric else [])):
        if name not in facets:
            raise MeshError(f"no facet of the mesh lies on the body's {name!r} face")
    curved = curve_contact(nodes, cells, on_carriers, carriers, facets["contact"])
    notes: dict[str, float | int | str] = {"straightened_contact_nodes": curved.straightened}
    return Mesh(curved.points, cells, regions, facets, "tetwild", symmetric, notes)


def _inside(body: Body, points: Array, tets: IntArray, symmetric: bool) -> tuple[Array, IntArray]:
    """The tetrahedra whose centroids lie in the body, positively oriented, with their points."""
    x, y, z = points[tets].mean(axis=1).T
    within = (np.abs(x) < 0.5 * body.width_mm) & (y > 0.0) & (z < 0.5 * body.depth_mm)
    within &= z > (0.0 if symmetric else -0.5 * body.depth_mm)
    surface = ContactSurface.of(body)
    within[within] = surface.encloses(np.stack([x, y, z], axis=1)[within])
    if not within.any():
        raise MeshError("fTetWild returned no tetrahedron inside the body")
    used, renumbered = np.unique(tets[within], return_inverse=True)
    points, tets = points[used], renumbered.reshape(-1, 4).astype(np.int64)
    negative = tet_volumes(points, tets) < 0.0
    tets[negative] = tets[negative][:, [0, 2, 1, 3]]
    return points, tets


def _named_facets(
    found: BoundaryFacets, carriers: Carriers, cells: IntArray, nodes: int
) -> dict[str, IntArray]:
    outer = quadratic_facets(cells, found.corners[found.outside], nodes)
    names = np.array([carriers.name(int(n)) for n in found.carrier[found.outside]])
    return {str(name): outer[names == name] for name in np.unique(names)}
