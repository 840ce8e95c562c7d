"""The faces of a STEP body as numpy sees them: a shape, its outward side, its border, a name.

``cad/step_read.py`` answers with them as arrays, once for a file and its rules; everything after
it (heights, distances, snapping) is computed from those. Lengths in mm, points (n, 3).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.shapes.border import Border
from fingerdesign.shapes.nurbs import Nurbs
from fingerdesign.shapes.quadrics import Cone, Plane, Shape, Sphere, Torus

# A vertical line that meets the surface this near outside of a face's border counts as meeting it:
# CAD files give places to 1e-7 mm.
ON_BORDER_MM = 1e-6
_SAMPLES = 400  # of a face's inside, for a bound of the distance to it
_SLACK_MM = 1e-5  # of that bound: samples lie on their face to 1e-7 mm


@dataclass(frozen=True, eq=False)
class CadFace:
    """One face: ``sign`` +1 where its shape's outside is the solid's outside, else -1.

    name       "base" | "contact" | "side" | "end"
    group      faces of one number join smoothly, or lie in one plane
    area       mm^2
    low, high  corners (3,) of a box that holds the face
    """

    shape: Shape
    sign: float
    border: Border
    name: str
    group: int
    area: float
    low: Array
    high: Array

    @cached_property
    def samples(self) -> Array:
        """Points (n, 3) on the face: of its border, and of its inside."""
        if isinstance(self.shape, Nurbs):
            inner = self.shape.sampled()
        else:
            share = np.random.default_rng(0).uniform(0.0, 1.0, (_SAMPLES, 3))
            inner = self.low + share * (self.high - self.low)
            inner = inner - self.shape.distance(inner)[:, None] * self.shape.normal(inner)
        return np.vstack([self.border.start, inner[self.border.beyond(inner) == 0.0]])

    def apart(self, points: Array) -> Array:
        """A lower bound (n,) of the distance from points to the face: that to its box."""
        out = np.maximum(np.maximum(self.low - points, points - self.high), 0.0)
        return np.asarray(np.linalg.norm(out, axis=1))

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
        outside = np.flatnonzero(self.border.beyond(place) > 0.0)
        apart[outside] = self.border.distance(points[outside])
        return away, normal, apart

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
    at_most = _tree(tuple(faces)).query(points)[0] + _SLACK_MM
    for number, face in enumerate(faces):
        rows = np.flatnonzero(face.apart(points) <= np.minimum(misfit + 1e-9, at_most))
        if not len(rows):
            continue
        each, direction, apart = face.nearness(points[rows])
        # At a sharp edge both faces are as near; the one seen more from outside tells the side.
        tie = np.abs(apart - misfit[rows]) <= 1e-9
        better = np.where(tie, np.abs(each) > np.abs(away[rows]) + 1e-12, apart < misfit[rows])
        rows = rows[better]
        owner[rows], away[rows], misfit[rows] = number, each[better], apart[better]
        normal[rows] = direction[better]
    return owner, away, normal, misfit


@lru_cache(maxsize=64)
def _tree(faces: tuple[CadFace, ...]) -> Any:
    """A tree of points on the faces: the nearest bounds the distance to the faces from above."""
    from scipy.spatial import cKDTree

    return cKDTree(np.vstack([face.samples for face in faces]))


def top_height(faces: Sequence[CadFace], x: Array, z: Array) -> Array:
    """Greatest height (n,) at which a vertical line meets one of the faces; NaN where none."""
    best = np.full(len(x), np.nan)
    for face in faces:
        rows = (x >= face.low[0] - ON_BORDER_MM) & (x <= face.high[0] + ON_BORDER_MM)
        rows &= (z >= face.low[2] - ON_BORDER_MM) & (z <= face.high[2] + ON_BORDER_MM)
        if rows.any():
            best[rows] = np.fmax(best[rows], np.fmax.reduce(face.heights(x[rows], z[rows])))
    return best


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
            "low": face.low.tolist(),
            "high": face.high.tolist(),
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
                np.array(words["low"]),
                np.array(words["high"]),
            )
        )
    return faces


def renamed(face: CadFace, name: str, group: int) -> CadFace:
    """The same face under another name and group."""
    return replace(face, name=name, group=group)
