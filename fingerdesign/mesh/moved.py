"""A mesh whose plates lie a little elsewhere: the same cells, so that two responses compare.

Two meshes of one finger differ by about a microstrain in what gages measure; a plate moved by a
hundredth of a millimetre changes it by no more. Nodes that move along add no such noise.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.types import Mesh

_FACES = ("base", "contact", "side")
_REACH = 0.95  # of the way from a plate to what must stay in its place
_LEAST_CELL = 0.2  # of its size before: a cell that shrinks to less was moved too far


def with_plates_moved(
    mesh: Mesh, before: Sequence[PlateFrame], after: Sequence[PlateFrame]
) -> Mesh | None:
    """Move flat level plates from ``before`` to ``after``, each rigidly in its section.

    The rubber around follows, less with distance, up to other plates and the finger's faces. None
    where the plates are so far off that cells would turn over.
    """
    change = np.zeros_like(mesh.points)
    section = mesh.points[:, :2]
    for old, new, weight in zip(before, after, plate_weights(mesh, before), strict=True):
        turned = np.radians(new.angle_deg - old.angle_deg)
        way = new.centre - old.centre
        arm = section - old.centre
        turn = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
        change[:, :2] += weight[:, None] * (way + arm @ turn - arm)
    points = mesh.points + straightened(mesh, change)
    sizes = cell_volumes(points, mesh.corners) / cell_volumes(mesh.points, mesh.corners)
    return None if sizes.min() < _LEAST_CELL else replace(mesh, points=points, moved=True)


def straightened(mesh: Mesh, change: Array) -> Array:
    """Changes (n, dim) of nodes' places, those of added nodes the mean of their ends': straight
    cells stay straight. On the contact surface they are as they were."""
    kind = mesh.kind
    own = np.zeros(len(mesh.points), dtype=bool)
    own[mesh.facets["contact"].ravel()] = True
    moving = np.flatnonzero(np.asarray(change.any(axis=1))[mesh.cells].any(axis=1))
    cells = mesh.cells[moving]
    found = change.copy()
    for place, corners in enumerate([*kind.edges, *kind.squares], kind.corners):
        nodes: IntArray = cells[:, place]
        middle = np.mean([change[cells[:, corner]] for corner in corners], axis=0)
        loose = ~own[nodes]
        found[nodes[loose]] = middle[loose]
    return found


def plate_weights(mesh: Mesh, frames: Sequence[PlateFrame]) -> Array:
    """Shares (plates, n) of plates' motions that nodes have: 1 in a plate, falling with the
    distance from it, 0 at other plates, at a core and at the finger's faces."""
    apart = ~np.isin(mesh.regions, [0, *(frame.index + 1 for frame in frames)])
    outside = [mesh.facets[name].ravel() for name in _FACES if name in mesh.facets]
    still = np.unique(np.concatenate([*outside, mesh.cells[apart].ravel()]))
    distance = [_distance(frame, mesh.points) for frame in frames]
    own = [_own_nodes(mesh, *pair) for pair in zip(frames, distance, strict=True)]
    weights = np.empty((len(frames), len(mesh.points)))
    for k, away in enumerate(distance):
        others = [float(away[there].min(initial=np.inf)) for j, there in enumerate(own) if j != k]
        reach = _REACH * min([float(away[still].min()), *others])
        weights[k] = np.clip(1.0 - away / reach, 0.0, None)
        weights[k, own[k]] = 1.0
    return weights


def _own_nodes(mesh: Mesh, plate: PlateFrame, away: Array) -> IntArray:
    """Nodes of a plate's cells; of a sheet, which has none, those within it."""
    inside = mesh.regions == plate.index + 1
    return np.unique(mesh.cells[inside]) if inside.any() else np.flatnonzero(away < 1e-9)


def _distance(plate: PlateFrame, points: Array) -> Array:
    """Distance in its section of points (n, dim) from a plate, mm; 0 inside. Of a bent one it is
    measured along the bend."""
    s, v = np.abs(plate.local(points)).T
    rest = np.stack([s - 0.5 * plate.length, v - 0.5 * plate.thickness])
    return np.asarray(np.linalg.norm(np.clip(rest, 1e-12, None), axis=0))
