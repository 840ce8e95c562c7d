"""Semi-smooth Newton for one increment, on the nodes in contact (numpy only).

Unknown: nodal forces lambda (m, dim), local. With gap and slip increment v = C lambda + w, the
natural map with an augmentation rho_i = factor / C_ii,

    F_n = lambda_n - max(0, lambda_n - rho gap)
    F_t = lambda_t - disc(b(lambda_n))(lambda_t - rho slip)

is linearised at each node by its status. Open nodes drop out, closed ones have no gap, sticking
ones no slip: the unknowns left are the slips of sliding nodes. In 2-D a small factor
makes a node that slides the wrong way stick first, where a large one throws it to the opposite slip
and cycles (Alart and Curnier, CMAME 92 (1991) 353, leave rho free).
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.friction import Friction
from fingerdesign.contact.laws import OPEN, SLIP, STICK, lengths, natural_residual
from fingerdesign.contact.solver.active_inverse import ActiveInverse, block, dofs_of

_TOLERANCE = 1e-10  # The relative residual at which the iteration ends.
# A step should remove gap and slip; if more than this part is left, the inverse has lost accuracy.
_DRIFT = 1e-3


@dataclass(frozen=True)
class NewtonResult:
    """Forces, residual relative to the force scale, iterations, and whether it converged."""

    multiplier: Array
    residual: float
    iterations: int
    converged: bool
    inverse: ActiveInverse | None = None


def newton(
    compliance: Array,
    offset: Array,
    friction: Friction,
    start: Array,
    factor: float = 0.05,
    inverse: ActiveInverse | None = None,
    max_iterations: int = 40,
) -> NewtonResult:
    """Solve the increment from ``start`` (m, dim); ``offset`` (m, dim) is v at lambda = 0.

    ``inverse`` of an earlier solve on the same compliance saves work; the answer is the same to
    rounding. Never raises on failure to converge: the caller decides. A singular system ends it.
    """
    m, dim = offset.shape
    self_compliance = np.diag(compliance).reshape(m, dim)[:, 0]
    rho = (factor / self_compliance)[:, None]
    multiplier = start.copy()
    motion = (compliance @ multiplier.reshape(-1)).reshape(m, dim) + offset
    best, best_residual = multiplier, np.inf
    rounding = 1e-12 * float(np.abs(offset).max())
    for iteration in range(1, max_iterations + 1):
        status, trial = classify(multiplier, motion, rho, friction)
        closed = np.flatnonzero(status != OPEN)
        try:
            if inverse is None or not len(inverse.nodes):
                inverse = ActiveInverse.of(compliance, closed, dim)
            inverse = inverse.moved_to(compliance, closed, dim)
            here = _Iterate(friction, rho, multiplier, motion, status, trial)
            multiplier = _linear_step(compliance, here, inverse)
        except np.linalg.LinAlgError:
            return NewtonResult(best, best_residual, iteration, False)
        was, motion = motion, (compliance @ multiplier.reshape(-1)).reshape(m, dim) + offset
        residual = relative_residual(multiplier, motion, self_compliance, friction)
        if not np.isfinite(residual):
            return NewtonResult(best, best_residual, iteration, False)
        if residual < best_residual:
            best, best_residual = multiplier, residual
        if residual <= _TOLERANCE:
            return NewtonResult(multiplier, residual, iteration, True, inverse)
        if _left(motion, status) > max(_DRIFT * _left(was, status), rounding):
            inverse = None  # after many updates rounding has spoilt it
    return NewtonResult(best, best_residual, max_iterations, False)


def _left(motion: Array, status: IntArray) -> float:
    """Largest gap of closed nodes and slip of sticking ones: zero after an exact step."""
    gap = np.abs(motion[status != OPEN, 0]).max(initial=0.0)
    return float(max(gap, np.abs(motion[status == STICK, 1:]).max(initial=0.0)))


def relative_residual(
    multiplier: Array, motion: Array, self_compliance: Array, friction: Friction
) -> float:
    """Largest natural residual over the largest normal force (or over gap / C_ii if none)."""
    residual = natural_residual(multiplier, motion, self_compliance, friction)
    scale = float(np.abs(multiplier[:, 0]).max())
    if scale == 0.0:
        scale = float(np.abs(motion[:, 0] / self_compliance).max())
    return float(np.abs(residual).max()) / max(scale, 1e-300)


def classify(
    multiplier: Array, motion: Array, rho: Array, friction: Friction
) -> tuple[IntArray, Array]:
    """Status (m,) by the projections, and the trial forces lambda - rho v (m, dim)."""
    trial = multiplier - rho * motion
    status = np.full(len(multiplier), STICK, dtype=np.int64)
    bound = friction.bound(np.maximum(trial[:, 0], 0.0))
    status[lengths(trial[:, 1:]) > bound] = SLIP
    status[trial[:, 0] <= 0.0] = OPEN
    return status, trial


@dataclass(frozen=True)
class _Iterate:
    """Forces, gaps and slips (m, dim) of an iteration, statuses (m,), trial forces (m, dim)."""

    friction: Friction
    rho: Array
    multiplier: Array
    motion: Array
    status: IntArray
    trial: Array


def _linear_step(compliance: Array, here: _Iterate, active: ActiveInverse) -> Array:
    """Forces that solve the law linearised at the iterate, as a correction of it."""
    multiplier, dim = here.multiplier, here.multiplier.shape[1]
    closed = active.nodes
    result = np.zeros_like(multiplier)
    if len(closed) == 0:
        return result
    opened = np.flatnonzero((here.status == OPEN) & multiplier.any(axis=1))
    now = here.motion[closed].reshape(-1)
    if len(opened):
        gone = block(compliance, dofs_of(closed, dim), dofs_of(opened, dim))
        now = now - gone @ multiplier[opened].reshape(-1)
    forces = multiplier[closed].reshape(-1) - active.inverse @ now  # if nothing slid
    sliding = np.flatnonzero(here.status[closed] == SLIP)
    if len(sliding):
        moved = np.zeros(len(forces))
        moved[tangential_dofs(sliding, dim)] = _slips(here, active, sliding, forces)
        forces = forces + active.inverse @ moved  # cheaper than picking the columns
    result[closed] = forces.reshape(-1, dim)
    return result


def _slips(here: _Iterate, active: ActiveInverse, sliding: IntArray, forces: Array) -> Array:
    """Slips d (s (dim - 1),) of the nodes at positions ``sliding`` of ``active``.

    With e a node's trial direction, q = bound / |trial| and Q = q (I - e e^T), the linearised law

        (I - Q) f_t - b' e f_n + rho Q d,       f = forces + G_d d,

    equals that of the iterate less its residual F_t.
    """
    nodes = active.nodes[sliding]
    count, dim = len(nodes), here.multiplier.shape[1]
    size = lengths(here.trial[nodes, 1:])
    direction = here.trial[nodes, 1:] / size[:, None]
    friction, pressed = here.friction.at(nodes), np.maximum(here.multiplier[nodes, 0], 0.0)
    bound = friction.bound(pressed)
    ratio = np.minimum(bound / size, 1.0)[:, None, None]
    # In plane strain there is no direction to turn to: turn is zero.
    turn = ratio * (np.eye(dim - 1) - direction[:, :, None] * direction[:, None, :])
    stay = np.eye(dim - 1) - turn
    pull = friction.slope(pressed)[:, None] * direction

    columns = tangential_dofs(sliding, dim)
    tangential = block(active.inverse, columns, columns).reshape(count, dim - 1, -1)
    normal = block(active.inverse, sliding * dim, columns)
    matrix = stay @ tangential - pull[:, :, None] * normal[:, None, :]
    diagonal = matrix.reshape(count, dim - 1, count, dim - 1)
    own = np.arange(count)
    diagonal[own, :, own, :] += here.rho[nodes][:, :, None] * turn

    current = here.multiplier[nodes, 1:]
    target = bound[:, None] * direction - current  # - F_t
    target += np.einsum("sab,sb->sa", stay, current) - pull * here.multiplier[nodes, :1]
    target += here.rho[nodes] * np.einsum("sab,sb->sa", turn, here.motion[nodes, 1:])
    shaped = forces.reshape(-1, dim)[sliding]
    target -= np.einsum("sab,sb->sa", stay, shaped[:, 1:]) - pull * shaped[:, :1]
    return np.asarray(np.linalg.solve(matrix.reshape(count * (dim - 1), -1), target.reshape(-1)))


def tangential_dofs(nodes: IntArray, dim: int) -> IntArray:
    """Numbers (k (dim - 1),) of the tangential components of nodes (k,)."""
    return np.asarray((nodes[:, None] * dim + np.arange(1, dim)).reshape(-1))
