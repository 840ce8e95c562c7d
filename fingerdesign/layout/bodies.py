"""Kinds of bodies: each computes its own geometry from the outline, or from its CAD faces.

Every parametric body is its outline (profile.py) drawn straight along z, revolved about a line
along x (dome) or about y (revolved): in the outline's plane one formula serves all, edges included.
A kind is registered under the name that ``body.shape`` takes. Numpy only; lengths in mm; points are
(n, 2), in the mid-section, or (n, 3).
"""

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.body import Body, BodyKind, body
from fingerdesign.design.step import StepFacts, step_facts
from fingerdesign.errors import GeometryError
from fingerdesign.layout.profile import profile_of

# Places, relative to the extent, at which the curvature of a STEP body's crest is fitted.
_ACROSS = np.linspace(-1.0, 1.0, 9)


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


def _bent(place: Array, heights: Array) -> float:
    """Curvature of a line through heights (n,); 0 where it is flat or hollow."""
    known = np.isfinite(heights)
    if known.sum() < 3:
        return 0.0
    bent = -2.0 * float(np.polyfit(place[known], heights[known], 2)[0])
    return bent if bent > 1e-6 else 0.0


@body("step", place=5)
class Cad(BodyKind):
    """The user's own solid, evaluated by its faces (surface.py)."""

    closed_form = False

    def height(self, body: Body, x: Array, z: Array) -> Array:
        return self._facts(body).height(x, z)

    def curvatures(self, body: Body) -> tuple[float, float]:
        """Fitted to the heights near the crest; 0 where it is flat or hollow."""
        across, along = (0.05 * extent * _ACROSS for extent in (body.width_mm, body.depth_mm))
        level = np.zeros_like(across)
        heights = self.height(body, across, level), self.height(body, level, along)
        return _bent(across, heights[0]), _bent(along, heights[1])

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


def crest_height(body: Body) -> float:
    """Height of the body at x = z = 0, mm: base_height + R - sqrt(R^2 - (width/2)^2) of an arc."""
    if body.shape == "step":
        return float(surface_height(body, 0.0, 0.0))
    return profile_of(body).crest


def surface_height(body: Body, x: Array | float, z: Array | float = 0.0) -> Array:
    """Height of the body's top over (x, z), mm; NaN where it has none (beyond the arc's circle)."""
    x, z = np.broadcast_arrays(np.asarray(x, dtype=float), np.asarray(z, dtype=float))
    return body.kind.height(body, x, z)
