"""The two sides of cut plates moved apart, and the nodes around so that all make room.

The displacement is harmonic: zero on the constrained nodes, half the thickness on the slots' faces.
Small elements move as if stiffer, so nothing is turned over where the room suffices.
"""

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.errors import MeshError
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.tetra.carriers import Carriers
from fingerdesign.mesh.tetra.improve import improve

_ALIGNED = 1e-9
_STIFFEST = 200.0  # of an element's stiffness times its edges' length squared; an even one has 6
_FLAT = 1e-18  # of the mesh's extent cubed: the least volume reckoned with
_NO_AREA = 1e-300
_CLOSE = 1e-3  # of the load: where nodes come to lie need not be exact
_MOST = 2000
_MENDABLE = 20  # tetrahedra turned over that moving single nodes may still mend


def widened(
    points: Array,
    tets: IntArray,
    fill: IntArray,
    regions: IntArray,
    outer: IntArray,
    targets: list[tuple[IntArray, Array]],
) -> Array:
    """Points with the slots' nodes at their targets and the others out of the way.

    tets (t, 4): the mesh that is cut, closed; fill (g, 4): what fills the slots' ends; regions
    (t,); outer (o, 3): facets on the body's outside, where nodes stay on it; targets: nodes (k,)
    and where they go (k, 3). MeshError where a tetrahedron is turned over.
    """
    goal = points.copy()
    placed = np.zeros(len(points), dtype=bool)
    for nodes, where in targets:
        goal[nodes], placed[nodes] = where, True
    fixed = placed[:, None] | fixed_on_faces(points, tets, regions, outer)
    shift = _harmonic(points, tets, goal - points, fixed)
    moved = points + shift
    moved[placed] = goal[placed]
    whole = np.vstack([tets, fill])
    _refuse_turned(moved, whole, max(_MENDABLE, len(fill) // 20))
    still = np.repeat(fixed.any(axis=1, keepdims=True), 3, axis=1)  # as by three faces, at a corner
    moved = improve(moved, whole, still, Carriers((), (), {}))
    _refuse_turned(moved, whole, 0)
    return moved


def _refuse_turned(points: Array, tets: IntArray, most: int) -> None:
    """MeshError where more than ``most`` tetrahedra are turned over."""
    turned = int((cell_volumes(points, tets) <= 0.0).sum())
    if turned > most:
        raise MeshError(
            f"{turned} tetrahedra were turned over where plates were opened to their thickness: "
            "make mesh.plate_size_mm smaller, or plates.model = 'solid'"
        )


def fixed_on_faces(points: Array, tets: IntArray, regions: IntArray, outer: IntArray) -> BoolArray:
    """Mask (n, 3) of the coordinates of nodes that must stay: on the outside and between regions.

    On flat faces across a coordinate axis only that coordinate is fixed; a facet without area, as
    fTetWild may leave, has no direction and fixes all.
    """
    a, b, c = (points[outer[:, k]] for k in range(3))
    normal = np.cross(b - a, c - a)
    normal = np.abs(normal) / np.maximum(np.linalg.norm(normal, axis=1), _NO_AREA)[:, None]
    across = normal > 1.0 - _ALIGNED
    across[~across.any(axis=1)] = True
    fixed = np.zeros((len(points), 3), dtype=bool)
    for corner in range(3):
        np.logical_or.at(fixed, outer[:, corner], across)
    for region in np.unique(regions[regions != 0]):
        inside = np.zeros(len(points), dtype=bool)
        inside[tets[regions == region]] = True
        fixed[inside] = True
    return fixed


def _harmonic(points: Array, tets: IntArray, goal: Array, fixed: BoolArray) -> Array:
    """Displacements (n, 3): ``goal`` where ``fixed``, harmonic between."""
    from scipy.sparse import coo_matrix, diags_array
    from scipy.sparse.linalg import cg

    corners = points[tets]
    edges = corners[:, 1:] - corners[:, :1]
    volume = np.maximum(np.abs(np.linalg.det(edges)) / 6.0, _FLAT * np.ptp(points) ** 3)
    a, b, c = (edges[:, k] for k in range(3))
    slopes = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=1)
    slopes /= 6.0 * volume[:, None, None]
    slopes = np.concatenate([-slopes.sum(axis=1, keepdims=True), slopes], axis=1)
    block = np.einsum("tia,tja->tij", slopes, slopes)
    # A flat tetrahedron on a face of a carrier is free to be mended from now on: it must not bind.
    most = _STIFFEST / (edges**2).sum(axis=2).mean(axis=1)
    block *= np.minimum(1.0, most / np.einsum("tii->t", block))[:, None, None]
    rows, columns = np.repeat(tets, 4, axis=1).ravel(), np.tile(tets, (1, 4)).ravel()
    size = len(points)
    matrix = coo_matrix((block.ravel(), (rows, columns)), shape=(size, size)).tocsr()
    shift = np.where(fixed, goal, 0.0)
    for axis in range(3):
        if not shift[:, axis].any():
            continue
        free = np.flatnonzero(~fixed[:, axis])
        inner = matrix[free][:, free]
        load = -(matrix[free] @ shift[:, axis])
        scale = diags_array(1.0 / inner.diagonal())
        found, failed = cg(inner, load, rtol=_CLOSE, maxiter=_MOST, M=scale)
        if failed:
            raise MeshError("the nodes around the plates could not be moved out of their way")
        shift[free, axis] = found
    return shift
