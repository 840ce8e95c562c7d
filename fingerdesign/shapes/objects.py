"""Rigid objects in closed form: plane, cylinder, sphere (numpy only).

Each knows its signed distance (> 0 outside) and outward unit normal at points (q, 2) or (q, 3), and
``underside``: the height of its lower face over (x, z), by which it is let down onto a finger until
it touches. In plane strain the object is its section z = 0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol, Self, TypeVar

import numpy as np

from fingerdesign.arrays import Array

Vector = tuple[float, float, float]

DOWN: Vector = (0.0, -1.0, 0.0)


class Indenter(Protocol):
    """A rigid object: signed distance and outward normal where points of the finger face it."""

    def distance(self, points: Array) -> Array:
        """Distance (q,) mm of points (q, dim) from the object, > 0 outside."""
        ...

    def normal(self, points: Array) -> Array:
        """Outward unit normals (q, dim) of the object at the facing points."""
        ...


class RigidObject(Indenter, Protocol):
    """An indenter that can be placed: moved along y, and asked for its lower face."""

    def underside(self, x: Array, z: Array) -> Array:
        """Height y of the lower face over (x, z); infinite beside the object."""
        ...

    def at_height(self, height: float) -> Self:
        """The same object with its reference point at ``height``."""
        ...


@dataclass(frozen=True)
class Plane:
    """A plane through (0, height, 0), the object above it; ``direction``: outward normal (down).

    >>> Plane(2.0).distance(np.array([[5.0, 1.5]])).tolist()
    [0.5]
    """

    height: float
    direction: Vector = DOWN

    def distance(self, points: Array) -> Array:
        relative = np.array(points, dtype=float)
        relative[:, 1] -= self.height
        # The object lies against its normal: outside is along it.
        return np.asarray(relative @ np.array(self.direction[: points.shape[1]]))

    def normal(self, points: Array) -> Array:
        return np.tile(np.array(self.direction[: points.shape[1]]), (len(points), 1))

    def underside(self, x: Array, z: Array) -> Array:
        across, down, along = self.direction
        return np.asarray(self.height - (across * x + along * z) / down)

    def at_height(self, height: float) -> Self:
        return replace(self, height=height)


@dataclass(frozen=True)
class Cylinder:
    """A cylinder of ``radius`` mm whose axis runs through (0, height, 0) along ``axis`` (unit)."""

    height: float
    radius: float
    axis: Vector = (0.0, 0.0, 1.0)

    def distance(self, points: Array) -> Array:
        return np.asarray(np.linalg.norm(self._from_axis(points), axis=1) - self.radius)

    def normal(self, points: Array) -> Array:
        away = self._from_axis(points)
        away /= np.linalg.norm(away, axis=1, keepdims=True)
        return np.asarray(away[:, : points.shape[1]])

    def underside(self, x: Array, z: Array) -> Array:
        # |q|^2 - (q . a)^2 = R^2 with q = (x, t, z): a quadratic in t, of which the lower root.
        a = np.array(self.axis)
        flat = a[0] * x + a[2] * z
        square = 1.0 - a[1] ** 2
        middle = flat * a[1] / square
        rest = (x**2 + z**2 - flat**2 - self.radius**2) / square
        inside = middle**2 - rest
        with np.errstate(invalid="ignore"):
            lower = self.height + middle - np.sqrt(inside)
        return np.asarray(np.where(inside >= 0.0, lower, np.inf))

    def at_height(self, height: float) -> Self:
        return replace(self, height=height)

    def _from_axis(self, points: Array) -> Array:
        relative = np.zeros((len(points), 3))
        relative[:, : points.shape[1]] = points
        relative[:, 1] -= self.height
        axis = np.array(self.axis)
        away: Array = relative - (relative @ axis)[:, None] * axis
        return away


@dataclass(frozen=True)
class Sphere:
    """A sphere of ``radius`` mm about (0, height, 0)."""

    height: float
    radius: float

    def distance(self, points: Array) -> Array:
        return np.asarray(np.linalg.norm(self._from_centre(points), axis=1) - self.radius)

    def normal(self, points: Array) -> Array:
        away = self._from_centre(points)
        return np.asarray(away / np.linalg.norm(away, axis=1, keepdims=True))

    def underside(self, x: Array, z: Array) -> Array:
        inside = self.radius**2 - x**2 - z**2
        with np.errstate(invalid="ignore"):
            lower = self.height - np.sqrt(inside)
        return np.asarray(np.where(inside >= 0.0, lower, np.inf))

    def at_height(self, height: float) -> Self:
        return replace(self, height=height)

    def _from_centre(self, points: Array) -> Array:
        away = np.array(points, dtype=float)
        away[:, 1] -= self.height
        return away


Height = Callable[[Array, Array], Array]
Placed = TypeVar("Placed", bound=RigidObject)
_GRID, _ROUNDS, _ZOOM = 65, 14, 0.2  # 0.2^14: the last grid is 1e-10 of the first


def touching(
    rigid: Placed, surface: Height, half_width: float, half_depth: float
) -> tuple[Placed, Array]:
    """The object let down along y to first touch on ``surface`` over |x|, |z| <= the halves, mm.

    Both faces being convex toward each other, their vertical gap has one minimum; a grid is zoomed
    onto it. Returns the object and the point of touch (3,).
    """
    rigid = rigid.at_height(0.0)
    centre, half = np.zeros(2), np.array([half_width, half_depth])
    for _ in range(_ROUNDS):
        low = np.maximum(centre - half, [-half_width, -half_depth])
        high = np.minimum(centre + half, [half_width, half_depth])
        x, z = np.meshgrid(*np.linspace(low, high, _GRID).T, indexing="ij")
        with np.errstate(invalid="ignore"):
            gap = rigid.underside(x.ravel(), z.ravel()) - surface(x.ravel(), z.ravel())
        gap = np.where(np.isnan(gap), np.inf, gap)  # no surface there: a round finger's corners
        # Where the gap is level (a flat plane along a straight finger) the middle is as good.
        least = np.flatnonzero(gap <= gap.min() + 1e-14 * (half_width + half_depth))
        offset = np.hypot(x.ravel()[least], z.ravel()[least])
        best = least[np.argmin(offset)]
        centre = np.array([x.ravel()[best], z.ravel()[best]])
        half = half * _ZOOM
    y = float(surface(centre[:1], centre[1:])[0])
    drop = float(rigid.underside(centre[:1], centre[1:])[0])
    return rigid.at_height(y - drop), np.array([centre[0], y, centre[1]])
