"""The faces of a STEP body as numpy sees them: a shape, its outward side, its border, a name.

``geometry/step_worker.py`` writes them as arrays, once for a file and its rules; everything after
it (heights, distances, snapping) is computed from those. Lengths in mm, points (n, 3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.face_border import Border
from fingerdesign.design.nurbs import Nurbs
from fingerdesign.design.quadrics import Cone, Plane, Shape, Sphere, Torus

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]

# A vertical line that meets the surface this near outside of a face's border counts as meeting it:
# CAD files give places to 1e-7 mm.
ON_BORDER_MM = 1e-6


@dataclass(frozen=True)
class CadFace:
    """One face: ``sign`` +1 where its shape's outside is the solid's outside, else -1.

    name   "base" | "contact" | "side" | "end"
    group  faces of one number join smoothly, or lie in one plane
    area   mm^2
    """

    shape: Shape
    sign: float
    border: Border
    name: str
    group: int
    area: float

    @property
    def flat(self) -> bool:
        """Whether it is plane."""
        return isinstance(self.shape, Plane)

    def distance(self, points: Array) -> Array:
        """Signed distance (n,) to the face continued beyond its border; positive outside."""
        return self.sign * self.shape.distance(points)

    def normal(self, points: Array) -> Array:
        """Outward unit normals (n, 3) at the nearest points of the face continued."""
        return self.sign * self.shape.normal(points)

    def nearness(self, points: Array) -> tuple[Array, Array, Array]:
        """Signed distance (n,) and normals (n, 3), continued; and the distance (n,) to the face as
        it ends."""
        if isinstance(self.shape, Nurbs):
            uv, place = self.shape.foot(points)
            normal = self.sign * self.shape.normal_at(uv)
            offset = points - place
            away = np.einsum("ij,ij->i", offset, normal)
            apart = np.linalg.norm(offset, axis=1)
        else:
            away, normal = self.distance(points), self.normal(points)
            place, apart = points - away[:, None] * normal, np.abs(away)
        return away, normal, np.hypot(apart, self.border.beyond(place))

    def heights(self, x: Array, z: Array) -> Array:
        """Heights (k, n) at which vertical lines meet the face; NaN where they do not."""
        found = self.shape.heights(x, z)
        for row in found:
            known = np.flatnonzero(np.isfinite(row))
            places = np.column_stack([x[known], row[known], z[known]])
            row[known[self.border.beyond(places) > ON_BORDER_MM]] = np.nan
        return found


def nearest(faces: Sequence[CadFace], points: Array) -> tuple[IntArray, Array, Array, Array]:
    """The face (n,) nearest to each point as they end; its signed distance (n,) and normal (n, 3),
    continued; the distance (n,) as it ends."""
    if len(faces) == 1:
        away, normal, misfit = faces[0].nearness(points)
        return np.zeros(len(points), dtype=np.int64), away, normal, misfit
    owner = np.zeros(len(points), dtype=np.int64)
    away, misfit = np.zeros(len(points)), np.full(len(points), np.inf)
    normal = np.zeros((len(points), 3))
    for number, face in enumerate(faces):
        each, direction, apart = face.nearness(points)
        # Where two are equally near (at their common edge) the farther inside one plane: convex.
        better = apart < misfit - 1e-12
        owner[better], away[better], misfit[better] = number, each[better], apart[better]
        normal[better] = direction[better]
    return owner, away, normal, misfit


def top_height(faces: Sequence[CadFace], x: Array, z: Array) -> Array:
    """Greatest height (n,) at which a vertical line meets one of the faces; NaN where none."""
    best = np.full(len(x), -np.inf)
    for face in faces:
        best = np.fmax(best, np.fmax.reduce(face.heights(x, z)))
    return np.where(np.isfinite(best), best, np.nan)


def arrays_of(faces: Sequence[CadFace]) -> tuple[list[dict[str, Any]], dict[str, Array]]:
    """Faces as plain words and numbers (JSON) and named arrays, for a file."""
    about: list[dict[str, Any]] = []
    arrays: dict[str, Array] = {}
    for number, face in enumerate(faces):
        words: dict[str, Any] = {
            "shape": type(face.shape).__name__,
            "sign": face.sign,
            "name": face.name,
            "group": face.group,
            "area": face.area,
            "values": {},
        }
        for table, owner in (("border", face.border), ("shape", face.shape)):
            for key in (field.name for field in fields(owner)):  # type: ignore[arg-type]
                value = getattr(owner, key)
                if isinstance(value, np.ndarray):
                    arrays[f"{number}.{table}.{key}"] = value
                elif isinstance(value, (int, float, tuple)):
                    words["values"][key] = value
        about.append(words)
    return about, arrays


_SHAPES: dict[str, Any] = {each.__name__: each for each in (Plane, Cone, Sphere, Torus, Nurbs)}


def faces_of(about: Sequence[Mapping[str, Any]], arrays: Mapping[str, Array]) -> list[CadFace]:
    """The faces that :func:`arrays_of` wrote. KeyError or ValueError where they do not fit."""
    faces = []
    for number, words in enumerate(about):
        tables: dict[str, dict[str, Any]] = {"border": {}, "shape": {}}
        for name in arrays:
            head, _, rest = name.partition(".")
            if head == str(number):
                table, _, key = rest.partition(".")
                tables[table][key] = arrays[name]
        values = {
            key: tuple(value) if isinstance(value, list) else value
            for key, value in words["values"].items()
        }
        shape: Any = _SHAPES[words["shape"]](**tables["shape"], **values)
        faces.append(
            CadFace(
                shape,
                float(words["sign"]),
                Border(**tables["border"]),
                str(words["name"]),
                int(words["group"]),
                float(words["area"]),
            )
        )
    return faces


def renamed(face: CadFace, name: str, group: int) -> CadFace:
    """The same face under another name and group."""
    return replace(face, name=name, group=group)
