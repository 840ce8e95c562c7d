"""A mesh whose plates lie a little elsewhere: the same cells, so that two answers compare.

Two meshes of one finger differ by about a microstrain in what gages read; a plate moved by a
hundredth of a millimetre changes it by no more. Nodes moved along leave no such noise.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.types import Mesh

_REACH = 0.95  # of the way from a plate to what must stay
_LEAST_CELL = 0.2  # of its size before, what a cell may shrink to


def with_plates_moved(
    mesh: Mesh, before: Sequence[PlateFrame], after: Sequence[PlateFrame]
) -> Mesh | None:
    """The mesh of plates ``before`` with flat level plates where ``after`` says, each moved rigidly
    in its section; the rubber around follows, less with distance, up to other plates and the
    finger's faces. None where they are so far off that cells would turn over.
    """
    points = mesh.points.copy()
    section = mesh.points[:, :2]
    outside = [mesh.facets[name].ravel() for name in ("base", "contact", "side")]
    still = np.unique(np.concatenate(outside))
    distance = {each.index: _distance(each, section) for each in before}
    for old, new in zip(before, after, strict=True):
        turned = np.radians(new.angle_deg - old.angle_deg)
        way = new.centre - old.centre
        if not turned and not way.any():
            continue
        away = distance[old.index]
        others = [away[near < 1e-9].min() for k, near in distance.items() if k != old.index]
        reach = _REACH * min(float(away[still].min()), *others)
        weight = np.clip(1.0 - away / reach, 0.0, None)[:, None]
        arm = section - old.centre
        turn = np.array([[np.cos(turned), np.sin(turned)], [-np.sin(turned), np.cos(turned)]])
        points[:, :2] += weight * (way + arm @ turn - arm)
    sizes = _sizes(points, mesh) / _sizes(mesh.points, mesh)
    return replace(mesh, points=points) if sizes.min() > _LEAST_CELL else None


def _distance(plate: PlateFrame, section: Array) -> Array:
    """Of points (n, 2) from a flat plate's rectangle, mm; 0 inside."""
    arm = section - plate.centre
    s, v = np.abs(arm @ plate.axis), np.abs(arm @ plate.normal)
    rest = np.stack([s - 0.5 * plate.length, v - 0.5 * plate.thickness])
    return np.asarray(np.linalg.norm(np.clip(rest, 1e-12, None), axis=0))


def _sizes(points: Array, mesh: Mesh) -> Array:
    """Signed area or volume of the cells' corners, (c,), in units of half or a sixth."""
    corners = points[mesh.corners]
    return np.asarray(np.linalg.det(corners[:, 1:] - corners[:, :1]))
