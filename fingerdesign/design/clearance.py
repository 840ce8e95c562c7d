"""Distances between plates, and from plates to the body's faces, in closed form (numpy only)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import Array, PlateFrame, crest_height
from fingerdesign.design.schema import Body

IntArray = NDArray[np.int64]


def all_corners(frames: tuple[PlateFrame, ...]) -> Array:
    """Section corners of every plate, shape (plates, 4, 2), mm."""
    return np.array([frame.corners() for frame in frames]).reshape(-1, 4, 2)


def cover_clearances(body: Body, corners: Array, half_span: float) -> Array:
    """Least distance of each plate to the contact surface's arc, shape (plates,), mm.

    ``corners`` (plates, 4, 2); the plates reach |z| <= half_span. Negative: the plate sticks out.
    The distance to the full circle (torus), which the body's faces cut off: never more than the
    distance to the surface. It is least at a corner, because the circle (torus) is convex there.
    """
    centre = crest_height(body) - body.arc_radius_mm
    height = _meridian_height(body, corners[..., 1], half_span) - centre
    return np.asarray((body.arc_radius_mm - np.hypot(corners[..., 0], height)).min(axis=1))


def cover_shortfall(body: Body, corners: Array, half_span: float, least: float) -> float:
    """By how much every plate must go down to lie ``least`` below the surface, mm; <= 0: none.

    Infinite where a corner lies beyond the arc's reach in x (no depth helps there).
    """
    centre = crest_height(body) - body.arc_radius_mm
    x, y = corners[..., 0], corners[..., 1]
    with np.errstate(invalid="ignore"):
        highest = centre + np.sqrt((body.arc_radius_mm - least) ** 2 - x**2)
        if body.dome_radius_mm is not None:
            axis = crest_height(body) - body.dome_radius_mm
            highest = axis + np.sqrt((highest - axis) ** 2 - half_span**2)
    return float(np.max(np.where(np.isnan(highest), np.inf, y - highest)))


def _meridian_height(body: Body, y: Array, z: float) -> Array:
    """Height at z = 0 of the point that revolving the section carries to (y, z)."""
    if body.dome_radius_mm is None:
        return y
    axis = crest_height(body) - body.dome_radius_mm
    return np.asarray(axis + np.hypot(y - axis, z))


def least_dome_radius(body: Body, least_height: float) -> float:
    """Least ``dome_radius_mm`` for which every edge of the body is ``least_height`` high, mm.

    With s the section's sagitta, h half the depth and b the side's height over ``least_height``,
    the revolved corner has the height D - s > h, or y = crest - D + sqrt((D - s)^2 - h^2).
    """
    half_depth = 0.5 * body.depth_mm
    height = body.base_height_mm - least_height
    sagitta = crest_height(body) - body.base_height_mm
    if half_depth < height:
        return sagitta + half_depth
    return sagitta + 0.5 * height + half_depth**2 / (2.0 * height)


@dataclass(frozen=True)
class PlateGap:
    """The least distance between two plates, mm (0: they touch or cross), and which ones."""

    distance: float
    first: int
    second: int


def pair_distances(first: Array, second: Array) -> Array:
    """Distances between the rectangles with corners (n, 4, 2) and (n, 4, 2): shape (n,).

    0 where they overlap, by separating axes; else the least distance of a corner of one to an
    edge of the other, which is exact for convex polygons.
    """
    edges = np.concatenate([np.diff(first[:, :3], axis=1), np.diff(second[:, :3], axis=1)], axis=1)
    along_first = np.einsum("nkd,ncd->nkc", edges, first)
    along_second = np.einsum("nkd,ncd->nkc", edges, second)
    apart = (along_first.min(2) > along_second.max(2)) | (along_second.min(2) > along_first.max(2))
    distance = np.minimum(_corners_to_edges(first, second), _corners_to_edges(second, first))
    return np.where(apart.any(axis=1), distance, 0.0)


def _corners_to_edges(points: Array, polygon: Array) -> Array:
    """Least distance of the points (n, 4, 2) to the edges of the polygons (n, 4, 2)."""
    start = polygon[:, None]
    edge = np.roll(polygon, -1, axis=1)[:, None] - start
    offset = points[:, :, None] - start
    share = (offset * edge).sum(-1) / (edge * edge).sum(-1)
    rest = offset - np.clip(share, 0.0, 1.0)[..., None] * edge
    return np.asarray(np.sqrt((rest * rest).sum(-1)).min(axis=(1, 2)))


def least_gap(corners: Array, pairs: tuple[IntArray, IntArray] | None = None) -> PlateGap | None:
    """The closest pair of plates, None for fewer than two; ``pairs`` limits the search."""
    if len(corners) < 2:
        return None
    first, second = pairs if pairs is not None else np.triu_indices(len(corners), 1)
    if pairs is None:
        # A pair is at most its centres' distance apart, and at least that less two half diagonals.
        centres = corners.mean(axis=1)
        between = np.linalg.norm(centres[first] - centres[second], axis=1)
        diagonal = np.linalg.norm(corners[:, 2] - corners[:, 0], axis=1).max()
        near = between - diagonal <= between.min()
        first, second = first[near], second[near]
    distances = pair_distances(corners[first], corners[second])
    closest = int(np.argmin(distances))
    return PlateGap(float(distances[closest]), int(first[closest]), int(second[closest]))


def adjacent(count: int) -> tuple[IntArray, IntArray]:
    """The pairs (0, 1), (1, 2), ... of a row of plates."""
    index = np.arange(count, dtype=np.int64)
    return index[:-1], index[1:]
