"""The section's outline as a 2-D mesher wants it: points, curves, domains and sizes (no mesher).

The body's own outline (layout/profile.py) and its core; section.py adds the plates.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.schema import Body
from fingerdesign.layout.outline import Piece
from fingerdesign.layout.profile import profile_of

BODY = 1  # domain numbers: the body, then plate k as BODY + 1 + k, the core after the last plate
_LEAST_LENGTH = 1e-9  # mm: an edge's rounding may be of no length where the arc ends upright
_ARC_STEP = 0.25  # radians of an arc that one edge may span, wherever it lies


@dataclass
class Outline:
    """points (x, y, size or None); curves (points of a line or of a rational quadratic spline, left
    domain, right domain, size; 0 is outside); domains (number, size). Lengths in mm."""

    far_size: float
    gradation: float
    points: list[tuple[float, float, float | None]] = field(default_factory=list)
    curves: list[tuple[list[int], int, int, float]] = field(default_factory=list)
    domains: list[tuple[int, float]] = field(default_factory=list)

    def point(self, x: float, y: float, size: float | None = None) -> int:
        """Add a point and return its number."""
        self.points.append((float(x), float(y), size))
        return len(self.points) - 1

    def curve(self, points: list[int], left: int, right: int, size: float) -> None:
        """Add a line (two points) or a spline (end, control, end)."""
        self.curves.append((points, left, right, size))

    def arc(self, ends: tuple[int, int], centre: Array, left: int, right: int, size: float) -> None:
        """Add an arc about ``centre`` of less than half a turn between two points.

        The control point is where the end tangents meet: it makes the rational spline a circle.
        """
        a, b = (np.array(self.points[end][:2]) - centre for end in ends)
        meet = centre + (a + b) * (a @ a) / (a @ a + a @ b)
        self.curve([ends[0], self.point(*meet), ends[1]], left, right, size)


@dataclass(frozen=True)
class CoreBox:
    """A core's section: |x| <= half_width, bottom <= y <= top; its domain number."""

    half_width: float
    bottom: float
    top: float
    domain: int


def core_box(body: Body, region: int) -> CoreBox | None:
    """The section of a body's core, which is region ``region`` of its meshes; None without one."""
    core = body.core
    if core is None:
        return None
    top = core.bottom_mm + core.height_mm
    return CoreBox(0.5 * core.width_mm, core.bottom_mm, top, BODY + region)


@dataclass(frozen=True)
class ContactSizes:
    """Edges on the contact surface, mm: ``sizes[k]`` over |x| <= ``reaches[k]``, both ascending;
    ``far`` beyond."""

    reaches: tuple[float, ...]
    sizes: tuple[float, ...]
    far: float

    def at(self, x: float) -> float:
        """The edge length at |x|, mm."""
        found = (size for reach, size in zip(self.reaches, self.sizes, strict=True) if x <= reach)
        return next(found, self.far)


def body_outline(
    body: Body, contact: ContactSizes, sizes: SectionMesh, core: CoreBox | None
) -> Outline:
    """A parametric body and its core, fine at the contact."""
    outline = Outline(sizes.far_size_mm, sizes.gradation)
    profile = profile_of(body)
    half, side = profile.half_width, profile.side_height
    # On the outside from the left upper corner down, along the base and up the right side.
    corners = [(-half, side), *_left_side(half, side, core), *_base(half, core)]
    corners += [(-x, y) for x, y in _left_side(half, side, core)[::-1]] + [(half, side)]
    numbers = {corner: outline.point(*corner) for corner in corners}
    for a, b in pairwise(corners):
        domain = core.domain if core is not None and _on_core(a, b, core) else BODY
        outline.curve([numbers[a], numbers[b]], domain, 0, sizes.far_size_mm)
    if core is not None:
        _add_core(outline, numbers, core, half, sizes)
    pieces = [piece for piece in profile.pieces if piece.length > _LEAST_LENGTH]
    for reach, size in zip(contact.reaches, contact.sizes, strict=True):
        pieces = [part for piece in pieces for part in _cut(piece, reach, size)]
    _add_top(outline, pieces, (numbers[half, side], numbers[-half, side]), contact)
    return outline


def _add_top(
    outline: Outline, pieces: Sequence[Piece], ends: tuple[int, int], contact: ContactSizes
) -> None:
    """The top from its right end over the crest to its left end; pieces: of the right half, from
    the crest outward."""
    right = [ends[0], *(outline.point(*piece.start) for piece in pieces[::-1])]
    for pair, piece in zip(pairwise(right), pieces[::-1], strict=True):
        _add_piece(outline, pair, piece, 1.0, contact)
    start = right[-1]
    for number, piece in enumerate(pieces):
        last = number == len(pieces) - 1
        x, y = piece.end
        end = ends[1] if last else outline.point(-x, y)
        _add_piece(outline, (start, end), piece, -1.0, contact)
        start = end


def _left_side(half: float, side: float, core: CoreBox | None) -> list[tuple[float, float]]:
    """Vertices of the left side below its upper corner, downward, without the base's corner."""
    if core is None or core.half_width < half - 1e-9:
        return []
    return [(-half, y) for y in (core.top, core.bottom) if 0.0 < y < side]


def _base(half: float, core: CoreBox | None) -> list[tuple[float, float]]:
    places = [-half, half]
    if core is not None and core.bottom == 0.0 and core.half_width < half - 1e-9:
        places[1:1] = [-core.half_width, core.half_width]
    return [(x, 0.0) for x in places]


def _on_core(a: tuple[float, float], b: tuple[float, float], core: CoreBox) -> bool:
    """True where a line of the outside bounds the core."""
    x, y = 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1])
    return abs(x) <= core.half_width + 1e-9 and core.bottom - 1e-9 <= y <= core.top


def _add_core(
    outline: Outline,
    numbers: dict[tuple[float, float], int],
    core: CoreBox,
    half: float,
    sizes: SectionMesh,
) -> None:
    """The core's faces inside the body; those on the outside are the outside's own lines."""
    free = core.half_width < half - 1e-9
    x = core.half_width if free else half
    corners = [(-x, core.bottom), (x, core.bottom), (x, core.top), (-x, core.top)]
    for corner in corners:
        if corner not in numbers:
            numbers[corner] = outline.point(*corner, sizes.plate_size_mm)
    inside = (core.bottom > 0.0, free, True, free)
    for k, target in enumerate(inside):
        if target:
            ends = [numbers[corners[k]], numbers[corners[(k + 1) % 4]]]
            outline.curve(ends, core.domain, BODY, sizes.far_size_mm)
    outline.domains.append((core.domain, sizes.far_size_mm))


def _cut(piece: Piece, zone: float, size: float) -> list[Piece]:
    """A piece in two where the zone ends well inside it."""
    if not piece.start[0] + 0.5 * size < zone < piece.end[0] - 0.5 * size:
        return [piece]
    at = (zone, float(piece.height(np.array([zone]))[0]))
    circle = (piece.x, piece.y, piece.radius)
    return [Piece(piece.start, at, *circle), Piece(at, piece.end, *circle)]


def _add_piece(
    outline: Outline, ends: tuple[int, int], piece: Piece, side: float, contact: ContactSizes
) -> None:
    """A piece of the contact surface, on the right (side 1) or mirrored (-1)."""
    size = contact.at(0.5 * (piece.start[0] + piece.end[0]))
    if not piece.radius:
        outline.curve(list(ends), BODY, 0, size)
        return
    centre = np.array([side * piece.x, piece.y])
    outline.arc(ends, centre, BODY, 0, min(size, _ARC_STEP * piece.radius))
