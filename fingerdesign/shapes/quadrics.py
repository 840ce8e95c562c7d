"""Planes, cylinders, cones and spheres in space: distance, normal, heights (numpy only).

The closed forms behind a STEP body's faces. Lengths in mm, points (n, 3), unit vectors (3,). Signs
are those of each form's own outside; a face whose solid lies there is turned by its ``sign``.
"""

from dataclasses import dataclass
from typing import Protocol

import numpy as np

from fingerdesign.arrays import Array


class Shape(Protocol):
    """A surface without borders."""

    def distance(self, points: Array) -> Array:
        """Signed distance (n,)."""

    def normal(self, points: Array) -> Array:
        """Unit normals (n, 3) at the nearest points, along growing distance."""

    def heights(self, x: Array, z: Array) -> Array:
        """Heights (k, n) at which vertical lines meet the surface; NaN where they do not."""


@dataclass(frozen=True)
class Plane:
    """Points with normal . point = offset."""

    direction: Array
    offset: float

    def distance(self, points: Array) -> Array:
        return np.asarray(points @ self.direction - self.offset)

    def normal(self, points: Array) -> Array:
        return np.tile(self.direction, (len(points), 1))

    def heights(self, x: Array, z: Array) -> Array:
        a, b, c = self.direction
        if abs(b) < 1e-9:  # upright
            return np.full((1, len(x)), np.nan)
        return np.asarray((self.offset - a * x - c * z) / b)[None]


@dataclass(frozen=True)
class Sphere:
    """Outside: away from the centre."""

    centre: Array
    radius: float

    def distance(self, points: Array) -> Array:
        return np.asarray(np.linalg.norm(points - self.centre, axis=1) - self.radius)

    def normal(self, points: Array) -> Array:
        return unit(points - self.centre)

    def heights(self, x: Array, z: Array) -> Array:
        across = (x - self.centre[0]) ** 2 + (z - self.centre[2]) ** 2
        found = roots(np.ones(len(x)), np.zeros(len(x)), across - self.radius**2, self.radius)
        return np.asarray(found + self.centre[1])


@dataclass(frozen=True)
class Cone:
    """A cone, or a cylinder (``slope`` 0): at ``s`` along the axis its radius is radius + s slope.

    Of a cone, the half with positive radius. Outside: away from the axis.
    """

    origin: Array
    axis: Array
    radius: float
    slope: float = 0.0

    def distance(self, points: Array) -> Array:
        offset = points - self.origin
        along = offset @ self.axis
        out = np.linalg.norm(offset - np.outer(along, self.axis), axis=1)
        cosine = 1.0 / np.hypot(1.0, self.slope)
        return np.asarray((out - self.radius - along * self.slope) * cosine)

    def normal(self, points: Array) -> Array:
        offset = points - self.origin
        radial = unit(offset - np.outer(offset @ self.axis, self.axis))
        return np.asarray((radial - self.slope * self.axis) / np.hypot(1.0, self.slope))

    def heights(self, x: Array, z: Array) -> Array:
        # |p|^2 - (p.a)^2 = (r + p.a slope)^2 with p = p0 + y e_y
        p0 = np.column_stack([x, np.zeros(len(x)), z]) - self.origin
        up, along, grow = self.axis[1], p0 @ self.axis, 1.0 + self.slope**2
        a = 1.0 - grow * up**2
        b = p0[:, 1] - grow * along * up - self.radius * self.slope * up
        c = np.einsum("ij,ij->i", p0, p0) - grow * along**2
        c -= 2.0 * self.radius * self.slope * along + self.radius**2
        found = roots(np.full(len(x), a), b, c, np.linalg.norm(p0, axis=1))
        reach = self.radius + self.slope * (along + found * up)
        return np.where(reach >= -1e-12 * (1.0 + self.radius), found, np.nan)


def roots(a: Array, b: Array, c: Array, scale: Array | float) -> Array:
    """Both roots (2, n) of a y^2 + 2 b y + c = 0, without cancellation; NaN where none is real.

    A discriminant that rounding made a little negative counts as 0: the line touches. ``scale``:
    the lengths that c is a difference of squares of.
    """
    inner = b * b - a * c
    root = np.sqrt(np.where(inner < -1e-14 * scale**2, np.nan, np.maximum(inner, 0.0)))
    far = -(b + np.where(b < 0.0, -1.0, 1.0) * root)
    square = np.abs(a) > 1e-14
    with np.errstate(divide="ignore", invalid="ignore"):
        first = np.where(square, far / a, np.nan)
        double = np.where(square, 0.0 * root, np.nan)
        second = np.where(np.abs(far) > 1e-14 * scale, c / far, double)
    return np.stack([first, second])


def unit(vectors: Array) -> Array:
    """Vectors (n, 3) at length 1; one of no length is left as it is."""
    return np.asarray(vectors / np.maximum(np.linalg.norm(vectors, axis=1), 1e-300)[:, None])


def dot(first: Array, second: Array) -> Array:
    """Row by row."""
    return np.asarray(np.einsum("ij,ij->i", first, second))
