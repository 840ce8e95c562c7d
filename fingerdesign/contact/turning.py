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

import math
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import Workspace, solve_increment
from fingerdesign.contact.laws import lengths
from fingerdesign.contact.problem import FREE, ContactProblem, ContactState, Motion
from fingerdesign.errors import SolverError

MOST_TURN_DEG = 10.0  # An object that has turned by more counts as dropped.
# Of the moment of the weight: what the spring would carry of it at MOST_TURN_DEG, if it did not
# rest again after each increment. A thousandth made matrices too stiff for small residuals.
_SPRING = 0.03
# The turn radius is that of full stick: at this friction coefficient, and sheared by this part of
# the approach, no node slides but those at the edge that hardly press.
_ROUGH, _SMALL_SHEAR = 10.0, 0.05
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


def turn_radius(problem: ContactProblem, approach: float) -> float:
    """Turn radius r of a whole finger in 3-D, mm: an object a off the middle that is pressed to an
    ``approach`` (mm) leaves 1 / (1 + (a / r)^2) of the stiffness dF_t/dx, where all sticks.

    r^2 is the finger's stiffness against a turn about the normal over that against a shear.
    Raises what :func:`turning` and solve_increment raise.
    """
    rough = problem.with_friction(_ROUGH)
    arm, shear = 0.5 * float(np.abs(problem.model.points[:, 2]).max()), _SMALL_SHEAR * approach

    def pulled(posed: ContactProblem) -> float:
        start, workspace = ContactState.untouched(posed), Workspace()
        pressed = solve_increment(posed, start, Motion(approach, 0.0), workspace)
        sheared = solve_increment(posed, pressed.state, Motion(approach, shear), workspace)
        return float(posed.resultant(sheared.force)[1])

    centred = pulled(rough)
    left = pulled(turning(rough, arm, centred)) / centred
    return arm * math.sqrt(left / (1.0 - left))


def carried_turning(problem: ContactProblem, normal: Array) -> tuple[float, float]:
    """F_n and F_t (N) along the stage's axes as all of a contact of normal forces (m,) N slides and
    turns. Raises SolverError where the least force is not found."""
    touching = np.flatnonzero(normal > 0.0)
    forces = normal[touching]
    bounds = problem.friction.at(touching).bound(forces)
    pull, free = problem.modes[1, touching], problem.modes[FREE][:, touching]
    columns = np.moveaxis(free[..., 1:], 0, -1).reshape(-1, 2)  # of the slips, two rows a node
    along = pull[:, 1:].ravel()
    lifts = np.einsum("m,kma->ka", forces, free[..., :1])[:, 0]
    size, before = lengths(pull[:, 1:]), np.inf
    for _ in range(_ITERATIONS):
        weighted = (bounds / np.maximum(size, _STILL * size.max())).repeat(2)[:, None] * columns
        found = np.linalg.solve(weighted.T @ columns, lifts - along @ weighted)
        slip = (along + columns @ found).reshape(-1, 2)
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
    return float(problem.resultant(problem.to_global(limit))[0]), float(carried)
