"""Surfaces of a finger from its design alone: body, core, plates, gages and holes as triangles.

No CAD is made. Axes as everywhere: x tangential, y normal (crest up), z along the plates; mm.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache

import numpy as np

from fingerdesign.analysis.page.surfaces import LIFT, gage_quads
from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.body import Body
from fingerdesign.design.schema import Design
from fingerdesign.design.step import content_of
from fingerdesign.layout.bodies import surface_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import core_solid, solids_of, turned_solid
from fingerdesign.layout.outline import Profile
from fingerdesign.layout.profile import profile_of
from fingerdesign.report.figure import Figure, Triangles, fans, micrometres, triangles_of

AROUND = 36  # Facets of a turned body.
SHARP_DEG = 14.0  # Facets of one surface meet at under 7 degrees.
STEP_SHARP_DEG = 35.0  # Roundings of a STEP body are drawn by few facets.
_HOLE_CORNERS = 16
LINES, POINTS = 25, 13  # Of a STEP body's grid: along z, and on each line.
_SAMPLES = 41  # Along x and along z, to find where the surface ends.
_HALVINGS = 8  # Of a sample's width, to find the end itself.
INNER = 1.0 - 1e-4  # On the border itself a height may be missing.
_ARC_STEP_DEG = 7.0  # Between neighbouring facets: half of what counts as an edge.
_LEAST_PIECES = 4
_DOME_LINES = 11  # Along z.

Covered = Callable[[Array], BoolArray]


def finger_parts(design: Design, frames: Sequence[PlateFrame]) -> Figure:
    """The parts of :func:`~fingerdesign.report.figure.finger_in_space` of a design.

    frames: of the plates that are drawn. Raises ValueError or FingerDesignError where the body has
    no surface.
    """
    body, plates = design.body, tuple(frames)
    solid, height = body_triangles(body)
    depth = body.width_mm if body.kind.turned else body.depth_mm
    core = body.core
    return {
        "size": micrometres([body.width_mm, height, depth]),
        "body": solid.drawn(),
        "edges": solid.outline(STEP_SHARP_DEG if body.step is not None else SHARP_DEG),
        "core": core and triangles_of([core_solid(core, core.depth_mm or depth)]).drawn(),
        "plates": triangles_of(solids_of(plates)).drawn(),
        "gages": fans(gage_quads(plates, design.gages)).drawn(),
        "holes": fans(rim for frame in plates for rim in hole_rims(frame)).drawn(),
    }


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
    halves = np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]])
    return Triangles(np.concatenate([top, top * (1.0, 0.0, 1.0)]), halves)


def hole_rims(frame: PlateFrame) -> list[Array]:
    """Polygons (n, 3) just above both faces of a plate: its holes."""
    angle = 2.0 * np.pi * np.arange(_HOLE_CORNERS) / _HOLE_CORNERS
    rims = []
    for face in (1, -1):
        above = face * (0.5 * frame.thickness + LIFT)
        for hole in frame.holes:
            plane = frame.from_local(hole.s + hole.radius * np.cos(angle), above)
            rims.append(frame.to_space(plane, hole.w + hole.radius * np.sin(angle)))
    return rims


@lru_cache(maxsize=32)
def step_grid(body: Body, content: str) -> tuple[tuple[Array, Array, Array], float]:
    """x (LINES,), z and heights (LINES, POINTS) of the contact surface, and its greatest height.

    Each line along z goes from border to border, so that a round outline is drawn round; heights
    are NaN where it leaves the surface in between. ``content``: of the STEP file (a study's
    variants share theirs). Lengths in mm. ValueError where there is no surface; DesignError where
    the file cannot be read.
    """
    wide, deep = (
        0.5 * INNER * size * np.linspace(-1.0, 1.0, _SAMPLES)
        for size in (body.width_mm, body.depth_mm)
    )

    def known(x: Array, z: Array) -> BoolArray:
        return np.isfinite(surface_height(body, x, z))

    def covered(x: Array) -> BoolArray:
        return np.asarray(known(x[:, None], deep).any(axis=1))

    there = np.flatnonzero(covered(wide))
    if not len(there):
        raise ValueError("the contact surface has no height anywhere")
    left, right = (
        _border(covered, wide[[there[end]]], wide, way) for end, way in ((0, -1.0), (-1, 1.0))
    )
    x = 0.5 * (left + right) + 0.5 * (right - left) * _dense_at_ends(LINES)
    found = known(x[:, None], deep)
    near, far = (
        _border(lambda z: known(x, z), deep[end], deep, way)
        for end, way in (
            (found.argmax(axis=1), -1.0),
            (_SAMPLES - 1 - found[:, ::-1].argmax(axis=1), 1.0),
        )
    )
    z = 0.5 * (near + far)[:, None] + 0.5 * (far - near)[:, None] * _dense_at_ends(POINTS)
    heights = surface_height(body, np.broadcast_to(x[:, None], z.shape), z)
    return (x, z, heights), float(np.nanmax(heights))


def _border(known: Covered, start: Array, samples: Array, way: float) -> Array:
    """Places (n,) where ``known`` ends, from ``start`` (n,) on, within a sample's width."""
    place, step = start, 0.5 * float(samples[1] - samples[0])
    for _ in range(_HALVINGS):
        further = np.clip(place + way * step, samples[0], samples[-1])
        place = np.where(known(further), further, place)
        step *= 0.5
    return place


def _dense_at_ends(count: int) -> Array:
    """Numbers (count,) from -1 to 1, closer together near both, where a rounding comes down."""
    return np.asarray(np.sin(np.linspace(-0.5, 0.5, count) * np.pi))


def body_triangles(body: Body) -> tuple[Triangles, float]:
    """The body's surface, and its greatest height."""
    half_depth = 0.5 * body.depth_mm
    if body.step is not None:
        grid, height = step_grid(body, content_of(body.step.file))
        return grid_body(*grid), height
    profile = profile_of(body)
    half = outline_of(profile)
    if body.kind.turned:
        return triangles_of([turned_solid(half, AROUND)]), profile.crest
    x = np.concatenate([-half[::-1, 0], half[1:, 0]])
    # A vertical piece of the outline ends at the side: no two heights over one x.
    keep = np.concatenate([[True], np.diff(x) > 1e-6])
    y = np.concatenate([half[::-1, 1], half[1:, 1]])[keep]
    x = x[keep]
    lines = 2 if body.dome_radius_mm is None else _DOME_LINES
    z = np.linspace(-half_depth, half_depth, lines)
    heights = np.tile(y[:, None], lines)
    if body.dome_radius_mm is not None:
        domed = surface_height(body, x[:, None], z[None, :])
        # At the side itself the outline's closed form may just miss.
        heights = np.where(np.isfinite(domed), domed, heights)
    return grid_body(x, z, heights), profile.crest


def outline_of(profile: Profile) -> np.ndarray:
    """Points (n, 2) of half the outline, from the crest to the side, arcs in short chords."""
    points = [np.array([profile.pieces[0].start])]
    for piece in profile.pieces:
        if not piece.radius:
            points.append(np.array([piece.end]))
            continue
        first, last = (
            float(np.arctan2(x - piece.x, y - piece.y)) for x, y in (piece.start, piece.end)
        )
        count = max(_LEAST_PIECES, int(np.ceil(np.degrees(last - first) / _ARC_STEP_DEG)))
        angle = np.linspace(first, last, count + 1)[1:]
        points.append(
            np.column_stack([piece.x, piece.y])
            + piece.radius * np.column_stack([np.sin(angle), np.cos(angle)])
        )
    return np.vstack(points)
