"""The section's upper outline in closed form: an arc or a flat top, its edges, down to the side.

Half of it, x >= 0, as pieces from the crest outward; the other half mirrors it. Every parametric
body is this outline drawn straight along z, revolved about a line along x (dome) or about y
(revolved): in its plane one formula serves all, edges included. Each kind of body, by the name that
``body.shape`` takes, answers for its own geometry. Numpy only; lengths in mm; points (n, 2) are
(x, y), those asked of a body also (n, 3).
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.body import Body, BodyKind, body
from fingerdesign.design.step import StepFacts, step_facts
from fingerdesign.errors import GeometryError


@dataclass(frozen=True)
class Piece:
    """A line (``radius`` 0), or an arc about (``x``, ``y``), convex outward, from start to end."""

    start: tuple[float, float]
    end: tuple[float, float]
    x: float = 0.0
    y: float = 0.0
    radius: float = 0.0

    def distance(self, points: Array) -> Array:
        """Signed distance (n,) to the piece continued beyond its ends; positive outside."""
        if self.radius:
            return np.asarray(np.hypot(points[:, 0] - self.x, points[:, 1] - self.y) - self.radius)
        return np.asarray((points - np.array(self.start)) @ self._line_normal)

    def normal(self, points: Array) -> Array:
        """Outward unit normals (n, 2) at the nearest points of the piece continued."""
        if not self.radius:
            return np.tile(self._line_normal, (len(points), 1))
        offset = points - np.array([self.x, self.y])
        return np.asarray(offset / np.maximum(np.linalg.norm(offset, axis=1), 1e-300)[:, None])

    def beyond(self, points: Array) -> Array:
        """How far (n,) the nearest point of the piece continued lies beyond its ends, mm; or 0."""
        a, b = np.array(self.start), np.array(self.end)
        if not self.radius:
            along = (b - a) / np.linalg.norm(b - a)
            s = (points - a) @ along
            return np.asarray(np.maximum(np.maximum(-s, s - np.linalg.norm(b - a)), 0.0))
        centre = np.array([self.x, self.y])
        angle = np.arctan2(*(points - centre).T)  # clockwise from +y
        first, last = (float(np.arctan2(*(end - centre))) for end in (a, b))
        return np.asarray(self.radius * np.maximum(np.maximum(first - angle, angle - last), 0.0))

    def height(self, x: Array) -> Array:
        """Height of the piece continued over x (n,)."""
        if self.radius:
            return np.asarray(self.y + np.sqrt(np.maximum(self.radius**2 - (x - self.x) ** 2, 0.0)))
        (x0, y0), (x1, y1) = self.start, self.end
        return np.asarray(y0 + (x - x0) * (y1 - y0) / (x1 - x0))

    @property
    def length(self) -> float:
        """Length of the piece, mm."""
        chord = float(np.hypot(self.end[0] - self.start[0], self.end[1] - self.start[1]))
        if not self.radius:
            return chord
        return float(2.0 * self.radius * np.arcsin(min(1.0, 0.5 * chord / self.radius)))

    @property
    def _line_normal(self) -> Array:
        (x0, y0), (x1, y1) = self.start, self.end
        return np.asarray(np.array([y0 - y1, x1 - x0]) / np.hypot(x1 - x0, y1 - y0))


@dataclass(frozen=True)
class Profile:
    """The pieces from the crest (x = 0) to the side (x = half_width, y = side_height)."""

    pieces: tuple[Piece, ...]

    @property
    def crest(self) -> float:
        """Greatest height, mm."""
        return self.pieces[0].start[1]

    @property
    def half_width(self) -> float:
        """x of the straight side, mm."""
        return self.pieces[-1].end[0]

    @property
    def side_height(self) -> float:
        """Height of the straight side, mm."""
        return self.pieces[-1].end[1]

    @property
    def area(self) -> float:
        """Area of the whole section, both halves, down to y = 0, mm^2."""
        _, y, weights = self.gauss_points()
        return float(2.0 * weights[:, 0] @ y)

    def chains(self) -> tuple[tuple[Piece, ...], ...]:
        """The pieces in groups that join without an edge (under 12 degrees)."""
        groups = [[self.pieces[0]]]
        for before, after in zip(self.pieces, self.pieces[1:], strict=False):
            joint = np.array([before.end])
            turn = float(before.normal(joint)[0] @ after.normal(joint)[0])
            if turn > np.cos(np.radians(12.0)):
                groups[-1].append(after)
            else:
                groups.append([after])
        return tuple(tuple(group) for group in groups)

    def height(self, place: Array | float) -> Array:
        """Height over x, both halves; NaN beyond the last piece's reach."""
        x: Array = np.abs(np.asarray(place, dtype=float))
        found = np.full(x.shape, np.nan)
        for k, piece in enumerate(self.pieces):
            last = k == len(self.pieces) - 1
            most = piece.x + piece.radius if last and piece.radius else piece.end[0]
            if last and not piece.radius:
                most = np.inf
            rows = (x >= piece.start[0]) & (x <= most * (1.0 + 1e-12)) & np.isnan(found)
            found = np.where(rows, piece.height(x), found)
        return np.asarray(found)

    def gauss_points(self) -> tuple[Array, Array, Array]:
        """Gauss points x (n,), heights and weights of the integral over x of half the outline.

        Piece by piece in the arc's angle, where a dome's integrands are smooth (error near 1e-15);
        weights are dx and, as a second column, the outline's length.
        """
        nodes, weights = np.polynomial.legendre.leggauss(64)
        nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
        xs, ys, ws = [], [], []
        for piece in self.pieces:
            (x0, y0), (x1, y1) = piece.start, piece.end
            if piece.radius:
                first, last = (
                    float(np.arctan2(x - piece.x, y - piece.y)) for x, y in ((x0, y0), (x1, y1))
                )
                angle = first + (last - first) * nodes
                xs.append(piece.x + piece.radius * np.sin(angle))
                ys.append(piece.y + piece.radius * np.cos(angle))
                length = weights * (last - first) * piece.radius
                ws.append(np.column_stack([length * np.cos(angle), length]))
            else:
                xs.append(x0 + (x1 - x0) * nodes)
                ys.append(y0 + (y1 - y0) * nodes)
                ws.append(np.column_stack([weights * (x1 - x0), weights * piece.length]))
        return np.concatenate(xs), np.concatenate(ys), np.vstack(ws)


def _folded(points: Array) -> Array:
    return np.column_stack([np.abs(points[:, 0]), points[:, 1]])


def nearest_piece(pieces: tuple[Piece, ...], points: Array) -> IntArray:
    """The piece (n,) that holds the nearest point of a chain, for points (n, 2) of either half."""
    if len(pieces) == 1:
        return np.zeros(len(points), dtype=np.int64)
    folded = _folded(points)
    away = [np.hypot(piece.distance(folded), piece.beyond(folded)) for piece in pieces]
    return np.asarray(np.argmin(away, axis=0), dtype=np.int64)


def chain_distance(pieces: tuple[Piece, ...], points: Array) -> Array:
    """Signed distance (n,) of points (n, 2) to the pieces, mirrored in x = 0."""
    owner, folded = nearest_piece(pieces, points), _folded(points)
    each = np.stack([piece.distance(folded) for piece in pieces])
    return np.asarray(each[owner, np.arange(len(points))])


def chain_misfit(pieces: tuple[Piece, ...], points: Array) -> Array:
    """Distance (n,) of points (n, 2) to the pieces as they end, not continued."""
    folded = _folded(points)
    away = [np.hypot(piece.distance(folded), piece.beyond(folded)) for piece in pieces]
    return np.asarray(np.min(away, axis=0))


def chain_normal(pieces: tuple[Piece, ...], points: Array) -> Array:
    """Outward unit normals (n, 2) of the pieces, mirrored in x = 0, nearest to points (n, 2)."""
    owner, folded = nearest_piece(pieces, points), _folded(points)
    each = np.stack([piece.normal(folded) for piece in pieces])
    normal = each[owner, np.arange(len(points))]
    normal[:, 0] *= np.where(points[:, 0] < 0.0, -1.0, 1.0)
    return np.asarray(normal)


@lru_cache(maxsize=256)
def _outline(
    half: float, height: float, radius: float, edge: float | None, chamfer: bool
) -> Profile:
    flat = not np.isfinite(radius)
    crest = height if flat else height + radius - float(np.sqrt(radius**2 - half**2))
    middle = crest - radius  # the arc's centre

    def top(x: float) -> float:
        return height if flat else middle + float(np.sqrt(radius**2 - x**2))

    def upper(end: tuple[float, float]) -> Piece:
        start = (0.0, crest)
        return Piece(start, end) if flat else Piece(start, end, 0.0, middle, radius)

    side = (half, height)
    if edge is None:
        return Profile((upper(side),))
    if chamfer:
        corner = (half - edge, top(half - edge))
        return Profile((upper(corner), Piece(corner, (half, height - edge))))
    x = half - edge
    if flat:
        y, joint = height - edge, (x, height)
    else:
        y = middle + float(np.sqrt((radius - edge) ** 2 - x**2))
        share = radius / (radius - edge)
        joint = (share * x, middle + share * (y - middle))
    rounding = Piece(joint, (half, y), x, y, edge)
    return Profile((upper(joint), rounding) if joint[0] > 1e-9 else (rounding,))


def profile_of(body: Body) -> Profile:
    """The outline of a parametric body. ValueError where the edge leaves nothing of the top."""
    radius = body.kind.top_radius(body)
    half, edge = 0.5 * body.width_mm, body.edge_radius_mm
    if radius < half or (edge is not None and not edge <= min(half, radius)):
        raise ValueError("the arc or its edge does not fit the width")
    return _outline(half, body.base_height_mm, radius, edge, body.edge == "chamfer")


@body("arc", place=1)
class Straight(BodyKind):
    """The outline drawn straight along z."""

    straight = True
    words = "an arc of radius {radius:g} mm on top, the same all along z"

    def height(self, body: Body, x: Array, z: Array) -> Array:
        return profile_of(body).height(x)

    def plane(self, body: Body, points: Array) -> Array:
        return np.column_stack([points[:, 0], points[:, 1]])

    def directions(self, body: Body, points: Array) -> tuple[Array, Array]:
        sideways, upward = np.zeros_like(points), np.zeros_like(points)
        sideways[:, 0] = upward[:, 1] = 1.0
        return sideways, upward

    def curvatures(self, body: Body) -> tuple[float, float]:
        return 1.0 / self.top_radius(body), 0.0

    def lowest(self, body: Body) -> float:
        return profile_of(body).side_height

    def row_radius(self, body: Body, along: str, middle: float) -> float | None:
        return self.top_radius(body) if along == "x" else np.inf

    def volume(self, body: Body) -> float:
        return profile_of(body).area * body.depth_mm

    def areas(self, body: Body) -> dict[str, float]:
        profile, depth = profile_of(body), body.depth_mm
        return {
            "base": body.width_mm * depth,
            "contact": 2.0 * depth * sum(piece.length for piece in profile.pieces),
            "side": 2.0 * depth * profile.side_height,
            "end": 2.0 * profile.area,
        }


@body("block", place=4)
class Block(Straight):
    """A flat top, drawn straight along z."""

    flat = True
    words = "a flat top, the same all along z"


@body("dome", place=2)
class Dome(Straight):
    """The outline revolved about a line along x."""

    straight = False
    words = "a dome on top, of radius {radius:g} mm in x and {dome:g} mm in z"
    section_words = "a domed finger"

    def axis(self, body: Body) -> float:
        return profile_of(body).crest - self._radius(body)

    def height(self, body: Body, x: Array, z: Array) -> Array:
        axis = self.axis(body)
        return np.asarray(axis + np.sqrt((profile_of(body).height(x) - axis) ** 2 - z**2))

    def plane(self, body: Body, points: Array) -> Array:
        axis = self.axis(body)
        return np.column_stack([points[:, 0], axis + self._out(body, points)])

    def directions(self, body: Body, points: Array) -> tuple[Array, Array]:
        out = self._out(body, points)
        if np.any(out < 1e-9 * self._radius(body)):
            raise GeometryError("a point on the dome's axis has no nearest surface point")
        sideways, upward = np.zeros_like(points), np.zeros_like(points)
        sideways[:, 0] = 1.0
        upward[:, 1] = (points[:, 1] - self.axis(body)) / out
        if points.shape[1] == 3:
            upward[:, 2] = points[:, 2] / out
        return sideways, upward

    def curvatures(self, body: Body) -> tuple[float, float]:
        return 1.0 / self.top_radius(body), 1.0 / self._radius(body)

    def lowest(self, body: Body) -> float:
        side, axis = profile_of(body).side_height, self.axis(body)
        return float(axis + np.sqrt(max((side - axis) ** 2 - 0.25 * body.depth_mm**2, 0.0)))

    def row_radius(self, body: Body, along: str, middle: float) -> float | None:
        if along == "x":
            return self.top_radius(body)
        x, none = np.array(middle), np.array(0.0)
        below = float(self.height(body, x, none)) - float(self.height(body, none, none))
        return self._radius(body) + below

    def volume(self, body: Body) -> float:
        _, y, weights = profile_of(body).gauss_points()
        z_end, axis = 0.5 * body.depth_mm, self.axis(body)
        reach = y - axis
        over_z = z_end * np.sqrt(reach**2 - z_end**2) + reach**2 * np.arcsin(z_end / reach)
        return float(2.0 * np.sum(weights[:, 0] * (over_z + 2.0 * z_end * axis)))

    def areas(self, body: Body) -> dict[str, float]:
        profile, z_end, axis = profile_of(body), 0.5 * body.depth_mm, self.axis(body)
        _, y, weights = profile.gauss_points()
        reach = y - axis  # radius of revolution of each point of the outline
        around = 2.0 * reach * np.arcsin(z_end / reach)
        end = weights[:, 0] * (axis + np.sqrt(reach**2 - z_end**2))
        edge = profile.side_height - axis
        under = z_end * np.sqrt(edge**2 - z_end**2) + edge**2 * np.arcsin(z_end / edge)
        return {
            "base": body.width_mm * body.depth_mm,
            "contact": float(2.0 * np.sum(weights[:, 1] * around)),
            "side": float(2.0 * (under + 2.0 * z_end * axis)),
            "end": float(4.0 * np.sum(end)),
        }

    def _radius(self, body: Body) -> float:
        if body.dome_radius_mm is None:
            raise GeometryError('body.shape = "dome" needs body.dome_radius_mm')
        return float(body.dome_radius_mm)

    def _out(self, body: Body, points: Array) -> Array:
        """Distance (n,) from the axis."""
        y = points[:, 1]
        z = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
        return np.hypot(y - self.axis(body), z)


@body("revolved", place=3)
class Revolved(Straight):
    """The outline revolved about y."""

    straight, turned = False, True
    words = "a round cap of radius {radius:g} mm, turned about y"
    section_words = "a turned finger"

    def height(self, body: Body, x: Array, z: Array) -> Array:
        return profile_of(body).height(np.hypot(x, z))

    def plane(self, body: Body, points: Array) -> Array:
        return np.column_stack([self._out(points), points[:, 1]])

    def directions(self, body: Body, points: Array) -> tuple[Array, Array]:
        out = self._out(points)
        safe = np.maximum(out, 1e-300)
        sideways, upward = np.zeros_like(points), np.zeros_like(points)
        sideways[:, 0] = np.where(out > 0.0, points[:, 0] / safe, 1.0)
        if points.shape[1] == 3:
            sideways[:, 2] = points[:, 2] / safe
        upward[:, 1] = 1.0
        return sideways, upward

    def curvatures(self, body: Body) -> tuple[float, float]:
        return 1.0 / self.top_radius(body), 1.0 / self.top_radius(body)

    def row_radius(self, body: Body, along: str, middle: float) -> float | None:
        radius = self.top_radius(body)
        if along == "x" or middle == 0.0:
            return radius
        profile = profile_of(body)
        return radius + (float(profile.height(middle)) - float(profile.height(0.0)))

    def volume(self, body: Body) -> float:
        x, y, weights = profile_of(body).gauss_points()
        return float(np.sum(weights[:, 0] * 2.0 * np.pi * x * y))

    def areas(self, body: Body) -> dict[str, float]:
        profile, radius = profile_of(body), 0.5 * body.width_mm
        x, _, weights = profile.gauss_points()
        return {
            "base": float(np.pi * radius**2),
            "contact": float(np.sum(weights[:, 1] * 2.0 * np.pi * x)),
            "side": float(2.0 * np.pi * radius * profile.side_height),
        }

    @staticmethod
    def _out(points: Array) -> Array:
        z = points[:, 2] if points.shape[1] == 3 else np.zeros(len(points))
        return np.hypot(points[:, 0], z)


_ACROSS = np.linspace(-1.0, 1.0, 9)


def _bent(place: Array, heights: Array) -> float:
    """Curvature of a line through heights (n,); 0 where it is flat or hollow."""
    known = np.isfinite(heights)
    if known.sum() < 3:
        return 0.0
    bent = -2.0 * float(np.polyfit(place[known], heights[known], 2)[0])
    return bent if bent > 1e-6 else 0.0


@body("step", place=5)
class Cad(BodyKind):
    """The user's own solid: its faces answer (surface.py)."""

    closed_form = False

    def height(self, body: Body, x: Array, z: Array) -> Array:
        return self._facts(body).height(x, z)

    def curvatures(self, body: Body) -> tuple[float, float]:
        """Fitted to the heights near the crest; 0 where it is flat or hollow."""
        across, along = (0.05 * extent * _ACROSS for extent in (body.width_mm, body.depth_mm))
        level = np.zeros_like(across)
        return _bent(across, self.height(body, across, level)), _bent(
            along, self.height(body, level, along)
        )

    def lowest(self, body: Body) -> float:
        return self._facts(body).lowest

    def volume(self, body: Body) -> float:
        return self._facts(body).volume

    def areas(self, body: Body) -> dict[str, float]:
        return {name: float(area) for name, area in self._facts(body).area.items()}

    @staticmethod
    def _facts(body: Body) -> StepFacts:
        assert body.step is not None
        return step_facts(body.step)
