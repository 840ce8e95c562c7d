"""Projected Gauss-Seidel over the contact nodes: slow, and very hard to throw off (numpy only).

Each node in turn takes the normal force that closes its gap, then the tangential force nearest to
sticking within its friction disc, all others held (Jean, CMAME 177 (1999) 235; Siconos calls it
NSGS). The production solver falls back on it for a starting point when Newton cycles.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from fingerdesign.contact.newton import NewtonResult, relative_residual

Array = NDArray[np.float64]


def gauss_seidel(
    compliance: Array,
    offset: Array,
    friction_coefficient: float,
    start: Array,
    sweeps: int = 500,
    tolerance: float = 1e-8,
) -> NewtonResult:
    """Sweep until the natural residual is below ``tolerance`` or ``sweeps`` are used up."""
    m, dim = offset.shape
    diagonal = np.diag(compliance).reshape(m, dim)
    tangential_diagonal = diagonal[:, 1:].max(axis=1)
    multiplier = start.reshape(-1).copy()
    blocks = [compliance[i * dim : (i + 1) * dim] for i in range(m)]
    residual = np.inf
    for sweep in range(1, sweeps + 1):
        for i in range(m):
            here = slice(i * dim, (i + 1) * dim)
            old = multiplier[here]
            motion = blocks[i] @ multiplier + offset[i]
            normal = max(0.0, old[0] - motion[0] / diagonal[i, 0])
            if normal == 0.0:
                multiplier[here] = 0.0
                continue
            change = (normal - old[0]) * blocks[i][1:, i * dim]
            trial = old[1:] - (motion[1:] + change) / tangential_diagonal[i]
            size = float(np.sqrt(trial @ trial))
            bound = friction_coefficient * normal
            multiplier[i * dim] = normal
            multiplier[i * dim + 1 : (i + 1) * dim] = (
                trial if size <= bound else trial * (bound / size)
            )
        if sweep % 10 == 0 or sweep == sweeps:
            shaped = multiplier.reshape(m, dim)
            motion_all = (compliance @ multiplier).reshape(m, dim) + offset
            residual = relative_residual(shaped, motion_all, diagonal[:, 0], friction_coefficient)
            if residual <= tolerance:
                return NewtonResult(shaped.copy(), residual, sweep, True)
    return NewtonResult(multiplier.reshape(m, dim).copy(), residual, sweeps, False)
