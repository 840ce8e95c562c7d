"""Sections that mirror in x = 0 are meshed by their half; of two mirror images one is meshed.

So a mirrored scene, or a mirrored finger, has a mirrored mesh, and its answer is the mirrored one
to rounding. Free meshers do not do that of themselves: their front starts somewhere. What is swept
mirrors too, but for one thing: beyond the ends of a sheet that is upright in x = 0 a few prisms
lie across the axis, and are cut to one side.
"""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.section.outline import Outline
from fingerdesign.mesh.section.size_field import SectionSize

_DIGITS = 10  # of lengths in mm and angles in degrees that are one
_ON = 1e-9  # mm: points that lie on x = 0

Drawn = tuple[float, ...]


def drawn_as(frame: PlateFrame) -> Drawn:
    """The part of a plate that the section shows: angle, place, height, length, thickness, bend. A
    flat plate turned by half a turn is the same one."""
    turn = 180.0 if frame.bend_radius is None else 360.0
    angle = round((frame.angle_deg + 0.5 * turn) % turn - 0.5 * turn, _DIGITS) % turn
    values = (frame.place, frame.y, frame.length, frame.thickness, frame.bend_radius or 0.0)
    return (angle, *(round(value, _DIGITS) + 0.0 for value in values))


def mirrored_frame(frame: PlateFrame) -> PlateFrame:
    """A plate's mirror image in x = 0; its upper side stays the upper one."""
    return replace(frame, place=-frame.place, angle_deg=-frame.angle_deg)


def partners(frames: Sequence[PlateFrame]) -> IntArray | None:
    """The place (n,) among ``frames`` of each one's mirror image; None where one has none."""
    drawn = {drawn_as(frame): k for k, frame in enumerate(frames)}
    found = [drawn.get(drawn_as(mirrored_frame(frame)), -1) for frame in frames]
    return None if -1 in found else np.array(found, dtype=np.int64)


def to_draw(frames: Sequence[PlateFrame]) -> tuple[tuple[PlateFrame, ...], float]:
    """The plates from - to +, and 1; or their mirror images, and -1, where those come first.

    The same of a finger and of its mirror image: which of the two is drawn does not matter.
    """
    own = sorted(frames, key=_from_left)
    other = sorted((mirrored_frame(frame) for frame in frames), key=_from_left)
    first = [drawn_as(frame) for frame in own] <= [drawn_as(frame) for frame in other]
    return (tuple(own), 1.0) if first else (tuple(other), -1.0)


def _from_left(frame: PlateFrame) -> Drawn:
    angle, place, *others = drawn_as(frame)
    return (place, angle, *others)


def half_of(outline: Outline) -> Outline:
    """The half x >= 0 of an outline that mirrors in x = 0, closed along the axis."""
    half = Outline(outline.far_size, outline.gradation)
    numbers: dict[int, int] = {}
    above: dict[int, int] = {}  # the domain above a point of the axis at which curves begin or end

    def copied(number: int) -> int:
        if number not in numbers:
            x, y, size = outline.points[number]
            numbers[number] = half.point(0.0 if abs(x) <= _ON else x, y, size)
        return numbers[number]

    for points, left, right, size in outline.curves:
        start, end = points[0], points[-1]
        a, b = (_side(outline, number) for number in (start, end))
        if a == b == 0:
            for number in (start, end):
                above.setdefault(copied(number), -1)
        elif a >= 0 and b >= 0:
            half.curve([copied(number) for number in points], left, right, size)
            if a * b == 0:
                above[copied(end if b == 0 else start)] = left if a == 0 else right
        elif max(a, b) > 0:
            at = half.point(0.0, _crossed(outline, points))
            ends = (copied(start), at) if a > 0 else (at, copied(end))
            centre = None if len(points) == 2 else _centre(outline, points)
            _add_part(half, ends, centre, (left, right), size)
            above[at] = left if b > 0 else right
    _close(half, above, SectionSize(outline))
    used = {domain for _, *sides, _ in half.curves for domain in sides}
    half.domains = [(domain, size) for domain, size in outline.domains if domain in used]
    return half


def _add_part(
    half: Outline, ends: tuple[int, int], centre: Array | None, sides: tuple[int, int], size: float
) -> None:
    """Add the part of a curve that lies in the half: a line, or an arc around ``centre``."""
    if centre is None:
        half.curve(list(ends), *sides, size)
        return
    # A whole number of edges fills half of an arc: rounded down, they would be longer than those of
    # the whole arc.
    (x, y), (u, v) = (half.points[number][:2] for number in ends)
    chord = float(np.hypot(u - x, v - y))
    half.arc(ends, centre, *sides, chord / float(np.ceil(chord / size)))


def _side(outline: Outline, number: int) -> int:
    """1 right of the axis, 0 on it, -1 left of it."""
    x = outline.points[number][0]
    return 0 if abs(x) <= _ON else int(np.sign(x))


def _centre(outline: Outline, points: Sequence[int]) -> Array:
    """The centre (2,) of an arc that mirrors in the axis: where the normal at an end crosses it."""
    (x, y), (_, meet) = (outline.points[number][:2] for number in points[:2])
    return np.array([0.0, y - x * x / (meet - y)])


def _crossed(outline: Outline, points: Sequence[int]) -> float:
    """Height at which a curve that mirrors in the axis crosses it."""
    x, y, _ = outline.points[points[0]]
    if len(points) == 2:
        other = outline.points[points[1]]
        return y + (other[1] - y) * x / (x - other[0])
    centre = float(_centre(outline, points)[1])
    return centre + float(np.copysign(np.hypot(x, y - centre), y - centre))


def _close(half: Outline, above: dict[int, int], size: SectionSize) -> None:
    """Add the axis to a half, downward: the half is on its left.

    Its edges have the size of the elements around them: netgen divides a curve by what is set for
    the curve itself, and would lay needles between a coarse axis and a fine contact.
    """
    upward = sorted(above, key=lambda number: half.points[number][1])
    domain, lines = 0, []
    for low, high in pairwise(upward):
        domain = above[low] if above[low] >= 0 else domain
        between = [half.point(0.0, y, h) for y, h in _graded(half, low, high, size)]
        lines += [(pair, domain) for pair in pairwise([high, *between, low])]
    for (start, end), domain in lines:
        long = half.points[start][1] - half.points[end][1]
        half.curve([start, end], domain, 0, long)


def _graded(half: Outline, low: int, high: int, size: SectionSize) -> list[tuple[float, float]]:
    """Heights, downward, that divide the axis between two points by a size field, and the sizes."""
    top, bottom = (half.points[number][1] for number in (high, low))
    walked = [top]
    while walked[-1] > bottom:
        walked.append(walked[-1] - float(size(np.array([[0.0, walked[-1]]]))[0]))
    last = (walked[-2] - bottom) / (walked[-2] - walked[-1])
    counts = np.append(np.arange(len(walked) - 1), len(walked) - 2 + last)
    parts = max(1, round(float(counts[-1])))
    shares = counts[-1] * np.arange(1, parts) / parts
    heights = np.interp(shares, counts, [*walked[:-1], bottom])
    points = np.column_stack([np.zeros(len(heights)), heights])
    return list(zip(heights.tolist(), size(points).tolist(), strict=True))


def mirrored(
    points: Array, triangles: IntArray, regions: IntArray, other: IntArray
) -> tuple[Array, IntArray, IntArray]:
    """A linear mesh (n, 2), (t, 3), (t,) whose left half is the mirror image of its right one.

    Of the mesh given, a half or the whole, only what lies right counts, and triangles across the
    axis. other (r,): a region's mirror image. Points on the axis come first, then the right ones,
    then the left ones in the same order: so what depends on the order of an edge's ends is
    the same on both sides.
    """
    points = points.copy()
    points[np.abs(points[:, 0]) <= _ON, 0] = 0.0
    x = points[:, 0]
    most, least = x[triangles].max(axis=1), x[triangles].min(axis=1)
    right, across = least >= 0.0, (least < 0.0) & (most > 0.0)
    axis, own = (np.flatnonzero(each) for each in (x == 0.0, x > 0.0))
    own = own[np.isin(own, triangles)]
    axis = axis[np.isin(axis, triangles)]
    new = np.full(len(points), -1)
    new[axis], new[own] = np.arange(len(axis)), len(axis) + np.arange(len(own))
    image = np.arange(len(axis) + 2 * len(own))
    image[len(axis) : len(axis) + len(own)] += len(own)
    for node in np.unique(triangles[across][x[triangles[across]] < 0.0]):
        away = np.hypot(*(points[own] - points[node] * [-1.0, 1.0]).T)
        new[node] = image[new[own[np.argmin(away)]]]
    placed = np.vstack([points[axis], points[own], points[own] * [-1.0, 1.0]])
    drawn = new[triangles[right]]
    cells = [drawn, image[drawn][:, ::-1], new[triangles[across]]]
    numbers = [regions[right], other[regions[right]], regions[across]]
    return placed, np.vstack(cells), np.concatenate(numbers)
