"""Plates as sheets: the facets of a mesh that lie on the plates' mid-surfaces."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame
from fingerdesign.errors import MeshError
from fingerdesign.mesh.types import TETRA_EDGES, TETRA_FACETS, TRIANGLE_EDGES

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

_ON_SURFACE = 1e-9  # mm: the sections' vertices lie on the lines to rounding
_FILLED = 1e-8  # relative: what is missing is a facet or nothing


def sheet_facets(
    points: Array, cells: IntArray, frames: tuple[PlateFrame, ...]
) -> dict[str, IntArray]:
    """Facets "plate_k" of each frame, (f, 3) edges or (f, 6) triangles: corners, mid-edge nodes.

    points (n, dim) and quadratic cells of a mesh whose edges (facets) follow the plates' mid-lines
    (mid-surfaces). Raises MeshError where they do not fill a plate's length (and span).
    """
    dimension = points.shape[1]
    facets = _unique_facets(cells, dimension)
    corners = points[facets[:, :dimension]]
    found = {}
    for frame in frames:
        along, off = np.moveaxis(frame.local(corners.reshape(-1, dimension)), 1, 0)
        on = (np.abs(off) < _ON_SURFACE) & (np.abs(along) < 0.5 * frame.length + _ON_SURFACE)
        chosen = facets[on.reshape(-1, dimension).all(axis=1)]
        _check_filled(points, chosen, frame)
        found[f"plate_{frame.index}"] = chosen
    return found


def _unique_facets(cells: IntArray, dimension: int) -> IntArray:
    """Each edge (triangle) of the mesh once, corners then mid-edge nodes."""
    if dimension == 2:
        parts = [[a, b, 3 + k] for k, (a, b) in enumerate(TRIANGLE_EDGES)]
        facets = np.concatenate([cells[:, part] for part in parts])
        return np.asarray(facets[np.unique(facets[:, 2], return_index=True)[1]])
    middle = {pair: 4 + k for k, pair in enumerate(TETRA_EDGES)}
    parts = [[a, b, c, middle[(a, b)], middle[(b, c)], middle[(a, c)]] for a, b, c in TETRA_FACETS]
    facets = np.concatenate([cells[:, part] for part in parts])
    key = np.sort(facets[:, 3:], axis=1)
    return np.asarray(facets[np.unique(key, axis=0, return_index=True)[1]])


def _check_filled(points: Array, facets: IntArray, frame: PlateFrame) -> None:
    dimension = points.shape[1]
    corners = points[facets[:, :dimension]]
    if dimension == 2:
        asked = frame.length
        filled = float(np.linalg.norm(corners[:, 1] - corners[:, 0], axis=1).sum())
    else:
        low, high = float(points[:, 2].min()), float(points[:, 2].max())
        asked = frame.length * (min(frame.z_max, high) - max(frame.z_min, low))
        normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        filled = float(0.5 * np.linalg.norm(normal, axis=1).sum())
    if not abs(filled / asked - 1.0) < _FILLED:
        unit = "mm" if dimension == 2 else "mm^2"
        raise MeshError(
            f"the mesh follows {filled:.6g} of {asked:.6g} {unit} of plate {frame.index}'s "
            "mid-surface"
        )
