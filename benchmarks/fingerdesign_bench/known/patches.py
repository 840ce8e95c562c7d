"""Patch tests: contact whose pressure is the same everywhere, on flat, round and hollow faces."""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.path import Step, follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.fem.reduction import body_model, reduced_model
from fingerdesign.fem.system import Body
from fingerdesign.shapes.objects import Indenter, Plane
from fingerdesign_bench.accuracy.block import rectangle
from fingerdesign_bench.accuracy.revolve import revolved_half, round_block_section
from fingerdesign_bench.accuracy.uniform import (
    condense_loaded,
    face_loads,
    held,
    nearest,
    uniform_body,
)
from fingerdesign_bench.known.case import Solution
from fingerdesign_bench.known.rounds import orders

SUNK = 0.01  # mm, all of it on faces that stand 1 mm deep; E = 1 MPa
_UNEVEN = np.array([-1.0, -0.85, -0.4, 0.1, 0.25, 0.7, 1.0])


@dataclass(frozen=True)
class Core:
    """A rigid round core in a bore about (0, 0): gaps along the radius."""

    radius: float

    def distance(self, points: Array) -> Array:
        return np.asarray(np.linalg.norm(points, axis=1) - self.radius)

    def normal(self, points: Array) -> Array:
        return np.asarray(points / np.linalg.norm(points, axis=1)[:, None])


def brick(poissons_ratio: float, friction: float) -> Solution:
    """An uneven mesh on rollers under a plane: p = E / (1 - nu^2) of the strain."""
    mesh = rectangle(_UNEVEN, np.array([-1.0, -0.7, -0.2, 0.0]))
    fixed = held(mesh, base=(1,))
    fixed[nearest(mesh, (0.1, -1.0)), 0] = True
    pressure = SUNK / (1.0 - poissons_ratio**2)
    return _pressed(uniform_body(mesh, 1.0, poissons_ratio, fixed), Plane(0.0), friction, pressure)


def sheared_brick(friction: float = 0.5, share: float = 0.8) -> Solution:
    """The same at nu = 0, held below, its sides under the shear that its middle has: all sticks.

    Pressure E SUNK and shear traction ``share`` mu times it, both even.
    """
    mesh = rectangle(_UNEVEN, np.array([-1.0, -0.7, -0.2, 0.0]))
    traction = share * friction * SUNK
    loads = face_loads(mesh, "right", (0.0, traction))
    loads -= face_loads(mesh, "left", (0.0, traction))
    condensed = condense_loaded(uniform_body(mesh, 1.0, 0.0, held(mesh, "base")), loads)
    problem = contact_problem(reduced_model(condensed), Plane(0.0), friction)
    motion = Motion(SUNK, 2.0 * traction, load=1.0)  # G = 1 / 2
    (step,) = follow(problem, [motion])
    found = step.increment.force / problem.model.areas[:, None]
    values = {
        "pressure, off": float(np.abs(-found[:, 1] / SUNK - 1.0).max()),
        "shear, off": float(np.abs(found[:, 0] / traction - 1.0).max()),
        "stick": float(step.measures.stick_ratio or 0.0),
    }
    return Solution(values, (problem, (step,)))


def cylinder(poissons_ratio: float, friction: float) -> Solution:
    """A round block in space on rollers under a plane: p = E times the strain."""
    mesh = revolved_half(round_block_section(1.0, 1.0, 0.4, 0.2), 6)
    fixed = held(mesh, base=(1,))
    fixed[nearest(mesh, (0.0, -1.0, 0.0)), 0] = True
    return _pressed(uniform_body(mesh, 1.0, poissons_ratio, fixed), Plane(0.0), friction, SUNK)


def ring(poissons_ratio: float, friction: float, facets: int = 12) -> Solution:
    """A core too large for the ring around it, radii 1 and 2: Lame's pressure in plane strain."""
    flat = rectangle(
        0.5 * np.pi * np.linspace(0.0, 1.0, facets + 1), -np.linspace(2.0, 1.0, facets)
    )
    angle, radius = flat.points[:, 0], -flat.points[:, 1]
    points = radius[:, None] * np.column_stack([np.sin(angle), -np.cos(angle)])
    mesh = replace(flat, points=points)
    fixed = held(mesh, left=(0,), right=(1,))
    modulus = 1.0 / (1.0 - poissons_ratio**2)
    spread = 5.0 / 3.0 + poissons_ratio / (1.0 - poissons_ratio)  # (b^2 + a^2) / (b^2 - a^2) + nu'
    body = uniform_body(mesh, 1.0, poissons_ratio, fixed)
    return _pressed(body, Core(1.0 + SUNK), friction, SUNK * modulus / spread, Motion(0.0, 0.0))


def ring_rates() -> Solution:
    """Order of the worst nodal pressure in the facets' size."""
    counts = (6, 12, 24)
    errors = [ring(0.3, 0.0, count).values["pressure, off"] for count in counts]
    return orders(1.0 / np.array(counts), {"pressure": np.array(errors)})


def _pressed(
    body: Body, indenter: Indenter, friction: float, pressure: float, motion: Motion | None = None
) -> Solution:
    """The worst nodal pressure, off the one that is known, over it."""
    problem = contact_problem(body_model(body), indenter, friction)
    steps: tuple[Step, ...] = tuple(follow(problem, [motion or Motion(SUNK, 0.0)]))
    found = steps[-1].increment.multiplier[:, 0] / problem.model.areas
    off = float(np.abs(found / pressure - 1.0).max())
    return Solution({"pressure, off": off}, (problem, steps))
