"""A body's contact surface: nearest point, normal, signed distance, height (numpy only).

A parametric body's is its section's outline (design/profile.py) in one of three ways: drawn
straight along z; revolved about the x-parallel axis at height crest - dome radius (dome); revolved
about y. In the meridian coordinates of each the surface is the plane outline, so one formula serves
all, edges included. A step body's is that of its CAD faces (geometry/cad_surface.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.design.layout import crest_height, surface_height
from fingerdesign.design.profile import (
    Piece,
    Profile,
    chain_distance,
    chain_misfit,
    chain_normal,
    nearest_piece,
    profile_of,
)
from fingerdesign.errors import GeometryError

if TYPE_CHECKING:
    from fingerdesign.design.body_table import Body


class Surface(Protocol):
    """What the mesh, the contact and the checks ask of a contact surface; lengths in mm.

    Points are (n, 2), in the mid-section z = 0, or (n, 3); answers have the shape of the question.
    Outside the body (toward the object) distances are positive.
    """

    @property
    def crest(self) -> float:
        """Height at x = z = 0, mm."""

    @property
    def lowest(self) -> float:
        """Least height of the body's contact surface, at its border, mm."""

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures at the crest along x and along z, 1/mm (>= 0)."""

    def encloses(self, points: Array) -> NDArray[np.bool_]:
        """Whether points (n, 3) with |x|, |z| within the body lie below the surface, (n,)."""

    def height(self, x: Array | float, z: Array | float = 0.0) -> Array:
        """Height y of the surface over (x, z), mm; NaN where there is none."""

    def distance(self, points: Array) -> Array:
        """Signed distance to the surface, (n,), mm, positive outside."""

    def normal(self, points: Array) -> Array:
        """Outward unit normal at the surface point nearest to each point, shape of ``points``."""

    def project(self, points: Array) -> Array:
        """Nearest points on the surface, shape of ``points``."""


@dataclass(frozen=True)
class ContactSurface:
    """A parametric body's curved or flat face with its edges, continued beyond the sides.

    ``pieces``: those of the outline that count (all by default; a mesh snaps chain by chain).
    """

    body: Body
    pieces: tuple[Piece, ...]

    @classmethod
    def of(cls, body: Body) -> ContactSurface:
        """The contact surface of a parametric body; GeometryError for others."""
        if body.shape == "step":
            raise GeometryError('body.shape = "step" has no contact surface in closed form')
        if body.shape == "dome" and body.dome_radius_mm is None:
            raise GeometryError('body.shape = "dome" needs body.dome_radius_mm')
        try:
            return cls(body, profile_of(body).pieces)
        except ValueError as error:
            raise GeometryError(f"body: {error}") from error

    def chains(self) -> tuple[ContactSurface, ...]:
        """The surface in parts that join without an edge."""
        return tuple(ContactSurface(self.body, chain) for chain in self.profile.chains())

    @property
    def profile(self) -> Profile:
        """The outline of the section."""
        return profile_of(self.body)

    @property
    def radius(self) -> float:
        """Radius of the arc in the section, mm; infinite for a flat top."""
        return float(self.body.arc_radius_mm) if self.body.shape != "block" else np.inf

    @property
    def crest(self) -> float:
        """Greatest height, at x = z = 0, mm."""
        return crest_height(self.body)

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures at the crest along x and along z, 1/mm (>= 0)."""
        if self.body.shape == "revolved":
            return 1.0 / self.radius, 1.0 / self.radius
        dome = self._dome_radius
        return 1.0 / self.radius, 0.0 if dome is None else 1.0 / dome

    @property
    def lowest(self) -> float:
        """Least height of the body's contact surface, at its corners, mm."""
        side = self.profile.side_height
        if self._dome_radius is None:
            return side
        axis = self._axis_height
        return float(axis + np.sqrt(max((side - axis) ** 2 - 0.25 * self.body.depth_mm**2, 0.0)))

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
        return chain_distance(self.pieces, self._meridian(points)[0])

    def misfit(self, points: Array) -> Array:
        """Distance (n,) to the pieces as they end, not continued."""
        return chain_misfit(self.pieces, self._meridian(points)[0])

    def owner(self, points: Array) -> NDArray[np.int64]:
        """Number of the piece (n,) that holds the nearest point."""
        return nearest_piece(self.pieces, self._meridian(points)[0])

    def normal(self, points: Array) -> Array:
        """Outward unit normal at the surface point nearest to each point, shape of ``points``."""
        plane, sideways, upward = self._meridian(points)
        normal = chain_normal(self.pieces, plane)
        if not np.all(np.abs(np.linalg.norm(normal, axis=1) - 1.0) < 1e-6):
            raise GeometryError("a point on the arc's centre has no nearest surface point")
        return np.asarray(normal[:, :1] * sideways + normal[:, 1:] * upward)

    def project(self, points: Array) -> Array:
        """Nearest points on the surface, shape of ``points``; exact to rounding."""
        points = np.asarray(points, dtype=float)
        return np.asarray(points - self.distance(points)[:, None] * self.normal(points))

    @property
    def _dome_radius(self) -> float | None:
        return None if self.body.dome_radius_mm is None else float(self.body.dome_radius_mm)

    @property
    def _axis_height(self) -> float:
        """Height of a dome's axis of revolution, mm."""
        return self.crest - float(self._dome_radius or 0.0)

    def _meridian(self, points: Array) -> tuple[Array, Array, Array]:
        """Points in the outline's plane (n, 2), and the unit vectors along its two axes in space
        (or in the section), shape of ``points``."""
        points = np.asarray(points, dtype=float)
        sideways, upward = np.zeros_like(points), np.zeros_like(points)
        x, y = points[:, 0], points[:, 1]
        z = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
        if self.body.shape == "revolved":
            out = np.hypot(x, z)
            safe = np.maximum(out, 1e-300)
            sideways[:, 0] = np.where(out > 0.0, x / safe, 1.0)
            if points.shape[1] == 3:
                sideways[:, 2] = z / safe
            upward[:, 1] = 1.0
            return np.column_stack([out, y]), sideways, upward
        sideways[:, 0] = 1.0
        if self._dome_radius is None:
            upward[:, 1] = 1.0
            return np.column_stack([x, y]), sideways, upward
        axis = self._axis_height
        r = np.hypot(y - axis, z)
        if np.any(r < 1e-9 * self._dome_radius):
            raise GeometryError("a point on the dome's axis has no nearest surface point")
        upward[:, 1] = (y - axis) / r
        if points.shape[1] == 3:
            upward[:, 2] = z / r
        return np.column_stack([x, axis + r]), sideways, upward


def surface_of(body: Body) -> Surface:
    """The contact surface of any body."""
    if body.step is None:
        return ContactSurface.of(body)
    from fingerdesign.geometry.cad_surface import CadSurface

    return CadSurface.of(body.step)
