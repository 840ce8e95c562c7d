"""Nodes of the flattest tetrahedra moved until no dihedral angle is small (numpy only).

fTetWild bounds the mean shape, not the worst: a few tetrahedra in a mesh have angles of 3 to 8
degrees, and snapping flattens some more. Their nodes are moved, within the CAD faces that they
lie on, to where the least angle around them is greatest.
"""

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.cells import Stars
from fingerdesign.mesh.measures import cell_angles, cell_volumes
from fingerdesign.mesh.tetra.carriers import Carriers
from fingerdesign.mesh.tetra.snap import snap_to_carriers

TARGET_DEG = 10.0  # the gate requires 5
ROUNDS = 6
MOST_NODES = 3000  # more nodes than this in flat tetrahedra: the mesh is bad as a whole
_REACHES = (0.3, 0.12, 0.04)  # of the shortest edge around a node
_DIRECTIONS = 26


def improve(points: Array, tets: IntArray, lies_on: BoolArray, carriers: Carriers) -> Array:
    """Points (n, 3) moved where tetrahedra (t, 4) have a dihedral angle below TARGET_DEG.

    lies_on (n, carriers): the CAD faces that each point lies on. Deterministic. What cannot be
    improved stays as it is.
    """
    points = points.copy()
    stars = Stars.of(tets, len(points))
    steps = _steps()
    settled = np.full(len(points), -1.0)
    for _ in range(ROUNDS):
        worst = least_dihedral(points[tets])
        flat = np.flatnonzero(worst < TARGET_DEG)
        nodes = np.unique(tets[flat])
        if len(flat) == 0 or len(nodes) > MOST_NODES:
            break
        moved = False
        own = np.full(len(points), np.inf)
        np.minimum.at(own, tets[flat].reshape(-1), np.repeat(worst[flat], 4))
        for node in nodes[np.argsort(own[nodes])]:
            star = tets[stars.around(node)]
            before = float(least_dihedral(points[star]).min())
            if before >= TARGET_DEG or before == settled[node]:
                continue
            found = _better(points, star, int(node), before, lies_on[node], carriers, steps)
            if found is None:
                settled[node] = before
            else:
                points[node], moved = found, True
        if not moved:
            break
    return points


def least_dihedral(corners: Array) -> Array:
    """Least dihedral angle (t,), degrees, of tetrahedra (t, 4, 3); below 0 if inverted."""
    points, cells = corners.reshape(-1, 3), np.arange(4 * len(corners)).reshape(-1, 4)
    angle = cell_angles(points, cells).min(axis=1)
    return np.asarray(np.where(cell_volumes(points, cells) > 0.0, angle, -1.0 - angle))


def _steps() -> Array:
    """Directions evenly over the sphere (Fibonacci's spiral), at each reach: (k, 3)."""
    k = np.arange(_DIRECTIONS) + 0.5
    y, turn = 1.0 - 2.0 * k / _DIRECTIONS, np.pi * (1.0 + np.sqrt(5.0)) * k
    ring = np.sqrt(1.0 - y * y)
    unit = np.column_stack([ring * np.cos(turn), y, ring * np.sin(turn)])
    return np.vstack([reach * unit for reach in _REACHES])


def _better(
    points: Array,
    star: IntArray,
    node: int,
    before: float,
    faces: BoolArray,
    carriers: Carriers,
    steps: Array,
) -> Array | None:
    """The trial place whose least angle around the node is greatest; None: its own place."""
    if faces.sum() >= 3:
        return None
    others = points[star]
    edge = np.linalg.norm(others - points[node], axis=2)
    trials = points[node] + steps * edge[edge > 0].min()
    if faces.any():
        try:
            trials = snap_to_carriers(trials, np.tile(faces, (len(trials), 1)), carriers)
        except MeshError:
            return None
    corners = np.broadcast_to(others, (len(trials), *others.shape)).copy()
    rows, places = np.nonzero(star == node)
    corners[:, rows, places] = trials[:, None, :]
    least = least_dihedral(corners.reshape(-1, 4, 3)).reshape(len(trials), -1).min(axis=1)
    best = int(np.argmax(least))
    return trials[best] if least[best] > before + 0.05 else None
