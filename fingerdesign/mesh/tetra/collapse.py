"""Nodes of flat tetrahedra merged until none is left that a mesh may not have (numpy only).

fTetWild may cut a sharp edge of the body off by a face as narrow as its envelope. Snapping then
puts both borders of that face on the same edge, and the tetrahedra behind it become flat or are
turned over. No place of their nodes mends that: the nodes must become one.
"""

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.mesh.cells import TETRA_EDGES, Stars
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.tetra.improve import least_dihedral

LEAST_DEG = 5.0  # the gate's bound
ROUNDS = 8
_VOLUME = 1e-3  # of the tetrahedra around a node: what may change where a curved face is followed


def collapse(
    points: Array, tets: IntArray, regions: IntArray, lies_on: BoolArray
) -> tuple[Array, IntArray, IntArray]:
    """Merge nodes until no tetrahedron that can be mended so has a dihedral angle < LEAST_DEG.

    points (n, 3), snapped; tets (t, 4); regions (t,); lies_on (n, carriers): the CAD faces that
    each point lies on. A node goes into a neighbour that lies on all of its faces, the nearest
    first, where the least angle around it grows and the volume stays. Returns points, tetrahedra
    and regions without the merged nodes.
    """
    pairs = np.array(TETRA_EDGES)
    for _ in range(ROUNDS):
        angle = least_dihedral(points[tets])
        flat = angle < LEAST_DEG
        edges = np.unique(np.sort(tets[flat][:, pairs].reshape(-1, 2), axis=1), axis=0)
        ways = np.vstack([edges, edges[:, ::-1]])
        ways = ways[~(lies_on[ways[:, 0]] & ~lies_on[ways[:, 1]]).any(axis=1)]
        length = np.linalg.norm(points[ways[:, 1]] - points[ways[:, 0]], axis=1)
        stars, taken = Stars.of(tets, len(points)), np.zeros(len(points), dtype=bool)
        into = np.arange(len(points))
        for node, other in ways[np.argsort(length, kind="stable")].tolist():
            around = stars.around(node)
            if taken[tets[around]].any() or not _merges(points, tets[around], node, other):
                continue
            taken[tets[around]] = True
            into[node] = other
        if (into == np.arange(len(points))).all():
            break
        tets = into[tets]
        whole = (np.diff(np.sort(tets, axis=1), axis=1) > 0).all(axis=1)
        used, numbers = np.unique(tets[whole], return_inverse=True)
        tets, regions = numbers.reshape(-1, 4), regions[whole]
        points, lies_on = points[used], lies_on[used]
    return points, tets, regions


def _merges(points: Array, star: IntArray, node: int, other: int) -> bool:
    """Return True if the tetrahedra ``star`` at a node are better with its neighbour instead."""
    left = star[~(star == other).any(axis=1)]
    if len(left) == 0:
        return False
    left = np.where(left == node, other, left)
    before, after = cell_volumes(points, star), cell_volumes(points, left)
    if abs(after.sum() - before.sum()) > _VOLUME * np.abs(before).sum():
        return False
    return bool(least_dihedral(points[left]).min() > least_dihedral(points[star]).min())
