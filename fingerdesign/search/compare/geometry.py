"""The shape of a finger as the comparison page draws it: outline, plates, gages, in under 5 kB.

Numpy only; no CAD is made. The page's scripts (templates/compare_solid.js) build polygons of it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.analysis.page.words import finger_words
from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.design.step import content_of
from fingerdesign.errors import FingerDesignError
from fingerdesign.layout.frames import plate_frames, surface_height
from fingerdesign.layout.profile import profile_of

if TYPE_CHECKING:
    from fingerdesign.design.body import Body, Core
    from fingerdesign.design.schema import Design
    from fingerdesign.layout.frames import PlateFrame
    from fingerdesign.layout.profile import Profile


# The contact surface of a STEP body as a few lines of heights, for the comparison page.

Known = Callable[[Array], NDArray[np.bool_]]

LINES, POINTS = 25, 13  # of the grid: along z, and on each line
_SAMPLES = 41  # along x and along z, to find where the surface ends
_HALVINGS = 8  # of a sample's width, to find the end itself
_INNER = 1.0 - 1e-4  # on the border itself a height may be missing


@lru_cache(maxsize=32)
def step_grid(body: Body, content: str) -> tuple[tuple[Array, Array, Array], float]:
    """x (LINES,), z and heights (LINES, POINTS) of the contact surface, and its greatest height.

    Each line along z goes from border to border, so that a round outline is drawn round; where one
    leaves the surface in between, all lines go over the whole depth, and heights are NaN there.
    ``content``: of the STEP file (a study's variants share theirs). Lengths in mm. ValueError where
    there is no surface; DesignError where the file cannot be read.
    """
    wide, deep = (
        0.5 * _INNER * size * np.linspace(-1.0, 1.0, _SAMPLES)
        for size in (body.width_mm, body.depth_mm)
    )

    def covered(x: Array) -> NDArray[np.bool_]:
        return np.isfinite(surface_height(body, x[:, None], deep[None, :]))

    there = np.flatnonzero(covered(wide).any(axis=1))
    if not len(there):
        raise ValueError("the contact surface has no height anywhere")

    def any_covered(x: Array) -> NDArray[np.bool_]:
        return np.asarray(covered(x).any(axis=1))

    left, right = (
        _border(any_covered, wide[[end]], wide, way)
        for end, way in ((there[0], -1.0), (there[-1], 1.0))
    )
    x = 0.5 * (left + right) + 0.5 * (right - left) * _dense_at_ends(LINES)
    known = covered(x)
    first, last = known.argmax(axis=1), _SAMPLES - 1 - known[:, ::-1].argmax(axis=1)
    places = np.arange(_SAMPLES)
    if (known == (places >= first[:, None]) & (places <= last[:, None])).all():

        def on_surface(z: Array) -> NDArray[np.bool_]:
            return np.isfinite(surface_height(body, x, z))

        near = _border(on_surface, deep[first], deep, -1.0)
        far = _border(on_surface, deep[last], deep, 1.0)
    else:
        near, far = np.full(LINES, deep[0]), np.full(LINES, deep[-1])
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


# What the page inlines for the views of two designs, in this order (report/templates).
COMPARE_VIEW_SCRIPTS = (
    "compare_draw.js",
    "compare_solid.js",
    "compare_patch.js",
    "compare_3d.js",
    "compare_contact.js",
    "compare_gages.js",
    "compare_forces.js",
    "compare_views.js",
    "compare_parallel.js",
)
COMPARE_VIEW_STYLES = ("compare_views.css",)

Packed = dict[str, Any]

MOST_PLATES = 150  # drawn; the order in which plates hide each other is found pair by pair
_ARC_STEP_DEG = 7.0  # between neighbouring facets; the page draws an edge from 14 degrees on
_LEAST_PIECES = 4
_DOME_LINES = 11  # along z
_STEP_SHARP_DEG = 35.0  # roundings of its own are drawn by few facets
_DIGITS = 3  # micrometres


def packed_geometry(design: Mapping[str, Any]) -> Packed:
    """What is drawn of a design (its TOML data), JSON-ready; lengths in mm, angles in degrees.

    words   the finger in sentences: the drawing's text alternative
    note    what the drawing leaves out, or why there is none; "" otherwise
    size    extents along x, y, z
    body    one of {"grid": [x.., z.. (of all, or of each height), heights over each x, row by row
            (null: none)], "sharp_deg": from what angle edges are drawn; absent: 14},
            {"rings": [r, y, ...]} (half of a body turned about y, crest outward)
    core    [x0, x1, y0, y1, z0, z1] or null
    plates  [place, y, angle, length, thickness, low, high, 1 if along z, bend radius or 0,
            hole radius or 0, places of the holes across...] each, as in design.layout.PlateFrame
    gages   {length, width, z, upper, lower}: on each plate, and on which faces

    Never raises for what a design may be: where it cannot be drawn there is no body, and a note.
    """
    from pydantic import ValidationError

    try:
        found = Design.model_validate(_shaping(design))
    except ValidationError:
        return _nothing("", "The design's data is not a whole design: it cannot be drawn.")
    words = finger_words(dict(_dotted(found.model_dump(mode="json"))))
    try:
        return _packed(found, words)
    except (FingerDesignError, ValueError):
        step = found.body.step is not None
        why = "its STEP file cannot be read here" if step else "its outline does not close"
        return _nothing(words, f"The finger is not drawn: {why}.")


def _packed(design: Design, words: str) -> Packed:
    body = design.body
    outline, height = _body(body)
    width, depth = body.width_mm, body.width_mm if body.shape == "revolved" else body.depth_mm
    notes = []
    if body.shape == "step":
        notes.append("Of the STEP body its contact surface is drawn, with straight sides below.")
    frames = [each for each in plate_frames(design) if np.isfinite([each.place, each.y]).all()]
    if len(frames) > MOST_PLATES:
        notes.append(f"Of {len(frames)} plates the first {MOST_PLATES} are drawn.")
    gages = design.gages
    return {
        "words": words,
        "note": " ".join(notes),
        "size": _rounded([width, height, depth]),
        "body": outline,
        "core": _core(body.core, depth),
        "plates": [_plate(frame) for frame in frames[:MOST_PLATES]],
        "gages": {
            "length": gages.length_mm,
            "width": gages.width_mm,
            "z": gages.z_mm,
            "upper": gages.face != "lower",
            "lower": gages.face != "upper",
        },
    }


def _nothing(words: str, note: str) -> Packed:
    return {
        "words": words,
        "note": note,
        "size": [1.0, 1.0, 1.0],
        "body": None,
        "core": None,
        "plates": [],
        "gages": None,
    }


def _body(body: Body) -> tuple[Packed, float]:
    """The body's outline, and its greatest height."""
    half_depth = 0.5 * body.depth_mm
    if body.step is not None:
        grid, height = step_grid(body, content_of(body.step.file))
        return {
            "grid": [_rounded(each.ravel()) for each in grid],
            "sharp_deg": _STEP_SHARP_DEG,
        }, height
    profile = profile_of(body)
    half = outline_of(profile)
    if body.shape == "revolved":
        return {"rings": _rounded(half.ravel())}, profile.crest
    x = np.concatenate([-half[::-1, 0], half[1:, 0]])
    # A vertical piece of the outline ends at the side: no two heights over one x.
    keep = np.concatenate([[True], np.diff(x) > 1e-6])
    y = np.concatenate([half[::-1, 1], half[1:, 1]])[keep]
    x = x[keep]
    lines = 2 if body.dome_radius_mm is None else _DOME_LINES
    z = np.linspace(-half_depth, half_depth, lines)
    if body.dome_radius_mm is None:
        heights = np.tile(y[:, None], 2)
    else:
        heights = surface_height(body, x[:, None], z[None, :])
        # At the side itself the outline's closed form may just miss.
        heights = np.where(np.isfinite(heights), heights, y[:, None])
    return {"grid": [_rounded(x), _rounded(z), _rounded(heights.ravel())]}, profile.crest


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


def _core(core: Core | None, depth: float) -> list[float] | None:
    if core is None:
        return None
    deep = 0.5 * (depth if core.depth_mm is None else core.depth_mm)
    half = 0.5 * core.width_mm
    ends = [-half, half, core.bottom_mm, core.bottom_mm + core.height_mm, -deep, deep]
    return [float(end) for end in ends]


def _plate(frame: PlateFrame) -> list[float | None]:
    radius = frame.holes[0].radius if frame.holes else 0.0
    numbers = (frame.place, frame.y, frame.angle_deg, frame.length, frame.thickness)
    ends = (frame.low, frame.high, float(frame.along == "z"), frame.bend_radius or 0.0, radius)
    return _rounded([*numbers, *ends, *(hole.w for hole in frame.holes)])


def _rounded(values: Any) -> list[float | None]:
    """To micrometres; None where there is no number; whole numbers without a point."""
    found = []
    for value in np.asarray(values, dtype=float).tolist():
        near = round(value, _DIGITS) if np.isfinite(value) else None
        found.append(int(near) if near is not None and near == int(near) else near)
    return found


def _dotted(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from _dotted(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def _shaping(design: Mapping[str, Any]) -> dict[str, Any]:
    """The tables that decide the shape: what a later version adds to others does not hinder."""
    shaping = ("design", "body", "plates", "gages", "materials")
    return {key: design[key] for key in shaping if key in design}
