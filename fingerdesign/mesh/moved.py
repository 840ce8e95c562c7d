"""A mesh whose plates lie a little elsewhere: the same cells, so that two responses compare.

Two meshes of one finger differ by about a microstrain in what gages measure; a plate moved by a
hundredth of a millimetre changes it by no more. Nodes that move along add no such noise. There are
two ways to carry the rubber along: ``moved_mesh`` solves a Laplace equation over a section, which
spares small triangles; ``with_plates_moved`` weighs by distance and moves any mesh at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.errors import MeshError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.cells import TRIANGLE_EDGES
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.types import Mesh

_REACH = 0.95  # of the way from a plate to what must stay in its place
_LEAST_CELL = 0.2  # of its size before: a cell that shrinks to less was moved too far


def moved_frames(frames: tuple[PlateFrame, ...], move: Array) -> tuple[PlateFrame, ...]:
    """Frames after a move (k, 3): along x and y, mm, and by an angle, degrees."""
    return tuple(
        replace(frame, place=frame.place + x, y=frame.y + y, angle_deg=frame.angle_deg + turn)
        for frame, (x, y, turn) in zip(frames, move.tolist(), strict=True)
    )


def moved_mesh(mesh: Mesh, frames: tuple[PlateFrame, ...], move: Array) -> Mesh:
    """Move the plates in a section's mesh (k, 3): along x and y, mm, and by an angle, degrees.

    Plates move rigidly, the rubber between them by a Laplace equation that lets small triangles
    deform least; outside and core stay. MeshError where a triangle would lose most of its area.
    """
    shift = np.zeros(mesh.points.shape)
    fixed = np.zeros(len(mesh.points), dtype=bool)
    fixed[np.unique(np.concatenate([facet.ravel() for facet in mesh.facets.values()]))] = True
    numbers = [frame.index + 1 for frame in frames]
    apart = ~np.isin(mesh.regions, [0, *numbers])  # a core
    fixed[np.unique(mesh.cells[apart])] = True
    for k, frame in enumerate(frames):
        nodes = np.unique(mesh.cells[mesh.regions == numbers[k]])
        angle = np.radians(move[k, 2])
        turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
        offset = mesh.points[nodes] - frame.centre
        shift[nodes] = offset @ turn.T - offset + move[k, :2]
        fixed[nodes] = True
    return _checked(mesh, mesh.points + _harmonic(mesh, shift, fixed))


def with_plates_moved(
    mesh: Mesh, before: Sequence[PlateFrame], after: Sequence[PlateFrame]
) -> Mesh | None:
    """Move flat level plates from ``before`` to ``after``, each rigidly in its section.

    The rubber around follows, less with distance, up to other plates and the finger's faces. None
    where the plates are so far off that cells would turn over.
    """
    points = mesh.points.copy()
    section = mesh.points[:, :2]
    for old, new, weight in zip(before, after, plate_weights(mesh, before), strict=True):
        turned = np.radians(new.angle_deg - old.angle_deg)
        way = new.centre - old.centre
        arm = section - old.centre
        turn = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
        points[:, :2] += weight[:, None] * (way + arm @ turn - arm)
    try:
        return _checked(mesh, points)
    except MeshError:
        return None


def plate_weights(mesh: Mesh, frames: Sequence[PlateFrame]) -> Array:
    """Shares (plates, n) of flat level plates' motions that nodes have: 1 in a plate, falling with
    the distance from it, 0 at other plates and at the finger's faces."""
    section = mesh.points[:, :2]
    outside = [mesh.facets[name].ravel() for name in ("base", "contact", "side")]
    still = np.unique(np.concatenate(outside))
    distance = [_distance(frame, section) for frame in frames]
    weights = np.empty((len(frames), len(section)))
    for k, away in enumerate(distance):
        others = [
            away[near < 1e-9].min(initial=np.inf) for j, near in enumerate(distance) if j != k
        ]
        reach = _REACH * min([float(away[still].min()), *others])
        weights[k] = np.clip(1.0 - away / reach, 0.0, None)
    return weights


def _distance(plate: PlateFrame, section: Array) -> Array:
    """Distance of points (n, 2) from a flat plate's rectangle, mm; 0 inside."""
    arm = section - plate.centre
    s, v = np.abs(arm @ plate.axis), np.abs(arm @ plate.normal)
    rest = np.stack([s - 0.5 * plate.length, v - 0.5 * plate.thickness])
    return np.asarray(np.linalg.norm(np.clip(rest, 1e-12, None), axis=0))


def _checked(mesh: Mesh, points: Array) -> Mesh:
    """Put the nodes at ``points``; MeshError where a cell would lose most of its size."""
    sizes = cell_volumes(points, mesh.corners) / cell_volumes(mesh.points, mesh.corners)
    if sizes.min() < _LEAST_CELL:
        raise MeshError(
            f"moved so far, the plates leave a cell {sizes.min():.2g} of its area or volume; "
            "plates or surface are too close for such a tolerance"
        )
    return replace(mesh, points=points)


def _harmonic(mesh: Mesh, shift: Array, fixed: BoolArray) -> Array:
    """Shifts (n, 2) of all nodes from those of the ``fixed`` ones: harmonic over the triangles'
    corners, each weighing by one over its area; middles of edges stay in the middle."""
    used = np.unique(mesh.corners)
    corner = mesh.points[mesh.corners]
    edge = corner[:, [2, 0, 1]] - corner[:, [1, 2, 0]]  # opposite to each corner
    area = cell_volumes(mesh.points, mesh.corners)
    local = np.einsum("cia,cja->cij", edge, edge) / (4.0 * area**2)[:, None, None]
    places = (np.repeat(mesh.corners, 3, axis=1).ravel(), np.tile(mesh.corners, (1, 3)).ravel())
    stiffness = sp.csr_matrix((local.ravel(), places), shape=(len(mesh.points),) * 2)
    known, free = used[fixed[used]], used[~fixed[used]]
    found = shift.copy()
    if len(free):
        load = -(stiffness[free][:, known] @ shift[known])
        found[free] = sp.linalg.splu(stiffness[free][:, free].tocsc()).solve(load)
    pairs = mesh.corners[:, TRIANGLE_EDGES].reshape(-1, 2)
    middles = mesh.cells[:, 3:].reshape(-1)
    loose = ~fixed[middles]
    found[middles[loose]] = found[pairs[loose]].mean(axis=1)
    return found
