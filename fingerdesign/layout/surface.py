"""A body's contact surface: nearest point, normal, signed distance, height (numpy only).

A parametric body's is its section's outline (layout/profile.py) in one of three ways: drawn
straight along z; revolved about the x-parallel axis at height crest - dome radius (dome); revolved
about y. In the meridian coordinates of each the surface is the plane outline, so one formula serves
all, edges included. A step body's is that of its CAD faces (layout/surface.py).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.step import StepFacts, step_facts
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import crest_height, surface_height
from fingerdesign.layout.profile import (
    Piece,
    Profile,
    chain_distance,
    chain_misfit,
    chain_normal,
    nearest_piece,
    profile_of,
)
from fingerdesign.shapes.faces import CadFace, nearest

if TYPE_CHECKING:
    from fingerdesign.design.body import Body, StepFile
if TYPE_CHECKING:
    from fingerdesign.design.body import Body

if TYPE_CHECKING:
    from fingerdesign.design.body import Body, StepFile


# A STEP body's contact surface, its faces to snap to, and its solid (numpy; kernel when asked).
#
# The faces are those that the worker described (design/step.py): closed forms and NURBS, so
# distances and heights are those of the true surface, not of a tessellation.

_SIDESTEP_MM = 1e-3  # along the crest, for its curvature


@dataclass(frozen=True)
class CadSurface:
    """The contact surface of a STEP body; see ``surface.Surface`` for what it answers.

    Beyond its border it is continued as its faces are. Errors: below 1e-9 mm for closed forms, as
    the Newton iteration leaves for NURBS (1e-12 of the face's size).
    """

    facts: StepFacts

    @classmethod
    def of(cls, step: StepFile) -> CadSurface:
        """The surface that the rules of ``[body.step]`` pick. DesignError where they pick none."""
        return cls(step_facts(step))

    @property
    def crest(self) -> float:
        """Height at x = z = 0, mm."""
        return float(self.height(0.0, 0.0))

    @property
    def lowest(self) -> float:
        """Least height of the contact surface, at its border, mm."""
        return self.facts.lowest

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures at the crest along x and along z, 1/mm; 0 where it is flat or hollow."""
        crest = np.array([0.0, self.crest, 0.0])
        normal = self.normal(crest[None])[0]
        found = []
        for axis in (0, 2):
            along = np.eye(3)[axis] - normal[axis] * normal
            along /= np.linalg.norm(along)
            either = self.project(np.stack([crest + s * _SIDESTEP_MM * along for s in (-1, 1)]))
            turn = np.diff(self.normal(either) @ along)[0]
            bent = float(turn / np.linalg.norm(either[1] - either[0]))
            found.append(bent if bent > 1e-9 else 0.0)
        return found[0], found[1]

    def encloses(self, points: Array) -> BoolArray:
        """Whether points (n, 3) lie below the surface, (n,)."""
        below = points[:, 1] < self.height(points[:, 0], points[:, 2])
        return np.asarray(below)

    def height(self, x: Array | float, z: Array | float = 0.0) -> Array:
        """Height y of the surface over (x, z), mm; NaN where there is none."""
        return self.facts.height(x, z)

    def distance(self, points: Array) -> Array:
        """Signed distance (n,), mm, positive outside; points (n, 3), or (n, 2) in z = 0."""
        return nearest(self.facts.contact, _in_space(points))[1]

    def normal(self, points: Array) -> Array:
        """Outward unit normals at the nearest points, shape of ``points``."""
        found = nearest(self.facts.contact, _in_space(points))[2]
        return found[:, : np.shape(points)[1]]

    def project(self, points: Array) -> Array:
        """Nearest points on the surface, shape of ``points``."""
        points = np.asarray(points, dtype=float)
        _, away, normal, _ = nearest(self.facts.contact, _in_space(points))
        return np.asarray(points - away[:, None] * normal[:, : points.shape[1]])


def _in_space(points: Array) -> Array:
    points = np.asarray(points, dtype=float)
    if points.shape[1] == 3:
        return points
    return np.column_stack([points, np.zeros(len(points))])


@dataclass(frozen=True)
class StepCarrier:
    """Faces of a STEP body that join smoothly, or lie in one plane: a mesher keeps no edge there.

    Fulfils mesh.carriers.Carrier. ``name``: "contact" where one of them belongs to the contact
    surface, else the name of the largest; ``names`` tells several apart.
    """

    faces: tuple[CadFace, ...]

    @property
    def name(self) -> str:
        """The boundary it stands for."""
        names = [face.name for face in self.faces]
        if "contact" in names:
            return "contact"
        return max(self.faces, key=lambda face: face.area).name

    @property
    def boundaries(self) -> tuple[str, ...]:
        """The boundaries that its faces belong to."""
        return tuple(dict.fromkeys(face.name for face in self.faces))

    @property
    def flat(self) -> bool:
        """Whether it is plane."""
        return all(face.flat for face in self.faces) and self._normals_agree()

    def distance(self, points: Array) -> Array:
        """Signed distance (n,), positive outside of the solid; continued beyond the border."""
        if self.flat:
            return self.faces[0].distance(points)
        return nearest(self.faces, points)[1]

    def normal(self, points: Array) -> Array:
        """Outward unit normals (n, 3) at the nearest points."""
        if self.flat:
            return self.faces[0].normal(points)
        return nearest(self.faces, points)[2]

    def misfit(self, points: Array) -> Array:
        """Distance (n,) to the faces as they end."""
        return nearest(self.faces, points)[3]

    def names(self, points: Array) -> NDArray[np.str_]:
        """The boundary (n,) that the nearest of its faces belongs to."""
        names = np.array([face.name for face in self.faces])
        if len(self.boundaries) == 1:
            return np.asarray(np.broadcast_to(names[:1], len(points)))
        return np.asarray(names[nearest(self.faces, points)[0]])

    def _normals_agree(self) -> bool:
        origin = np.zeros((1, 3))
        first = self.faces[0].normal(origin)[0]
        return all(float(face.normal(origin)[0] @ first) > 1.0 - 1e-12 for face in self.faces)


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
        if not body.kind.closed_form:
            shape = f'body.shape = "{body.shape}"'
            raise GeometryError(f"{shape} has no contact surface in closed form")
        try:
            body.kind.axis(body)
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
        return self.body.kind.top_radius(self.body)

    @property
    def crest(self) -> float:
        """Greatest height, at x = z = 0, mm."""
        return crest_height(self.body)

    @property
    def curvatures(self) -> tuple[float, float]:
        """Curvatures at the crest along x and along z, 1/mm (>= 0)."""
        return self.body.kind.curvatures(self.body)

    @property
    def lowest(self) -> float:
        """Least height of the body's contact surface, at its corners, mm."""
        return self.body.kind.lowest(self.body)

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

    def _meridian(self, points: Array) -> tuple[Array, Array, Array]:
        """Points in the outline's plane (n, 2), and the unit vectors along its two axes in space
        (or in the section), shape of ``points``."""
        points = np.asarray(points, dtype=float)
        kind = self.body.kind
        sideways, upward = kind.directions(self.body, points)
        return kind.plane(self.body, points), sideways, upward


def surface_of(body: Body) -> Surface:
    """The contact surface of any body."""
    if body.step is None:
        return ContactSurface.of(body)
    return CadSurface.of(body.step)


def step_carriers(step: StepFile) -> tuple[StepCarrier, ...]:
    """The carriers of a STEP body's outside, of the whole body."""
    grouped: dict[int, list[CadFace]] = {}
    for face in step_facts(step).faces:
        grouped.setdefault(face.group, []).append(face)
    return tuple(StepCarrier(tuple(faces)) for faces in grouped.values())
