"""A finger's body, core and plates as triangles, for the comparison page's view in space.

Axes as everywhere: x tangential, y normal (crest up), z along the plates; mm.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.layout.frames import PlateFrame

AROUND = 36  # facets of a turned body
SHARP_DEG = 14.0  # facets of one surface meet at under 7 degrees
BENT_RAD = 0.17  # a bent plate is drawn as boxes that turn by at most this
LIFT = 0.02  # mm, of gages and holes above their plate's face: neither hides the other
# Quadrilaterals of a box whose corners 0-3 are one end and 4-7 the other.
_BOX = ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7))
_HOLE_CORNERS = 16


@dataclass(frozen=True)
class Triangles:
    """Vertices (n, 3), and triangles (m, 3) of their numbers, anticlockwise seen from outside."""

    vertices: Array
    triangles: IntArray

    @property
    def volume(self) -> float:
        """Of the closed surface, mm3, by the divergence theorem."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        return float((a * np.cross(b, c)).sum() / 6.0)

    def edges(self) -> tuple[IntArray, Array]:
        """Each edge once, (k, 2), and the cosine (k,) between its two facets; NaN: it has one."""
        a, b, c = np.moveaxis(self.vertices[self.triangles], 1, 0)
        normal = np.cross(b - a, c - a)
        normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
        directed = np.concatenate([self.triangles[:, pair] for pair in ([0, 1], [1, 2], [2, 0])])
        facet = np.tile(np.arange(len(self.triangles)), 3)
        ends, number = np.unique(np.sort(directed, axis=1), axis=0, return_inverse=True)
        order = np.argsort(number.ravel(), kind="stable")
        first = np.searchsorted(number.ravel()[order], np.arange(len(ends)))
        count = np.bincount(number.ravel(), minlength=len(ends))
        cosine = np.full(len(ends), np.nan)
        two = np.flatnonzero(count == 2)
        pair = facet[order[first[two]]], facet[order[first[two] + 1]]
        cosine[two] = (normal[pair[0]] * normal[pair[1]]).sum(axis=1)
        return np.asarray(ends), cosine

    def sharp_edges(self, angle_deg: float = SHARP_DEG) -> IntArray:
        """Ends (k, 2) of the edges whose facets meet at more than an angle, or that have one."""
        ends, cosine = self.edges()
        return np.asarray(ends[~(cosine >= np.cos(np.radians(angle_deg)))])


def together(parts: Iterable[Triangles]) -> Triangles:
    """Several surfaces as one."""
    vertices, triangles, count = [np.zeros((0, 3))], [np.zeros((0, 3), dtype=int)], 0
    for part in parts:
        vertices.append(part.vertices)
        triangles.append(part.triangles + count)
        count += len(part.vertices)
    return Triangles(np.concatenate(vertices), np.concatenate(triangles))


def grid_body(x: Array, z: Array, heights: Array) -> Triangles:
    """A body below heights (n, m) over x (n,) and z (m,) or (n, m), with straight sides to y = 0.

    Where a height is NaN there is no body.
    """
    n, m = heights.shape
    deep = np.broadcast_to(z, heights.shape)
    wide = np.broadcast_to(x[:, None], heights.shape)
    top = np.column_stack([wide.ravel(), np.nan_to_num(heights).ravel(), deep.ravel()])
    number = np.arange(n * m).reshape(n, m)
    corners = (number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1])
    cells = np.stack([each.ravel() for each in corners], axis=1)
    cells = cells[np.isfinite(heights).ravel()[cells].all(axis=1)]
    # The border: an edge that no neighbouring cell walks along the other way.
    edges = np.concatenate([cells[:, [k, (k + 1) % 4]] for k in range(4)])
    size = n * m
    met = np.isin(edges[:, 0] * size + edges[:, 1], edges[:, 1] * size + edges[:, 0])
    a, b = edges[~met].T
    sides = np.stack([a, a + size, b + size, b], axis=1)
    quads = np.concatenate([cells, cells[:, ::-1] + size, sides])
    return Triangles(np.concatenate([top, top * (1.0, 0.0, 1.0)]), _halved(quads))


def turned_body(outline: Array) -> Triangles:
    """A body turned about y: of its outline's points (r, y), from the crest outward, to y = 0."""
    rings = np.concatenate([outline[1:], [[outline[-1, 0], 0.0]]])
    angle = 2.0 * np.pi * np.arange(AROUND) / AROUND
    round_ = np.stack([np.cos(angle), np.zeros(AROUND), -np.sin(angle)], axis=1)
    points = rings[:, None, :1] * round_ + rings[:, None, 1:] * (0.0, 1.0, 0.0)
    ends = [[0.0, outline[0, 1], 0.0], [0.0, 0.0, 0.0]]  # the crest, and the base's middle
    number = np.arange(points.shape[0] * AROUND).reshape(-1, AROUND) + 2
    after = np.roll(number, -1, axis=1)
    strips = [
        np.stack([number[k], number[k + 1], after[k + 1], after[k]], axis=1)
        for k in range(len(rings) - 1)
    ]
    caps = [
        np.stack([np.zeros(AROUND, dtype=int), number[0], after[0]], axis=1),
        np.stack([np.ones(AROUND, dtype=int), after[-1], number[-1]], axis=1),
    ]
    triangles = np.concatenate([*(_halved(each) for each in strips), *caps])
    return Triangles(np.concatenate([ends, points.reshape(-1, 3)]), triangles)


def box(corners: Array) -> Triangles:
    """A box of corners (8, 3): one end's four in turn, then the other end's."""
    made = Triangles(corners, _halved(np.array(_BOX)))
    return made if made.volume > 0 else Triangles(corners, made.triangles[:, ::-1])


def block(ends: Sequence[float]) -> Triangles:
    """A box along the axes, of [x0, x1, y0, y1, z0, z1]."""
    x0, x1, y0, y1, z0, z1 = ends
    ring = [(x0, y0), (x1, y0), (x1, y1), (x0, y1)]
    return box(np.array([[x, y, z] for z in (z0, z1) for x, y in ring]))


def plate_boxes(frame: PlateFrame) -> Triangles:
    """One plate: a box, or where it is bent several, which turn little by little."""
    count = _pieces(frame)
    half = 0.5 * frame.thickness
    shares = np.linspace(-0.5, 0.5, count + 1) * frame.length
    parts = []
    for start, end in pairwise(shares):
        along, across = np.array([start, end, end, start]), np.array([-half, -half, half, half])
        ends = [_in_space(frame, along, across, w) for w in (frame.low, frame.high)]
        parts.append(box(np.concatenate(ends)))
    return together(parts)


def plate_marks(
    frame: PlateFrame, gage: tuple[float, float, float] | None, faces: Sequence[int]
) -> tuple[Triangles, Triangles]:
    """Patches just above a plate's faces (+1 upper, -1 lower): its gage, and its holes on both.

    gage: length, width and place along z; None: there is none.
    """
    middle, gages, holes = 0.5 * (frame.low + frame.high), [], []
    angle = 2.0 * np.pi * np.arange(_HOLE_CORNERS) / _HOLE_CORNERS
    for face in (1, -1):
        above = face * (0.5 * frame.thickness + LIFT)
        for hole in frame.holes:
            along, across = hole.radius * np.cos(angle), hole.w + hole.radius * np.sin(angle)
            holes.append(_fan(_in_space(frame, along, np.full(_HOLE_CORNERS, above), across)))
        if gage is None or face not in faces:
            continue
        length, width, z = gage
        s = min(0.5 * length, 0.5 * frame.length / _pieces(frame))
        low = max(frame.low, middle + z - 0.5 * width)
        high = min(frame.high, middle + z + 0.5 * width)
        ring = np.array([(-s, low), (s, low), (s, high), (-s, high)])
        gages.append(_fan(_in_space(frame, ring[:, 0], np.full(4, above), ring[:, 1])))
    return together(gages), together(holes)


def _pieces(frame: PlateFrame) -> int:
    """Boxes of a plate; odd, so that the middle one carries the gage."""
    if not frame.bend_radius:
        return 1
    return 2 * int(np.ceil((frame.length / frame.bend_radius / BENT_RAD - 1) / 2)) + 1


def _in_space(frame: PlateFrame, s: Array, v: Array, w: Array | float) -> Array:
    """Places (n, 3) of s along the plate, v across its thickness, w along its width."""
    turn = np.radians(frame.angle_deg)
    if frame.bend_radius:
        radius, at = frame.bend_radius, s / frame.bend_radius
        s, v = (radius + v) * np.sin(at), (radius + v) * np.cos(at) - radius
    place = frame.place + s * np.cos(turn) - v * np.sin(turn)
    y = frame.y + s * np.sin(turn) + v * np.cos(turn)
    wide = np.broadcast_to(np.asarray(w, dtype=float), place.shape)
    axes = (wide, y, place) if frame.along == "z" else (place, y, wide)
    return np.stack(axes, axis=1)


def _fan(corners: Array) -> Triangles:
    """A convex polygon."""
    rest = np.arange(1, len(corners) - 1)
    return Triangles(corners, np.stack([np.zeros_like(rest), rest, rest + 1], axis=1))


def _halved(quads: IntArray) -> IntArray:
    """Quadrilaterals (m, 4) as triangles (2 m, 3)."""
    return np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
