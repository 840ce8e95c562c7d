"""From fTetWild's tetrahedra to a finger's mesh: inside, tagged, snapped, quadratic, named."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.layout import plate_frames
from fingerdesign.errors import MeshError
from fingerdesign.mesh.boundary import BoundaryFacets, boundary_facets, regions_by_centroid
from fingerdesign.mesh.carriers import Carriers, carriers_of, in_core
from fingerdesign.mesh.improve import improve
from fingerdesign.mesh.inside import enclosed
from fingerdesign.mesh.plate_ways import PlateWay
from fingerdesign.mesh.refine import refine
from fingerdesign.mesh.sizing import SizeField
from fingerdesign.mesh.slot_fill import fill_slots
from fingerdesign.mesh.slots import open_slots
from fingerdesign.mesh.snap import curve_facets, quadratic_facets, snap_to_carriers, tet_volumes
from fingerdesign.mesh.types import Mesh, quadratic

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

NONE = np.zeros((0, 3), dtype=np.int64)


def finish(
    design: Design,
    way: PlateWay,
    points: Array,
    tets: IntArray,
    outside: tuple[Array, IntArray],
    symmetric: bool,
    field: SizeField,
    most: int,
) -> Mesh:
    """Keep what is inside, tag it, snap it to the CAD faces, make it quadratic, name its facets.

    points (n, 3) and tets (t, 4) fill more than the body, whose closed outside has the vertices and
    triangles ``outside``; ``way``: how its plates were meshed.
    Edges longer than ``field`` asks at the contact are split, up to ``most`` tetrahedra. MeshError
    where snapping would invert a tetrahedron or a face of the body has no facet.
    """
    points, tets = _inside(points, tets, outside)
    regions = regions_by_centroid(points, tets, way.meshed)
    regions[in_core(design.body, points[tets].mean(axis=1))] = design.core_region
    carriers = carriers_of(design, way.meshed, symmetric)
    found = boundary_facets(points, tets, regions, carriers, NONE)
    points = snap_to_carriers(points, found.on_carriers(len(points), carriers), carriers)
    made = len(tets)
    scale = np.array([1.0, 1.0, 1.0 / field.sizes.stretch])
    points, tets, regions = refine(points, tets, regions, field.at_contact, scale, most)
    if len(tets) > made:
        found = boundary_facets(points, tets, regions, carriers, NONE)
    on_carriers = found.on_carriers(len(points), carriers)
    points = snap_to_carriers(points, on_carriers, carriers)
    points = improve(points, tets, on_carriers, carriers)
    slots: dict[str, IntArray] = {}
    if way.cut:
        points, tets, regions, slots = _opened(design, points, tets, regions, way.filled)
        carriers = carriers_of(design, plate_frames(design) if way.filled else (), symmetric)
        besides = np.vstack([NONE, *slots.values()])
        found = boundary_facets(points, tets, regions, carriers, besides)
    volumes = tet_volumes(points, tets)
    if volumes.min() <= 0.0:
        raise MeshError(
            f"snapping to the CAD faces inverted {int((volumes <= 0).sum())} tetrahedra"
        )
    return _quadratic(design, way, points, tets, regions, carriers, found, slots, symmetric)


def _inside(
    points: Array, tets: IntArray, outside: tuple[Array, IntArray]
) -> tuple[Array, IntArray]:
    """The tetrahedra whose centroids lie in the body, positively oriented, with their points."""
    within = enclosed(points[tets].mean(axis=1), *outside)
    if not within.any():
        raise MeshError("fTetWild returned no tetrahedron inside the body")
    used, renumbered = np.unique(tets[within], return_inverse=True)
    points, tets = points[used], renumbered.reshape(-1, 4).astype(np.int64)
    negative = tet_volumes(points, tets) < 0.0
    tets[negative] = tets[negative][:, [0, 2, 1, 3]]
    return points, tets


def _opened(
    design: Design, points: Array, tets: IntArray, regions: IntArray, filled: bool
) -> tuple[Array, IntArray, IntArray, dict[str, IntArray]]:
    """Carriers become elastomer, cut open at the mid-surfaces; ``filled``: with solid plates."""
    frames = plate_frames(design)
    slots = open_slots(points, tets, regions, frames)
    if not filled:
        return slots.points, slots.tets, slots.regions, slots.facets
    return slots.points, *fill_slots(slots, frames), {}


def _quadratic(
    design: Design,
    way: PlateWay,
    points: Array,
    tets: IntArray,
    regions: IntArray,
    carriers: Carriers,
    found: BoundaryFacets,
    slots: dict[str, IntArray],
    symmetric: bool,
) -> Mesh:
    nodes, cells = quadratic(points, tets)
    whole = quadratic_facets(cells, found.corners, len(nodes))
    outer, names = whole[found.outside], found.name[found.outside]
    facets = {str(name): outer[names == name] for name in np.unique(names)}
    for name in carriers.outer_names():
        if name not in facets:
            raise MeshError(f"no facet of the mesh lies on the body's {name!r} face")
    curved = curve_facets(nodes, cells, carriers, whole, found.carrier)
    on_contact = np.isin(curved.straightened, facets["contact"])
    facets |= {name: quadratic_facets(cells, rows, len(nodes)) for name, rows in slots.items()}
    notes: dict[str, float | int | str] = {
        "straightened_contact_nodes": int(on_contact.sum()),
        "straightened_nodes": len(curved.straightened),
        "plates": way.name,
    }
    names_of = {design.core_region: "core"} if design.body.core is not None else {}
    return Mesh(curved.points, cells, regions, facets, "tetwild", symmetric, notes, names_of)
