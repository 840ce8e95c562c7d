"""Plates as sheets in tetrahedra: a mesh cut along the plates' mid-surfaces, opened to slots.

fTetWild follows closed surfaces, so each plate is meshed as one face, its mid-surface, of a box of
rubber, the *carrier*, thicker than the plate by far. Then the mesh is cut along that face
(slot_cut.py), the two sides are moved t/2 apart, and what opens beyond the plate's
square ends is filled with tetrahedra. So the rubber has its true shape, and the plate is the slot,
which structural elements fill (fem/sheet.py), or prisms for a solid plate (finish.py).
fTetWild makes no element of the plate's thickness, and across it the mesh is regular.
Measured on maeno2000 against a fine extruded mesh: plates cut in, readings within 1.2 to 1.8 % on
130k to 190k dofs; resolved by fTetWild itself, 10 to 14 % on 230k.
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.cells import Stars, boundary_facets, pieces, same_keys, tetra_facets
from fingerdesign.mesh.tetra.slot_cut import Cut, plan_cut, sheet_facets_of
from fingerdesign.mesh.tetra.widen import widened


@dataclass(frozen=True)
class Slots:
    """A linear mesh with a slot for each plate.

    points (n, 3) mm; tets (t, 4), positively oriented: those given, then those that fill the
    slots' ends; regions (t,): carriers have become elastomer, 0; facets: name -> corners (f, 3) of
    "plate_k_upper", "plate_k_lower" and "plate_k_end"; origin (n,): the node given that each node
    was, or that it was split from.
    """

    points: Array
    tets: IntArray
    regions: IntArray
    facets: dict[str, IntArray]
    origin: IntArray


def open_slots(
    points: Array, tets: IntArray, regions: IntArray, frames: tuple[PlateFrame, ...]
) -> Slots:
    """Cut a snapped mesh along the mid-surfaces of ``frames`` and open it to their thickness.

    points (n, 3), tets (t, 4) positively oriented; regions (t,): k + 1 where plate k's carrier is;
    others stay. MeshError where a mid-surface is not filled by facets, where its rim leaves no
    way for the cut, and where tetrahedra would be turned over.
    """
    stars, outer = Stars.of(tets, len(points)), boundary_facets(tets)
    sheets = [
        sheet_facets_of(points, tets, regions == number, frame)
        for number, frame in enumerate(frames, start=1)
    ]
    taken = np.zeros(len(points), dtype=bool)
    for sheet, frame in zip(sheets, frames, strict=True):
        if taken[sheet].any():
            raise MeshError(f"plate {frame.index}'s mid-surface touches another plate's")
        taken[sheet] = True
    opened, count = tets.copy(), len(points)
    origin, fills = [np.arange(count)], []
    targets: list[tuple[IntArray, Array]] = []
    facets: dict[str, IntArray] = {}
    for sheet, frame in zip(sheets, frames, strict=True):
        cut = plan_cut(points, stars, sheet, outer, frame, taken)
        nodes = cut.nodes
        lower = np.arange(len(points))
        lower[nodes] = count + np.arange(len(nodes))
        below, up = sides(points, stars, cut, frame)
        part = opened[below]
        opened[below] = np.where(
            np.isin(part, nodes), lower[np.minimum(part, len(points) - 1)], part
        )
        made, ends = _filled(points, cut, lower, up)
        fills.append(made)
        name = f"plate_{frame.index}"
        facets |= {f"{name}_upper": sheet, f"{name}_lower": lower[sheet], f"{name}_end": ends}
        place = frame.local(points[nodes])[:, 0], frame.across(points[nodes])
        for copies, side in ((nodes, 0.5), (lower[nodes], -0.5)):
            plane = frame.from_local(place[0], side * frame.thickness)
            targets.append((copies, frame.to_space(plane, place[1])))
        origin.append(nodes)
        count += len(nodes)
    source = np.concatenate(origin)
    fill = np.vstack([np.empty((0, 4), dtype=np.int64), *fills])
    remaining = np.where((regions >= 1) & (regions <= len(frames)), 0, regions)
    moved = widened(points[source], opened, fill, remaining, outer, targets)
    regions = np.concatenate([remaining, np.zeros(len(fill), dtype=remaining.dtype)])
    return Slots(moved, np.vstack([opened, fill]), regions, facets, source)


def sides(points: Array, stars: Stars, cut: Cut, frame: PlateFrame) -> tuple[IntArray, IntArray]:
    """The tetrahedra around a cut that lie below it, and the apex (f,) above each of its facets.
    MeshError where the cut does not part the tetrahedra around it in two."""
    around = np.unique(np.concatenate([stars.around(int(n)) for n in cut.nodes]))
    cells = stars.cells[around]
    facets, apex, owner = tetra_facets(cells)
    facets = np.sort(facets, axis=1)
    at_cut = np.isin(facets, cut.nodes).any(axis=1)
    facets, apex, owner = facets[at_cut], apex[at_cut], owner[at_cut]
    barrier = np.sort(cut.facets, axis=1)
    unique, label = np.unique(np.vstack([barrier, facets]), axis=0, return_inverse=True)
    label = label.ravel()
    walls, label = label[: len(barrier)], label[len(barrier) :]
    one, two = same_keys(label)
    joined = ~np.isin(label[one], walls)
    _, part = pieces(owner[one[joined]], owner[two[joined]], len(cells))
    first = np.full(len(unique), -1)
    second = np.full(len(unique), -1)
    first[label[one]], second[label[one]] = one, two
    a, b = first[walls], second[walls]
    if (a < 0).any():
        raise MeshError(f"the cut of plate {frame.index} leaves the mesh")
    normal = frame.direction(frame.normal)
    start = points[cut.sheet[:, 0]]
    first_up = (points[apex[a[: len(start)]]] - start) @ normal > 0.0
    above = np.unique(part[owner[np.where(first_up, a[: len(start)], b[: len(start)])]])
    under = np.unique(part[owner[np.where(first_up, b[: len(start)], a[: len(start)])]])
    both = np.concatenate([above, under])
    if len(np.unique(both)) != len(both) or len(both) != part.max() + 1:
        raise MeshError(f"the cut of plate {frame.index} does not part its two sides")
    a_above = np.isin(part[owner[a]], above)
    if (a_above == np.isin(part[owner[b]], above)).any():
        raise MeshError(f"the cut of plate {frame.index} does not part its two sides")
    return around[np.isin(part, under)], np.where(a_above, apex[a], apex[b])


def _filled(points: Array, cut: Cut, lower: IntArray, up: IntArray) -> tuple[IntArray, IntArray]:
    """Tetrahedra (t, 4) of what opens beyond the rim, and the facets (f, 3) of the square ends. A
    flap (r, x, y) opens to the tetrahedron (r below, x, y, r above), a wing (a, b, c) to a pyramid
    over the end's facets (a, b below, b, a above), which is two tetrahedra."""
    beyond = cut.facets[len(cut.sheet) :]
    apex = points[up[len(cut.sheet) :]]
    p, q, r = (points[beyond[:, k]] for k in range(3))
    turned = np.einsum("ij,ij->i", np.cross(q - p, r - p), apex - p) < 0.0
    count = len(cut.wings)
    wings, flaps = beyond[:count].copy(), beyond[count:].copy()
    wings[turned[:count]] = wings[turned[:count]][:, [1, 0, 2]]
    flaps[turned[count:]] = flaps[turned[count:]][:, [0, 2, 1]]
    (a, b, c), (n, x, y) = wings.T, flaps.T
    # The ends' diagonals start above at the node of lower number, as those of the prisms do.
    first = (a < b)[:, None]
    la, lb = lower[a], lower[b]
    one = np.where(first, np.column_stack([la, lb, c, a]), np.column_stack([la, lb, c, b]))
    two = np.where(first, np.column_stack([a, lb, c, b]), np.column_stack([la, b, c, a]))
    tets = [one, two, np.column_stack([lower[n], x, y, n])]
    ends = [
        np.where(first, np.column_stack([a, la, lb]), np.column_stack([la, lb, b])),
        np.where(first, np.column_stack([a, lb, b]), np.column_stack([a, la, b])),
    ]
    return np.vstack(tets), np.vstack(ends)
