"""The shape of a finger as the comparison page draws it: triangles, edges, and where it is touched.

No CAD is made.
"""

from collections.abc import Callable, Mapping
from functools import lru_cache
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.analysis.page.finger import LIFT, gage_quads
from fingerdesign.analysis.page.sketch import facts
from fingerdesign.arrays import Array
from fingerdesign.design.body import Body
from fingerdesign.design.schema import Design
from fingerdesign.design.step import content_of
from fingerdesign.errors import FingerDesignError
from fingerdesign.layout.bodies import surface_height
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import core_solid, solids_of, turned_solid
from fingerdesign.layout.outline import Profile
from fingerdesign.layout.profile import profile_of
from fingerdesign.layout.rows import plate_frames
from fingerdesign.records.outcome import Traces
from fingerdesign.report.figure import Triangles, fans, micrometres, places, triangles_of

# A finger's body, core and plates as triangles, for the comparison page's view in space.
#
# Axes as everywhere: x tangential, y normal (crest up), z along the plates; mm.

AROUND = 36  # facets of a turned body
SHARP_DEG = 14.0  # facets of one surface meet at under 7 degrees
_HOLE_CORNERS = 16


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


# The contact surface of a STEP body as a few lines of heights, for the comparison page.

Known = Callable[[Array], NDArray[np.bool_]]

LINES, POINTS = 25, 13  # of the grid: along z, and on each line
_SAMPLES = 41  # along x and along z, to find where the surface ends
_HALVINGS = 8  # of a sample's width, to find the end itself
_INNER = 1.0 - 1e-4  # on the border itself a height may be missing


@lru_cache(maxsize=32)
def step_grid(body: Body, content: str) -> tuple[tuple[Array, Array, Array], float]:
    """x (LINES,), z and heights (LINES, POINTS) of the contact surface, and its greatest height.

    Each line along z goes from border to border, so that a round outline is drawn round; heights
    are NaN where it leaves the surface in between. ``content``: of the STEP file (a study's
    variants share theirs). Lengths in mm. ValueError where there is no surface; DesignError where
    the file cannot be read.
    """
    wide, deep = (
        0.5 * _INNER * size * np.linspace(-1.0, 1.0, _SAMPLES)
        for size in (body.width_mm, body.depth_mm)
    )

    def known(x: Array, z: Array) -> NDArray[np.bool_]:
        return np.isfinite(surface_height(body, x, z))

    def covered(x: Array) -> NDArray[np.bool_]:
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


def _border(known: Known, start: Array, samples: Array, way: float) -> Array:
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


Packed = dict[str, Any]

MOST_PLATES = 150  # drawn
_ARC_STEP_DEG = 7.0  # between neighbouring facets, half of what counts as an edge
_LEAST_PIECES = 4
_DOME_LINES = 11  # along z
_STEP_SHARP_DEG = 35.0  # roundings of its own are drawn by few facets
_CONTACT_LIFT = 0.03  # mm of what touches above the drawn surface


def packed_geometry(design: Mapping[str, Any], traces: Traces | None = None) -> Packed:
    """What is drawn of a design (its TOML data), JSON-ready; lengths in mm.

    words   the finger in sentences: the drawing's text alternative
    note    what the drawing leaves out, or why there is none; "" otherwise
    size    extents along x, y, z
    body, core, plates, gages, holes
            triangles {x, y, z (of the vertices), i, j, k (of the triangles)}, None: there is none
    edges   {x, y, z}: lines along the body's sharp edges, with None between two of them
    touch   {places: {x, y, z}, each}: for every contact point of ``traces`` ``each`` places on the
            surface, one after another; in plane strain a line along z

    Never raises for what a design may be: where it cannot be drawn there is no body, and a note.
    """
    from pydantic import ValidationError

    try:
        # The tables that decide the shape: what a later version adds to others does not hinder.
        shaping = {"design", "body", "plates", "gages", "materials"} & design.keys()
        found = Design.model_validate({key: design[key] for key in shaping})
    except ValidationError:
        return _nothing("", "The design's data is not a whole design: it cannot be drawn.")
    words = "; ".join(each.strip() for each in facts(found))
    try:
        return _packed(found, words, traces or Traces())
    except (FingerDesignError, ValueError):
        step = found.body.step is not None
        why = "its STEP file cannot be read here" if step else "its outline does not close"
        return _nothing(words, f"The finger is not drawn: {why}.")


def _packed(design: Design, words: str, traces: Traces) -> Packed:
    body = design.body
    solid, height = body_triangles(body)
    width, depth = body.width_mm, body.width_mm if body.kind.turned else body.depth_mm
    notes, core = [], body.core
    if body.shape == "step":
        notes.append("Of the STEP body its contact surface is drawn, with straight sides below.")
    frames = [each for each in plate_frames(design) if np.isfinite([each.place, each.y]).all()]
    if len(frames) > MOST_PLATES:
        notes.append(f"Of {len(frames)} plates the first {MOST_PLATES} are drawn.")
        frames = frames[:MOST_PLATES]
    return {
        "words": words,
        "note": " ".join(notes),
        "size": micrometres([width, height, depth]),
        "body": solid.drawn(),
        "edges": solid.outline(_STEP_SHARP_DEG if body.step is not None else SHARP_DEG),
        "core": core and triangles_of([core_solid(core, core.depth_mm or depth)]).drawn(),
        "plates": triangles_of(solids_of(tuple(frames))).drawn(),
        "gages": fans(gage_quads(tuple(frames), design.gages)).drawn(),
        "holes": fans(rim for frame in frames for rim in hole_rims(frame)).drawn(),
        "touch": _touched(body, depth, traces),
    }


def _nothing(words: str, note: str) -> Packed:
    drawn = ("body", "edges", "core", "plates", "gages", "holes", "touch")
    return {"words": words, "note": note, "size": [1.0, 1.0, 1.0], **dict.fromkeys(drawn)}


def _touched(body: Body, depth: float, traces: Traces) -> Packed | None:
    """Where the contact points lie on the surface, a little above it; lines along z in 2-D."""
    x = np.array(traces.contact_x_mm, dtype=float)
    if not len(x) or not traces.status:
        return None
    if traces.contact_z_mm:
        z = np.array(traces.contact_z_mm, dtype=float)[:, None]
        if (z >= -1e-9).all():  # a model of the half z >= 0 alone is its own mirror image
            z = np.concatenate([z, -z], axis=1)
    else:
        straight = body.step is None and body.shape != "revolved" and body.dome_radius_mm is None
        across = np.linspace(-1.0, 1.0, 2 if straight else POINTS)
        far = np.full(len(x), 0.5 * depth)
        if body.shape == "revolved":
            far = np.sqrt(np.maximum(0.0, far**2 - x**2))
        z = _INNER * far[:, None] * across
    height = surface_height(body, x[:, None], z)
    points = np.stack([np.broadcast_to(x[:, None], z.shape), height + _CONTACT_LIFT, z], axis=-1)
    return {"places": places(points.reshape(-1, 3)), "each": z.shape[1]}


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
