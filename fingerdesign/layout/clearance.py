"""Distances from plates and core to the body's faces, in closed form (numpy only); mm.

The space below a parametric body's contact surface and between its sides is convex, so a plate is
nearest to the surface at a corner; above a STEP body's faces it is sampled.
"""

from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Body
from fingerdesign.design.step import step_facts
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.outline import Piece
from fingerdesign.layout.profile import profile_of
from fingerdesign.shapes.faces import nearest

# Thinner skins of rubber tear when the mold is opened, and no mesh of sane size resolves them.
LEAST_CLEARANCE_MM = 0.1
BEND_PIECES = 16  # chords of a bent plate: 2 mm long at R = 10 they stray by 0.2 micrometres
_CORE_SAMPLES = 9  # along each edge of a core in a STEP body
_SAMPLES = 7  # along each edge of a plate below a step body's surface


def plate_points(frame: PlateFrame) -> Array:
    """The corners of a plate, and those along a bent one's faces, at both ends of its span."""
    outline = frame.outline(BEND_PIECES)
    return np.vstack([frame.to_space(outline, frame.low), frame.to_space(outline, frame.high)])


def least_of_each(groups: list[Array], values: Array) -> Array:
    """The least of the values of all points, by their groups, (groups,)."""
    starts = np.cumsum([0, *(len(group) for group in groups[:-1])])
    return np.asarray(np.minimum.reduceat(values, starts))


def cover_clearances(body: Body, frames: tuple[PlateFrame, ...]) -> Array:
    """Least distance of each plate to the contact surface, shape (plates,), mm.

    Negative: the plate sticks out; NaN: it lies where there is no surface. To a dome's surface
    continued beyond the end faces: never more than the true distance.
    """
    groups = [_dense(f) if body.shape == "step" else plate_points(f) for f in frames]
    return least_of_each(groups, surface_clearances(body, np.vstack(groups)))


def surface_clearances(body: Body, points: Array) -> Array:
    """Depth of points (n, 3) below the contact surface, (n,), mm; negative above it."""
    if body.shape == "step":
        return _to_faces(body, ("contact",), points)
    profile = profile_of(body)
    x, y, z = points.T
    above = np.maximum(y, body.kind.axis(body))  # the surface lies above its axis
    x, y = body.kind.plane(body, np.column_stack([x, above, z])).T
    plane = np.column_stack([np.abs(x), y])
    away = np.min([_to_piece(piece, plane) for piece in profile.pieces], axis=0)
    with np.errstate(invalid="ignore"):
        inside = (plane[:, 0] <= profile.half_width + 1e-9) & (y < profile.height(plane[:, 0]))
    return np.where(np.isnan(y + x), np.nan, np.where(inside, away, -away))


def _to_piece(piece: Piece, plane: Array) -> Array:
    """Unsigned distances (n,) to a piece of the outline, as it ends."""
    a, b = np.array(piece.start), np.array(piece.end)
    ends = np.minimum(np.linalg.norm(plane - a, axis=1), np.linalg.norm(plane - b, axis=1))
    within = piece.beyond(plane) == 0.0
    return np.where(within, np.abs(piece.distance(plane)), ends)


def _dense(frame: PlateFrame) -> Array:
    """Points all over a plate's upper and lower face, (n, 3)."""
    along, across = np.linspace(-0.5, 0.5, _SAMPLES), np.linspace(frame.low, frame.high, _SAMPLES)
    s, w = (axis.ravel() for axis in np.meshgrid(along * frame.length, across))
    faces = (frame.from_local(s, side * frame.thickness) for side in (-0.5, 0.5))
    return np.vstack([frame.to_space(face, w) for face in faces])


def wall_clearances(body: Body, frames: tuple[PlateFrame, ...]) -> Array:
    """Least distance of each plate to a STEP body's sides and ends, (plates,), mm; < 0: outside.

    Of a plate that ends with the body, the last ``LEAST_CLEARANCE_MM`` of its span are left out: it
    may end in a flat end face there.
    """
    groups = []
    for frame in frames:
        half = 0.5 * (body.depth_mm if frame.along == "x" else body.width_mm)
        low, high = frame.low, frame.high
        low += LEAST_CLEARANCE_MM if abs(low + half) < 1e-6 else 0.0
        high -= LEAST_CLEARANCE_MM if abs(high - half) < 1e-6 else 0.0
        groups.append(_dense(replace(frame, low=low, high=high)))
    away = _to_faces(body, ("side", "end"), np.vstack(groups))
    return least_of_each(groups, away)


def core_clearance(body: Body) -> float:
    """Least distance of the core to a STEP body's sides and ends, mm; <= 0: it leaves the body.

    Sampled all through the core, for a void may lie within; in a flat face of the body's extents it
    may end, as a plate may.
    """
    core = body.core
    assert body.step is not None
    assert core is not None
    own = np.array([core.width_mm, body.core_depth_mm])
    ends = np.abs(own - [body.width_mm, body.depth_mm]) < 1e-6
    half, top = 0.5 * own - LEAST_CLEARANCE_MM * ends, core.bottom_mm + core.height_mm
    corners = (-half[0], core.bottom_mm, -half[1]), (half[0], top, half[1])
    lines = np.linspace(*corners, _CORE_SAMPLES).T
    grid = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    walls = [f.samples for f in step_facts(body.step).faces if f.name in ("side", "end")]
    x, y, z = np.vstack([np.zeros((0, 3)), *walls]).T
    within = (np.abs(x) < half[0]) & (np.abs(z) < half[1]) & (core.bottom_mm < y) & (y < top)
    if within.any():  # a void between the samples
        return 0.0
    return float(_to_faces(body, ("side", "end"), grid).min())


def _to_faces(body: Body, names: tuple[str, ...], points: Array) -> Array:
    """Distances (n,) to a STEP body's faces of these names as they end; negative beyond them."""
    assert body.step is not None
    faces = step_facts(body.step).faces
    among = np.array([face.name in names for face in faces])
    known = np.isfinite(points).all(axis=1)
    found = np.where(known, np.inf, np.nan)
    if known.any() and among.any():
        owner, signed, _, _ = nearest(faces, points[known])  # the nearest of all tells the side
        away = nearest(tuple(face for face in faces if face.name in names), points[known])[3]
        found[known] = np.where((signed > 1e-6) & among[owner], -away, away)
    return found


def least_dome_radius(body: Body, least_height: float) -> float:
    """Least ``dome_radius_mm`` for which every edge of the body is ``least_height`` high, mm.

    With s the section's sagitta (edges included), h half the depth and b the side's height over
    ``least_height``, the revolved corner has the height D - s > h, or
    y = crest - D + sqrt((D - s)^2 - h^2).
    """
    profile = profile_of(body)
    half_depth = 0.5 * body.depth_mm
    height = profile.side_height - least_height
    sagitta = profile.crest - profile.side_height
    if half_depth < height:
        return sagitta + half_depth
    return sagitta + 0.5 * height + half_depth**2 / (2.0 * height)
