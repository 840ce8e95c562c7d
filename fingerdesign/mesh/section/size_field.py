"""The size field of an outline: the least size that its points and curves leave at a place."""

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.mesh.section.outline import Outline

_PARTS = 8  # straight pieces of a bent curve


class SectionSize:
    """The size field of an outline, ``field(points (n, 2 or 3)) -> (n,)`` in mm.

    The least, over all of its points and curves, of their own size grown with the distance away,
    s + gradation x distance (the outline's gradation, or another); nowhere above the far size.
    """

    def __init__(self, outline: Outline, gradation: float | None = None) -> None:
        self.far = outline.far_size
        self.gradation = outline.gradation if gradation is None else gradation
        places = np.array([(x, y) for x, y, _ in outline.points])
        lines = [(line_of(places[numbers]), size) for numbers, _, _, size in outline.curves]
        lines = [(line, min(size, float(lengths_of(line).sum()))) for line, size in lines]
        for place, (_, _, at) in zip(places, outline.points, strict=True):
            lines += [] if at is None else [(np.array([place, place]), at)]
        lines = [(line, size) for line, size in lines if size < self.far]
        none = np.zeros((0, 2))
        self.size = np.array([size for line, size in lines for _ in line[1:]])
        self.start = np.vstack([none, *(line[:-1] for line, _ in lines)])
        self.along = np.vstack([none, *(np.diff(line, axis=0) for line, _ in lines)])
        self.square = np.maximum((self.along**2).sum(axis=1), 1e-300)
        self.least = float(self.size.min(initial=self.far))

    def __call__(self, points: Array) -> Array:
        """Target edge length (n,), mm."""
        found = np.full(len(points), self.far)
        if not len(self.size):
            return found
        (ax, ay), (tx, ty) = self.start.T, self.along.T
        for k in range(0, len(points), 1000):
            x, y = points[k : k + 1000, :2].T[:, :, None]
            x, y = x - ax, y - ay
            share = np.clip((x * tx + y * ty) / self.square, 0.0, 1.0)
            away = np.sqrt((x - share * tx) ** 2 + (y - share * ty) ** 2)
            grown = (self.size + self.gradation * away).min(axis=1)
            found[k : k + 1000] = np.minimum(grown, self.far)
        return found


def line_of(points: Array) -> Array:
    """Points along a line, or along netgen's rational spline (end, control, end)."""
    if len(points) == 2:
        return points
    a, control, b = points
    t = np.linspace(0.0, 1.0, _PARTS + 1)[:, None]
    chord = np.linalg.norm(b - a)
    arms = np.linalg.norm(control - a) + np.linalg.norm(control - b)
    weight = chord / arms  # cosine of half the angle turned through: a circle
    low, middle, high = (1 - t) ** 2, 2 * weight * t * (1 - t), t**2
    return np.asarray((low * a + middle * control + high * b) / (low + middle + high))


def lengths_of(line: Array) -> Array:
    """Lengths (n - 1,) of the pieces of a line of n points."""
    return np.asarray(np.linalg.norm(np.diff(line, axis=0), axis=1))
