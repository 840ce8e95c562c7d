"""Put boundary nodes exactly on the CAD faces that they stand for (numpy only).

fTetWild's surface sits micrometres inside the true one, several percent of a 0.1 mm approach. Every
node takes the faces of the facets around it: one on a face moves to it, one on an edge to both
faces, one at a corner to all three.
"""

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.measures import least_jacobian_ratios
from fingerdesign.mesh.tetra.carriers import Carriers
from fingerdesign.shapes.faces import Carrier

MOST_STEPS = 40
PARALLEL = 0.05  # faces that meet at less than 3 degrees
RESIDUAL_MM = 1e-7
# Least Jacobian of a curved tetrahedron over its straight one's; below, it is straightened.
LEAST_JACOBIAN_RATIO = 0.1


def snap_to_carriers(points: Array, lies_on: BoolArray, carriers: Carriers) -> Array:
    """Move points (n, 3) onto every CAD face that they lie on, (n, carriers); returns new points.

    Newton's method with the least motion, for all points together that lie on the same faces. Where
    faces meet at less than a few degrees they count as one, or a point would slide far. MeshError
    where a point cannot be on all of its faces.
    """
    snapped = points.copy()
    rows = np.flatnonzero(lies_on.any(axis=1))
    if len(rows) == 0:
        return snapped
    patterns, which = np.unique(lies_on[rows], axis=0, return_inverse=True)
    order = np.argsort(which.reshape(-1), kind="stable")
    groups = np.split(rows[order], np.cumsum(np.bincount(which.reshape(-1)))[:-1])
    for pattern, group in zip(patterns, groups, strict=True):
        faces = [carriers.faces[number] for number in np.flatnonzero(pattern)]
        snapped[group] = _onto(snapped[group], faces)
    return snapped


def _onto(points: Array, faces: list[Carrier]) -> Array:
    points = points.copy()
    scale = max(1.0, float(np.abs(points).max()))
    for _ in range(MOST_STEPS):
        away = np.stack([face.distance(points) for face in faces], axis=1)
        if np.abs(away).max() < 1e-13 * scale:
            return points
        normals = np.stack([face.normal(points) for face in faces], axis=1)
        inverse = np.linalg.pinv(normals, rcond=PARALLEL)
        points -= np.einsum("nij,nj->ni", inverse, away)
    worst = float(np.abs(away).max())
    if worst > RESIDUAL_MM:
        names = ", ".join(face.name for face in faces)
        raise MeshError(f"a node cannot be snapped to {names}: {worst:.2g} mm are left")
    return points


def curve_facets(
    points: Array, cells: IntArray, carriers: Carriers, facets: IntArray, carrier: IntArray
) -> tuple[Array, IntArray]:
    """Project the mid-nodes of facets (f, 6) on curved CAD faces, ``carrier`` (f,), onto them.

    A mid-node lies on every face that a facet of its edge lies on. Where a curved tetrahedron's
    Jacobian would fall below LEAST_JACOBIAN_RATIO of the straight one's, the mid-nodes of its edges
    stay straight. Returns the points (n, 3) and the nodes that stayed straight.
    """
    curved_faces = [number for number, face in enumerate(carriers.faces) if not face.flat]
    bent = np.isin(carrier, curved_faces)
    middles = np.unique(facets[bent][:, 3:])
    on = np.zeros((len(middles), len(carriers.faces)), dtype=bool)
    for column in range(3, 6):
        # An edge of a curved facet may belong to a flat one too, and then lies on both.
        rows = np.flatnonzero(np.isin(facets[:, column], middles))
        on[np.searchsorted(middles, facets[rows, column]), carrier[rows]] = True
    straight, curved = points[middles], points.copy()
    curved[middles] = snap_to_carriers(straight, on, carriers)
    touched = cells[np.isin(cells[:, 4:], middles).any(axis=1)]
    backed_off: set[int] = set()
    for _ in range(10):
        bad = touched[least_jacobian_ratios(curved, touched) < LEAST_JACOBIAN_RATIO]
        back = np.intersect1d(bad[:, 4:], middles)
        if len(back) == 0:
            break
        backed_off.update(int(node) for node in back)
        curved[back] = straight[np.searchsorted(middles, back)]
    return curved, np.array(sorted(backed_off), dtype=np.int64)
