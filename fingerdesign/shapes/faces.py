"""The faces of a body as numpy sees them: a shape, its outward side, its border, a name.

A parametric body's are known without a border; those of a STEP body ``cad/step_read.py`` answers
with, once for a file and its rules. Heights, distances and snapping are computed from them. Lengths
in mm, points (n, 3).
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.shapes.nurbs import Nurbs
from fingerdesign.shapes.quadrics import Plane, Shape, dot, unit

# A vertical line that meets the surface this near outside of a face's border counts as meeting it:
# CAD files give places to 1e-7 mm.
ON_BORDER_MM = 1e-6
_SAMPLES = 400  # of a face's inside, for a bound of the distance to it
_SLACK_MM = 1e-5  # of that bound: samples lie on their face to 1e-7 mm
_NEAR = 8  # pieces looked at: those that meet in a corner, and their neighbours
_CORNER_MM = 1e-7  # places nearer to each other are the one corner where two pieces meet


@dataclass(frozen=True)
class Border:
    """The end of a face, in short cubic (Hermite) pieces, exact to h^4/(384 R^3) mm for pieces of
    length h on a curve of radius R.

    Pieces from ``start`` to ``end`` (n, 3) with derivatives by a parameter from 0 to 1 there, and
    unit vectors in the face, toward its inside, at both ends; n = 0: a closed face.
    """

    start: Array
    end: Array
    leaving: Array
    arriving: Array
    inward_start: Array
    inward_end: Array

    def beyond(self, points: Array) -> Array:
        """Distance (n,) from points of the face's surface, (n, 3), to the face as it ends. 0 within
        the face."""
        if not len(self.start) or not len(points):
            return np.zeros(len(points))
        flat, t, place, away = self._near(points)
        k = away.shape[1]
        slope, weight = self._curve(flat, t)[1], t[:, None]
        inward = (1.0 - weight) * self.inward_start[flat] + weight * self.inward_end[flat]
        inward = unit(inward - dot(inward, unit(slope))[:, None] * unit(slope))
        # Where two pieces meet in the nearest point, the sum of their directions points inside.
        best = np.argmin(away, axis=1) + k * np.arange(len(points))
        apart = np.linalg.norm(place.reshape(len(points), k, 3) - place[best][:, None], axis=2)
        toward = ((apart < _CORNER_MM)[..., None] * inward.reshape(len(points), k, 3)).sum(axis=1)
        within = dot(points - place[best], toward) >= 0.0
        return np.asarray(np.where(within, 0.0, away.min(axis=1)))

    def distance(self, points: Array) -> Array:
        """Distance (n,) from any points (n, 3) to the border; infinite where there is none."""
        if not len(self.start) or not len(points):
            return np.full(len(points), np.inf)
        return np.asarray(self._near(points)[3].min(axis=1))

    def _near(self, points: Array) -> tuple[NDArray[Any], Array, Array, Array]:
        """Find k near pieces for each point: their numbers, parameters (n k,) and places (n k, 3)
        nearest to it, and the distances (n, k)."""
        _, near = self._tree.query(points, k=min(_NEAR, len(self.start)))
        near = near.reshape(len(points), -1)
        k = near.shape[1]
        flat, p = near.ravel(), np.repeat(points, k, axis=0)
        a, chord = self.start[flat], self.end[flat] - self.start[flat]
        t = np.clip(dot(p - a, chord) / np.maximum(dot(chord, chord), 1e-300), 0.0, 1.0)
        for _ in range(2):  # onto the curve itself
            place, slope = self._curve(flat, t)
            t = t + dot(p - place, slope) / np.maximum(dot(slope, slope), 1e-300)
            t = np.clip(t, 0.0, 1.0)
        place = self._curve(flat, t)[0]
        return flat, t, place, np.linalg.norm(p - place, axis=1).reshape(len(points), k)

    def _curve(self, rows: NDArray[Any], t: Array) -> tuple[Array, Array]:
        """Places and derivatives (n, 3) of pieces at parameters (n,)."""
        t = t[:, None]
        a, b, da, db = (each[rows] for each in (self.start, self.end, self.leaving, self.arriving))
        place = (1 + 2 * t) * (1 - t) ** 2 * a + t**2 * (3 - 2 * t) * b
        place += t * (1 - t) ** 2 * da + t**2 * (t - 1) * db
        slope = 6 * t * (1 - t) * (b - a) + (1 - t) * (1 - 3 * t) * da + t * (3 * t - 2) * db
        return place, slope

    @cached_property
    def _tree(self) -> Any:
        from scipy.spatial import cKDTree

        return cKDTree(self._curve(np.arange(len(self.start)), np.full(len(self.start), 0.5))[0])


class Carrier:
    """A face of a solid, or several that join smoothly, on which nodes of a mesh lie.

    name: the boundary that it belongs to, "base", "contact", "side", "end", "symmetry", a part's.
    flat: true if it is plane, so that straight mid-nodes lie on it already.
    """

    name: str

    @property
    def flat(self) -> bool:
        return False

    @property
    def boundaries(self) -> tuple[str, ...]:
        """The boundaries that its faces belong to: more than its name where they join smoothly."""
        return (self.name,)

    def names(self, points: Array) -> NDArray[np.str_]:
        """The boundary (n,) that each point's nearest face belongs to."""
        return np.full(len(points), self.name)

    def distance(self, points: Array) -> Array:
        """Signed distance (n,) to it continued beyond its border; positive outside the solid."""
        raise NotImplementedError

    def normal(self, points: Array) -> Array:
        """Outward unit normals (n, 3) at the nearest points of it continued."""
        raise NotImplementedError

    def misfit(self, points: Array) -> Array:
        """Distance (n,) to it as it ends."""
        return np.abs(self.distance(points))


@dataclass(frozen=True, eq=False)
class Face(Carrier):
    """A shape without a border; ``sign`` +1 where its outside is the solid's outside, else -1."""

    name: str
    shape: Shape
    sign: float = 1.0

    @property
    def flat(self) -> bool:
        return isinstance(self.shape, Plane)

    def distance(self, points: Array) -> Array:
        return self.sign * self.shape.distance(points)

    def normal(self, points: Array) -> Array:
        return self.sign * self.shape.normal(points)


@dataclass(frozen=True, eq=False, kw_only=True)
class CadFace(Face):
    """A face of a STEP body.

    group      faces of one number join smoothly, or lie in one plane; -1 before it is known
    area       mm^2
    low, high  corners (3,) of a box that holds the face
    """

    border: Border
    area: float
    low: Array
    high: Array
    group: int = -1

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

    def nearness(self, points: Array) -> tuple[Array, Array, Array]:
        """Signed distance (n,) and normals (n, 3), continued; and the distance (n,) to the face as
        it ends."""
        if isinstance(self.shape, Nurbs):
            uv, place = self.shape.foot(points)
            normal = self.sign * self.shape.normal_at(uv)
            away, apart = dot(points - place, normal), np.linalg.norm(points - place, axis=1)
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


@dataclass(frozen=True)
class Smooth(Carrier):
    """Faces of a STEP body that join smoothly, or lie in one plane: a mesher keeps no edge there.

    ``name``: "contact" where one of them belongs to the contact surface, else that of the largest;
    ``names`` tells several apart.
    """

    name: str
    faces: tuple[CadFace, ...]

    @classmethod
    def of(cls, faces: Sequence[CadFace]) -> Self:
        """The carrier of all faces of one group."""
        names = [face.name for face in faces]
        largest = max(faces, key=lambda face: face.area).name
        return cls("contact" if "contact" in names else largest, tuple(faces))

    @property
    def boundaries(self) -> tuple[str, ...]:
        return tuple(dict.fromkeys(face.name for face in self.faces))

    @cached_property
    def flat(self) -> bool:
        origin = np.zeros((1, 3))
        if not all(face.flat for face in self.faces):
            return False
        normals = np.vstack([face.normal(origin) for face in self.faces])
        return bool((normals @ normals[0] > 1.0 - 1e-12).all())

    def distance(self, points: Array) -> Array:
        if self.flat:
            return self.faces[0].distance(points)
        return nearest(self.faces, points)[1]

    def normal(self, points: Array) -> Array:
        if self.flat:
            return self.faces[0].normal(points)
        return nearest(self.faces, points)[2]

    def misfit(self, points: Array) -> Array:
        return nearest(self.faces, points)[3]

    def names(self, points: Array) -> NDArray[np.str_]:
        if len(self.boundaries) == 1:
            return np.full(len(points), self.boundaries[0])
        return np.array([face.name for face in self.faces])[nearest(self.faces, points)[0]]


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
