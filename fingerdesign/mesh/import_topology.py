"""Whether a mesh made elsewhere is one whole: joined facet to facet, no cracks, no cavities."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.layout import crest_height
from fingerdesign.errors import MeshError
from fingerdesign.mesh.boundary import BoundaryFacets
from fingerdesign.mesh.types import TETRA_FACETS

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


OFF = 0.3  # of a facet's longest edge: outside facets farther off the design's faces are cracks
OFF_HEIGHT = 1e-2  # of the finger's height, besides


def check_joined(points: Array, corners: IntArray, path: Path) -> None:
    """MeshError where cells (c, 4) overlap (three at a facet), or are not all joined by facets."""
    keys, cells = _facet_keys(corners, len(points))
    order = np.argsort(keys, kind="stable")
    keys, cells = keys[order], cells[order]
    same = keys[1:] == keys[:-1]
    thrice = np.flatnonzero(same[1:] & same[:-1])
    if len(thrice):
        owners = np.unique(cells[thrice])
        raise MeshError(
            f"{path.name} has {len(np.unique(keys[thrice]))} facets that more than two tetrahedra "
            f"share {_where(points[corners[owners]].mean(axis=1))}: cells overlap or are double"
        )
    count, piece = _pieces(cells[:-1][same], cells[1:][same], len(corners))
    if count > 1:
        size = np.bincount(piece)
        away = piece != size.argmax()
        raise MeshError(
            f"{path.name} falls into {count} pieces that share no facet; {int(away.sum())} of "
            f"{len(piece)} tetrahedra are not joined to the rest "
            f"{_where(points[corners[away]].mean(axis=1))} (in Gmsh: fragment the volumes, so "
            "that they share their surfaces)"
        )


def check_outside(points: Array, faces: BoundaryFacets, design: Design, path: Path) -> None:
    """MeshError where the mesh's outside runs inside the body: a crack, or cells that lack."""
    corners = faces.corners[faces.outside]
    places = points[corners]
    edge = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(axis=1)
    off = faces.misfit[faces.outside]
    far = off > OFF * edge + OFF_HEIGHT * crest_height(design.body)
    if far.any():
        raise MeshError(
            f"{int(far.sum())} facets on the outside of {path.name} lie up to "
            f"{off[far].max():.3g} mm off the faces of {design.design.name} "
            f"{_where(places[far].mean(axis=1))}: the mesh is torn, or cells lack"
        )
    if design.body.shape == "step":  # its solid may have voids
        return
    sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    _, edges = np.unique(sides[:, 0] * len(points) + sides[:, 1], return_inverse=True)
    owner = np.repeat(np.arange(len(corners)), 3)
    order = np.argsort(edges, kind="stable")
    same = edges[order][1:] == edges[order][:-1]
    count, piece = _pieces(owner[order][:-1][same], owner[order][1:][same], len(corners))
    if count > 1:
        inner = piece != np.bincount(piece).argmax()
        raise MeshError(
            f"the outside of {path.name} has {count} surfaces, where that of {design.design.name} "
            f"has one: {int(inner.sum())} facets bound a cavity or crack "
            f"{_where(places[inner].mean(axis=1))}"
        )


def _facet_keys(corners: IntArray, nodes: int) -> tuple[IntArray, IntArray]:
    """One number for each facet of each cell, and its cell."""
    facets = np.sort(corners[:, np.array(TETRA_FACETS)].reshape(-1, 3), axis=1).astype(np.int64)
    a, b, c = facets.T
    return (a * nodes + b) * nodes + c, np.repeat(np.arange(len(corners)), 4)


def _pieces(first: IntArray, second: IntArray, count: int) -> tuple[int, IntArray]:
    """Number of connected pieces of ``count`` things joined by pairs, and each thing's piece."""
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components

    graph = coo_array((np.ones(len(first)), (first, second)), shape=(count, count))
    number, piece = connected_components(graph, directed=False)
    return int(number), np.asarray(piece, dtype=np.int64)


def _where(middles: Array) -> str:
    x, y, z = middles[0]
    return f"(near x = {x:.4g}, y = {y:.4g}, z = {z:.4g})"
