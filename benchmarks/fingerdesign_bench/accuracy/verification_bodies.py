"""Two elastic bodies, flat faces, and blocks that only contact holds: analytic and published cases.

An elastic object's compliance is added to the finger's (facing.py), gaps are taken along y. Where
contact alone holds a body against a motion, a support takes that motion in the model, force control
finds it, and the support must come out without force.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.fem.body import CondensedBody, condense_body
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.reduction import reduced_model
from fingerdesign.fem.system import Body
from fingerdesign.mesh.types import Mesh
from fingerdesign.shapes.objects import Cylinder, Plane
from fingerdesign_bench.accuracy.block import (
    block_section,
    both_sides,
    graded,
    near,
    rectangle,
    upside_down,
)
from fingerdesign_bench.accuracy.disc import disc, half_disc
from fingerdesign_bench.accuracy.facing import facing_compliance

Element = Literal["P1", "P2", "mixed"]

STILL = Motion(0.0, 0.0)


@dataclass(frozen=True)
class FromAbove:
    """The lower face of a round object of ``radius`` mm that touches (0, 0): gaps along y.

    For an elastic object on an elastic finger, where neither surface alone gives the common normal.
    """

    radius: float

    def distance(self, points: Array) -> Array:
        across = points[:, 0] ** 2
        rise = across / (self.radius + np.sqrt(self.radius**2 - across))
        return np.asarray(rise - points[:, 1])

    def normal(self, points: Array) -> Array:
        normals = np.zeros_like(points)
        normals[:, 1] = -1.0
        return normals


@dataclass(frozen=True)
class Solved:
    """The condensed lower body, its contact problem, the solved path, and the body's own nodal
    forces (n dim, 1) N at share 1."""

    body: CondensedBody
    problem: ContactProblem
    steps: tuple[Step, ...]
    loads: Array | float = 0.0

    @property
    def pressure(self) -> Array:
        """Nodal contact pressures (m,) MPa of the last step."""
        return np.asarray(self.steps[-1].increment.multiplier[:, 0] / self.problem.model.areas)

    def displacement(self, place: Array) -> Array:
        """Displacement (2,) mm of the lower body's mesh node nearest to ``place``, last step."""
        increment = self.steps[-1].increment
        own = increment.motion.load * self.loads
        field = self.body.displacement_fields(increment.force[None], own)[0]
        nearest = np.argmin(np.linalg.norm(self.body.body.mesh.points - place, axis=1))
        return np.asarray(field[nearest])


def equal_cylinders(
    size: float = 0.02, below: float = 200.0, above_modulus: float = 200.0
) -> Solved:
    """Half cylinders R = 8, nu = 0.3, crest to crest: P = 10, Q up to 0.93616, mu = 0.2.

    E = 200 of both in the published case; ``below`` and ``above_modulus`` may differ.
    """
    mesh = half_disc(8.0, 1.6, size)
    lower = condense_body(_body(mesh, below, 0.3, _held(mesh, "base"), 1.4))
    upper = upside_down(half_disc(8.0, 1.8, 1.25 * size))
    shears = [share * 0.93616 for share in (0.25, 0.5, 0.75, 1.0)]
    path = [Forces(10.0, held=STILL), *(Forces(10.0, shear) for shear in shears)]
    above = _body(upper, above_modulus, 0.3, _held(upper, "base"), 2.0)
    return _two(lower, above, FromAbove(8.0), 0.2, path)


def nafems_roller(size: float = 0.15, friction_coefficient: float = 0.0) -> Solved:
    """A steel roller R = 50 on an aluminium block 200 x 200, 35 kN per mm through its top point.

    Advanced Finite Element Contact Benchmarks (Konter, NAFEMS 2006), 1; E 210 and 70 GPa, nu 0.3,
    the block's base fixed. The top point carries the force as a support.
    """
    mesh = block_section(100.0, 200.0, 9.0, size)
    lower = condense_body(_body(mesh, 70e3, 0.3, _held(mesh, "base"), 9.0))
    upper = upside_down(disc(50.0, 10.0, size))
    fixed = np.zeros(upper.points.shape, dtype=bool)
    fixed[_nearest(upper, [0.0, 100.0])] = True
    fixed[_nearest(upper, [0.0, 50.0]), 0] = True  # against rolling
    above = _body(upper, 210e3, 0.3, fixed, 12.0)
    path = [Forces(35e3 * share, held=STILL) for share in (0.25, 0.5, 0.75, 1.0)]
    return _two(lower, above, FromAbove(50.0), friction_coefficient, path)


def pressed_plate(size: float = 0.5) -> Solved:
    """SSNV128: a plate 80 x 40 pressed on a rigid plane by 50 MPa and from its sides by 150 MPa.

    The half 0 <= x <= 40, mirrored in x = 40; E = 130 GPa, nu = 0.2, mu = 1. The plane is above
    here. Nothing but contact carries y: the support of one node takes the rigid motion.
    """
    x = graded(size, 20.0, 40.0, 1.2)
    mesh = rectangle(x, -graded(size, 8.0, 40.0, 1.2)[::-1])
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    fixed[np.unique(mesh.facets["right"]), 0] = True
    fixed[_nearest(mesh, [40.0, -40.0]), 1] = True
    loads = face_loads(mesh, "base", np.array([0.0, 50.0]))
    loads += face_loads(mesh, "left", np.array([150.0, 0.0]))
    own = loads.reshape(-1, 1)
    condensed = condense_body(_body(mesh, 130e3, 0.2, fixed, 41.0), [sp.csr_matrix(own.T)])
    condensed = replace(condensed, load_displacement=condensed.readouts[0][0])
    problem = contact_problem(reduced_model(condensed), Plane(0.0), 1.0)
    shares = np.linspace(0.1, 1.0, 10)
    path = [Forces(2000.0 * share, held=Motion(0.0, 0.0, load=float(share))) for share in shares]
    return Solved(condensed, problem, tuple(follow(problem, path)), own)


def flat_punch(size: float = 0.02, poissons_ratio: float = 0.3) -> Solved:
    """A rigid flat punch |x| <= 1 without friction on a block 100 deep, P = 1 per mm, E = 1."""
    mesh = block_section(100.0, 100.0, 1.0, size)
    ends = {**mesh.facets, "contact": near(mesh, "contact", 1.0)}  # the punch ends, not the zone
    mesh = replace(mesh, facets=ends)
    condensed = condense_body(_body(mesh, 1.0, poissons_ratio, _held(mesh, "base"), 1.0))
    problem = contact_problem(reduced_model(condensed), Plane(0.0), 0.0)
    return Solved(condensed, problem, tuple(follow(problem, [Forces(1.0, held=STILL)])))


def bonded_layer(
    half_width: float = 40.0,
    size: float = 0.1,
    poissons_ratio: float = 0.499999,
    sinking: float = 6.0,
) -> Solved:
    """A frictionless cylinder, R = 1e6, on a bonded layer 1 mm thick, to a given half-width.

    E = 1. The approach is half_width^2 / (sinking R): 6 of the thin incompressible layer, 2 of the
    thin compressible one.
    """
    reach = 1.1 * half_width
    x = both_sides(graded(3.0 * size, reach, half_width + 10.0, 1.2))
    mesh = rectangle(x, np.linspace(-1.0, 0.0, round(1.0 / size) + 1))
    body = _body(mesh, 1.0, poissons_ratio, _held(mesh, "base"), reach, "mixed")
    condensed = condense_body(body)
    problem = contact_problem(reduced_model(condensed), Cylinder(1e6, 1e6), 0.0)
    motion = Motion(half_width**2 / (sinking * 1e6), 0.0)
    return Solved(condensed, problem, tuple(follow(problem, [motion])))


def wedge(slope: float = 0.1, friction_coefficient: float = 0.3) -> Solved:
    """NAFEMS CGS-4: a block pushed up a rigid slope tan a, far enough to slide everywhere."""
    mesh = block_section(1.0, 1.0, 1.0, 0.2)
    condensed = condense_body(_body(mesh, 1.0, 0.3, _held(mesh, "base"), 1.0))
    angle = np.arctan(slope)
    plane = Plane(0.0, (float(np.sin(angle)), -float(np.cos(angle)), 0.0))
    problem = contact_problem(reduced_model(condensed), plane, friction_coefficient)
    path = [Motion(0.15, 0.0), Motion(0.15, 1.0)]
    return Solved(condensed, problem, tuple(follow(problem, path)))


def face_loads(mesh: Mesh, face: str, traction: Array) -> Array:
    """Consistent nodal forces (n, dim) N of a constant ``traction`` (dim,) MPa on a named face."""
    facets, dimension = mesh.facets[face], mesh.dimension
    table = tabulate(dimension - 1, *quadrature(dimension - 1, 4))
    tangents = np.einsum("fna,nbq->fqab", mesh.points[facets], table.gradient)
    if dimension == 2:
        stretch = np.linalg.norm(tangents[..., 0], axis=2)
    else:
        stretch = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=2)
    share = np.einsum("nq,fq,q->fn", table.value, stretch, table.weights)
    loads = np.zeros(mesh.points.shape)
    np.add.at(loads, facets, share[:, :, None] * traction)
    return loads


def _two(
    lower: CondensedBody, above: Body, gap: FromAbove, friction: float, path: list[Forces]
) -> Solved:
    model = reduced_model(lower)
    problem = contact_problem(model, gap, friction, facing_compliance(above, model))
    return Solved(lower, problem, tuple(follow(problem, path)))


def _body(
    mesh: Mesh,
    youngs_modulus: float,
    poissons_ratio: float,
    fixed: NDArray[np.bool_],
    zone: float,
    element: Element = "P2",
) -> Body:
    """A body of one material, held at ``fixed`` (n, dim), with contact facets in |x| <= zone."""
    count = len(mesh.cells)
    return Body(
        mesh,
        np.full(count, youngs_modulus),
        np.full(count, poissons_ratio),
        fixed.reshape(-1),
        near(mesh, "contact", zone),
        element=element,
    )


def _held(mesh: Mesh, *faces: str) -> NDArray[np.bool_]:
    fixed = np.zeros(mesh.points.shape, dtype=bool)
    for face in faces:
        fixed[np.unique(mesh.facets[face])] = True
    return fixed


def _nearest(mesh: Mesh, place: list[float]) -> int:
    return int(np.argmin(np.linalg.norm(mesh.points - place, axis=1)))
