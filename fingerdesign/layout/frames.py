"""The frame of a plate: its place, axes and local coordinates, in closed form (numpy only).

Axes: x tangential, y normal (base at y = 0, crest toward +y), z along the plates, mid-plane z = 0.
Lengths in mm, angles anticlockwise from the row's axis (+x, or +z for rows along z).
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray


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

    def upward(self, s: float) -> Array:
        """Unit vector toward the upper side at ``s``, in the section plane, shape (2,)."""
        along = self.tangent(s)
        return np.array([-along[1], along[0]])

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

    def holds(self, points: Array) -> BoolArray:
        """True for points (n, 3) inside the plate (and in none of its holes)."""
        s, v = self.local(points).T
        w = self.across(points)
        inside = (np.abs(s) < 0.5 * self.length) & (np.abs(v) < 0.5 * self.thickness)
        inside &= (w > self.low) & (w < self.high)
        for hole in self.holes:
            inside &= np.hypot(s - hole.s, w - hole.w) > hole.radius
        return np.asarray(inside)

    @property
    def mirrors_in_z(self) -> bool:
        """True if the plate is its own mirror image in z = 0."""
        places = {(round(h.s, 9), round(h.w, 9)) for h in self.holes}
        if self.along == "x":
            return abs(self.low + self.high) < 1e-9 and places == {(s, -w) for s, w in places}
        upright, level = np.abs(self.axis) < 1e-12
        even = places == {(-s, w) for s, w in places}
        return abs(self.place) < 1e-9 and bool(upright or (level and even))
