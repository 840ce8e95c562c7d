"""From fTetWild's tetrahedra to a finger's mesh: inside, tagged, snapped, quadratic, named."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.measures import cell_volumes, oriented
from fingerdesign.mesh.sizing import SizeField
from fingerdesign.mesh.tetra.boundary import (
    BoundaryFacets,
    boundary_facets,
    boundary_names,
    enclosed,
    regions_by_centroid,
)
from fingerdesign.mesh.tetra.carriers import Carriers, carriers_of, in_core
from fingerdesign.mesh.tetra.slots import PlateWay, Slots, open_slots
from fingerdesign.mesh.tetra.snap import curve_facets, improve, snap_to_carriers
from fingerdesign.mesh.types import TETRA_EDGES, Mesh, core_name, prisms, quadratic, with_mid_nodes

# Split edges that came out longer than asked: fTetWild stops when shapes are good, not sizes.
#
# It makes no element much smaller than a fortieth of the body, so that a small contact on a large
# finger would be a few facets. The longest edges are halved first (after Rivara, IJNME 20 (1984)
# 745), all at once that no other split touches, until none is too long. Numpy only.

TOO_LONG = 1.6  # times the size asked; a good mesh has edges of 0.6 to 1.5 times
MOST_ROUNDS = 60


def refine(
    points: Array,
    tets: IntArray,
    regions: IntArray,
    size: Callable[[Array], Array],
    scale: Array,
    most: int,
) -> tuple[Array, IntArray, IntArray]:
    """Points, tetrahedra and regions with no edge over TOO_LONG times ``size`` at its ends.

    Lengths are measured after multiplying coordinates by ``scale`` (3,). New points are edges'
    middles, at the end. Stops at ``most`` tetrahedra: the caller judges their number.
    """
    pairs, wanted = np.array(TETRA_EDGES), size(points)
    for _ in range(MOST_ROUNDS):
        ends = tets[:, pairs]  # (t, 6, 2)
        length = np.linalg.norm((points[ends[..., 1]] - points[ends[..., 0]]) * scale, axis=2)
        long = length > TOO_LONG * 0.5 * wanted[ends].sum(axis=2)
        around = np.flatnonzero(long.any(axis=1))  # every cell of a long edge finds it long
        if len(around) == 0 or len(tets) > most:
            break
        new, cut, upper, lower = _halves(points, tets[around], long[around], length[around])
        cells = around[cut]
        tets = np.vstack([tets, lower])
        tets[cells] = upper
        regions = np.concatenate([regions, regions[cells]])
        points, wanted = np.vstack([points, new]), np.concatenate([wanted, size(new)])
    return points, tets, regions


def _halves(
    points: Array, tets: IntArray, long: NDArray[np.bool_], length: Array
) -> tuple[Array, IntArray, IntArray, IntArray]:
    """One round: new points, the tetrahedra that are halved, and their two halves.

    Of the edges that are too ``long`` those are split that are the longest such in every
    tetrahedron around them: no two are in one, and the longest of all is among them.
    """
    pairs = np.array(TETRA_EDGES)
    ends = np.sort(tets[:, pairs].reshape(-1, 2), axis=1)
    keys, first, of_edge = np.unique(
        ends[:, 0] * len(points) + ends[:, 1], return_index=True, return_inverse=True
    )
    of_edge, edges = of_edge.reshape(len(tets), 6), ends[first]
    rank = np.empty(len(keys))
    rank[np.argsort(length.reshape(-1)[first], kind="stable")] = np.arange(len(keys))
    rank[~long.reshape(-1)[first]] = -1.0
    local = rank[of_edge].argmax(axis=1)
    longest = of_edge[np.arange(len(tets)), local]
    around = np.bincount(of_edge.reshape(-1), minlength=len(keys))
    chosen = np.bincount(longest, minlength=len(keys)) == around
    number = np.cumsum(chosen) - 1 + len(points)
    cut = np.flatnonzero(chosen[longest])
    rows, place = np.arange(len(cut)), local[cut]
    upper, lower = tets[cut].copy(), tets[cut].copy()
    upper[rows, pairs[place, 0]] = number[longest[cut]]
    lower[rows, pairs[place, 1]] = number[longest[cut]]
    return points[edges[chosen]].mean(axis=1), cut, upper, lower


# Solid plates in the slots of a mesh: prisms between the two faces, three tetrahedra each.
#
# fTetWild resolves a plate's thickness with whatever tetrahedra its envelope allows, and what
# strains a gage comes out 10 % off. A slot's faces pair node by node, so the plate between them is
# a layer of prisms: regular across the thickness, at the cost of no node.


def fill_slots(slots: Slots, frames: tuple[PlateFrame, ...]) -> tuple[IntArray, IntArray]:
    """Tetrahedra (t, 4) and regions (t,) of the whole mesh, its slots filled as plates.

    Region k + 1 is plate k. Each quadrilateral between two prisms is cut from the upper node of
    lower number to the lower node of the other, so that neighbours, and the slots' ends, agree.
    """
    tets, regions = [slots.tets], [slots.regions]
    for frame in frames:
        upper = slots.facets[f"plate_{frame.index}_upper"]
        lower = slots.facets[f"plate_{frame.index}_lower"]
        tets.append(oriented(slots.points, prisms(upper, lower)))
        regions.append(np.full(len(tets[-1]), frame.index + 1, dtype=slots.regions.dtype))
    return np.vstack(tets), np.concatenate(regions)


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
        # Carriers become elastomer, cut open at the mid-surfaces; filled with solid plates, or not.
        frames = plate_frames(design)
        made_open = open_slots(points, tets, regions, frames)
        points, tets, regions = made_open.points, made_open.tets, made_open.regions
        if way.filled:
            tets, regions = fill_slots(made_open, frames)
        else:
            slots = made_open.facets
        carriers = carriers_of(design, frames if way.filled else (), symmetric)
        besides = np.vstack([NONE, *slots.values()])
        found = boundary_facets(points, tets, regions, carriers, besides)
    volumes = cell_volumes(points, tets)
    if volumes.min() <= 0.0:
        raise MeshError(
            f"snapping to the CAD faces inverted {int((volumes <= 0).sum())} tetrahedra"
        )
    names = boundary_names(points, found.corners, found.carrier, carriers)
    found = replace(found, name=names)
    return _quadratic(design, way, points, tets, regions, carriers, found, slots, symmetric)


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
    points: Array,
    tets: IntArray,
    regions: IntArray,
    carriers: Carriers,
    found: BoundaryFacets,
    slots: dict[str, IntArray],
    symmetric: bool,
) -> Mesh:
    nodes, cells = quadratic(points, tets)
    whole = with_mid_nodes(cells, found.corners)
    outer, names = whole[found.outside], found.name[found.outside]
    facets = {str(name): outer[names == name] for name in np.unique(names)}
    wanted = {name for number in carriers.outside for name in carriers.faces[number].boundaries}
    for name in sorted(wanted):
        if name not in facets:
            raise MeshError(f"no facet of the mesh lies on the body's {name!r} face")
    nodes, straightened = curve_facets(nodes, cells, carriers, whole, found.carrier)
    on_contact = np.isin(straightened, facets["contact"])
    facets |= {name: with_mid_nodes(cells, rows, name) for name, rows in slots.items()}
    notes: dict[str, float | int | str] = {
        "straightened_contact_nodes": int(on_contact.sum()),
        "straightened_nodes": len(straightened),
        "plates": way.name,
    }
    core = core_name(design)
    return Mesh(nodes, cells, regions, facets, "tetwild", symmetric, notes, core)
