"""Measured contacts: bonded rubber discs in compression, rubber rings between plates.

Nothing is fitted: rubber is its tabulated modulus, geometry is given. Neither needs a friction
coefficient: discs are bonded, and the flat of a ring's half and the middle of a disc are planes of
mirror symmetry, where no shear acts.
"""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.fem.finite.body import finite_body
from fingerdesign.fem.finite.facing import facing
from fingerdesign.fem.finite.row import Follower, untouched
from fingerdesign.fem.reduction import body_model
from fingerdesign.fem.system import Body
from fingerdesign.shapes.objects import Plane
from fingerdesign_bench.accuracy.block import graded, rectangle
from fingerdesign_bench.accuracy.disc import half_disc
from fingerdesign_bench.accuracy.revolve import revolved_half
from fingerdesign_bench.accuracy.uniform import held, uniform_body
from fingerdesign_bench.known.case import Solution

# Rubber of 47 IRHD between the rows 45 and 50 of Lindley's Table 3, MPa. Modulus and hardness were
# measured apart from the discs. 3 G is 1.74 where E is 1.96: a bonded disc is mostly sheared.
SHEAR_MODULUS, BULK_MODULUS = 0.58, 1012.0

# Lindley's Fig. 27 as we read it off, axes' turn of 0.9 degrees taken out: shape factor -> (strain
# %, compressive stress MPa), to 0.02 % and 0.02 MPa; of 44 points those that are drawn.
FIG_27 = {
    1: ((4.63, 0.238), (8.28, 0.442), (14.89, 0.792)),
    2: ((3.78, 0.518), (5.49, 0.770), (9.74, 1.538)),
    3: ((3.43, 1.181), (5.23, 1.752), (9.83, 3.341)),
    4: ((3.71, 1.941), (4.94, 2.557), (9.43, 5.080)),
    6: ((2.59, 2.870), (5.30, 5.699), (9.99, 11.341)),
}
THICKNESS = 6.35  # mm, of each disc


def disc(shape_factor: int, percent: float, finite_rows: int = 0) -> Solution:
    """A disc of diameter 4 S t, bonded to both plates, compressed by ``percent`` of t: MPa.

    The half below its middle plane, which a frictionless plane pushes: by symmetry the whole. At
    finite strain, too, in so many rows.
    """
    body, area = _half_disc(shape_factor, SHEAR_MODULUS, BULK_MODULUS)
    half = 0.5 * THICKNESS
    problem, force = _small(body, [0.01 * percent * half])
    values = {"stress": float(force[-1]) / area}
    if finite_rows:
        strains = percent * np.arange(1, finite_rows + 1) / finite_rows
        force = _finite(body, 0.01 * half * strains)
        values["stress, finite strain"] = float(force[-1]) / area
    return Solution(values, problem)


def compression_modulus(
    shear_modulus: float, bulk_modulus: float, youngs_modulus: float, k: float
) -> Solution:
    """Stress over strain, MPa, of bonded discs S = 1, 2, 4 of one row of Lindley's Table 3, all in
    MPa: youngs_modulus and k are those of his law alone."""
    values = {}
    for shape_factor in (1, 2, 4):
        body, area = _half_disc(shape_factor, shear_modulus, bulk_modulus)
        problem, force = _small(body, [0.005 * THICKNESS])
        values[f"S = {shape_factor}"] = float(force[0]) / area / 0.01
    return Solution(values, problem)


def measured_blocks(
    shape_factor: Array, youngs_modulus: float, k: float, bulk_modulus: float
) -> Array:
    """Lindley's law of measured bonded blocks: E (1 + 2 k S^2), bulk compression in series, MPa."""
    modulus = youngs_modulus * (1.0 + 2.0 * k * shape_factor**2)
    return np.asarray(modulus / (1.0 + modulus / bulk_modulus))


def ring(mean: float = 5.0, size: float = 0.04) -> Solution:
    """A ring of round cord, diameter 1 mm, between frictionless plates: F / (length E d).

    mean: radius, mm, of the ring; facets of ``size`` mm in the first fifth of a mm, then growing.
    Half of the cord's section, swept around the ring's axis: it may widen, as a closed ring does,
    which plane strain does not know.
    """
    shares = np.array([0.1, 0.2, 0.3, 0.4])  # of the diameter
    reach = 0.42
    section = half_disc(0.5, 0.2, size, 1.25)
    section = replace(section, points=section.points + np.array([mean, 0.0]))
    mesh = revolved_half(section, 6)
    fixed = held(mesh, base=(1,))
    fixed[np.abs(mesh.points[:, 0]) < 1e-9, 0] = True  # against sliding along x as a whole
    crest, facets = np.abs(_around(mesh.points) - mean), mesh.facets["contact"]
    near = facets[(crest[facets] <= reach + 1e-9).all(axis=1)]

    def onto_the_cord(points: Array) -> Array:
        across = (_around(points) - mean) ** 2
        exact = points.copy()
        exact[:, 1] = -across / (0.5 + np.sqrt(0.25 - across))
        return exact

    body = replace(
        uniform_body(mesh, 1.0, 0.4997, fixed, element="mixed"), contact=near, project=onto_the_cord
    )
    length = 2.0 * np.pi * mean
    problem, force = _small(body, 0.5 * shares)
    small, large = force / length, _finite(body, 0.5 * shares) / length
    values = {f"at {100 * x:.0f} %": float(f) for x, f in zip(shares, large, strict=True)}
    values |= {
        f"at {100 * x:.0f} %, small strain": float(f) for x, f in zip(shares, small, strict=True)
    }
    return Solution(values, problem)


def measured_ring(compression: Array) -> Array:
    """Lindley's law of measured rings: F / (length E d) at ``compression`` over diameter d."""
    return np.asarray(1.25 * compression**1.5 + 50.0 * compression**6)


def _half_disc(shape_factor: int, shear_modulus: float, bulk_modulus: float) -> tuple[Body, float]:
    """A disc's half below its middle plane, the half z >= 0 of that, and the disc's area mm^2."""
    radius, half = 2.0 * shape_factor * THICKNESS, 0.5 * THICKNESS
    x = radius - graded(half / 3.0, half, radius)[::-1]
    mesh = revolved_half(rectangle(x, np.linspace(-half, 0.0, 4)), 8)
    modulus = 9.0 * bulk_modulus * shear_modulus / (3.0 * bulk_modulus + shear_modulus)
    ratio = 0.5 * modulus / shear_modulus - 1.0
    body = uniform_body(mesh, modulus, ratio, held(mesh, "base"), element="mixed")
    return body, float(np.pi * radius**2)


def _around(points: Array) -> Array:
    """Distances (n,) from the axis y."""
    return np.asarray(np.hypot(points[:, 0], points[:, 2]))


def _small(
    body: Body, approaches: Sequence[float] | Array
) -> tuple[tuple[ContactProblem, tuple[Step, ...]], Array]:
    """The problem with its path, and forces N of the whole, at small strain."""
    problem = contact_problem(body_model(body), Plane(0.0), 0.0)
    steps = tuple(follow(problem, [Motion(float(each), 0.0) for each in approaches]))
    return (problem, steps), np.array([step.measures.normal_force for step in steps])


def _finite(body: Body, approaches: Array) -> Array:
    """Forces N of the whole at finite strain."""
    follower = Follower(facing(finite_body(body), Plane(0.0), 0.0))
    past, forces = untouched(follower.facing), []
    for approach in approaches:
        past = follower.row(past, Motion(float(approach), 0.0)).past
        forces.append(-2.0 * float(past.force[:, 1].sum()))
    return np.array(forces)
