"""The outcome of an answer: its certificate and the state after it (numpy only)."""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.laws import (
    OPEN,
    SLIP,
    STICK,
    Certificate,
    certify,
    coded,
    lengths,
    status_of,
)
from fingerdesign.contact.problem import ContactProblem, ContactState

_ON_LIMIT = 1e-9  # of the largest normal force: ten times what the solvers leave; and of slips


@dataclass(frozen=True)
class Answer:
    """Forces (m, dim) N, C f and gap and slip increment (m, dim) mm, still to be certified."""

    multiplier: Array
    yielded: Array
    motion: Array
    residual: float
    iterations: int


@dataclass(frozen=True)
class Outcome:
    """The certificate of an answer; all else holds where that is accepted.

    force (m, dim) N in x, y(, z); status (m,), and touching: by the force alone; ahead (m, dim) as
    in tracking.LastIncrement; largest normal force; slip, travelled, sliding: of the new state.
    """

    certificate: Certificate
    force: Array
    status: IntArray
    touching: IntArray
    ahead: Array
    largest: float
    at_rim: bool
    slip: Array
    travelled: Array
    sliding: Array


def outcome(problem: ContactProblem, past: ContactState, found: Answer, before: Array) -> Outcome:
    """Certify an answer that starts from a state, where C f was ``before`` (m, dim)."""
    multiplier, local, model = found.multiplier, found.motion, problem.model
    force, free = problem.to_global(multiplier), model.balanced
    typical, friction = problem.typical_compliance, problem.friction
    carried, pushed = (model.reaction_readout @ force.reshape(-1))[free], force.sum(axis=0)[free]
    certificate = certify(multiplier, local, typical, friction, carried, pushed)
    status = status_of(multiplier, local, problem.self_compliance, problem.friction)
    moved, normal = lengths(local[:, 1:]), multiplier[:, 0]
    largest = float(normal.max(initial=0.0))
    near = problem.friction.bound(normal) - _ON_LIMIT * largest
    on_limit = (normal > 0.0) & (lengths(multiplier[:, 1:]) >= near)
    # Without motion such nodes stay on the limit without a slip of their own: they slid before.
    still = moved <= _ON_LIMIT * problem.self_compliance * normal
    sliding = np.where(on_limit, np.where(still, past.sliding, moved), 0.0)
    status[(sliding > 0.0) & (status == STICK)] = SLIP
    touching = coded(status == SLIP, normal > 0.0)
    ahead = (found.yielded - before) * (touching == OPEN)[:, None]
    slid = (touching == SLIP).nonzero()[0]
    ahead[slid, 1:] = local.take(slid, 0)[:, 1:]
    return Outcome(
        certificate,
        force,
        status,
        touching,
        ahead,
        largest,
        bool((multiplier[model.rim, 0] > 0.0).any()),
        local[:, 1:] + past.slip,
        # A sticking node has not moved, whatever the rounding; an open one starts from zero.
        (status != OPEN) * (past.travelled + moved * (status == SLIP)),
        sliding,
    )
