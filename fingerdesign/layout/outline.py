"""The section's upper outline as lines and arcs: distances, normals, heights, in closed form.

One half, x >= 0, is a chain of pieces from the crest outward; the other half mirrors it. Numpy
only; lengths in mm; points (n, 2) are (x, y).
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray


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
        """Distance (n,) of the nearest point of the continued piece beyond its ends, mm; or 0."""
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


def _away(pieces: tuple[Piece, ...], points: Array) -> list[Array]:
    """Distances (n,) to each of the pieces as they end."""
    folded = _folded(points)
    return [np.hypot(piece.distance(folded), piece.beyond(folded)) for piece in pieces]


def nearest_piece(pieces: tuple[Piece, ...], points: Array) -> IntArray:
    """The piece (n,) that holds the nearest point of a chain, for points (n, 2) of either half."""
    if len(pieces) == 1:
        return np.zeros(len(points), dtype=np.int64)
    return np.asarray(np.argmin(_away(pieces, points), axis=0), dtype=np.int64)


def chain_distance(pieces: tuple[Piece, ...], points: Array) -> Array:
    """Signed distance (n,) of points (n, 2) to the pieces, mirrored in x = 0."""
    owner, folded = nearest_piece(pieces, points), _folded(points)
    each = np.stack([piece.distance(folded) for piece in pieces])
    return np.asarray(each[owner, np.arange(len(points))])


def chain_misfit(pieces: tuple[Piece, ...], points: Array) -> Array:
    """Distance (n,) of points (n, 2) to the pieces as they end, not continued."""
    return np.asarray(np.min(_away(pieces, points), axis=0))


def chain_normal(pieces: tuple[Piece, ...], points: Array) -> Array:
    """Outward unit normals (n, 2) of the pieces, mirrored in x = 0, nearest to points (n, 2)."""
    owner, folded = nearest_piece(pieces, points), _folded(points)
    each = np.stack([piece.normal(folded) for piece in pieces])
    normal = each[owner, np.arange(len(points))]
    normal[:, 0] *= np.where(points[:, 0] < 0.0, -1.0, 1.0)
    return np.asarray(normal)
