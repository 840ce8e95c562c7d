"""Extent of a finger in mold space, and the height of its walls: numbers only, mm."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.body import Body, StepFile
from fingerdesign.design.schema import Design
from fingerdesign.design.step import step_facts
from fingerdesign.layout.bodies import crest_height, surface_height
from fingerdesign.layout.clearance import surface_clearances
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.plan.pieces import Side, across, direction
from fingerdesign.mold.plan.plan import Extent, MoldPlan
from fingerdesign.shapes.faces import CadFace, nearest

_ALONG, _ACROSS = 3, 2  # points of a bar's section at which it is followed outward
_STEPS = 10  # along a leg in a STEP body, which need not be convex
_HALVINGS = 40
_STEP_HALVINGS = 14
_ON_FACE_MM = 1e-6
_PLACES = 40  # to either side at which a STEP body is looked at
_HEIGHTS = 5
_SHARE = 0.7  # of the half-width must be left at the corner: that of a circle at 45 degrees
_WITHIN = 0.98  # of the corner found: walls that end on the body's surface would end in a point


@dataclass(frozen=True)
class Exits:
    """Exits of bars from the finger on their sides, arrays over the bars (mold space).

    nearest, farthest   distances from the mid-plane at which a point of the bar's section leaves
    face_margin         how far the section lies inside a flat face normal to the side, from the
                        face's border; -inf where there is none
    surface_margin      how far below the contact surface it lies in the plane of the body's extent;
                        negative where it leaves through the contact surface
    top, bottom         greatest and least height of the section
    reach               greatest distance of the section from the middle, across the side
    """

    nearest: Array
    farthest: Array
    face_margin: Array
    surface_margin: Array
    top: Array
    bottom: Array
    reach: Array


def flat_sided(body: Body) -> bool:
    """True where every side is a flat face normal to x or z, so that the contact surface can be
    continued outward; else the walls end at the rim's height."""
    if body.kind.turned:
        return False
    if body.step is None:
        return True
    return all(
        face.flat and min(abs(face.high[k] - face.low[k]) for k in (0, 2)) < _ON_FACE_MM
        for face in step_facts(body.step).faces
        if face.name in ("side", "end")
    )


def half_extent(body: Body, side: Side) -> float:
    """|x| or |z| of the body's extent on a side, mm, in the design's space."""
    if body.step is not None:
        facts, k = step_facts(body.step), 0 if side.endswith("x") else 2
        return facts.high[k] if side[0] == "+" else -facts.low[k]
    return 0.5 * (body.width_mm if side.endswith("x") else body.depth_mm)


def exits_of(
    body: Body,
    scale: float,
    bars: Sequence[PlateFrame],
    sides: Sequence[Side],
    starts: Sequence[float],
    followed: bool = True,
) -> Exits:
    """Find how ``bars`` leave on their ``sides``; each lies inside the finger at its ``start``.

    Not ``followed``: exits that are not in a flat face are not looked for; nearest and farthest are
    those of the body's extent.
    """
    if not bars:
        return Exits(*[np.zeros(0)] * 7)
    rays = _sections(bars) / scale
    level, way = (np.array([of(side) for side in sides])[:, None] for of in (across, direction))
    foot = rays[..., :1] * level + rays[..., 1:] * np.array([0.0, 1.0, 0.0])
    half = np.array([[half_extent(body, side)] for side in sides])
    face, surface = _margins(body, foot + half[..., None] * way, sides)
    out = np.tile(half, rays.shape[1])
    rest = np.flatnonzero(face < 0.0)
    if followed and len(rest):
        first = np.minimum(np.array(starts)[rest, None] / scale, half[rest])
        out[rest] = _followed(body, foot[rest], way[rest], first, half[rest])
    place, height = np.abs(rays[..., 0]), rays[..., 1]
    least, most = [out.min(axis=1), out.max(axis=1)], [height.max(axis=1), height.min(axis=1)]
    return Exits(*(scale * each for each in (*least, face, surface, *most, place.max(axis=1))))


def _sections(bars: Sequence[PlateFrame]) -> Array:
    """Points (n, points, 2) all over the sections of straight bars."""
    s, v = np.meshgrid(np.linspace(-0.5, 0.5, _ALONG), np.linspace(-0.5, 0.5, _ACROSS))
    along = np.array([bar.length for bar in bars])[:, None] * s.ravel()
    across = np.array([bar.thickness for bar in bars])[:, None] * v.ravel()
    centre, axis, normal = (
        np.array([getattr(bar, name) for bar in bars])[:, None]
        for name in ("centre", "axis", "normal")
    )
    return np.asarray(centre + along[..., None] * axis + across[..., None] * normal)


def _margins(body: Body, points: Array, sides: Sequence[Side]) -> tuple[Array, Array]:
    """Least margin (n,) of points (n, k, 3) in the planes of the body's extents: to the border of
    a flat face there, and below the contact surface; -inf where there is none."""
    shape = points.shape[:2]
    face, below = np.full((2, *shape), -np.inf)
    if body.step is not None:
        for side in set(sides):
            rows = [k for k, each in enumerate(sides) if each == side]
            found = _on_step(body.step, side, points[rows].reshape(-1, 3))
            face[rows], below[rows] = (each.reshape(len(rows), -1) for each in found)
    elif not body.kind.turned:
        level = np.array([across(side) for side in sides])
        half = 0.5 * level @ [body.width_mm, 0.0, body.depth_mm]
        margin = half[:, None] - np.abs(np.einsum("nki,ni->nk", points, level))
        x, y, z = points.reshape(-1, 3).T
        half_x = 0.5 * body.width_mm * (1.0 - 1e-12)
        clear = surface_clearances(body, np.column_stack([np.clip(x, -half_x, half_x), y, z]))
        below = np.where(np.isnan(clear), -np.inf, clear).reshape(shape)
        face = np.minimum(np.minimum(below, margin), y.reshape(shape))
    return face.min(axis=1), below.min(axis=1)


def _on_step(step: StepFile, side: Side, points: Array) -> tuple[Array, Array]:
    facts, axis = step_facts(step), 0 if side.endswith("x") else 2
    faces, extent = facts.faces, (facts.high if side[0] == "+" else facts.low)[axis]
    here: list[CadFace] = []
    others: list[CadFace] = []
    for face in faces:
        level = max(abs(face.low[axis] - extent), abs(face.high[axis] - extent)) < _ON_FACE_MM
        (here if face.flat and level else others).append(face)
    if not here:
        return np.full(len(points), -np.inf), np.full(len(points), -np.inf)
    contact = [face for face in faces if face.name == "contact"]
    on_it = nearest(here, points)[3] < _ON_FACE_MM
    border, below = (nearest(each, points)[3] for each in (others, contact))
    return np.where(on_it, border, -np.inf), np.where(on_it, below, -np.inf)


def _followed(body: Body, foot: Array, way: Array, first: Array, last: Array) -> Array:
    """Distances (n, k) along unit vectors at which lines from ``foot`` (n, k, 3) leave the body,
    between two (n, 1) of which it holds the first."""

    def inside(out: Array) -> BoolArray:
        points = foot + out[..., None] * way
        return _inside(body, points.reshape(-1, 3)).reshape(out.shape)

    steps, halvings = (1, _HALVINGS) if body.step is None else (_STEPS, _STEP_HALVINGS)
    low = np.tile(first, foot.shape[1])
    for share in np.linspace(0.0, 1.0, steps + 1)[1:]:
        trial = np.broadcast_to(first + share * (last - first), low.shape)
        low = np.where(inside(trial), trial, low)
    high = np.minimum(low + (last - first) / steps, last)
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        within = inside(middle)
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    return np.asarray(high)


def _inside(body: Body, points: Array) -> BoolArray:
    if body.step is not None:
        return np.asarray(nearest(step_facts(body.step).faces, points)[1] < 0.0)
    x, y, z = points.T
    half_x, half_z = 0.5 * body.width_mm, 0.5 * body.depth_mm
    within = (np.abs(x) <= half_x) & (np.abs(z) <= half_z)
    if body.kind.turned:
        within = np.hypot(x, z) <= half_x
    with np.errstate(invalid="ignore"):
        height = surface_height(body, np.where(within, x, 0.0), np.where(within, z, 0.0))
        return np.asarray(within & (y <= height) & (y <= crest_height(body)))


def extent_of(design: Design, scale: float) -> Extent:
    """The extent of a design's outline, enlarged by ``scale``."""
    body = design.body
    half_width = max(half_extent(body, "+x"), half_extent(body, "-x"))
    half_depth = max(half_extent(body, "+z"), half_extent(body, "-z"))
    continued, rim = flat_sided(body), body.kind.lowest(body)
    corner = half_depth
    if body.kind.turned:
        corner = half_depth / np.sqrt(2.0)
    elif body.step is not None and not continued:
        corner = _corner(step_facts(body.step).faces, half_width, half_depth, rim)
    sizes = scale * np.array([half_width, half_depth, corner, rim, crest_height(body)])
    half_width, half_depth, corner, rim, crest = sizes.tolist()
    return Extent(half_width, half_depth, corner, rim, crest, continued)


@lru_cache(maxsize=64)  # it takes 0.1 s
def _corner(faces: tuple[CadFace, ...], half_width: float, half_depth: float, rim: float) -> float:
    """|z| up to which a STEP body, at every height below the rim, parts left from right."""
    heights = np.linspace(1e-3, 1.0 - 1e-3, _HEIGHTS) * rim
    shares = np.linspace(-1.0, 1.0, 2 * _PLACES + 1)

    def reach(places: Array, most: float) -> float:
        """Length to which lines of places (lines, heights, shares, 3) stay inside, both ways."""
        outside = nearest(faces, places.reshape(-1, 3))[1].reshape(places.shape[:-1]) > -1e-9
        far = np.where(outside, np.abs(shares), np.inf).min()
        return most * min(1.0, float(far) - 1.0 / _PLACES)

    def grid(x: Array, z: Array) -> Array:
        """Places (..., heights, shares, 3) of one of x and z at every height and share."""
        return np.stack(np.broadcast_arrays(x, heights[:, None], z), axis=-1)

    wide = reach(grid(half_width * shares, np.zeros(1))[None], half_width)
    lines = _SHARE * wide * np.array([-1.0, 0.0, 1.0])[:, None, None]
    return _WITHIN * reach(grid(lines, half_depth * shares), half_depth)


def seam_height(plan: MoldPlan, x: float, z: float) -> float:
    """Height of the walls' top at (x, z) next to the finger, in mold space, mm."""
    if not plan.continued:
        return plan.rim
    half = np.array([plan.half_width, plan.half_depth])
    place = np.clip([x, z], -half, half) / plan.scale * (1.0 - 1e-9)
    return plan.scale * float(surface_height(plan.design.body, *place))
