"""A STEP body's contact surface, its faces to snap to, and its solid (numpy; kernel when asked).

The faces are those that the worker described (design/step_facts.py): closed forms and NURBS, so
distances and heights are those of the true surface, not of a tessellation.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.design.cad_faces import CadFace, nearest
from fingerdesign.design.step_facts import StepFacts, outline_file, step_facts
from fingerdesign.errors import GeometryError

if TYPE_CHECKING:
    import cadquery as cq

    from fingerdesign.design.body_table import StepFile


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


def step_carriers(step: StepFile) -> tuple[StepCarrier, ...]:
    """The carriers of a STEP body's outside, of the whole body."""
    grouped: dict[int, list[CadFace]] = {}
    for face in step_facts(step).faces:
        grouped.setdefault(face.group, []).append(face)
    return tuple(StepCarrier(tuple(faces)) for faces in grouped.values())


def step_outline(step: StepFile) -> cq.Solid:
    """The body's solid, turned and moved, for the CAD kernel (which this loads).

    GeometryError where what was kept cannot be read any more.
    """
    import cadquery as cq

    kept = outline_file(step)
    try:
        shape = cq.Shape.importBrep(str(kept))
        solids: Sequence[cq.Solid] = [shape] if isinstance(shape, cq.Solid) else shape.Solids()
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(f"the kept solid {kept.name} cannot be read: {error}") from error
    if len(solids) != 1:
        raise GeometryError(f"the kept solid {kept.name} holds {len(solids)} solids")
    return solids[0]
