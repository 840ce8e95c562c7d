"""Projected Gauss-Seidel over the contact nodes: slow and very robust (numpy only).

Each node in turn takes the normal force that closes its gap, then the tangential force nearest to
sticking within its friction disc; all other nodes are fixed (Jean, CMAME 177 (1999) 235; Siconos
calls it NSGS). A change of one node moves all others by a column of the compliance, so a visit
costs one product of a vector, and nothing where the node stays as it is.
"""

import time

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.friction import Friction
from fingerdesign.contact.solver.newton import NewtonResult, relative_residual

_LOOK = 10  # Sweeps between two checks of the residual and the clock.
# N. Forces grow to it only where the compliance is not positive definite, and soon overflow.
_ABSURD = 1e20


def gauss_seidel(
    compliance: Array,
    offset: Array,
    friction: Friction,
    start: Array,
    sweeps: int = 500,
    tolerance: float = 1e-8,
    time_limit: float = np.inf,
) -> NewtonResult:
    """Sweep until the natural residual is below ``tolerance``, or sweeps or processor time run out.

    compliance (m dim, m dim) symmetric, offset and start (m, dim), as in newton.newton. The best
    iterate looked at is returned, with converged = False where the tolerance was not met, as with a
    compliance that is not positive definite.
    ``time_limit``: seconds of processor time.
    """
    m, dim = offset.shape
    diagonal = np.diag(compliance).reshape(m, dim)
    normal_diagonal = diagonal[:, 0].tolist()
    # A step by the largest eigenvalue of the tangential block overshoots in no direction.
    tangential = (diagonal[:, 1] if dim == 2 else _largest(compliance, m, dim)).tolist()
    force = start.copy()
    rows = compliance.reshape(m, dim, m * dim)
    own = [friction.at(node) for node in range(m)]
    best, best_residual = force.copy(), np.inf
    if (diagonal < 0.0).any():
        return NewtonResult(best, best_residual, 0, False)
    until = time.process_time() + time_limit
    sweep = 0
    while sweep < sweeps:
        # Computed again at each look, so that rounding of the updates does not add up.
        motion = (compliance @ force.reshape(-1)).reshape(m, dim) + offset
        for _ in range(min(_LOOK, sweeps - sweep)):
            _one_sweep(force, motion, rows, normal_diagonal, tangential, own)
            sweep += 1
            if np.abs(force).max() > _ABSURD:
                return NewtonResult(best, best_residual, sweep, False)
        motion = (compliance @ force.reshape(-1)).reshape(m, dim) + offset
        residual = relative_residual(force, motion, diagonal[:, 0], friction)
        if residual < best_residual:
            best, best_residual = force.copy(), residual
        if residual <= tolerance:
            return NewtonResult(best, best_residual, sweep, True)
        if time.process_time() > until:
            break
    return NewtonResult(best, best_residual, sweep, False)


def _one_sweep(
    force: Array,
    motion: Array,
    rows: Array,
    normal_diagonal: list[float],
    tangential: list[float],
    friction: list[Friction],
) -> None:
    """Visit each node once; ``force`` and ``motion`` (m, dim) are changed in place."""
    flat = motion.reshape(-1)
    for i, stiff in enumerate(normal_diagonal):
        old, moved = force[i].tolist(), motion[i].tolist()
        normal = old[0] - moved[0] / stiff
        if normal <= 0.0:
            if any(old):
                flat -= force[i] @ rows[i]
                force[i] = 0.0
            continue
        change, bound = normal - old[0], float(friction[i].bound(np.asarray(normal)))
        dim = len(old)
        own = rows[i, 1:, i * dim].tolist()
        trial = [old[k] - (moved[k] + change * own[k - 1]) / tangential[i] for k in range(1, dim)]
        size = abs(trial[0]) if dim == 2 else (trial[0] ** 2 + trial[1] ** 2) ** 0.5
        if size > bound:
            trial = [value * (bound / size) for value in trial]
        new = np.array([normal, *trial])
        flat += (new - force[i]) @ rows[i]
        force[i] = new


def _largest(compliance: Array, m: int, dim: int) -> Array:
    """Largest eigenvalue (m,) of each node's own tangential block."""
    here = np.arange(m)
    blocks = compliance.reshape(m, dim, m, dim)[here, :, here, :][:, 1:, 1:]
    return np.asarray(np.linalg.eigvalsh(blocks)[:, -1])
