"""How the forces of an accepted increment answer to a change of the motion (numpy only).

The laws linearised at the solution, as in newton.py: open nodes stay without force, sticking ones
follow the object, sliding ones keep to their friction limit. One-sided where a node is just about
to change its status.
"""

from __future__ import annotations

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import Increment, Workspace
from fingerdesign.contact.laws import OPEN, SLIP
from fingerdesign.contact.newton import ActiveInverse, classify, slip_system, tangential_dofs
from fingerdesign.contact.problem import ContactProblem


def force_response(
    problem: ContactProblem,
    increment: Increment,
    modes: Array,
    workspace: Workspace | None = None,
    held: bool = False,
) -> Array:
    """Change of the multipliers (k, m, dim) N per unit of each mode (k, m, dim) of gap and slip.

    ``held``: sliding nodes are taken to stick, as they do when the motion turns back.
    """
    m, dim = problem.shape
    friction = problem.friction_coefficient
    motion = np.column_stack([increment.gap, increment.slip_increment])
    rho = (0.05 / problem.self_compliance)[:, None]
    status, trial = classify(increment.multiplier, motion, rho, friction)
    closed = np.flatnonzero(status != OPEN)
    changes = np.zeros((len(modes), m, dim))
    if not len(closed):
        return changes
    inverse = workspace.inverse if workspace is not None else None
    if inverse is None or not len(inverse.nodes):
        inverse = ActiveInverse.of(problem.compliance, closed, dim)
    inverse = inverse.moved_to(problem.compliance, closed, dim)
    nodes = inverse.nodes
    forces = -inverse.inverse @ modes[:, nodes].reshape(len(modes), -1).T  # were nothing to slide
    sliding = np.flatnonzero(status[nodes] == SLIP)
    if len(sliding) and not held:
        system = slip_system(friction, trial, rho, increment.multiplier, inverse, sliding)
        shaped = forces.reshape(len(nodes), dim, -1)[sliding]
        wanted = -(
            np.einsum("sab,sbk->sak", system.keep, shaped[:, 1:])
            - system.pull[:, :, None] * shaped[:, :1]
        )
        slips = np.linalg.solve(system.matrix, wanted.reshape(-1, len(modes)))
        forces = forces + inverse.inverse[:, tangential_dofs(sliding, dim)] @ slips
    changes[:, nodes] = forces.T.reshape(len(modes), len(nodes), dim)
    return changes


def stiffness(
    problem: ContactProblem,
    increment: Increment,
    workspace: Workspace | None = None,
    held: bool = False,
) -> Array:
    """d(F_n, F_t) / d(approach, shear) (2, 2) of the whole finger, N/mm; ``held`` as above."""
    changes = force_response(problem, increment, problem.modes[:2], workspace, held)
    columns = [problem.model.total_force(problem.to_global(change)) for change in changes]
    return np.array([[-column[1], column[0]] for column in columns]).T
