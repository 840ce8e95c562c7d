"""Distances between plates along x and plates along z, in closed form (numpy only); mm.

The one is a polygon in (x, y) spanning z, the other a polygon in (z, y) spanning x. They overlap
where the heights at which the one lies within the other's span meet the heights at which the other
lies within the one's. Apart, they are nearest at a corner of one or at an edge of each.
"""

from __future__ import annotations

import numpy as np

from fingerdesign.arrays import Array


def crossing_distances(
    first: Array, first_spans: Array, second: Array, second_spans: Array
) -> Array:
    """Distances (n,) between prisms of quads (n, 4, 2) and spans (n, 2) drawn crosswise.

    The planes of ``first`` and ``second`` share their second coordinate, the height; each one's
    first coordinate runs along the other's span.
    """
    one, two = _heights_within(first, second_spans), _heights_within(second, first_spans)
    with np.errstate(invalid="ignore"):
        overlap = (one[:, 0] <= two[:, 1]) & (two[:, 0] <= one[:, 1])  # False for NaN
    corners = np.minimum(
        _corners_apart(first, first_spans, second, second_spans),
        _corners_apart(second, second_spans, first, first_spans),
    )
    a = _edges(first, first_spans)
    b = _edges(second, second_spans)[..., ::-1]  # (z, y, x) to (x, y, z)
    edges = _segment_distances(a[:, :, None], b[:, None, :]).min(axis=(1, 2))
    return np.where(overlap, 0.0, np.minimum(corners, edges))


def _heights_within(quads: Array, strips: Array) -> Array:
    """Least and greatest height (n, 2) of each quad's part with first coordinate in its strip.

    NaN where no part of it does.
    """
    x, y = quads[..., 0], quads[..., 1]
    x_next, y_next = np.roll(x, -1, axis=1), np.roll(y, -1, axis=1)
    inside = (x >= strips[:, :1]) & (x <= strips[:, 1:])
    heights = [np.where(inside, y, np.nan)]
    for side in (strips[:, :1], strips[:, 1:]):
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (side - x) / (x_next - x)
            met = (share >= 0.0) & (share <= 1.0)
            heights.append(np.where(met, y + share * (y_next - y), np.nan))
    every = np.concatenate(heights, axis=1)
    known = ~np.isnan(every).all(axis=1)
    low = np.where(np.isnan(every), np.inf, every).min(axis=1)
    high = np.where(np.isnan(every), -np.inf, every).max(axis=1)
    return np.where(known[:, None], np.column_stack([low, high]), np.nan)


def _corners_apart(first: Array, first_spans: Array, second: Array, second_spans: Array) -> Array:
    """Least distance (n,) of a corner of the first prism to the second prism."""
    found = np.full(len(first), np.inf)
    for end in range(2):
        plane = np.stack(
            [np.broadcast_to(first_spans[:, end : end + 1], first.shape[:2]), first[..., 1]],
            axis=-1,
        )
        across = first[..., 0]
        beyond = np.maximum(
            np.maximum(second_spans[:, :1] - across, across - second_spans[:, 1:]), 0.0
        )
        found = np.minimum(found, np.hypot(_to_quads(plane, second), beyond).min(axis=1))
    return found


def _to_quads(points: Array, quads: Array) -> Array:
    """Distances (n, p) of points (n, p, 2) to anticlockwise convex quads (n, 4, 2), 0 inside."""
    start = quads[:, None]
    edge = np.roll(quads, -1, axis=1)[:, None] - start
    offset = points[:, :, None] - start
    share = np.clip((offset * edge).sum(-1) / (edge * edge).sum(-1), 0.0, 1.0)
    away = np.linalg.norm(offset - share[..., None] * edge, axis=-1).min(axis=2)
    turn = edge[..., 0] * offset[..., 1] - edge[..., 1] * offset[..., 0]
    inside = (turn >= 0.0).all(axis=2) | (turn <= 0.0).all(axis=2)
    return np.where(inside, 0.0, away)


def _edges(quads: Array, spans: Array) -> Array:
    """The twelve edges (n, 12, 2, 3) of each prism, in (plane, plane, across)."""
    low, high = (
        np.concatenate(
            [quads, np.broadcast_to(spans[:, end, None, None], (*quads.shape[:2], 1))], axis=2
        )
        for end in range(2)
    )
    return np.concatenate(
        [
            np.stack([low, np.roll(low, -1, axis=1)], axis=2),
            np.stack([high, np.roll(high, -1, axis=1)], axis=2),
            np.stack([low, high], axis=2),
        ],
        axis=1,
    )


def _segment_distances(first: Array, second: Array) -> Array:
    """Distances between segments (..., 2, 3), broadcast against each other.

    The closest points of the two lines, each clamped to its segment in turn; of parallel ones any.
    """
    p, q = first[..., 0, :], second[..., 0, :]
    u, v = first[..., 1, :] - p, second[..., 1, :] - q
    w = p - q
    uu, vv, uv = (u * u).sum(-1), (v * v).sum(-1), (u * v).sum(-1)
    uw, vw = (u * w).sum(-1), (v * w).sum(-1)
    det = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        s = np.where(det > 1e-12 * uu * vv, np.clip((uv * vw - vv * uw) / det, 0.0, 1.0), 0.0)
    t = np.clip((uv * s + vw) / vv, 0.0, 1.0)
    s = np.clip((uv * t - uw) / uu, 0.0, 1.0)
    gap = w + s[..., None] * u - t[..., None] * v
    return np.asarray(np.sqrt((gap * gap).sum(-1)))
