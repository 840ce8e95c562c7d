"""An object whose weight is off the middle of a contact: it turns about the normal (numpy only).

The weight W acts at its centre of mass, z = c from the middle. Supported under that centre or
hanging, the object is free to turn about it and to move along z, so at any shear h of the centre

    sum of modes_k . force = 0        (k: along z; about +y through x = 0, z = c)

and F_t has the moment F_t c about the middle. Soft springs stand for the two equations: they add a
term of rank two to the compliance, so that solvers and certificate stay as they are, and each
increment starts with the springs at rest, so that no moment is left in them but that of the last
increment's turn.

Under normal forces N_i the contact carries the least F_t of all motions in which it slides as a
whole (limit analysis; the turn and the way along z are free, v_i the slips at h = 1):

    F_t = min over (way, turn) of  sum_i b_i |v_i| - N_i g_i        b: bounds, g: rates of the gaps

This is a convex function, so the least one is found by weighted least squares.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.laws import lengths
from fingerdesign.contact.problem import FREE, ContactProblem
from fingerdesign.errors import SolverError

MOST_TURN_DEG = 10.0  # An object that has turned by more counts as dropped.
# Of the moment of the weight: what the spring would carry of it at MOST_TURN_DEG, if it did not
# rest again after each increment. A thousandth made matrices too stiff for small residuals.
_SPRING = 0.03
_ITERATIONS = 1000
_SETTLED = 1e-10  # Of the force: near a least one the place of the axis counts less.
_STILL = 1e-9  # of the largest slip: nearer to the axis of the turn a node counts as so far off


def turning(problem: ContactProblem, centre_mm: float, tangential: float) -> ContactProblem:
    """The same finger, whole and in 3-D, with an object that turns about z = ``centre_mm``.

    tangential: F_t (N, over 0) that this finger is to carry; it sets the springs alone. The shear
    of motions is then that of the centre. Raises ValueError in plane strain and for half a finger.
    """
    if problem.shape[1] == 2 or problem.model.symmetry_factor == 2:
        raise ValueError("an object turns on a whole finger in 3-D alone")
    modes = problem.modes.copy()
    modes[3] -= np.deg2rad(centre_mm) * modes[1]
    along_z = _SPRING * tangential  # N/mm
    about_y = _SPRING * tangential * max(abs(centre_mm), 1.0) / MOST_TURN_DEG  # N mm/degree
    softness = np.array([1.0 / along_z, 1.0 / (np.deg2rad(1.0) * about_y)])
    free = modes[FREE].reshape(2, -1)
    yields = problem.compliance + (softness * free.T) @ free
    return replace(problem, compliance=np.ascontiguousarray(yields), modes=modes, softness=softness)


def carried_turning(problem: ContactProblem, normal: Array) -> tuple[float, float]:
    """F_n and F_t (N) along the stage's axes as all of a contact of normal forces (m,) N slides and
    turns. Raises SolverError where the least force is not found."""
    touching = np.flatnonzero(normal > 0.0)
    forces = normal[touching]
    bounds = problem.friction.at(touching).bound(forces)
    pull, free = problem.modes[1, touching], problem.modes[FREE][:, touching]
    columns = np.moveaxis(free[..., 1:], 0, -1)  # (k, dim - 1, 2)
    lifts = np.einsum("m,kma->ka", forces, free[..., :1])[:, 0]
    size, before = lengths(pull[:, 1:]), np.inf
    for _ in range(_ITERATIONS):
        weight = bounds / np.maximum(size, _STILL * size.max())
        normal_matrix = np.einsum("k,kai,kaj->ij", weight, columns, columns)
        right = lifts - np.einsum("k,kai,ka->i", weight, columns, pull[:, 1:])
        found = np.linalg.solve(normal_matrix, right)
        slip = pull[:, 1:] + columns @ found
        size = lengths(slip)
        # By their power, for the force at the axis of the turn is not known.
        carried = bounds @ size - forces @ pull[:, 0] - lifts @ found
        if abs(before - carried) <= _SETTLED * abs(carried):
            break
        before = carried
    else:
        raise SolverError("the least force of a contact that turns was not found")
    limit = np.zeros(problem.shape)
    limit[touching, 0] = forces
    limit[touching, 1:] = -(bounds / np.maximum(size, 1e-300))[:, None] * slip
    force = problem.model.total_force(problem.to_global(limit))
    return -float(force[1]), float(carried)
