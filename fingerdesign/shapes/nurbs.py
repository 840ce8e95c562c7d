"""A NURBS surface: points, derivatives, nearest points, heights (numpy and scipy).

S(u, v) = sum N_i(u) N_j(v) w_ij P_ij / sum N_i(u) N_j(v) w_ij with B-spline bases N (Piegl and
Tiller, The NURBS Book, 2nd ed., eq. 4.15). Nearest points by Newton's method on the squared
distance, from the nearest of many samples. Lengths in mm.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.errors import GeometryError
from fingerdesign.shapes.quadrics import dot, unit

SAMPLES = 4000  # of a face, from which Newton starts
BEYOND = 0.03  # of the parameters' range: how far a surface is continued beyond its border
POLE_MM = 1e-5  # a border smaller than this is a point: CAD files are good to 1e-7 mm
_PASSES = 300  # six from a near start; more near a centre of curvature
_FALLS = 40  # along vertical lines; a pole is neared tenfold each time
_PATIENCE = 4  # passes that bring a line no nearer
_STARTS = 3
_STALL = 30  # passes after which a distance that changes no more will do
_CREEP = 1e-9  # of the size: by so little may a distance fall in the last _STALL passes


@dataclass(frozen=True)
class Nurbs:
    """A surface of degrees (p, q) with flat knot vectors, poles (m, n, 3) and weights (m, n).

    ``bounds``: (u0, u1, v0, v1), the part that the face needs; ``closed``: whether it runs into
    itself along u, along v. Outside: along the cross product of the derivatives by u and v.
    """

    degrees: tuple[int, int]
    knots_u: Array
    knots_v: Array
    poles: Array
    weights: Array
    bounds: tuple[float, float, float, float]
    closed: tuple[bool, bool] = (False, False)

    def at(self, u: Array, v: Array) -> Array:
        """Points (n, 3) at parameters (n,)."""
        found = self._spline(np.column_stack([u, v]), nu=(0, 0))
        return np.asarray(found[:, :3] / found[:, 3:])

    def derivatives(self, u: Array, v: Array) -> tuple[Array, Array, Array, Array, Array, Array]:
        """S, S_u, S_v, S_uu, S_uv, S_vv, each (n, 3); continued by its end polynomials."""
        orders, places = ((0, 0), (1, 0), (0, 1), (2, 0), (1, 1), (0, 2)), np.column_stack([u, v])
        sums = [self._spline(places, nu=order) for order in orders]  # of (w S, w), (n, 4)
        (s, su, sv, suu, suv, svv), (weight, wu, wv, wuu, wuv, wvv) = (
            [each[:, part] for each in sums] for part in (slice(0, 3), slice(3, 4))
        )
        point = s / weight
        by_u, by_v = (su - wu * point) / weight, (sv - wv * point) / weight
        by_uu = (suu - 2.0 * wu * by_u - wuu * point) / weight
        by_uv = (suv - wu * by_v - wv * by_u - wuv * point) / weight
        by_vv = (svv - 2.0 * wv * by_v - wvv * point) / weight
        return point, by_u, by_v, by_uu, by_uv, by_vv

    @cached_property
    def _spline(self) -> Any:
        """The surface in homogeneous coordinates (w S, w); beyond its knots the end polynomials."""
        from scipy.interpolate import NdBSpline

        weights = self.weights[..., None]
        poles = np.concatenate([weights * self.poles, weights], axis=2)
        return NdBSpline((self.knots_u, self.knots_v), poles, self.degrees, extrapolate=True)

    def sampled(self) -> Array:
        """Points (n, 3) all over the part within ``bounds``."""
        return self.at(*self._samples[1].T)

    def foot(self, points: Array) -> tuple[Array, Array]:
        """Parameters (n, 2) and place (n, 3) of the nearest points; the surface is continued a
        little (``BEYOND``). Raises GeometryError where Newton's method does not end and the
        distance still falls."""
        tree, where = self._samples
        _, nearest = tree.query(points)
        uv, damping = where[nearest].copy(), np.zeros(len(points))
        least = self._away(points, uv)
        late = least
        size = float(np.ptp(self.poles.reshape(-1, 3), axis=0).max())
        open_rows = np.arange(len(points))
        for turn in range(_PASSES):
            if not len(open_rows):
                break
            if turn == _PASSES - _STALL:
                late = least.copy()
            here = uv[open_rows]
            step, slope = self._newton(points[open_rows], here, damping[open_rows])
            new = self._kept(here, step)
            after = self._away(points[open_rows], new)
            worse = after > least[open_rows] * (1.0 + 1e-14) + 1e-15 * size
            more, less = np.maximum(4.0 * damping[open_rows], 1e-2), 0.25 * damping[open_rows]
            damping[open_rows] = np.where(worse, more, less)
            moved = np.linalg.norm(step * slope, axis=1)
            # Near a centre of curvature the foot hardly matters, and is hardly to be found.
            stalled = (turn > _STALL) & (np.abs(after - least[open_rows]) < 1e-14 * size)
            uv[open_rows[~worse]], least[open_rows[~worse]] = new[~worse], after[~worse]
            going = worse & (damping[open_rows] < 1e12) | (moved > 1e-12 * size)
            open_rows = open_rows[going & ~stalled]
        # Near a centre of curvature a foot creeps along points of equal distance.
        open_rows = open_rows[late[open_rows] - least[open_rows] > _CREEP * size]
        if len(open_rows):
            raise GeometryError(
                f"a face of the STEP body has no nearest point found for {len(open_rows)} points, "
                f"as {np.round(points[open_rows[0]], 4).tolist()}"
            )
        return uv, self.at(*uv.T)

    def _away(self, points: Array, uv: Array) -> Array:
        return np.asarray(np.linalg.norm(points - self.at(*uv.T), axis=1))

    def _newton(self, points: Array, uv: Array, damping: Array) -> tuple[Array, Array]:
        """The step (n, 2) that lessens the distance, and lengths of the derivatives (n, 2)."""
        s, su, sv, suu, suv, svv = self.derivatives(*uv.T)
        away = s - points
        metric = np.stack([dot(su, su), dot(su, sv), dot(sv, sv)])
        hessian = metric + np.stack([dot(away, suu), dot(away, suv), dot(away, svv)])
        low, high = self._limits
        g, h = dot(away, su), dot(away, sv)
        # At a limit that the descent pushes against, the step runs along it.
        held_u = ((uv[:, 0] <= low[0]) & (g > 0)) | ((uv[:, 0] >= high[0]) & (g < 0))
        held_v = ((uv[:, 1] <= low[1]) & (h > 0)) | ((uv[:, 1] >= high[1]) & (h < 0))
        held_u, held_v = held_u & (not self.closed[0]), held_v & (not self.closed[1])
        g, h = np.where(held_u, 0.0, g), np.where(held_v, 0.0, h)
        hessian[1] = np.where(held_u | held_v, 0.0, hessian[1])
        metric[1] = np.where(held_u | held_v, 0.0, metric[1])
        hessian[0] = np.where(held_u, metric[0], hessian[0])
        hessian[2] = np.where(held_v, metric[2], hessian[2])
        a, b, c = hessian + (_lift(hessian, metric) + damping) * metric
        det = np.maximum(a * c - b * b, 1e-300)
        du, dv = (b * h - c * g) / det, (b * g - a * h) / det
        step = self._bounded(uv, np.column_stack([du, dv]))
        return step, np.sqrt(np.column_stack([metric[0], metric[2]]))

    def _bounded(self, uv: Array, step: Array) -> Array:
        """A step (n, 2) that stays within the limits, and goes nine tenths of the way to a pole at
        most: in the pole itself one parameter means nothing."""
        low, high = self._limits
        longest = 0.25 * (high - low)
        step = np.clip(step, -longest, longest)
        share = np.where(self._poles, 0.9, 1.0)
        inside = np.clip(step, share[0] * (low - uv), share[1] * (high - uv))
        return np.where(np.array(self.closed), step, inside)

    def _kept(self, uv: Array, step: Array) -> Array:
        """Parameters (n, 2) after a step, once around where the surface is closed."""
        start, end = np.array(self.bounds).reshape(2, 2).T
        around = start + np.mod(uv + step - start, end - start)
        low, high = self._limits
        return np.where(np.array(self.closed), around, np.clip(uv + step, low, high))

    def normal_at(self, uv: Array) -> Array:
        """Unit normals (n, 3) at parameters (n, 2)."""
        _, su, sv, *_ = self.derivatives(*uv.T)
        normal = np.cross(su, sv)
        flat = np.linalg.norm(normal, axis=1) < 1e-9 * np.abs(self.poles).max()
        if flat.any():  # at a pole of the parameters: next to it
            middle = np.array(self.bounds).reshape(2, 2).mean(axis=1)
            _, su, sv, *_ = self.derivatives(*(uv[flat] + 1e-7 * (middle - uv[flat])).T)
            normal[flat] = np.cross(su, sv)
        return unit(normal)

    def distance(self, points: Array) -> Array:
        """Signed distance (n,), along the normal at the nearest point."""
        uv, place = self.foot(points)
        return dot(points - place, self.normal_at(uv))

    def normal(self, points: Array) -> Array:
        """Unit normals (n, 3) at the nearest points."""
        return self.normal_at(self.foot(points)[0])

    def heights(self, x: Array, z: Array) -> Array:
        """Heights (k, n) at which vertical lines meet the surface, by Newton's method from the
        nearest samples, and from others near that lie at another height (an overhang)."""
        where, tree, flat = self._seen_from_above
        targets = np.column_stack([x, z])
        apart, nearest = tree.query(targets, k=min(_STARTS, len(flat)))
        spacing = 3.0 * self._spacing
        found = np.full(nearest.shape, np.nan).T
        for k in range(len(found)):
            rows = apart[:, k] < spacing
            if k:  # the first start's answer will do, unless this one lies on another sheet
                rows &= ~(np.abs(flat[nearest[:, k], 1] - found[0]) < spacing)
            rows = np.flatnonzero(rows)
            found[k, rows] = self._height_from(where[nearest[rows, k]], targets[rows])
        return found

    def _height_from(self, uv: Array, targets: Array) -> Array:
        """Heights (n,) over (x, z) targets (n, 2) from starts uv (n, 2); NaN where none is met."""
        found = np.full(len(uv), np.nan)
        alive, uv = np.arange(len(uv)), uv.copy()
        before, idle = np.full(len(uv), np.inf), np.zeros(len(uv), dtype=int)
        for _ in range(_FALLS):
            if not len(alive):
                break
            s, su, sv, *_ = self.derivatives(*uv[alive].T)
            miss = targets[alive] - s[:, [0, 2]]
            away = np.linalg.norm(miss, axis=1)
            hit = away < 1e-13 * (1.0 + np.abs(targets[alive]).max(axis=1))
            idle[alive] = np.where(away > 0.9 * before[alive], idle[alive] + 1, 0)
            before[alive] = away
            found[alive[hit]] = s[hit, 1]
            det = su[:, 0] * sv[:, 2] - su[:, 2] * sv[:, 0]
            det = np.where(np.abs(det) < 1e-12, np.copysign(1e-12, det), det)
            du = (miss[:, 0] * sv[:, 2] - miss[:, 1] * sv[:, 0]) / det
            dv = (su[:, 0] * miss[:, 1] - su[:, 2] * miss[:, 0]) / det
            step = self._bounded(uv[alive], np.column_stack([du, dv]))
            new = self._kept(uv[alive], step)
            # A line that is met comes nearer by half at least; one met 1e-13 mm away may stay.
            going = ~hit & (idle[alive] < _PATIENCE)
            going &= (np.abs(step) > 1e-15 * np.ptp(self.bounds)).any(axis=1)
            ended = ~hit & ~going & (away < 1e-9)
            found[alive[ended]] = s[ended, 1]
            uv[alive] = new
            alive = alive[going]
        if len(alive):
            s = self.at(*uv[alive].T)
            met = np.linalg.norm(s[:, [0, 2]] - targets[alive], axis=1) < 1e-9
            found[alive[met]] = s[met, 1]
        return found

    @cached_property
    def _seen_from_above(self) -> tuple[Array, Any, Array]:
        """Parameters (n, 2) of samples, a tree of their (x, z), and their points (n, 3)."""
        from scipy.spatial import cKDTree

        points = self.sampled()
        return self._samples[1], cKDTree(points[:, [0, 2]]), points

    @cached_property
    def _spacing(self) -> float:
        """Greatest distance of a sample from its eighth neighbour, mm."""
        tree, where = self._samples
        return float(tree.query(self.at(*where.T), k=9)[0].max())

    @cached_property
    def _limits(self) -> tuple[Array, Array]:
        u0, u1, v0, v1 = self.bounds
        low, high = np.array([u0, v0]), np.array([u1, v1])
        margin = BEYOND * (high - low) * ~self._poles  # beyond a pole it would turn inside out
        return low - margin[0], high + margin[1]

    @cached_property
    def _poles(self) -> BoolArray:
        """True where the surface is a point, at the least and greatest (rows) u and v (columns)."""
        u0, u1, v0, v1 = self.bounds
        u, v, full = np.linspace(u0, u1, 9), np.linspace(v0, v1, 9), np.ones(9)
        borders = (u0 * full, v), (u, v0 * full), (u1 * full, v), (u, v1 * full)
        sizes = [float(np.ptp(self.at(*border), axis=0).max()) for border in borders]
        return np.array(sizes).reshape(2, 2) < POLE_MM

    @cached_property
    def _samples(self) -> tuple[Any, Array]:
        """A tree of sampled points, and their parameters (n, 2)."""
        from scipy.spatial import cKDTree

        u0, u1, v0, v1 = self.bounds
        line, full = np.linspace(0.0, 1.0, 33), np.ones(33)
        wide = self.at(u0 + (u1 - u0) * line, 0.5 * (v0 + v1) * full)
        tall = self.at(0.5 * (u0 + u1) * full, v0 + (v1 - v0) * line)
        lengths = [np.linalg.norm(np.diff(p, axis=0), axis=1).sum() + 1e-9 for p in (wide, tall)]
        number = int(np.clip(np.sqrt(SAMPLES * lengths[0] / lengths[1]), 16, SAMPLES // 16))
        across = SAMPLES // number
        by_u = u0 + (u1 - u0) * (np.arange(number) + 0.5) / number
        by_v = v0 + (v1 - v0) * (np.arange(across) + 0.5) / across
        where = np.stack(np.meshgrid(by_u, by_v, indexing="ij"), axis=-1).reshape(-1, 2)
        return cKDTree(self.at(*where.T)), where


def _lift(hessian: Array, metric: Array) -> Array:
    """Multiple of the metric (n,) that makes a Hessian positive: (3, n) each, entries 11, 12, 22.

    None where its least eigenvalue, relative to the metric, is positive; else so much that this
    keeps its size and loses its sign: beyond a centre of curvature Newton's step would climb.
    """
    size = np.maximum(metric[0] * metric[2] - metric[1] ** 2, 1e-300)
    half = hessian[0] * metric[2] - 2.0 * hessian[1] * metric[1] + hessian[2] * metric[0]
    half = 0.5 * half / size
    product = (hessian[0] * hessian[2] - hessian[1] ** 2) / size
    least = half - np.sqrt(np.maximum(half**2 - product, 0.0))
    return np.where(least > 1e-3, 0.0, np.maximum(np.abs(least), 0.05) - least)
