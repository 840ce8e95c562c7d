"""Where things lie: the plates' frames and the body's heights, in closed form (numpy only).

Axes: x tangential, y normal (base at y = 0, crest toward +y), z along the plates, mid-plane z = 0.
Lengths in mm, angles anticlockwise from the row's axis (+x, or +z for rows along z).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from pydantic import ValidationError

from fingerdesign.arrays import Array
from fingerdesign.design.body import Body
from fingerdesign.design.faults import set_value
from fingerdesign.design.plates import PlateLayout, Plates, plate_layout
from fingerdesign.design.schema import Design
from fingerdesign.design.step import StepFacts, step_facts
from fingerdesign.layout.profile import profile_of


@dataclass(frozen=True)
class Hole:
    """A round hole through a plate: middle (s along the axis, w across the row), radius; mm."""

    s: float
    w: float
    radius: float


@dataclass(frozen=True)
class PlateFrame:
    """One plate: a box of ``length`` along ``axis``, ``thickness`` along ``normal``, and its span.

    The plate is drawn in a section plane and extends ``low`` to ``high`` across it. ``along`` "x":
    the section plane is (x, y) and the span runs along z; "z": the plane is (z, y), the span runs
    along x. (``place``, ``y``) is the centre in that plane; ``axis`` is at ``angle_deg``
    anticlockwise from the plane's first axis, ``normal`` 90 degrees anticlockwise from ``axis``
    (the *upper* side). ``bend_radius``: of the mid-surface, whose centre of curvature lies below,
    along -normal; None: flat. ``length`` is measured along the mid-surface. Local coordinates are
    (s along it from the centre, v along the normal, w across from z = 0 or x = 0).
    """

    index: int
    place: float
    y: float
    angle_deg: float
    length: float
    thickness: float
    low: float
    high: float
    along: str = "x"
    bend_radius: float | None = None
    holes: tuple[Hole, ...] = ()

    @property
    def x(self) -> float:
        """x of the centre, mm."""
        return self.place if self.along == "x" else 0.5 * (self.low + self.high)

    @property
    def z(self) -> float:
        """z of the centre, mm."""
        return self.place if self.along == "z" else 0.5 * (self.low + self.high)

    @property
    def middle(self) -> float:
        """The span's middle, mm: z of a plate along x, x of one along z."""
        return 0.5 * (self.low + self.high)

    @property
    def span(self) -> float:
        """Extent across the section plane, mm."""
        return self.high - self.low

    @property
    def axis(self) -> Array:
        """Unit vector along the plate at its centre, in its section plane, shape (2,)."""
        angle = np.radians(self.angle_deg)
        return np.array([np.cos(angle), np.sin(angle)])

    @property
    def normal(self) -> Array:
        """Unit vector toward the upper side at the centre, in the section plane, shape (2,)."""
        axis = self.axis
        return np.array([-axis[1], axis[0]])

    @property
    def centre(self) -> Array:
        """The centre in the section plane, shape (2,)."""
        return np.array([self.place, self.y])

    def across(self, points: Array) -> Array:
        """Coordinates (n,) of points (n, 3) across the section plane."""
        return np.asarray(points[:, 2 if self.along == "x" else 0])

    def to_space(self, plane: Array, across: Array | float) -> Array:
        """Points (n, 3) of section-plane points (n, 2) at ``across`` (n,)."""
        plane = np.atleast_2d(plane)
        across = np.broadcast_to(np.asarray(across, dtype=float), len(plane))
        columns = (plane[:, 0], plane[:, 1], across)
        order = columns if self.along == "x" else (across, plane[:, 1], plane[:, 0])
        return np.column_stack(order)

    def direction(self, vector: Array) -> Array:
        """A section-plane direction (2,) or (n, 2) as one in space, (3,) or (n, 3)."""
        zero = np.zeros_like(vector[..., 0])
        parts = (vector[..., 0], vector[..., 1], zero)
        order = parts if self.along == "x" else (zero, vector[..., 1], vector[..., 0])
        return np.stack(order, axis=-1)

    def local(self, points: Array) -> Array:
        """Coordinates (s along the mid-surface, v along the normal), (n, 2), from the centre, of
        points (n, 3), or (n, 2) in the section plane."""
        turned = points.shape[1] == 3 and self.along == "z"
        offset = points[:, [2, 1] if turned else [0, 1]] - self.centre
        s, v = offset @ self.axis, offset @ self.normal
        if self.bend_radius is not None:
            rise = v + self.bend_radius
            s = self.bend_radius * np.arctan2(s, rise)
            v = np.hypot(offset @ self.axis, rise) - self.bend_radius
        return np.stack([s, v], axis=1)

    def from_local(self, s: Array | float, v: Array | float) -> Array:
        """Section-plane points (n, 2) at local coordinates s, v (n,)."""
        s, v = np.broadcast_arrays(np.atleast_1d(np.asarray(s, dtype=float)), v)
        if self.bend_radius is not None:
            radius = self.bend_radius + v
            angle = s / self.bend_radius
            s, v = radius * np.sin(angle), radius * np.cos(angle) - self.bend_radius
        return np.asarray(self.centre + s[:, None] * self.axis + v[:, None] * self.normal)

    def tangent(self, s: float) -> Array:
        """Unit vector along the mid-surface at ``s``, in the section plane, shape (2,)."""
        if self.bend_radius is None:
            return self.axis
        angle = s / self.bend_radius
        return np.asarray(np.cos(angle) * self.axis - np.sin(angle) * self.normal)

    def corners(self) -> Array:
        """Section corners, anticlockwise from the lower near end, shape (4, 2)."""
        s, v = 0.5 * self.length, 0.5 * self.thickness
        return self.from_local(np.array([-s, s, s, -s]), np.array([-v, -v, v, v]))

    def outline(self, pieces: int = 16) -> Array:
        """Section polygon (n, 2), anticlockwise; a bent plate's long sides in ``pieces`` chords."""
        if self.bend_radius is None:
            return self.corners()
        along = np.linspace(-0.5, 0.5, pieces + 1) * self.length
        v = np.full(pieces + 1, 0.5 * self.thickness)
        return np.vstack([self.from_local(along, -v), self.from_local(along[::-1], v)])

    def holds(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) lie inside the plate (and in none of its holes)."""
        s, v = self.local(points).T
        w = self.across(points)
        inside = (np.abs(s) < 0.5 * self.length) & (np.abs(v) < 0.5 * self.thickness)
        inside &= (w > self.low) & (w < self.high)
        for hole in self.holes:
            inside &= np.hypot(s - hole.s, w - hole.w) > hole.radius
        return np.asarray(inside)

    @property
    def mirrors_in_z(self) -> bool:
        """Whether the plate is its own mirror image in z = 0."""
        places = {(round(h.s, 9), round(h.w, 9)) for h in self.holes}
        if self.along == "x":
            return abs(self.low + self.high) < 1e-9 and places == {(s, -w) for s, w in places}
        upright, level = np.abs(self.axis) < 1e-12
        even = places == {(-s, w) for s, w in places}
        return abs(self.place) < 1e-9 and bool(upright or (level and even))


def crest_height(body: Body) -> float:
    """Height of the body at x = z = 0, mm: base_height + R - sqrt(R^2 - (width/2)^2) of an arc."""
    if body.shape == "step":
        return float(surface_height(body, 0.0, 0.0))
    return profile_of(body).crest


def surface_height(body: Body, x: Array | float, z: Array | float = 0.0) -> Array:
    """Height of the body's top over (x, z), mm; NaN where it has none (beyond the arc's circle)."""
    x, z = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(z, dtype=float))
    return body.kind.height(body, x, z)


def plate_frames(design: Design) -> tuple[PlateFrame, ...]:
    """The plates' frames: row by row, each from - to + (or in the order of ``placement``)."""
    plates, body = design.plates, design.body
    if plates.placement is None:
        found: list[PlateFrame] = []
        for row in plates.all_rows:
            found += row_frames(body, row, len(found))
        return tuple(found)
    span = plates.span_mm if plates.span_mm is not None else body.depth_mm
    frames = []
    for index, (x, y, angle, *more) in enumerate(plates.placement):
        middle = _middle(plates, index, float(more[0]) if more else plates.span_offset_mm)
        place = float(x), float(y), float(angle)
        frames.append(_frame(plates, index, place, None, middle, span))
    return tuple(frames)


def _middle(row: Plates, number: int, offset: float) -> float:
    """The middle of a plate's span, mm; every other one of a row is staggered."""
    return offset + 0.5 * row.stagger_mm * (-1.0 if number % 2 else 1.0)


def _frame(
    row: Plates,
    index: int,
    place: tuple[float, float, float],
    bend: float | None,
    middle: float,
    span: float,
) -> PlateFrame:
    """A row's plate at a place and angle in its section plane."""
    return PlateFrame(
        index,
        *place,
        row.length_mm,
        row.thickness_mm,
        middle - 0.5 * span,
        middle + 0.5 * span,
        row.along,
        bend,
        holes_of(row, middle, span),
    )


# Rows of plates: from pitch, cover and the surface that they follow to a frame for each plate.

_STEPS = 2000  # of the surface line along which a row is paced out


def row_frames(body: Body, row: Plates, first: int) -> list[PlateFrame]:
    """The frames of one row, from - to +, numbered from ``first``.

    Coordinates are NaN where a plate lies beyond the surface: the checks refuse it, with its key.
    """
    full = body.depth_mm if row.along == "x" else body.width_mm
    span = row.span_mm if row.span_mm is not None else full
    paces = row.offset_mm + (np.arange(row.count) - 0.5 * (row.count - 1)) * row.pitch_mm
    frames = []
    for k, pace in enumerate(paces):
        middle = _middle(row, k, row.span_offset_mm)
        x, y, turn, bend = row.layout.placed(body, row, float(pace), middle)
        angle = -row.angle_deg if row.alternate and k % 2 else row.angle_deg
        frames.append(_frame(row, first + k, (x, y, angle + turn), bend, middle, span))
    return frames


def holes_of(plates: Plates, middle: float, span: float) -> tuple[Hole, ...]:
    """A plate's perforation: holes on its middle line, ``hole_pitch_mm`` apart, none at the middle.

    As many as leave a hole's diameter of metal to the span's ends.
    """
    if plates.hole_diameter_mm is None:
        return ()
    diameter, pitch = plates.hole_diameter_mm, plates.hole_pitch_mm
    count = int(np.floor(max(0.5 * span - 1.5 * diameter, 0.0) / pitch + 0.5 + 1e-9))
    places = (np.arange(count) + 0.5) * pitch
    places = places[places <= 0.5 * span - 1.5 * diameter + 1e-9]
    both = np.concatenate([-places[::-1], places])
    return tuple(Hole(0.0, float(middle + w), 0.5 * diameter) for w in both)


def _height(body: Body, row: Plates, place: Array, middle: float) -> Array:
    with np.errstate(invalid="ignore"):
        if row.along == "x":
            # The section whose surface a row keeps its cover from: the crest's.
            return surface_height(body, place, 0.0 if body.step is None else middle)
        return surface_height(body, middle, place)


@plate_layout("level", place=1)
class Level(PlateLayout):
    """Cover along y, pitch along the row's axis."""

    level = True

    def placed(
        self, body: Body, row: Plates, pace: float, middle: float
    ) -> tuple[float, float, float, float | None]:
        height = float(_height(body, row, np.array([pace]), middle)[0])
        return pace, height - row.cover_mm, 0.0, None


@plate_layout("turned", place=2)
class Turned(PlateLayout):
    """Cover along the surface's normal, pitch along the surface."""

    def placed(
        self, body: Body, row: Plates, pace: float, middle: float
    ) -> tuple[float, float, float, float | None]:
        place, y, slope, curvature = _paced_out(body, row, pace, middle)
        turn = np.arctan(slope)
        x = place + row.cover_mm * np.sin(turn)
        y = y - row.cover_mm * np.cos(turn)
        bend = None
        if self.bends and curvature > 1e-6:
            bend = float(1.0 / curvature - row.cover_mm)
        return float(x), float(y), float(np.degrees(turn)), bend


@plate_layout("bent", place=3)
class Bent(Turned):
    """Turned, and bent to the surface's curve."""

    bends = True


def _paced_out(
    body: Body, row: Plates, pace: float, middle: float
) -> tuple[float, float, float, float]:
    """Where the surface line is ``pace`` mm long from the crest: place, height, slope, curvature.

    Exact on the crest's own arc or flat, by many chords beyond it and on a step body.
    """
    radius = body.kind.row_radius(body, row.along, middle)
    if radius is not None:
        if not np.isfinite(radius):
            return pace, float(_height(body, row, np.zeros(1), middle)[0]), 0.0, 0.0
        angle = pace / radius
        if abs(angle) >= 0.5 * np.pi:
            return (np.nan,) * 4
        place = radius * np.sin(angle)
        crest = float(_height(body, row, np.zeros(1), middle)[0])
        return place, crest - radius * (1.0 - np.cos(angle)), -float(np.tan(angle)), 1.0 / radius
    half = 0.5 * (body.width_mm if row.along == "x" else body.depth_mm)
    line, heights = _surface_line(body, row, middle, half)
    if len(line) < 3:
        return (np.nan,) * 4
    paced = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(line), np.diff(heights)))])
    paced -= np.interp(0.0, line, paced)
    if not paced[0] <= pace <= paced[-1]:
        return (np.nan,) * 4
    place = float(np.interp(pace, paced, line))
    reach = 0.02 * half
    window = np.abs(line - place) <= reach + 2.0 * half / _STEPS
    c2, c1, c0 = np.polyfit(line[window] - place, heights[window], 2)
    return place, float(c0), float(c1), float(max(-2.0 * c2 / (1.0 + c1**2) ** 1.5, 0.0))


def _surface_line(body: Body, row: Plates, middle: float, half: float) -> tuple[Array, Array]:
    """Places and heights (n,) of the surface line over a row's middle, where there is a surface."""
    if body.step is not None:
        return _step_line(step_facts(body.step), row.along, middle, half)
    line = np.linspace(-half, half, _STEPS + 1)
    heights = _height(body, row, line, middle)
    known = np.isfinite(heights)
    return line[known], heights[known]


@lru_cache(maxsize=128)
def _step_line(facts: StepFacts, along: str, middle: float, half: float) -> tuple[Array, Array]:
    """That of a STEP body, which takes 30 ms; every plate of a row asks for it."""
    line = np.linspace(-half, half, _STEPS + 1)
    heights = facts.height(line, middle) if along == "x" else facts.height(middle, line)
    known = np.isfinite(heights)
    line, heights = line[known], heights[known]
    line.flags.writeable = heights.flags.writeable = False
    return line, heights


def mirrors_in_z(design: Design) -> bool:
    """Whether the finger is its own mirror image in z = 0, plate by plate."""
    step = design.body.step
    return (step is None or step.mirrors_in_z) and all(
        frame.mirrors_in_z for frame in plate_frames(design)
    )


# Rows of plates with the keys that they are owed to, and designs with one key changed.


@dataclass(frozen=True)
class PlateRow:
    """One row of plates: its values, its frames, and where each value stands in the file.

    ``number``: None for [plates] itself, else that of ``plates.rows``; ``own``: keys that the row
    gives itself, the others are those of [plates]. ``placed``: a ``plates.placement``.
    """

    table: Plates
    frames: tuple[PlateFrame, ...]
    number: int | None = None
    own: frozenset[str] = frozenset()
    placed: bool = False

    def key(self, name: str) -> str:
        """The dotted key that gave the row's value ``name``."""
        return f"plates.rows[{self.number}].{name}" if name in self.own else f"plates.{name}"

    def value(self, name: str) -> object:
        """The row's value ``name``; what absence means where it is absent."""
        value = getattr(self.table, name)
        return "(absent: the full extent)" if name == "span_mm" and value is None else value

    def blame(self, index: int, name: str) -> tuple[str, object]:
        """Key and value to blame for plate ``index``: the row's ``name``, or its own placement."""
        if self.placed and self.table.placement is not None:
            return f"plates.placement[{index}]", list(self.table.placement[index])
        return self.key(name), self.value(name)


def plate_rows(design: Design) -> tuple[PlateRow, ...]:
    """The rows that hold any plate, each with its frames; a placement is one row."""
    frames = plate_frames(design)
    plates = design.plates
    if plates.placement is not None:
        return (PlateRow(plates, frames, placed=True),) if frames else ()
    rows, start = [], 0
    for number, table in enumerate(plates.all_rows):
        own = frames[start : start + table.count]
        start += table.count
        given = plates.rows[number - 1].model_dump(exclude_none=True) if number else {}
        if own:
            rows.append(PlateRow(table, own, number - 1 if number else None, frozenset(given)))
    return tuple(rows)


def with_key(design: Design, key: str, value: object) -> Design | None:
    """A copy of a design with one dotted key of [body] or [plates] set; None: refused by itself.

    A revolved body's depth goes with its width.
    """
    table = key.partition(".")[0]
    old: Body | Plates = getattr(design, table)
    data = {table: old.model_dump(mode="json", exclude_none=True)}
    set_value(data, key, value)
    if data[table].get("shape") == "revolved":
        data[table]["depth_mm"] = data[table]["width_mm"]
    try:
        return design.model_copy(update={table: type(old).model_validate(data[table])})
    except ValidationError:
        return None
