"""How far a finger reaches in mold space, and how high its walls may be: numbers only, mm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.body import Body
from fingerdesign.design.schema import Design
from fingerdesign.design.step import StepFacts, step_facts
from fingerdesign.layout.clearance import surface_clearances
from fingerdesign.layout.frames import PlateFrame, crest_height, surface_height
from fingerdesign.layout.profile import profile_of
from fingerdesign.mold.plan.plan import Side
from fingerdesign.shapes.faces import CadFace, nearest

_ALONG, _ACROSS = 3, 2  # points of a bar's section at which it is followed outward
_STEPS = 10  # along a leg in a STEP body, which need not be convex
_HALVINGS = 40
_STEP_HALVINGS = 14
_ON_FACE_MM = 1e-6


@dataclass(frozen=True)
class Exits:
    """How bars leave the finger on their sides, arrays over the bars (mold space).

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

    def with_others(self, others: Exits) -> Exits:
        """The worse of two bars at each leg: what holds for both."""
        both = zip(vars(self).items(), vars(others).values(), strict=True)
        great = ("farthest", "top", "reach")
        return Exits(
            *((np.maximum if name in great else np.minimum)(a, b) for (name, a), b in both)
        )


def rim_height(body: Body) -> float:
    """Least height of the contact surface's border, mm, in the design's space."""
    if body.step is not None:
        return step_facts(body.step).lowest
    profile = profile_of(body)
    if body.dome_radius_mm is None:
        return profile.side_height
    return float(surface_height(body, profile.half_width, 0.5 * body.depth_mm))


def flat_sided(body: Body) -> bool:
    """Whether every side is a flat face normal to x or z, so that the contact surface can be
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
    follow: bool = True,
) -> Exits:
    """How ``bars`` leave on their ``sides``; each lies inside the finger at its ``start``.

    Not ``follow``: exits that are not in a flat face are not looked for, nearest and farthest are
    those of the body's extent.
    """
    if not bars:
        nothing = np.zeros(0)
        return Exits(*[nothing] * 7)
    rays = _sections(bars) / scale
    signs = np.array([1.0 if side[0] == "+" else -1.0 for side in sides])
    half = np.array([half_extent(body, side) for side in sides])
    along_x = np.array([side.endswith("z") for side in sides])

    def space(across: Array) -> Array:
        """Points (n * points, 3) of the rays at distances ``across`` (n, points)."""
        way = signs[:, None] * across
        x = np.where(along_x[:, None], rays[..., 0], way)
        z = np.where(along_x[:, None], way, rays[..., 0])
        return np.column_stack([x.ravel(), rays[..., 1].ravel(), z.ravel()])

    shape = rays.shape[:2]
    ends = np.broadcast_to(half[:, None], shape)
    face, surface = _margins(body, space(ends), along_x, signs, shape)
    first = np.broadcast_to(np.minimum(np.array(starts) / scale, half)[:, None], shape)
    out = np.array(ends, dtype=float)
    rest = np.flatnonzero(face < 0.0)
    if follow and len(rest):
        out[rest] = _followed(body, space, first, ends, rest)
    return Exits(
        scale * out.min(axis=1),
        scale * out.max(axis=1),
        scale * face,
        scale * surface,
        scale * rays[..., 1].max(axis=1),
        scale * rays[..., 1].min(axis=1),
        scale * np.abs(rays[..., 0]).max(axis=1),
    )


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


def _margins(
    body: Body, points: Array, along_x: BoolArray, signs: Array, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """Least margin (n,) to the border of a flat face, and to the contact surface."""
    if body.step is None:
        x, y, z = points.T
        half_x = 0.5 * body.width_mm * (1.0 - 1e-12)
        on_side = np.column_stack([np.clip(x, -half_x, half_x), y, z])
        if body.kind.turned:
            surface = np.full(shape[0], -np.inf)
            return surface, surface
        below = surface_clearances(body, on_side).reshape(shape)
        below = np.where(np.isnan(below), -np.inf, below).min(axis=1)
        beside = np.where(
            along_x,
            (0.5 * body.width_mm - np.abs(x)).reshape(shape).min(axis=1),
            (0.5 * body.depth_mm - np.abs(z)).reshape(shape).min(axis=1),
        )
        height = y.reshape(shape).min(axis=1)
        return np.minimum(np.minimum(below, beside), height), below
    facts = step_facts(body.step)
    face, surface = np.full(shape[0], -np.inf), np.full(shape[0], -np.inf)
    grouped = points.reshape(*shape, 3)
    for axis, mine in ((2, along_x), (0, ~along_x)):
        for sign in (1.0, -1.0):
            rows = np.flatnonzero(mine & (signs == sign))
            if len(rows):
                some = grouped[rows].reshape(-1, 3)
                inside, below = _step_margins(facts, axis, sign, some)
                face[rows] = inside.reshape(len(rows), -1).min(axis=1)
                surface[rows] = below.reshape(len(rows), -1).min(axis=1)
    return face, surface


def _step_margins(facts: StepFacts, axis: int, sign: float, points: Array) -> tuple[Array, Array]:
    """Of points (n, 3) in the plane of a STEP body's extent: inside its flat face, by how much;
    and how far below the contact surface."""
    extent = facts.high[axis] if sign > 0 else facts.low[axis]
    here: list[CadFace] = []
    others: list[CadFace] = []
    for face in facts.faces:
        level = max(abs(face.low[axis] - extent), abs(face.high[axis] - extent)) < _ON_FACE_MM
        (here if face.flat and level else others).append(face)
    if not here:
        return np.full(len(points), -np.inf), np.full(len(points), -np.inf)
    contact = tuple(face for face in facts.faces if face.name == "contact")
    on_it = nearest(tuple(here), points)[3] < _ON_FACE_MM
    inside = np.where(on_it, nearest(tuple(others), points)[3], -np.inf)
    return inside, np.where(on_it, nearest(contact, points)[3], -np.inf)


def _followed(
    body: Body, space: Callable[[Array], Array], first: Array, ends: Array, rest: IntArray
) -> Array:
    """Distances (rest, points) at which the rays of some bars leave the body."""
    shape = first.shape

    def inside(across: Array) -> BoolArray:
        full = np.array(ends, dtype=float)
        full[rest] = across
        points = space(full).reshape(*shape, 3)[rest].reshape(-1, 3)
        return _inside(body, points).reshape(across.shape)

    low, high = np.array(first[rest]), np.array(ends[rest])
    halvings = _HALVINGS
    if body.step is not None:
        last = np.array(low)
        for share in np.linspace(0.0, 1.0, _STEPS + 1)[1:]:
            trial = low + share * (high - low)
            last = np.where(inside(trial), trial, last)
        low, high = last, np.minimum(last + (high - low) / _STEPS, high)
        halvings = _STEP_HALVINGS
    for _ in range(halvings):
        middle = 0.5 * (low + high)
        within = inside(middle)
        low, high = np.where(within, middle, low), np.where(within, high, middle)
    return high


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


_PLACES = 40  # to either side at which a STEP body is looked at
_HEIGHTS = 5
_SHARE = 0.7  # of the half-width that must be left at the corner: that of a circle at 45 degrees
_WITHIN = 0.98  # of the corner found: walls that end on the body's surface would end in a point


@dataclass(frozen=True)
class Extent:
    """The enlarged outline's half sizes, mm; ``corner``, ``rim``, ``crest`` as of a MoldPlan.

    continued   whether the walls continue the contact surface outward; else they end at the rim
    """

    half_width: float
    half_depth: float
    corner: float
    rim: float
    crest: float
    continued: bool


def extent_of(design: Design, scale: float) -> Extent:
    """The extent of a design's outline, enlarged by ``scale``."""
    body = design.body
    half_width = max(half_extent(body, "+x"), half_extent(body, "-x"))
    half_depth = max(half_extent(body, "+z"), half_extent(body, "-z"))
    continued, rim = flat_sided(body), rim_height(body)
    corner = half_depth
    if body.kind.turned:
        corner = half_depth / np.sqrt(2.0)
    elif body.step is not None and not continued:
        corner = _corner(step_facts(body.step).faces, half_width, half_depth, rim)
    sizes = scale * np.array([half_width, half_depth, corner, rim, crest_height(body)])
    half_width, half_depth, corner, rim, crest = sizes.tolist()
    return Extent(half_width, half_depth, corner, rim, crest, continued)


def _corner(faces: tuple[CadFace, ...], half_width: float, half_depth: float, rim: float) -> float:
    """|z| up to which a STEP body, at every height below the rim, parts left from right."""
    heights = np.linspace(1e-3, 1.0 - 1e-3, _HEIGHTS) * rim
    shares = np.linspace(-1.0, 1.0, 2 * _PLACES + 1)

    def reach(places: Array, most: float) -> float:
        """How far lines of places (lines, heights, shares, 3) stay inside, both ways."""
        outside = nearest(faces, places.reshape(-1, 3))[1].reshape(places.shape[:-1]) > -1e-9
        far = np.where(outside, np.abs(shares), np.inf).min()
        return most * min(1.0, float(far) - 1.0 / _PLACES)

    grid = np.zeros((1, _HEIGHTS, len(shares), 3))
    grid[..., 1] = heights[:, None]
    grid[..., 0] = half_width * shares
    wide = reach(grid, half_width)
    grid = np.zeros((3, _HEIGHTS, len(shares), 3))
    grid[..., 0] = _SHARE * wide * np.array([-1.0, 0.0, 1.0])[:, None, None]
    grid[..., 1] = heights[:, None]
    grid[..., 2] = half_depth * shares
    return _WITHIN * reach(grid, half_depth)


def seam_height(design: Design, extent: Extent, scale: float, x: float, z: float) -> float:
    """Height of the walls' top at (x, z) beside the finger, in mold space, mm."""
    if not extent.continued:
        return extent.rim
    inside = 1.0 - 1e-9
    place = (
        float(np.clip(x, -extent.half_width, extent.half_width)) / scale * inside,
        float(np.clip(z, -extent.half_depth, extent.half_depth)) / scale * inside,
    )
    return scale * float(surface_height(design.body, *place))
