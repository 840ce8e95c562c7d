"""The cases of the stability map: body, object, friction coefficient and path of motions."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.problem import Motion
from fingerdesign.reduced import ReducedModel
from fingerdesign.shapes.objects import Cylinder, Plane, RigidObject, Sphere, touching
from fingerdesign_bench.stability.bodies import HardBody

Shares = tuple[tuple[float, float], ...]  # of the approach and of the shear
Path = Callable[[float], tuple[Motion | Forces, ...]]
Family = tuple[str, RigidObject, Path]

WITHIN = "forces prescribed"
BEYOND = "forces beyond friction"  # its last row has no answer: |F_t| > mu F_n on a plane
FRICTIONS = (0.0, 0.1, 0.3, 0.5, 1.0, 2.0, 5.0)
_LEAST = 0.1  # friction coefficient, below which shears no longer shrink with it
_TINY = 1e-6  # mm
# Shares of the body's approach, and of the shear by which every point slides, about.
_BY_SLIDING: dict[str, Shares] = {
    "normal": tuple((k / 4, 0.0) for k in range(1, 5)),
    "shear to complete slip": (
        *((0.5, 0.0), (1.0, 0.0), (1.0, 0.25), (1.0, 0.5), (1.0, 0.75)),
        *((1.0, 1.0), (1.0, 1.5)),
    ),
    "unloading": ((1.0, 0.0), (1.0, 0.5), (0.7, 0.5), (0.4, 0.5), (0.1, 0.5), (-0.05, 0.5)),
    "reversed shear": (
        *((1.0, 0.0), (1.0, 0.5), (1.0, 1.2), (1.0, 0.6)),
        *((1.0, -0.3), (1.0, -1.2), (1.0, 0.4)),
    ),
}
# Whole motions at once: ordinary increments are a hundredth of these.
_HUGE: Shares = ((1.0, 1.0), (0.5, -1.0), (1.0, 0.15))
# Dragged in while it comes down, back while it lifts: friction holds against the lift.
_JAMMING: Shares = ((1.0, 1.0), (0.6, 0.3), (0.3, -0.5), (0.8, 0.5), (0.1, 0.2))
# Against a slope and back: at a high friction it holds itself. Shears are shares of the approach.
_INTO: Shares = ((0.5, 0.0), (0.5, -3.0), (0.7, 3.0), (0.3, 3.0), (0.3, -1.0))
_ROLL: Shares = ((0.5, 0.0), (1.0, 0.5), (1.0, 1.5), (0.4, -0.5))
# Shears along x and z, and degrees.
_TWIST = ((0.0, 0.0, 0.0), (0.3, 0.3, 5.0), (0.3, 1.5, 30.0), (-0.5, 0.0, -10.0))


@dataclass(frozen=True)
class Case:
    """One path on one body; ``family`` is its row of the map."""

    body: str
    group: str
    family: str
    friction: float
    indenter: RigidObject
    rows: tuple[Motion | Forces, ...]
    solvable: int  # rows from the first on that have an answer, by the laws alone

    @property
    def under_force(self) -> bool:
        """Forces are prescribed: for the production solver alone, no other method offers it."""
        return any(isinstance(row, Forces) for row in self.rows)


def cases_of(body: HardBody, model: ReducedModel, crest: float) -> Iterator[Case]:
    """All cases of a body, by family and friction coefficient."""
    for family, indenter, paths in _families(body, model, crest):
        for friction in FRICTIONS:
            rows = paths(friction)
            solvable = len(rows) - (family == BEYOND)
            yield Case(body.name, body.group, family, friction, indenter, rows, solvable)


def _moved(shares: Shares, press: float, end: Callable[[float], float]) -> Path:
    """The path of a friction coefficient: shares of an approach and of the shear ``end``."""

    def path(friction: float) -> tuple[Motion, ...]:
        far = end(friction)
        return tuple(Motion(press * approach, far * shear) for approach, shear in shares)

    return path


def _fixed(*rows: tuple[float, float]) -> Path:
    """The same approaches and shears at every friction coefficient."""
    return lambda friction: tuple(Motion(float(a), float(s)) for a, s in rows)


def _families(body: HardBody, model: ReducedModel, crest: float) -> list[Family]:
    """Families: a name, an object, and the path for a friction coefficient."""
    plane, press = Plane(crest), body.press
    distance = plane.distance(model.surface.points)
    gaps = np.unique(np.round(model.surface.mean(distance, model.nodes), 12))
    first, second = float(gaps[0]), float(gaps[1])
    depth = second - first
    middle, touched = first + 0.5 * depth, first + _TINY

    def full(friction: float) -> float:
        return 3.0 * press * max(friction, _LEAST)

    touch = _fixed((touched, 0.0), (touched, 0.1 * _TINY), (first + 2 * _TINY, -_TINY))
    one = _fixed((middle, 0.0), (middle, 0.2 * depth), (middle, 100.0 * depth))
    huge = _moved(_HUGE, press, lambda friction: min(2.0 * full(friction), 8.0 * press))
    jam = _moved(_JAMMING, press, lambda friction: press * max(1.0, friction))
    families: list[Family] = [("first touch", plane, touch), ("one node", plane, one)]
    families += [(name, plane, _moved(rows, press, full)) for name, rows in _BY_SLIDING.items()]
    families += [("increments 100 times too large", plane, huge), ("jamming", plane, jam)]
    families += _under_force(body, plane)
    if model.rim.any():  # Pressed until the contact is wider than the candidates.
        far = body.zone**2  # R is 20 or more: 2 to 10 times the approach that fills the zone
        beyond = _fixed((press / 2, 0.0), (0.3 * far, 0.1 * far))
        families.append(("zone exhausted", plane, beyond))
    return families + (_objects(body, crest) if body.objects else [])


def _under_force(body: HardBody, plane: Plane) -> list[Family]:
    """Forces prescribed: what friction carries, and a tenth more than it can."""
    load = body.load

    def within(friction: float) -> tuple[Forces, ...]:
        pull = 0.9 * load * min(friction, 0.5)
        rows = [Forces(load, 0.0), Forces(load, 0.5 * pull), Forces(load, pull)]
        return (*rows, Forces(load, -0.5 * pull), Forces(0.5 * load, 0.0))

    def beyond(friction: float) -> tuple[Forces, ...]:
        return (Forces(load, 0.0), Forces(load, 1.1 * friction * load + 0.01 * load))

    return [(WITHIN, plane, within), (BEYOND, plane, beyond)]


def _objects(body: HardBody, crest: float) -> list[Family]:
    """A tilted plane that wedges the finger, a cylinder, and in 3-D a sphere and a twist."""
    press = body.press

    def touch(rigid: RigidObject) -> RigidObject:
        radius, half = body.radius, 0.5 * body.zone

        def surface(x: Array, z: Array) -> Array:
            return np.asarray(crest - radius + np.sqrt(radius**2 - x**2))

        return touching(rigid, surface, half, 0.0 if not body.solid else half)[0]

    angle = np.deg2rad(2.0 if body.solid else 5.0)
    tilted = Plane(crest, (float(np.sin(angle)), -float(np.cos(angle)), 0.0))

    roll = _moved(_ROLL, press, lambda friction: 2.0 * press * max(friction, _LEAST))

    def twist(friction: float) -> tuple[Motion, ...]:
        end = 2.0 * press * max(friction, _LEAST)
        rows = ((end * s, end * across, max(friction, _LEAST) * turn) for s, across, turn in _TWIST)
        return tuple(Motion(press, *row) for row in rows)

    families: list[Family] = [
        ("tilted plane", touch(tilted), _moved(_INTO, press, lambda friction: press)),
        ("cylinder", touch(Cylinder(crest, 10.0)), roll),
    ]
    if body.solid:
        families += [("sphere", touch(Sphere(crest, 10.0)), roll)]
        if not body.symmetric:
            families += [("twist and shear in z", Plane(crest), twist)]
    return families
