"""A body's contact surface: nearest point, normal, signed distance, height (numpy only).

A parametric body's is its section's outline (layout/profile.py), in the meridian coordinates of
its kind. A STEP body's is that of its CAD faces, closed forms and NURBS: distances and heights are
those of the true surface, not of a tessellation.
"""

from dataclasses import dataclass
from typing import Self

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.body import Body, StepFile
from fingerdesign.design.step import step_facts
from fingerdesign.errors import GeometryError
from fingerdesign.layout.bodies import crest_height, surface_height
from fingerdesign.layout.outline import (
    Piece,
    chain_distance,
    chain_misfit,
    chain_normal,
    nearest_piece,
)
from fingerdesign.layout.profile import profile_of
from fingerdesign.shapes.faces import CadFace, Smooth, nearest


@dataclass(frozen=True)
class Surface:
    """Contact surface of a body for mesh, contact and checks; lengths in mm.

    Points are (n, 2), in the mid-section z = 0, or (n, 3); answers have the shape of the question.
    Outside the body (toward the object) distances are positive.
    """

    body: Body

    @property
    def crest(self) -> float:
        """Height at x = z = 0, mm."""
        return crest_height(self.body)

    @property
    def lowest(self) -> float:
        """Least height of the body's contact surface, at its border, mm."""
        return self.body.kind.lowest(self.body)

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures at the crest along x and along z, 1/mm (>= 0)."""
        return self.body.kind.curvatures(self.body)

    def encloses(self, points: Array) -> BoolArray:
        """Mask of points (n, 3) with |x|, |z| within the body that lie below the surface, (n,).

        Not the sign of the distance: continued, the surface closes below its axis.
        """
        return np.asarray(points[:, 1] < self.height(points[:, 0], points[:, 2]))

    def height(self, x: Array | float, z: Array | float = 0.0) -> Array:
        """Height y of the surface over (x, z), mm; NaN where there is none."""
        return surface_height(self.body, x, z)

    def distance(self, points: Array) -> Array:
        """Signed distance to the surface, (n,), mm, positive outside."""
        raise NotImplementedError

    def normal(self, points: Array) -> Array:
        """Outward unit normal at the surface point nearest to each point, shape of ``points``."""
        raise NotImplementedError

    def project(self, points: Array) -> Array:
        """Nearest points on the surface, shape of ``points``; exact to rounding."""
        points = np.asarray(points, dtype=float)
        return np.asarray(points - self.distance(points)[:, None] * self.normal(points))


class CadSurface(Surface):
    """The contact surface of a STEP body, continued beyond its border as its faces are.

    Errors: below 1e-9 mm for closed forms, as the Newton iteration leaves for NURBS (1e-12 of the
    face's size).
    """

    def distance(self, points: Array) -> Array:
        return self._nearest(points)[0]

    def normal(self, points: Array) -> Array:
        return self._nearest(points)[1]

    def project(self, points: Array) -> Array:
        points = np.asarray(points, dtype=float)
        away, normal = self._nearest(points)
        return np.asarray(points - away[:, None] * normal)

    def _nearest(self, points: Array) -> tuple[Array, Array]:
        """Distances (n,) and normals, shape of ``points``."""
        assert self.body.step is not None
        points = np.asarray(points, dtype=float)
        dimension = points.shape[1]
        if dimension == 2:
            points = np.column_stack([points, np.zeros(len(points))])
        _, away, normal, _ = nearest(step_facts(self.body.step).contact, points)
        return away, normal[:, :dimension]


@dataclass(frozen=True)
class ContactSurface(Surface):
    """A parametric body's curved or flat face with its edges, continued beyond the sides.

    ``pieces``: those of the outline that count (all by default; a mesh snaps chain by chain).
    """

    pieces: tuple[Piece, ...]

    @classmethod
    def of(cls, body: Body) -> Self:
        """The contact surface of a parametric body; GeometryError for others."""
        if not body.kind.closed_form:
            shape = f'body.shape = "{body.shape}"'
            raise GeometryError(f"{shape} has no contact surface in closed form")
        try:
            body.kind.axis(body)
            return cls(body, profile_of(body).pieces)
        except ValueError as error:
            raise GeometryError(f"body: {error}") from error

    def distance(self, points: Array) -> Array:
        return chain_distance(self.pieces, self._meridian(points)[0])

    def misfit(self, points: Array) -> Array:
        """Distance (n,) to the pieces as they end, not continued."""
        return chain_misfit(self.pieces, self._meridian(points)[0])

    def owner(self, points: Array) -> IntArray:
        """Number of the piece (n,) that holds the nearest point."""
        return nearest_piece(self.pieces, self._meridian(points)[0])

    def normal(self, points: Array) -> Array:
        plane, sideways, upward = self._meridian(points)
        normal = chain_normal(self.pieces, plane)
        if not np.all(np.abs(np.linalg.norm(normal, axis=1) - 1.0) < 1e-6):
            raise GeometryError("a point on the arc's centre has no nearest surface point")
        return np.asarray(normal[:, :1] * sideways + normal[:, 1:] * upward)

    def _meridian(self, points: Array) -> tuple[Array, Array, Array]:
        """Points in the outline's plane (n, 2), and the unit vectors along its two axes in space
        (or in the section), shape of ``points``."""
        points = np.asarray(points, dtype=float)
        kind = self.body.kind
        sideways, upward = kind.directions(self.body, points)
        return kind.plane(self.body, points), sideways, upward


def surface_of(body: Body) -> Surface:
    """The contact surface of any body."""
    return ContactSurface.of(body) if body.step is None else CadSurface(body)


def step_carriers(step: StepFile) -> tuple[Smooth, ...]:
    """The carriers of a STEP body's outside, of the whole body."""
    grouped: dict[int, list[CadFace]] = {}
    for face in step_facts(step).faces:
        grouped.setdefault(face.group, []).append(face)
    return tuple(Smooth.of(faces) for faces in grouped.values())
