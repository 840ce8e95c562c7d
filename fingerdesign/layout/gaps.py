"""Distances between plates in space, and from plates to the core, by manifold3d; mm.

A plate is its section polygon drawn straight across its section plane, a bent one with chords.
"""

import math
from dataclasses import dataclass
from functools import cache, lru_cache

import numpy as np
from manifold3d import CrossSection, Manifold, Mesh64
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Core
from fingerdesign.layout.frames import PlateFrame

MOST_PIECES = 16  # Chords of a bent plate.
_STRAY_MM = 1e-3  # The distance by which chords may leave the arc.
FAR_MM = 1e5  # Larger than any finger and its mold.
_ROUNDING_MM = 1e-12  # Of pairs that are equally near to rounding, the first counts.


@dataclass(frozen=True)
class PlateGap:
    """The least distance between two plates, mm (0: they touch or cross), and which ones."""

    distance: float
    first: int
    second: int


def solids_of(frames: tuple[PlateFrame, ...]) -> list[Manifold]:
    """Plates as solids, their holes left out; empty where one has no place (NaN)."""
    flat = flat_corners(frames)
    return [
        _solid(frame, flat[k] if frame.bend_radius is None else frame.outline(_pieces(frame)))
        for k, frame in enumerate(frames)
    ]


def flat_corners(frames: tuple[PlateFrame, ...]) -> Array:
    """Section corners (plates, 4, 2) of flat plates, anticlockwise, all at once."""
    values = np.array([[f.place, f.y, f.angle_deg, f.length, f.thickness] for f in frames])
    place, y, angle, length, thickness = values.reshape(-1, 5).T[..., None]
    s = 0.5 * length * np.array([-1.0, 1.0, 1.0, -1.0])
    v = 0.5 * thickness * np.array([-1.0, -1.0, 1.0, 1.0])
    cosine, sine = np.cos(np.radians(angle)), np.sin(np.radians(angle))
    return np.stack([place + s * cosine - v * sine, y + s * sine + v * cosine], axis=-1)


def _pieces(frame: PlateFrame) -> int:
    """Chords of a bent plate's long sides."""
    assert frame.bend_radius is not None
    enough = np.sqrt(frame.length**2 / (8.0 * max(frame.bend_radius, 1e-3) * _STRAY_MM))
    return int(np.clip(np.ceil(enough), 1, MOST_PIECES))


def _solid(frame: PlateFrame, outline: Array) -> Manifold:
    """The prism over an outline (n, 2): its lower side forth, its upper side back."""
    if not math.isfinite(frame.place + frame.y):
        return Manifold()
    count, mirrored = len(outline), frame.along == "z"
    points = np.empty((2 * count, 3))
    points[:count, 2], points[count:, 2] = frame.low, frame.high
    points[:count, :2] = points[count:, :2] = outline
    if mirrored:  # (z, y, x)
        points = np.ascontiguousarray(points[:, ::-1])
    return Manifold(Mesh64(points, _triangles(count, mirrored)))


@cache
def _triangles(count: int, mirrored: bool) -> NDArray[np.uint64]:
    """Triangles of a prism over a strip of ``count`` corners, outward; of its mirror image."""
    k, here = np.arange(count // 2 - 1), np.arange(count)
    back, then = count - 2 - k, np.roll(here, -1)
    cap = np.vstack([np.column_stack([k, k + 1, back]), np.column_stack([k, back, back + 1])])
    sides = [np.column_stack([here, then, then + count])]
    sides.append(np.column_stack([here, then + count, here + count]))
    every = np.vstack([cap[:, ::-1], cap + count, *sides])
    return np.ascontiguousarray(every[:, ::-1] if mirrored else every, dtype=np.uint64)


def boxes_apart(first: list[Manifold], second: list[Manifold]) -> Array:
    """Distances (first, second) between the solids' boxes, mm; NaN: one is empty."""
    (low_a, high_a), (low_b, high_b) = _boxes(first), _boxes(second)
    apart = np.maximum(low_b[None] - high_a[:, None], low_a[:, None] - high_b[None])
    return np.asarray(np.linalg.norm(np.maximum(apart, 0.0), axis=2))


def _boxes(solids: list[Manifold]) -> tuple[Array, Array]:
    """Least and greatest x, y, z of each, (n, 3); NaN: it is empty."""
    found = [(np.nan,) * 6 if solid.is_empty() else solid.bounding_box() for solid in solids]
    corners = np.array(found).reshape(-1, 6)
    return corners[:, :3], corners[:, 3:]


@lru_cache(maxsize=256)  # A search checks the same plates a hundred times.
def least_gap(
    first: tuple[PlateFrame, ...], second: tuple[PlateFrame, ...] | None = None
) -> PlateGap | None:
    """The closest pair of plates, or of one in ``first`` and one in ``second``; None: no pair."""
    other = first if second is None else second
    a = solids_of(first)
    b = a if second is None else solids_of(other)
    apart = boxes_apart(a, b)
    if second is None:
        apart[np.tril_indices(len(a))] = np.nan
    i, j = np.nonzero(np.isfinite(apart))
    if not len(i):
        return None
    least = apart[i, j]
    best, pair = FAR_MM, (0, 0)
    for k in np.argsort(least, kind="stable"):
        if least[k] > best or best == 0.0:
            break
        distance = float(a[i[k]].min_gap(b[j[k]], best))
        if distance < best - _ROUNDING_MM:
            best, pair = distance, (first[i[k]].index, other[j[k]].index)
    return PlateGap(best, min(pair), max(pair))


def core_gaps(core: Core, depth: float, frames: tuple[PlateFrame, ...]) -> Array:
    """Distances (plates,) from each plate to the core, mm; 0: they touch or cross; NaN: no place.

    ``depth``: the core's extent along z, mm.
    """
    box, plates = core_solid(core, depth), solids_of(frames)
    return np.array([np.nan if each.is_empty() else each.min_gap(box, FAR_MM) for each in plates])


def below_middle(vertices: Array, triangles: IntArray) -> tuple[Array, IntArray]:
    """The part of a closed surface at z <= 0, closed by its section; empty where there is none.

    vertices (n, 3), triangles (t, 3), anticlockwise from outside; returned in the same form.
    """
    solid = Manifold(Mesh64(np.ascontiguousarray(vertices), triangles.astype(np.uint64)))
    found = solid.trim_by_plane((0.0, 0.0, -1.0), 0.0).to_mesh64()
    return found.vert_properties, found.tri_verts.astype(np.int64)


def core_solid(core: Core, depth: float) -> Manifold:
    """The core as a solid, with the extent ``depth`` along z, mm."""
    box = Manifold.cube((core.width_mm, core.height_mm, depth), center=True)
    return box.translate((0.0, core.bottom_mm + 0.5 * core.height_mm, 0.0))


def turned_solid(outline: Array, facets: int) -> Manifold:
    """A body turned about y: of its outline's points (r, y), from the crest outward, to y = 0."""
    section = np.concatenate([[[0.0, 0.0], [outline[-1, 0], 0.0]], outline[::-1]])
    return CrossSection([section]).revolve(facets).rotate((-90.0, 0.0, 0.0))
