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

WITHIN = "forces prescribed"
BEYOND = "forces beyond friction"  # its last row has no answer: |F_t| > mu F_n on a plane
FRICTIONS = (0.0, 0.1, 0.3, 0.5, 1.0, 2.0, 5.0)


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

    @property
    def name(self) -> str:
        return f"{self.body}; {self.family}; mu {self.friction:g}"


def cases_of(body: HardBody, model: ReducedModel, crest: float) -> Iterator[Case]:
    """All cases of a body, by family and friction coefficient."""
    for family, indenter, paths in _families(body, model, crest):
        for friction in FRICTIONS:
            rows = paths(friction)
            solvable = len(rows) - (family == BEYOND)
            yield Case(body.name, body.group, family, friction, indenter, rows, solvable)


Path = Callable[[float], tuple[Motion | Forces, ...]]
Family = tuple[str, RigidObject, Path]


def _families(body: HardBody, model: ReducedModel, crest: float) -> list[Family]:
    """Families: a name, an object, and the path for a friction coefficient."""
    plane = Plane(crest)
    press = body.press
    gaps = np.unique(np.round(_gaps(model, plane), 12))
    first, second = float(gaps[0]), float(gaps[1])

    def path(*rows: tuple[float, float]) -> tuple[Motion, ...]:
        return tuple(Motion(float(approach), float(shear)) for approach, shear in rows)

    def full(friction: float) -> float:
        """Shear by which every point slides, about."""
        return 3.0 * press * max(friction, 0.1)

    def first_touch(friction: float) -> tuple[Motion, ...]:
        tiny = 1e-6
        return path((first + tiny, 0.0), (first + tiny, 0.1 * tiny), (first + 2 * tiny, -tiny))

    def one_node(friction: float) -> tuple[Motion, ...]:
        depth = second - first
        approach = first + 0.5 * depth
        return path((approach, 0.0), (approach, 0.2 * depth), (approach, 100.0 * depth))

    def normal(friction: float) -> tuple[Motion, ...]:
        return path(*((press * k / 4, 0.0) for k in range(1, 5)))

    def shear(friction: float) -> tuple[Motion, ...]:
        end = full(friction)
        rows = [(press / 2, 0.0), (press, 0.0)]
        return path(*rows, *((press, end * k / 4) for k in (1, 2, 3, 4, 6)))

    def unloading(friction: float) -> tuple[Motion, ...]:
        half = 0.5 * full(friction)
        shares = (0.7, 0.4, 0.1, -0.05)
        return path((press, 0.0), (press, half), *((press * share, half) for share in shares))

    def reversal(friction: float) -> tuple[Motion, ...]:
        end = full(friction)
        shears = (0.5, 1.2, 0.6, -0.3, -1.2, 0.4)
        return path((press, 0.0), *((press, end * share) for share in shears))

    def huge(friction: float) -> tuple[Motion, ...]:
        """Whole motions at once: ordinary increments are a hundredth of these."""
        end = min(2.0 * full(friction), 8.0 * press)
        return path((press, end), (0.5 * press, -end), (press, 0.15 * end))

    def jamming(friction: float) -> tuple[Motion, ...]:
        """Dragged in while it comes down, back while it lifts: friction holds against the lift."""
        end = press * max(1.0, friction)
        rows = ((press, end), (0.6 * press, 0.3 * end), (0.3 * press, -0.5 * end))
        return path(*rows, (0.8 * press, 0.5 * end), (0.1 * press, 0.2 * end))

    def beyond(friction: float) -> tuple[Motion, ...]:
        """Pressed until the contact is wider than the candidates."""
        far = body.zone**2  # R is 20 or more: 2 to 10 times the approach that fills the zone
        return path((press / 2, 0.0), (0.3 * far, 0.1 * far))

    families: list[Family] = [
        ("first touch", plane, first_touch),
        ("one node", plane, one_node),
        ("normal", plane, normal),
        ("shear to complete slip", plane, shear),
        ("unloading", plane, unloading),
        ("reversed shear", plane, reversal),
        ("increments 100 times too large", plane, huge),
        ("jamming", plane, jamming),
    ]
    families += _under_force(body, plane)
    if model.rim.any():
        families.append(("zone exhausted", plane, beyond))
    if body.objects:
        families += _objects(body, crest)
    return families


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

    def into(friction: float) -> tuple[Motion, ...]:
        """Against the slope and back: at a high friction it holds itself."""
        return tuple(
            Motion(press * a, press * s)
            for a, s in ((0.5, 0.0), (0.5, -3.0), (0.7, 3.0), (0.3, 3.0), (0.3, -1.0))
        )

    def roll(friction: float) -> tuple[Motion, ...]:
        end = 2.0 * press * max(friction, 0.1)
        return tuple(
            Motion(press * a, end * s) for a, s in ((0.5, 0.0), (1.0, 0.5), (1.0, 1.5), (0.4, -0.5))
        )

    def twist(friction: float) -> tuple[Motion, ...]:
        end = 2.0 * press * max(friction, 0.1)
        rows = ((0.0, 0.0, 0.0), (0.3, 0.3, 5.0), (0.3, 1.5, 30.0), (-0.5, 0.0, -10.0))
        return tuple(
            Motion(press, end * s, end * across, max(friction, 0.1) * turn)
            for s, across, turn in rows
        )

    families: list[Family] = [
        ("tilted plane", touch(tilted), into),
        ("cylinder", touch(Cylinder(crest, 10.0)), roll),
    ]
    if body.solid:
        families += [("sphere", touch(Sphere(crest, 10.0)), roll)]
        if not body.symmetric:
            families += [("twist and shear in z", Plane(crest), twist)]
    return families


def _gaps(model: ReducedModel, plane: Plane) -> Array:
    return model.surface.mean(plane.distance(model.surface.points), model.nodes)
