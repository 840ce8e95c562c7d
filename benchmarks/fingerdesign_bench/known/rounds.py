"""Hertz and Cattaneo-Mindlin: a rigid cylinder or sphere on a half-space, a ball under a plane.

A rigid cylinder or sphere, 1000 contact half-widths in radius, is pressed into a block with force
control, sheared to near the friction limit, brought back and sheared the other way. Lengths are in
half-widths of the last normal load (mm here), E = 1 MPa. Values are over Hertz's at that load.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import parse_design
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.design.io import parse_scene
from fingerdesign.fem.reduction import body_model
from fingerdesign.fem.system import Body
from fingerdesign.pipeline import analyse
from fingerdesign.shapes.objects import Cylinder, Indenter, Plane, Sphere
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy.block import block_section
from fingerdesign_bench.accuracy.disc import half_disc, right_half
from fingerdesign_bench.accuracy.revolve import both_halves, revolved_half, round_block_section
from fingerdesign_bench.accuracy.uniform import held, uniform_body
from fingerdesign_bench.known.case import Solution

RADIUS = 1000.0  # of the object, in contact half-widths
DEPTH = 1000.0  # of the block: what lies deeper would yield 0.1 % of a sphere's approach
NU, FRICTION = 0.4999, 0.3  # Normal and tangential problems uncouple at this Poisson's ratio.
LOADS = (0.83, 0.89, 0.94, 1.0)  # half-widths: the border falls at all places of a facet
SHEARS = (0.4, 0.6, 0.8)  # of the friction limit, loading
BACK = (0.0, -0.3, -0.6)  # and on the way back, into the other direction
_BALL = 40.0  # Radius of the elastic ball, in contact radii.
# A dome of R = 20 mm both ways, or a revolved pin of that radius; the contact's radius is a ninth
# of its height.
_ROUND, _CONTACT, _ROUND_FRICTION = 20.0, 1.2, 0.5
_SHAPES = {
    "dome": f'body.shape = "dome"\nbody.depth_mm = 20.0\nbody.dome_radius_mm = {_ROUND}',
    "pin": 'body.shape = "revolved"',
}
_DESIGN = f"""
design.name = "ball"
body.width_mm = 20.0
body.base_height_mm = 10.0
body.arc_radius_mm = {_ROUND}
plates.count = 0
materials.silicone.poissons_ratio = {NU}
"""


@dataclass(frozen=True)
class Pressed:
    """A solved case: one step per normal load, then per shear, then per shear on the way back.

    radius: of the object or the ball.
    """

    problem: ContactProblem
    pressed: tuple[Step, ...]
    sheared: tuple[Step, ...]
    returned: tuple[Step, ...]
    radius: float

    @property
    def plane(self) -> bool:
        return self.problem.model.dimension == 2

    def hertz(self, step: Step) -> analytic.Hertz:
        """Hertz's solution for the normal force of a step."""
        solution = analytic.hertz_line if self.plane else analytic.hertz_point
        return solution(step.measures.normal_force, self.radius, modulus())

    def half_width(self, area: float) -> float:
        """Half-width of a line contact of 1 mm depth, or radius of a circle, with this area."""
        return 0.5 * area if self.plane else float(np.sqrt(area / np.pi))

    def width_error(self, step: Step) -> float:
        """Relative error of the half-width, or radius, of contact."""
        return self.half_width(step.measures.contact_area) / self.hertz(step).half_width - 1.0

    def peak_error(self, step: Step) -> float:
        """Relative error of the peak pressure."""
        return step.measures.peak_pressure / self.hertz(step).peak_pressure - 1.0

    def pressure_error(self, step: Step) -> float:
        """L2 norm of the pressure's error over that of the pressure, at the nodes' own weights."""
        model = self.problem.model
        distance = np.linalg.norm(model.points[:, ::2], axis=1)
        return self._off(step.increment.multiplier[:, 0], self.hertz(step).pressure(distance))

    def traction(self, step: Step, distance: Array) -> Array:
        """Cattaneo's and Mindlin's traction for the forces of a sheared step."""
        share = (
            analytic.cattaneo_mindlin_line if self.plane else analytic.cattaneo_mindlin_sphere
        )(step.measures.tangential_force, step.measures.normal_force, FRICTION)
        return analytic.cattaneo_mindlin_traction(distance, self.hertz(step), share, FRICTION)

    def traction_error(self, step: Step) -> float:
        """The same of the shear traction along x, of a step with shear."""
        distance = np.linalg.norm(self.problem.model.points[:, ::2], axis=1)
        return self._off(step.increment.force[:, 0], self.traction(step, distance))

    def _off(self, force: Array, exact: Array) -> float:
        areas = self.problem.model.areas
        off = force / areas - exact
        return float(np.sqrt((areas @ off**2) / (areas @ exact**2)))


def modulus(poissons_ratio: float = NU) -> float:
    """E* of the blocks."""
    return analytic.plane_strain_modulus(1.0, poissons_ratio)


def load(plane: bool, half_width: float = 1.0, poissons_ratio: float = NU) -> float:
    """N (per mm) that a frictionless cylinder or sphere needs for this half-width (Hertz)."""
    if plane:
        return float(np.pi * modulus(poissons_ratio) * half_width**2 / (4.0 * RADIUS))
    return float(4.0 / 3.0 * modulus(poissons_ratio) * half_width**3 / RADIUS)


def line_block(size: float, poissons_ratio: float = NU) -> Body:
    """A deep block for a cylinder, facets of ``size`` half-widths about the contact."""
    mesh = block_section(DEPTH, DEPTH, 1.3, size)
    return uniform_body(mesh, 1.0, poissons_ratio, held(mesh, "base"), 1.3, "mixed")


def point_block(
    size: float, poissons_ratio: float = NU, depth: float = DEPTH, whole: bool = False
) -> Body:
    """A deep round block for a sphere, held all round: its half z >= 0, or all of it."""
    growth = 2.0 if whole else 1.6
    mesh = revolved_half(round_block_section(depth, depth, 1.2, size, growth), 8)
    mesh = both_halves(mesh) if whole else mesh
    return uniform_body(mesh, 1.0, poissons_ratio, held(mesh, "base", "side"), 1.2, "mixed")


@lru_cache(maxsize=8)
def line_contact(size: float) -> Pressed:
    """A cylinder on a deep block."""
    return _solve(line_block(size), Cylinder(RADIUS, RADIUS), RADIUS)


@lru_cache(maxsize=4)
def point_contact(size: float) -> Pressed:
    """A sphere on a deep round block."""
    return _solve(point_block(size), Sphere(RADIUS, RADIUS), RADIUS)


def ball(size: float = 0.1) -> Solution:
    """Half an elastic ball, held at its equator, under a rigid plane: half z >= 0.

    Curved facets instead of a curved object. The ball's whole yielding shows in the approach, which
    Hertz does not give: compare at the force.
    """
    mesh = revolved_half(right_half(half_disc(_BALL, 1.2, size, 1.5)), 8)

    def onto_the_ball(points: Array) -> Array:
        across = points[:, 0] ** 2 + points[:, 2] ** 2
        exact = points.copy()
        exact[:, 1] = -across / (_BALL + np.sqrt(_BALL**2 - across))
        return exact

    body = uniform_body(mesh, 1.0, NU, held(mesh, "base"), 1.2, "mixed")
    return _hertz(_solve(replace(body, project=onto_the_ball), Plane(0.0), _BALL))


def _solve(body: Body, indenter: Indenter, radius: float) -> Pressed:
    problem = contact_problem(body_model(body), indenter, FRICTION)
    plane = problem.model.dimension == 2
    loads = [load(plane, a) * RADIUS / radius for a in LOADS]
    path = [Forces(each, held=Motion(0.0, 0.0)) for each in loads]
    path += [Forces(loads[-1], share * FRICTION * loads[-1]) for share in (*SHEARS, *BACK)]
    steps = tuple(follow(problem, path))
    first, turn = len(LOADS), len(LOADS) + len(SHEARS)
    return Pressed(problem, steps[:first], steps[first:turn], steps[turn:], radius)


def line(size: float = 0.025) -> Solution:
    """A cylinder: facets of ``size`` half-widths."""
    return _hertz(line_contact(size))


def sphere(size: float = 0.1) -> Solution:
    """A sphere: the approach, too."""
    case = point_contact(size)
    solution, last = _hertz(case), case.pressed[-1]
    known = analytic.hertz_point_force(last.increment.motion.approach, RADIUS, modulus())
    solution.values["force at the approach"] = last.measures.normal_force / known
    return solution


def _hertz(case: Pressed) -> Solution:
    """Half-width and peak over Hertz's, stick c / a, worst L2 errors."""
    last = case.pressed[-1]
    named = {f"stick at {q:g}": s for q, s in zip(SHEARS, case.sheared, strict=True)}
    named |= {f"stick back at {q:g}": s for q, s in zip(BACK, case.returned, strict=True)}
    values = {
        name: case.half_width(step.measures.stick_area) / case.hertz(last).half_width
        for name, step in named.items()
    }
    values |= {
        "half-width": 1.0 + case.width_error(last),
        "peak pressure": 1.0 + case.peak_error(last),
        "pressure, L2": case.pressure_error(last),
        "traction, L2": max(case.traction_error(step) for step in case.sheared),
    }
    return Solution(values, (case.problem, (*case.pressed, *case.sheared, *case.returned)))


def line_rates(sizes: tuple[float, ...] = (0.1, 0.07, 0.05, 0.035, 0.025)) -> Solution:
    """Fitted orders in the facets' size."""
    return _rates([line_contact(size) for size in sizes], sizes)


def sphere_rates(sizes: tuple[float, ...] = (0.2, 0.14, 0.1)) -> Solution:
    """The same of a sphere."""
    return _rates([point_contact(size) for size in sizes], sizes)


def _rates(cases: list[Pressed], sizes: tuple[float, ...]) -> Solution:
    """1 is expected of pressure and traction in L2 and of the borders, 2 of the peak pressure."""

    def mean(error: Callable[[Pressed, Step], float], sheared: bool = False) -> Array:
        rows = [[error(c, s) for s in (c.sheared if sheared else c.pressed)] for c in cases]
        return np.asarray(np.sqrt(np.mean(np.square(rows), axis=1)))

    errors = {
        "pressure, L2": mean(Pressed.pressure_error),
        "traction, L2": mean(Pressed.traction_error, sheared=True),
        "peak pressure": mean(Pressed.peak_error),
        "half-width": mean(Pressed.width_error),
    }
    return orders(np.array(sizes), errors)


def orders(sizes: Array, errors: dict[str, Array]) -> Solution:
    """Fit the order of each error in the sizes."""
    return Solution(
        {
            name: float(np.polyfit(np.log(sizes), np.log(np.abs(each)), 1)[0])
            for name, each in errors.items()
        }
    )


def product(shape: str, size: float) -> Solution:
    """The dome or the pin through ``analyse``, its mesh by fTetWild: the worst over Hertz's."""
    design = parse_design(f"{_DESIGN}\n{_SHAPES[shape]}\nmesh.contact_size_mm = {size}")
    own = analytic.plane_strain_modulus(4.96, NU)
    normal = 4.0 / 3.0 * own * _CONTACT**3 / _ROUND
    limit = _ROUND_FRICTION * normal
    back = BACK[:2]
    rows = [[normal, 0.0], *([normal, share * limit] for share in (*SHEARS, *back))]
    scene = parse_scene(
        f'object.friction_coefficient = {_ROUND_FRICTION}\npath.control = "force"\n'
        f"path.increments_N = {rows}\npath.substeps = 1"
    )
    increments = analyse(design, scene, "3d").increments
    peak, width, stick = [], [], []
    for number, each in enumerate(increments):
        hertz = analytic.hertz_point(each.normal_force_N, _ROUND, own)
        before = SHEARS[-1] * limit if number > len(SHEARS) else None
        forces = (each.tangential_force_N, each.normal_force_N)
        known = analytic.cattaneo_mindlin_sphere(*forces, _ROUND_FRICTION, before)
        peak.append(each.peak_pressure_MPa / hertz.peak_pressure - 1.0)
        width.append(0.5 * each.contact_width_mm / hertz.half_width - 1.0)
        stick.append(float(np.sqrt(each.stick_ratio or 0.0)) - known)
    worst = {
        "peak pressure": 1.0 + max(peak, key=abs),
        "width": 1.0 + max(width, key=abs),
        "stick, off": max(stick, key=abs),
    }
    return Solution(worst)
