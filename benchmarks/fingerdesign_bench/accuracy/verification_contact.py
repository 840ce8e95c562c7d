"""A rigid round on a deep elastic block, where Hertz and Cattaneo-Mindlin hold: line and point.

A rigid cylinder or sphere, 1000 contact half-widths in radius, is pressed into a block with force
control, sheared to near the friction limit, brought back and sheared the other way. Lengths are in
half-widths of the last normal load (mm here), E = 1 MPa.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.fem.reduction import body_model
from fingerdesign.fem.system import Body
from fingerdesign.mesh.types import Mesh
from fingerdesign.shapes.objects import Cylinder, Indenter, Plane, Sphere
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.accuracy.block import block_section, near
from fingerdesign_bench.accuracy.disc import half_disc, right_half
from fingerdesign_bench.accuracy.revolve import both_halves, revolved_half, round_block_section

Element = Literal["P1", "P2", "mixed"]

RADIUS = 1000.0  # of the object, in contact half-widths
LOADS = (0.83, 0.89, 0.94, 1.0)  # half-widths: the border falls at all places of a facet
SHEARS = (0.4, 0.6, 0.8)  # of the friction limit, loading
BACK = (0.0, -0.3, -0.6)  # and on the way back, into the other direction


@dataclass(frozen=True)
class Pressed:
    """A solved case: one step per normal load, then per shear, then per shear on the way back."""

    problem: ContactProblem
    steps: tuple[Step, ...]
    modulus: float
    dofs: int
    radius: float = RADIUS

    @property
    def pressed(self) -> tuple[Step, ...]:
        return self.steps[: len(LOADS)]

    @property
    def sheared(self) -> tuple[Step, ...]:
        return self.steps[len(LOADS) : len(LOADS) + len(SHEARS)]

    @property
    def returned(self) -> tuple[Step, ...]:
        return self.steps[len(LOADS) + len(SHEARS) :]

    def is_return(self, step: Step) -> bool:
        """Whether the shear has turned round before this step."""
        return any(step is each for each in self.returned)


def line_contact(
    size: float,
    poissons_ratio: float = 0.4999,
    friction_coefficient: float = 0.3,
    element: Element = "mixed",
    depth: float = 1000.0,
) -> Pressed:
    """A cylinder on a block ``depth`` half-widths deep and twice as wide, facets of ``size``."""
    modulus = analytic.plane_strain_modulus(1.0, poissons_ratio)
    body = line_block(size, poissons_ratio, element, depth)
    loads = [np.pi * modulus * a**2 / (4.0 * RADIUS) for a in LOADS]
    return _solve(body, Cylinder(RADIUS, RADIUS), friction_coefficient, loads, modulus)


def point_contact(
    size: float,
    poissons_ratio: float = 0.4999,
    friction_coefficient: float = 0.3,
    element: Element = "mixed",
    depth: float = 1000.0,
    growth: float = 1.6,
    steps: int = 8,
) -> Pressed:
    """A sphere on a round block ``depth`` contact radii deep and wide, held all round; half z >= 0.

    So deep that what a half space would still yield beyond it is 0.1 % of the approach: force
    against approach is compared without a correction.
    """
    modulus = analytic.plane_strain_modulus(1.0, poissons_ratio)
    body = point_block(size, poissons_ratio, element, depth, growth, steps)
    loads = [4.0 / 3.0 * modulus * a**3 / RADIUS for a in LOADS]
    return _solve(body, Sphere(RADIUS, RADIUS), friction_coefficient, loads, modulus)


def line_block(
    size: float, poissons_ratio: float, element: Element = "mixed", depth: float = 1000.0
) -> Body:
    """The block of ``line_contact``: E = 1, facets of ``size`` in |x| <= 1.3."""
    mesh = block_section(depth, depth, 1.3, size)
    return _block(mesh, poissons_ratio, element, ("base",))


def point_block(
    size: float,
    poissons_ratio: float,
    element: Element = "mixed",
    depth: float = 1000.0,
    growth: float = 1.6,
    steps: int = 8,
    whole: bool = False,
) -> Body:
    """The block of ``point_contact``: its half z >= 0, or all of it."""
    mesh = revolved_half(round_block_section(depth, depth, 1.2, size, growth), steps)
    return _block(both_halves(mesh) if whole else mesh, poissons_ratio, element, ("base", "side"))


def ball_on_plane(
    size: float, radius: float = 40.0, friction_coefficient: float = 0.3, steps: int = 8
) -> Pressed:
    """Half an elastic ball, held at its equator, under a rigid plane: nu = 0.4999, half z >= 0.

    Curved facets instead of a curved object. The ball is ``radius`` contact radii deep, so that its
    whole yielding shows in the approach, which Hertz does not give: compare at the force.
    """
    modulus = analytic.plane_strain_modulus(1.0, 0.4999)
    mesh = revolved_half(right_half(half_disc(radius, 1.2, size, 1.5)), steps)

    def onto_the_ball(points: Array) -> Array:
        across = points[:, 0] ** 2 + points[:, 2] ** 2
        exact = points.copy()
        exact[:, 1] = -across / (radius + np.sqrt(radius**2 - across))
        return exact

    body = replace(_block(mesh, 0.4999, "mixed", ("base",)), project=onto_the_ball)
    loads = [4.0 / 3.0 * modulus * a**3 / radius for a in LOADS]
    solved = _solve(body, Plane(0.0), friction_coefficient, loads, modulus)
    return replace(solved, radius=radius)


def hertz_of(case: Pressed, step: Step) -> analytic.Hertz:
    """Hertz's solution for the normal force of a step."""
    force = step.measures.normal_force
    if case.problem.model.dimension == 2:
        return analytic.hertz_line(force, case.radius, case.modulus)
    return analytic.hertz_point(force, case.radius, case.modulus)


def stick_share(case: Pressed, step: Step) -> float:
    """Cattaneo's and Mindlin's c / a for the forces of a step of ``case``."""
    share = (
        analytic.cattaneo_mindlin_line
        if case.problem.model.dimension == 2
        else analytic.cattaneo_mindlin_sphere
    )
    measures = step.measures
    before = case.sheared[-1].measures.tangential_force if case.is_return(step) else None
    friction = case.problem.friction_coefficient
    return share(measures.tangential_force, measures.normal_force, friction, before)


def half_width(case: Pressed, area: float) -> float:
    """Half-width of a line contact of 1 mm depth, or radius of a circle, with this area."""
    return 0.5 * area if case.problem.model.dimension == 2 else float(np.sqrt(area / np.pi))


def width_errors(case: Pressed) -> Array:
    """Relative errors (loads,) of the half-width, or radius, of contact."""
    return np.array(
        [
            half_width(case, step.measures.contact_area) / hertz_of(case, step).half_width - 1.0
            for step in case.pressed
        ]
    )


def peak_errors(case: Pressed) -> Array:
    """Relative errors (loads,) of the peak pressure."""
    return np.array(
        [
            step.measures.peak_pressure / hertz_of(case, step).peak_pressure - 1.0
            for step in case.pressed
        ]
    )


def stick_errors(case: Pressed, steps: tuple[Step, ...]) -> Array:
    """Errors (steps,) of the half-width or radius of the stick zone over that of the contact."""
    errors = []
    for step in steps:
        contact = hertz_of(case, step).half_width
        stick = half_width(case, step.measures.stick_area)
        errors.append(stick / contact - stick_share(case, step))
    return np.array(errors)


def approach_errors(case: Pressed) -> Array:
    """Relative errors (loads,) of a sphere's force at the approach that was found."""
    return np.array(
        [
            step.measures.normal_force
            / analytic.hertz_point_force(step.increment.motion.approach, case.radius, case.modulus)
            - 1.0
            for step in case.pressed
        ]
    )


def pressure_error(case: Pressed, step: Step) -> float:
    """L2 norm of the pressure's error over that of the pressure, at the nodes' own weights."""
    model = case.problem.model
    got = step.increment.multiplier[:, 0] / model.areas
    exact = hertz_of(case, step).pressure(_distance(model.points))
    return _norm(got - exact, model.areas) / _norm(exact, model.areas)


def traction_error(case: Pressed, step: Step) -> float:
    """As ``pressure_error`` for the shear traction along x, of a step with shear."""
    model = case.problem.model
    friction = case.problem.friction_coefficient
    contact, share = hertz_of(case, step), stick_share(case, step)
    distance = _distance(model.points)
    if case.is_return(step):
        before = stick_share(case, case.sheared[-1])
        exact = analytic.reversed_traction(distance, contact, before, share, friction)
    else:
        exact = analytic.cattaneo_mindlin_traction(distance, contact, share, friction)
    got = step.increment.force[:, 0] / model.areas
    return _norm(got - exact, model.areas) / _norm(exact, model.areas)


def _distance(points: Array) -> Array:
    return np.asarray(np.linalg.norm(points[:, ::2], axis=1))


def _norm(values: Array, areas: Array) -> float:
    return float(np.sqrt(areas @ values**2))


def _block(mesh: Mesh, poissons_ratio: float, element: Element, held: tuple[str, ...]) -> Body:
    """A block of E = 1 held on the named faces, its candidates within 1.2 or 1.3 of the middle."""
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    for name in held:
        fixed[np.unique(mesh.facets[name])] = True
    if mesh.symmetric:
        fixed[np.unique(mesh.facets["symmetry"]), 2] = True
    count = len(mesh.cells)
    return Body(
        mesh,
        np.ones(count),
        np.full(count, poissons_ratio),
        fixed.reshape(-1),
        near(mesh, "contact", 1.3 if mesh.dimension == 2 else 1.2),
        element=element,
    )


def _solve(
    body: Body, indenter: Indenter, friction: float, loads: list[float], modulus: float
) -> Pressed:
    problem = contact_problem(body_model(body), indenter, friction)
    limit = friction * loads[-1]
    still = Motion(0.0, 0.0)
    path = [Forces(load, held=still) for load in loads]
    path += [Forces(loads[-1], share * limit) for share in (*SHEARS, *BACK)]
    steps = tuple(follow(problem, path))
    return Pressed(problem, steps, modulus, int((~body.fixed).sum()))
