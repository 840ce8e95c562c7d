"""Rigid objects in closed form: plane, cylinder, sphere, or one registered elsewhere (numpy only).

Each knows its signed distance (> 0 outside) and outward unit normal at points (q, 2) or (q, 3), and
``underside``: the height of its lower face over (x, z), by which it is let down onto a finger until
it touches. In plane strain the object is its section z = 0.

A scene's ``[object]`` table is read by the object's :class:`SceneShape`, which is registered
with ``@scene_object("name")``.
"""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Protocol, Self, TypeVar

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.runtime.registry import SCENE_OBJECTS
from fingerdesign.shapes import quadrics
from fingerdesign.shapes.quadrics import Shape

Vector = tuple[float, float, float]
Height = Callable[[Array, Array], Array]
Placed = TypeVar("Placed", bound="RigidObject")

DOWN: Vector = (0.0, -1.0, 0.0)
_GRID, _ROUNDS, _ZOOM = 65, 14, 0.2  # 0.2^14: the last grid is 1e-10 of the first
scene_object = SCENE_OBJECTS.kind  # registers a SceneShape under a name of ``object.shape``


class Indenter(Protocol):
    """A rigid object: signed distance and outward normal where points of the finger face it."""

    def distance(self, points: Array) -> Array:
        """Distance (q,) mm of points (q, dim) from the object, > 0 outside."""

    def normal(self, points: Array) -> Array:
        """Outward unit normals (q, dim) of the object at the facing points."""


class RigidObject(Indenter, Protocol):
    """An indenter that can be placed: moved along y, with a lower face."""

    def underside(self, x: Array, z: Array) -> Array:
        """Height y of the lower face over (x, z); infinite outside the object."""

    def at_height(self, height: float) -> Self:
        """The same object with its reference point at ``height``."""


@dataclass(frozen=True)
class _Placed:
    """A closed form of shapes/quadrics.py about (0, height, 0)."""

    height: float

    @property
    def _shape(self) -> Shape:
        raise NotImplementedError

    def distance(self, points: Array) -> Array:
        return self._shape.distance(self._relative(points))

    def normal(self, points: Array) -> Array:
        return self._shape.normal(self._relative(points))[:, : points.shape[1]]

    def underside(self, x: Array, z: Array) -> Array:
        lower = np.fmin.reduce(self._shape.heights(x, z))
        return np.where(np.isnan(lower), np.inf, self.height + lower)

    def at_height(self, height: float) -> Self:
        return replace(self, height=height)

    def _relative(self, points: Array) -> Array:
        """Points (n, 3) seen from the reference point."""
        relative = np.zeros((len(points), 3))
        relative[:, : points.shape[1]] = points
        relative[:, 1] -= self.height
        return relative


@dataclass(frozen=True)
class Plane(_Placed):
    """A plane through (0, height, 0), the object above it; ``direction``: outward normal (down).

    >>> Plane(2.0).distance(np.array([[5.0, 1.5]])).tolist()
    [0.5]
    """

    direction: Vector = DOWN

    @property
    def _shape(self) -> Shape:
        return quadrics.Plane(np.array(self.direction), 0.0)


@dataclass(frozen=True)
class Cylinder(_Placed):
    """A cylinder of ``radius`` mm whose axis runs through (0, height, 0) along ``axis`` (unit)."""

    radius: float
    axis: Vector = (0.0, 0.0, 1.0)

    @property
    def _shape(self) -> Shape:
        return quadrics.Cone(np.zeros(3), np.array(self.axis), self.radius)


@dataclass(frozen=True)
class Sphere(_Placed):
    """A sphere of ``radius`` mm about (0, height, 0)."""

    radius: float

    @property
    def _shape(self) -> Shape:
        return quadrics.Sphere(np.zeros(3), self.radius)


def touching(
    rigid: Placed, surface: Height, half_width: float, half_depth: float
) -> tuple[Placed, Array]:
    """The object let down along y to first touch on ``surface`` over |x|, |z| <= the halves, mm.

    Both faces being convex toward each other, their vertical gap has one minimum; a grid is zoomed
    onto it. Returns the object and the point of touch (3,).
    """
    rigid = rigid.at_height(0.0)
    centre, half = np.zeros(2), np.array([half_width, half_depth])
    for _ in range(_ROUNDS):
        low = np.maximum(centre - half, [-half_width, -half_depth])
        high = np.minimum(centre + half, [half_width, half_depth])
        grid = np.meshgrid(*np.linspace(low, high, _GRID).T, indexing="ij")
        x, z = (axis.ravel() for axis in grid)
        with np.errstate(invalid="ignore"):
            gap = rigid.underside(x, z) - surface(x, z)
        gap = np.where(np.isnan(gap), np.inf, gap)  # no surface there: a round finger's corners
        # Where the gap is level (a flat plane along a straight finger) the middle is as good.
        least = np.flatnonzero(gap <= gap.min() + 1e-14 * (half_width + half_depth))
        best = least[np.argmin(np.hypot(x[least], z[least]))]
        centre = np.array([x[best], z[best]])
        half = half * _ZOOM
    y = float(surface(centre[:1], centre[1:])[0])
    drop = float(rigid.underside(centre[:1], centre[1:])[0])
    return rigid.at_height(y - drop), np.array([centre[0], y, centre[1]])


class SceneShape:
    """A kind of object in a scene's table; a new kind defines at least ``make``.

    ``table``: ``[object]``, of which every kind may read radius_mm, axis, tilt_deg and turn_deg.

    The defaults suit any object: no two sections alike, no mirror plane, as wide a contact as
    under a flat one.
    """

    needs: ClassVar[tuple[str, ...]] = ()  # keys, else absent, that must be given
    flat: ClassVar[bool] = False  # its lower face is a plane

    def make(self, table: Any) -> RigidObject:
        """The object, its reference point at height 0."""
        raise NotImplementedError

    def curvature(self, table: Any) -> Array:
        """Curvature (2, 2) of the lower face over (x, z), 1/mm; tilt left out."""
        return np.zeros((2, 2))

    def idle(self, table: Any) -> Iterator[tuple[str, str | float]]:
        """Keys that would change nothing, each with its default."""
        return iter(())

    def plane_in_z(self, table: Any) -> bool:
        """True if every section of constant z is the same."""
        return False

    def mirrors_in_z(self, table: Any) -> bool:
        """True if it is its own mirror image in z = 0."""
        return self.plane_in_z(table)

    def words(self, keys: Mapping[str, object]) -> str:
        """Words for its direction, to follow its name; empty: no direction."""
        return ""


@scene_object("plane", place=1)
class ScenePlane(SceneShape):
    """Level, or turned into a slope."""

    flat = True

    def make(self, table: Any) -> RigidObject:
        tilt = math.radians(table.tilt_deg)
        normal = np.array([math.sin(tilt), -math.cos(tilt), 0.0])
        return Plane(0.0, _turned(normal, math.radians(table.turn_deg)))

    def idle(self, table: Any) -> Iterator[tuple[str, str | float]]:
        yield "axis", "z"
        if not table.tilt_deg:
            yield "turn_deg", 0.0

    def plane_in_z(self, table: Any) -> bool:
        return not table.tilt_deg or _half_turns(table)


@scene_object("cylinder", place=2)
class SceneCylinder(SceneShape):
    """Along z or x, or turned."""

    needs = ("radius_mm",)

    def make(self, table: Any) -> RigidObject:
        tilt = math.radians(table.tilt_deg)
        along_x = np.array([math.cos(tilt), math.sin(tilt), 0.0])
        axis = along_x if table.axis == "x" else np.array([0.0, 0.0, 1.0])
        radius = float(table.radius_mm or 0.0)
        return Cylinder(0.0, radius, _turned(axis, math.radians(table.turn_deg)))

    def curvature(self, table: Any) -> Array:
        turn = math.radians(table.turn_deg)
        along_x, along_z = [math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]
        axis = np.array(along_x if table.axis == "x" else along_z)
        return np.asarray(1.0 / float(table.radius_mm or 0.0) * (np.eye(2) - np.outer(axis, axis)))

    def idle(self, table: Any) -> Iterator[tuple[str, str | float]]:
        if table.axis == "z":
            yield "tilt_deg", 0.0

    def plane_in_z(self, table: Any) -> bool:
        return _half_turns(table) and table.axis != "x"

    def mirrors_in_z(self, table: Any) -> bool:
        return _half_turns(table)

    def words(self, keys: Mapping[str, object]) -> str:
        return f"along {keys.get('axis', 'z')}"


@scene_object("sphere", place=3)
class SceneSphere(SceneShape):
    """A sphere, the same in each direction."""

    needs = ("radius_mm",)

    def make(self, table: Any) -> RigidObject:
        return Sphere(0.0, float(table.radius_mm or 0.0))

    def curvature(self, table: Any) -> Array:
        return np.asarray(np.eye(2) * (1.0 / float(table.radius_mm or 0.0)))

    def idle(self, table: Any) -> Iterator[tuple[str, str | float]]:
        return iter([("axis", "z"), ("tilt_deg", 0.0), ("turn_deg", 0.0)])

    def mirrors_in_z(self, table: Any) -> bool:
        return True


def _half_turns(table: Any) -> bool:
    """True if the turn is a whole number of half turns."""
    half_turns = float(table.turn_deg) / 180.0
    return half_turns == round(half_turns)


def _turned(vector: Array, turn: float) -> Vector:
    """``vector`` turned about +y."""
    x, y, z = (float(value) for value in vector)
    if turn == 0.0:
        return x, y, z
    return x * math.cos(turn) + z * math.sin(turn), y, -x * math.sin(turn) + z * math.cos(turn)
