"""Semi-smooth Newton for one increment, on the nodes in contact (numpy only).

Unknown: nodal forces lambda (m, dim), local. With gap and slip increment v = C lambda + w, the
natural map with an augmentation rho_i = factor / C_ii,

    F_n = lambda_n - max(0, lambda_n - rho gap)
    F_t = lambda_t - disc(mu lambda_n)(lambda_t - rho slip)

is linearised at each node by its status. Open nodes drop out, so an iteration factors a matrix of
the size of the contact. In 2-D a small factor makes a node that slides the wrong way stick first,
where a large one throws it to the opposite slip and cycles (Alart and Curnier, CMAME 92 (1991) 353,
leave rho free).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from fingerdesign.contact.laws import OPEN, SLIP, STICK, natural_residual

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class NewtonResult:
    """Forces, residual relative to the force scale, iterations, and whether it converged."""

    multiplier: Array
    residual: float
    iterations: int
    converged: bool


def newton(
    compliance: Array,
    offset: Array,
    friction_coefficient: float,
    start: Array,
    factor: float = 0.05,
    tolerance: float = 1e-11,
    max_iterations: int = 40,
) -> NewtonResult:
    """Solve the increment from ``start`` (m, dim); ``offset`` (m, dim) is v at lambda = 0.

    Never raises on failure to converge: the caller decides. A singular linear system ends it.
    """
    m, dim = offset.shape
    self_compliance = np.diag(compliance).reshape(m, dim)[:, 0]
    rho = (factor / self_compliance)[:, None]
    multiplier = start.copy()
    motion = (compliance @ multiplier.reshape(-1)).reshape(m, dim) + offset
    best, best_residual = multiplier, np.inf
    for iteration in range(1, max_iterations + 1):
        status, trial = _classify(multiplier, motion, rho, friction_coefficient)
        try:
            multiplier = _linear_step(
                compliance, offset, friction_coefficient, status, trial, rho, multiplier, motion
            )
        except np.linalg.LinAlgError:
            return NewtonResult(best, best_residual, iteration, False)
        motion = (compliance @ multiplier.reshape(-1)).reshape(m, dim) + offset
        residual = relative_residual(multiplier, motion, self_compliance, friction_coefficient)
        if not np.isfinite(residual):
            return NewtonResult(best, best_residual, iteration, False)
        if residual < best_residual:
            best, best_residual = multiplier, residual
        if residual <= tolerance:
            return NewtonResult(multiplier, residual, iteration, True)
    return NewtonResult(best, best_residual, max_iterations, False)


def relative_residual(
    multiplier: Array, motion: Array, self_compliance: Array, friction_coefficient: float
) -> float:
    """Largest natural residual over the largest normal force (or over gap / C_ii if none)."""
    residual = natural_residual(multiplier, motion, self_compliance, friction_coefficient)
    scale = float(np.abs(multiplier[:, 0]).max())
    if scale == 0.0:
        scale = float(np.abs(motion[:, 0] / self_compliance).max())
    return float(np.abs(residual).max()) / max(scale, 1e-300)


def _classify(
    multiplier: Array, motion: Array, rho: Array, friction_coefficient: float
) -> tuple[IntArray, Array]:
    trial = multiplier - rho * motion
    status = np.full(len(multiplier), STICK, dtype=np.int64)
    bound = friction_coefficient * np.maximum(trial[:, 0], 0.0)
    status[np.linalg.norm(trial[:, 1:], axis=1) > bound] = SLIP
    status[trial[:, 0] <= 0.0] = OPEN
    return status, trial


def _linear_step(
    compliance: Array,
    offset: Array,
    friction_coefficient: float,
    status: IntArray,
    trial: Array,
    rho: Array,
    multiplier: Array,
    motion: Array,
) -> Array:
    dim = offset.shape[1]
    closed = np.flatnonzero(status != OPEN)
    result = np.zeros_like(multiplier)
    if len(closed) == 0:
        return result
    index = (closed[:, None] * dim + np.arange(dim)).reshape(-1)
    # Rows of gap = 0 (normal) and slip = 0 (stick); sliding nodes' tangential rows come after.
    matrix = compliance[np.ix_(index, index)]
    right = -offset[closed].copy()
    slipping = np.flatnonzero(status[closed] == SLIP)
    if len(slipping):
        nodes = closed[slipping]
        size = np.linalg.norm(trial[nodes, 1:], axis=1)
        direction = trial[nodes, 1:] / size[:, None]
        bound = friction_coefficient * np.maximum(multiplier[nodes, 0], 0.0)
        rows = slipping[:, None] * dim + np.arange(1, dim)
        if dim == 2:
            matrix[rows[:, 0]] = 0.0
            matrix[rows[:, 0], rows[:, 0]] = 1.0
            matrix[rows[:, 0], slipping * dim] = -friction_coefficient * direction[:, 0]
            right[slipping, 1] = 0.0
        else:
            # d lambda_t - mu e d lambda_n - q (I - e e^T) (d lambda_t - rho d slip) = -F_t
            ratio = np.minimum(bound / size, 1.0)
            turn = np.eye(2) - direction[:, :, None] * direction[:, None, :]
            turn *= ratio[:, None, None]
            step = rho[nodes, 0][:, None, None] * turn
            picked = matrix[rows]  # (s, 2, index): slip rows of C, before they are replaced
            matrix[rows] = np.einsum("sab,sbi->sai", step, picked)
            for a in range(2):
                for b in range(2):
                    matrix[rows[:, a], rows[:, b]] += float(a == b) - turn[:, a, b]
                matrix[rows[:, a], slipping * dim] -= friction_coefficient * direction[:, a]
            # J lambda_new = J lambda - F; nodes now open have lambda_new = 0, hence no columns.
            now = multiplier[nodes, 1:]
            force = now - bound[:, None] * direction
            linear = now - np.einsum("sab,sb->sa", turn, now)
            linear -= friction_coefficient * direction * multiplier[nodes, :1]
            linear += np.einsum("sab,sb->sa", step, motion[nodes, 1:] - offset[nodes, 1:])
            right[slipping, 1:] = linear - force
    solution = np.linalg.solve(matrix, right.reshape(-1))
    result[closed] = solution.reshape(-1, dim)
    return result
