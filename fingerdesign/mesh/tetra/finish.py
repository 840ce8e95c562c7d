"""From fTetWild's tetrahedra to a finger's mesh: inside, tagged, snapped, quadratic, named."""

from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.cells import quadratic, split_prisms, with_mid_nodes
from fingerdesign.mesh.measures import cell_volumes, oriented
from fingerdesign.mesh.sizing import SizeField
from fingerdesign.mesh.tetra.boundary import (
    BoundaryFacets,
    boundary_names,
    carried_facets,
    enclosed,
    regions_by_centroid,
)
from fingerdesign.mesh.tetra.carriers import Carriers, beyond, carriers_of, in_core
from fingerdesign.mesh.tetra.collapse import collapse
from fingerdesign.mesh.tetra.improve import improve
from fingerdesign.mesh.tetra.refine import refine
from fingerdesign.mesh.tetra.slots import Slots, open_slots
from fingerdesign.mesh.tetra.snap import curve_facets, snap_to_carriers
from fingerdesign.mesh.tetra.ways import PlateWay
from fingerdesign.mesh.types import Mesh, core_name

NONE = np.zeros((0, 3), dtype=np.int64)


def fill_slots(slots: Slots, frames: tuple[PlateFrame, ...]) -> Slots:
    """The whole mesh, its slots filled as plates: no facet of a slot is left.

    fTetWild resolves a plate's thickness with whatever tetrahedra its envelope allows, and what
    strains a gage comes out 10 % off. A slot's faces pair node by node, so the plate between them
    is a layer of prisms: regular across the thickness, at the cost of no node.
    Region k + 1 is plate k. Each quadrilateral between two prisms is cut from the upper node of
    lower number to the lower node of the other, so that neighbours, and the slots' ends, agree.
    """
    tets, regions = [slots.tets], [slots.regions]
    for frame in frames:
        upper = slots.facets[f"plate_{frame.index}_upper"]
        lower = slots.facets[f"plate_{frame.index}_lower"]
        tets.append(oriented(slots.points, split_prisms(upper, lower)))
        regions.append(np.full(len(tets[-1]), frame.index + 1, dtype=slots.regions.dtype))
    return replace(slots, tets=np.vstack(tets), regions=np.concatenate(regions), facets={})


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
    """Select what is inside, tag it, snap it to the CAD faces, make it quadratic, name its facets.

    points (n, 3) and tets (t, 4) fill more than the body, whose closed outside has the vertices and
    triangles ``outside``; ``way``: how its plates were meshed.
    Nodes of flat tetrahedra are merged. Edges at the contact longer than ``field`` are split, up to
    ``most`` tetrahedra. MeshError where snapping would invert a tetrahedron or a face of the body
    has no facet.
    """
    points, tets = _inside(points, tets, outside)
    regions = regions_by_centroid(points, tets, way.meshed)
    regions[in_core(design.body, points[tets].mean(axis=1))] = design.core_region
    carriers = carriers_of(design, way.meshed, symmetric)
    found = carried_facets(points, tets, regions, carriers, NONE)
    lies_on = found.on_carriers(len(points), carriers) | beyond(points, carriers)
    points = snap_to_carriers(points, lies_on, carriers)
    before = len(tets)
    points, tets, regions = collapse(points, tets, regions, lies_on)
    made = len(tets)
    scale = np.array([1.0, 1.0, 1.0 / field.sizes.stretch])
    points, tets, regions = refine(points, tets, regions, field.at_contact, scale, most)
    if len(tets) > made or made < before:
        found = carried_facets(points, tets, regions, carriers, NONE)
    on_carriers = found.on_carriers(len(points), carriers)
    points = snap_to_carriers(points, on_carriers, carriers)
    points = improve(points, tets, on_carriers, carriers)
    linear = Slots(points, tets, regions, {}, np.arange(len(points)))
    if way.cut:
        # Carriers become elastomer, cut open at the mid-surfaces; filled with solid plates, or not.
        frames = plate_frames(design)
        linear = open_slots(points, tets, regions, frames)
        if way.filled:
            linear = fill_slots(linear, frames)
        carriers = carriers_of(design, frames if way.filled else (), symmetric)
        slot_facets = np.vstack([NONE, *linear.facets.values()])
        found = carried_facets(linear.points, linear.tets, linear.regions, carriers, slot_facets)
    volumes = cell_volumes(linear.points, linear.tets)
    if volumes.min() <= 0.0:
        raise MeshError(
            f"snapping to the CAD faces inverted {int((volumes <= 0).sum())} tetrahedra"
        )
    names = boundary_names(linear.points, found.corners, found.carrier, carriers)
    found = replace(found, name=names)
    return _quadratic(design, way, linear, carriers, found, symmetric)


def _inside(
    points: Array, tets: IntArray, outside: tuple[Array, IntArray]
) -> tuple[Array, IntArray]:
    """The tetrahedra whose centroids lie in the body, positively oriented, with their points."""
    within = enclosed(points[tets].mean(axis=1), *outside)
    if not within.any():
        raise MeshError("fTetWild returned no tetrahedron inside the body")
    used, renumbered = np.unique(tets[within], return_inverse=True)
    points = points[used]
    return points, oriented(points, renumbered.reshape(-1, 4).astype(np.int64))


def _quadratic(
    design: Design,
    way: PlateWay,
    linear: Slots,
    carriers: Carriers,
    found: BoundaryFacets,
    symmetric: bool,
) -> Mesh:
    nodes, cells = quadratic(linear.points, linear.tets)
    whole = with_mid_nodes(cells, found.corners)
    outer, names = whole[found.outside], found.name[found.outside]
    facets = {str(name): outer[names == name] for name in np.unique(names)}
    target = {name for number in carriers.outside for name in carriers.faces[number].boundaries}
    for name in sorted(target):
        if name not in facets:
            raise MeshError(f"no facet of the mesh lies on the body's {name!r} face")
    nodes, straightened = curve_facets(nodes, cells, carriers, whole, found.carrier)
    on_contact = np.isin(straightened, facets["contact"])
    facets |= {name: with_mid_nodes(cells, rows, name) for name, rows in linear.facets.items()}
    notes: dict[str, float | int | str] = {
        "straightened_contact_nodes": int(on_contact.sum()),
        "straightened_nodes": len(straightened),
        "plates": way.name,
    }
    core = core_name(design)
    return Mesh(nodes, cells, linear.regions, facets, "tetwild", symmetric, notes, core)
