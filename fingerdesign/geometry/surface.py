"""The curved contact surface in closed form: nearest point, normal, signed distance (numpy only).

The arc is a cylinder of radius R along z. The dome is that section revolved about the x-parallel
axis at height crest - dome radius: a torus patch. With r = hypot(y - axis height, z), both are the
circle of radius R about (x, r) = (0, dome radius - R), so one formula serves both.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import crest_height, surface_height
from fingerdesign.errors import GeometryError

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body

Array = NDArray[np.float64]


@dataclass(frozen=True)
class ContactSurface:
    """The body's curved face, continued beyond its edges; lengths in mm.

    Points are (n, 2), in the mid-section z = 0, or (n, 3); answers have the shape of the question.
    Outside the body (toward the object) distances are positive.
    """

    body: Body

    @classmethod
    def of(cls, body: Body) -> ContactSurface:
        """The contact surface of a body of shape "arc" or "dome"; GeometryError for others."""
        if body.shape not in ("arc", "dome"):
            raise GeometryError(
                f"body.shape = {body.shape!r} has no contact surface in closed form; "
                'use "arc" or "dome"'
            )
        if body.shape == "dome" and body.dome_radius_mm is None:
            raise GeometryError('body.shape = "dome" needs body.dome_radius_mm')
        return cls(body)

    @property
    def radius(self) -> float:
        """Radius of the arc in the section, mm."""
        return float(self.body.arc_radius_mm)

    @property
    def crest(self) -> float:
        """Greatest height, at x = z = 0, mm."""
        return crest_height(self.body)

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures at the crest along x and along z, 1/mm (>= 0)."""
        dome = self._dome_radius
        return 1.0 / self.radius, 0.0 if dome is None else 1.0 / dome

    @property
    def lowest(self) -> float:
        """Least height of the body's contact surface, at its corners, mm."""
        return float(self.height(0.5 * self.body.width_mm, 0.5 * self.body.depth_mm))

    def encloses(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) with |x|, |z| within the body lie below the surface, (n,).

        Not the sign of the distance: continued, the surface closes below its axis.
        """
        return np.asarray(points[:, 1] < self.height(points[:, 0], points[:, 2]))

    def height(self, x: Array | float, z: Array | float = 0.0) -> Array:
        """Height y of the surface over (x, z), mm."""
        return surface_height(self.body, x, z)

    def distance(self, points: Array) -> Array:
        """Signed distance to the surface, (n,), mm, positive outside."""
        x, r, _ = self._meridian(points)
        return np.asarray(np.hypot(x, r - self._centre) - self.radius)

    def normal(self, points: Array) -> Array:
        """Outward unit normal at the surface point nearest to each point, shape of ``points``."""
        x, r, radial = self._meridian(points)
        length = np.hypot(x, r - self._centre)
        if np.any(length < 1e-9 * self.radius):
            raise GeometryError("a point on the arc's centre has no nearest surface point")
        normal = ((r - self._centre) / length)[:, None] * radial
        normal[:, 0] = x / length
        return normal

    def project(self, points: Array) -> Array:
        """Nearest points on the surface, shape of ``points``; exact to rounding."""
        points = np.asarray(points, dtype=float)
        return np.asarray(points - self.distance(points)[:, None] * self.normal(points))

    @property
    def _dome_radius(self) -> float | None:
        return None if self.body.dome_radius_mm is None else float(self.body.dome_radius_mm)

    @property
    def _centre(self) -> float:
        """The circle's centre as the radius r from the axis (height above y = 0 for an arc)."""
        dome = self._dome_radius
        return self.crest - self.radius if dome is None else dome - self.radius

    def _meridian(self, points: Array) -> tuple[Array, Array, Array]:
        """x (n,), distance from the axis of revolution (n,), and the unit vector away from it."""
        points = np.asarray(points, dtype=float)
        radial = np.zeros_like(points)
        dome = self._dome_radius
        if dome is None:
            radial[:, 1] = 1.0
            return points[:, 0], points[:, 1], radial
        y = points[:, 1] - (self.crest - dome)
        z = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
        r = np.hypot(y, z)
        if np.any(r < 1e-9 * dome):
            raise GeometryError("a point on the dome's axis has no nearest surface point")
        radial[:, 1] = y / r
        if points.shape[1] == 3:
            radial[:, 2] = z / r
        return points[:, 0], r, radial
