"""Tangent of an accepted increment: the change of its forces with the motion (numpy only).

The laws are linearised at the solution, as in newton.py: open nodes stay without force, sticking
nodes follow the object, sliding nodes stay on their friction limit. The derivative is one-sided
where a node is just about to change its status.
"""

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.increment import Increment, Workspace
from fingerdesign.contact.laws import OPEN, STICK
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.contact.solver.active_inverse import ActiveInverse
from fingerdesign.contact.solver.linearised import Factors, System
from fingerdesign.contact.solver.newton import classify
from fingerdesign.contact.solver.tracking import WorkingSet


def force_response(
    problem: ContactProblem,
    increment: Increment,
    modes: Array,
    workspace: Workspace | None = None,
    turning_back: bool = False,
) -> Array:
    """Change of the multipliers (k, m, dim) N per unit of each mode (k, m, dim) of gap and slip.

    turning_back: sliding nodes are taken to stick, as they do when the motion reverses.
    """
    m, dim = problem.shape
    motion = np.column_stack([increment.gap, increment.slip_increment])
    rho = 0.05 / problem.self_compliance
    friction = problem.friction
    status, _ = classify(increment.multiplier, motion, rho[:, None], friction)
    closed = status != OPEN
    changes = np.zeros((len(modes), m, dim))
    if not closed.any():
        return changes
    base = None if workspace is None else workspace.tracker(problem).base
    if base is None or (closed & ~base.inside).any():
        index = np.flatnonzero(closed)
        inverse = None if workspace is None else workspace.inverse
        if inverse is None or not len(inverse.nodes):
            inverse = ActiveInverse.of(problem.compliance, index, dim)
        base = WorkingSet(inverse.moved_to(problem.compliance, index, dim), m)
    nodes = base.nodes
    forces = -(modes * closed[:, None])[:, nodes].reshape(len(modes), -1) @ base.inverse
    moving = np.flatnonzero(status[nodes] == OPEN if turning_back else status[nodes] != STICK)
    if len(moving):  # the others stick
        system = System(base.inverse, moving, rho[nodes], friction.at(nodes))
        mine = nodes[moving]
        here = increment.multiplier[mine].reshape(-1), motion[mine].reshape(-1)
        point = system.at(*here, status[mine])
        factors = Factors(system, point)
        if not factors.sound:
            raise np.linalg.LinAlgError("the increment's tangent is singular")
        motions = np.array([factors.moved(force[system.dofs]) for force in forces])
        forces += motions @ base.inverse[system.dofs]
    changes[:, nodes] = forces.reshape(len(modes), len(nodes), dim)
    return changes


def stiffness(
    problem: ContactProblem,
    increment: Increment,
    workspace: Workspace | None = None,
    turning_back: bool = False,
) -> Array:
    """d(F_n, F_t) / d(approach, shear) (2, 2) of the whole finger, N/mm; arguments as above."""
    changes = force_response(problem, increment, problem.modes[:2], workspace, turning_back)
    return np.array([problem.resultant(problem.to_global(change)) for change in changes]).T
