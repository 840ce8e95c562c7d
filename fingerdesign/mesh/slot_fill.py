"""Solid plates in the slots of a mesh: prisms between the two faces, three tetrahedra each.

fTetWild resolves a plate's thickness with whatever tetrahedra its envelope allows, and what strains
a gage comes out 10 % off. A slot's faces pair node by node, so the plate between them is a layer of
prisms: regular across the thickness, at the cost of no node.
"""

from __future__ import annotations

import numpy as np

from fingerdesign.arrays import IntArray
from fingerdesign.design.layout import PlateFrame
from fingerdesign.mesh.slots import Slots


def fill_slots(slots: Slots, frames: tuple[PlateFrame, ...]) -> tuple[IntArray, IntArray]:
    """Tetrahedra (t, 4) and regions (t,) of the whole mesh, its slots filled as plates.

    Region k + 1 is plate k. Each quadrilateral between two prisms is cut from the upper node of
    lower number to the lower node of the other, so that neighbours, and the slots' ends, agree.
    """
    tets, regions = [slots.tets], [slots.regions]
    for frame in frames:
        upper = slots.facets[f"plate_{frame.index}_upper"]
        lower = slots.facets[f"plate_{frame.index}_lower"]
        prisms = _prisms(upper, lower)
        tets.append(prisms)
        regions.append(np.full(len(prisms), frame.index + 1, dtype=slots.regions.dtype))
    return np.vstack(tets), np.concatenate(regions)


def _prisms(upper: IntArray, lower: IntArray) -> IntArray:
    """Positively oriented tetrahedra (3 f, 4) between facets (f, 3) whose normal looks upward."""
    order = np.argsort(upper, axis=1)
    a, b, c = (np.take_along_axis(upper, order[:, k : k + 1], axis=1)[:, 0] for k in range(3))
    d, e, f = (np.take_along_axis(lower, order[:, k : k + 1], axis=1)[:, 0] for k in range(3))
    # Diagonals a-e, a-f and b-f (d, e, f are below a, b, c).
    parts = [
        np.column_stack([d, e, f, a]),
        np.column_stack([e, f, a, b]),
        np.column_stack([f, a, b, c]),
    ]
    # Sorting may have turned a facet round; then its tetrahedra are too.
    turned = (order[:, 1] - order[:, 0]) % 3 != 1
    found = [np.where(turned[:, None], part[:, [1, 0, 2, 3]], part) for part in parts]
    return np.stack(found, axis=1).reshape(-1, 4)
