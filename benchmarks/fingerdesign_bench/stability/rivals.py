"""Methods that the stability map compares the production solver with, written plainly.

Each solves one increment in local components (normal first), v = C f + w, from the last forces, on
all candidate nodes, and raises SolverError where its own test does not pass within its iterations
or its seconds. None is crippled: parameters are those that did best over the map's cases.
"""

import time
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.friction import Coulomb
from fingerdesign.contact.solver.gauss_seidel import gauss_seidel
from fingerdesign.errors import SolverError

# compliance (m dim, m dim), offset (m, dim), friction coefficient, last forces (m, dim), seconds
Solve = Callable[[Array, Array, float, Array, float], Array]

_TOLERANCE = 1e-9  # of the largest force, in each method's own residual
_NEWTON_ITERATIONS = 40
_SWEEPS = 1000
_PENALTIES = (1.0, 10.0, 100.0)  # over 1 / C_ii, each from the last one's answer


@dataclass(frozen=True)
class Rival:
    """``claim``: the relative accuracy that the method is held to."""

    name: str
    solve: Solve
    claim: float


def plain_newton(
    compliance: Array, offset: Array, friction: float, start: Array, seconds: float
) -> Array:
    """Semi-smooth Newton on Alart and Curnier's residual, augmentation 1 / C_ii, no safeguard.

    All forces are unknowns; full steps; ends where its residual is small (Alart and Curnier, CMAME
    92 (1991) 353).
    """
    m, dim = offset.shape
    weight = 1.0 / np.diag(compliance).reshape(m, dim)[:, :1]
    moved = np.eye(m * dim) - np.repeat(weight, dim, axis=0) * compliance

    def residual_and_slope(force: Array) -> tuple[Array, Array]:
        motion = (compliance @ force.ravel()).reshape(m, dim) + offset
        target, at = _projected(force - weight * motion, friction)
        return force - target, np.eye(m * dim) - _times(at, moved)

    return _newton(residual_and_slope, start.copy(), offset, weight, seconds)


def penalty(
    compliance: Array, offset: Array, friction: float, start: Array, seconds: float
) -> Array:
    """Regularised contact: p = e max(0, -gap), t = t_last - e slip within the friction disc.

    e = 100 / C_ii, both ways: ten times that fails to converge more often, a tenth is less exact.
    Newton on all forces, from the last ones (Wriggers, Computational Contact Mechanics, 2006, 6.3).
    """
    m, dim = offset.shape
    unit = 1.0 / np.diag(compliance).reshape(m, dim)[:, :1]
    last = start.copy()
    last[:, 0] = 0.0

    def residual_and_slope(force: Array) -> tuple[Array, Array]:
        motion = (compliance @ force.ravel()).reshape(m, dim) + offset
        target, at = _projected(last - weight * motion, friction)
        stiff = np.repeat(weight, dim, axis=0) * compliance
        return force - target, np.eye(m * dim) + _times(at, stiff)

    force = start.copy()
    for factor in _PENALTIES:
        weight = factor * unit
        try:
            name = "Newton on penalties"
            force = _newton(residual_and_slope, force, offset, weight, seconds, name)
        except SolverError:
            if factor == _PENALTIES[-1]:
                raise
    return force


def _projected(trial: Array, friction: float) -> tuple[Array, Array]:
    """Trial forces (m, dim) projected onto pressure and the friction disc, and the slopes of that
    (m, dim, dim) with respect to the trial."""
    m, dim = trial.shape
    at, target = np.zeros((m, dim, dim)), np.zeros((m, dim))
    closed = trial[:, 0] > 0.0
    at[closed, 0, 0] = 1.0
    target[:, 0] = np.maximum(trial[:, 0], 0.0)
    bound = friction * target[:, 0]
    size = np.linalg.norm(trial[:, 1:], axis=1)
    stick = closed & (size <= bound)
    slip = closed & ~stick
    target[stick, 1:] = trial[stick, 1:]
    at[stick, 1:, 1:] = np.eye(dim - 1)
    along = trial[slip, 1:] / size[slip, None]
    target[slip, 1:] = bound[slip, None] * along
    turn = np.eye(dim - 1) - along[:, :, None] * along[:, None, :]
    at[slip, 1:, 1:] = (bound[slip] / size[slip])[:, None, None] * turn
    at[slip, 1:, 0] = friction * along
    return target, at


def _times(at: Array, matrix: Array) -> Array:
    """Node-wise slopes (m, dim, dim) times a matrix (m dim, m dim)."""
    m, dim, _ = at.shape
    pushed = np.einsum("mab,mbk->mak", at, matrix.reshape(m, dim, m * dim))
    return np.asarray(pushed.reshape(m * dim, m * dim))


def sweeps(
    compliance: Array, offset: Array, friction: float, start: Array, seconds: float
) -> Array:
    """Projected Gauss-Seidel from the last forces (contact.sweeps)."""
    found = gauss_seidel(compliance, offset, Coulomb(friction), start, _SWEEPS, _TOLERANCE, seconds)
    if not found.converged:
        raise SolverError(
            f"Gauss-Seidel: residual {found.residual:.0e} after {found.iterations} sweeps"
        )
    return found.multiplier


def _newton(
    residual_and_slope: Callable[[Array], tuple[Array, Array]],
    force: Array,
    offset: Array,
    weight: Array,
    seconds: float,
    name: str = "Newton",
) -> Array:
    until = time.process_time() + seconds
    size = np.inf
    for iteration in range(_NEWTON_ITERATIONS):
        residual, slope = residual_and_slope(force)
        scale = float(np.abs(force).max()) or float(np.abs(weight * offset).max())
        size = float(np.abs(residual).max()) / max(scale, 1e-300)
        if size <= _TOLERANCE:
            return force
        if time.process_time() > until:
            raise SolverError(f"{name}: out of time after {iteration} iterations")
        try:
            force = force - np.linalg.solve(slope, residual.ravel()).reshape(force.shape)
        except np.linalg.LinAlgError as error:
            raise SolverError(f"{name}: singular system at iteration {iteration}") from error
        if not np.isfinite(force).all():
            raise SolverError(f"{name}: not finite at iteration {iteration}")
    raise SolverError(f"{name}: residual {size:.0e} after {_NEWTON_ITERATIONS} iterations")
