"""Derivative of a path of increments by its own laws, statuses as they are (numpy only).

With y = C f + gap and slip of the motion, an accepted increment k satisfies, node by node,

    open    lambda = 0
    closed  y_n = 0
    stick   y_t(k) - y_t(k - 1) = 0
    slip    lambda_t + mu lambda_n e = 0,      e = d / |d|,  d = y_t(k) - y_t(k - 1)

which are differentiated as they stand, de = (I - e e^T) dd / |d|. The past enters through
dy_t(k - 1) alone. All parameters are solved for together, with one factorisation an increment.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.contact.increment import Increment
from fingerdesign.contact.laws import OPEN, SLIP, STICK, lengths
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.errors import SolverError

# Relative to the largest force, and to its displacement of a node: nearer than this to another
# status, a node is on a kink. The solver leaves 1e-10.
_KINK = 1e-7


@dataclass(frozen=True)
class PathRates:
    """Rates of K increments at ``nodes`` (n,), for P parameters.

    multiplier (K, n, dim, P) N; local (K, n, dim, P): of gap and slip from first contact on, mm;
    on_kink (K,): the share of the normal force that stands on nodes between two statuses.
    """

    nodes: IntArray
    multiplier: Array
    local: Array
    on_kink: Array


def near_nodes(problem: ContactProblem, increments: Sequence[Increment]) -> IntArray:
    """Nodes that touch at some time, their neighbours in the facets, and the neighbours of these:
    between the first two lies the border of contact, whose place depends on the third."""
    ever, facets = _touching(increments), problem.model.facets
    for _ in range(2):
        ever[facets[ever[facets].any(axis=1)]] = True
    return np.flatnonzero(ever)


def needed_dofs(
    problem: ContactProblem, increments: Sequence[Increment], nodes: IntArray
) -> BoolArray:
    """Dofs (n, dim) of ``nodes`` whose fields the path's rates need: all that are free of nodes
    that touch at some time; of the others what their normals have."""
    touching = _touching(increments)[nodes, None]
    needed = touching | (problem.frames[nodes, 0] != 0.0)
    return np.asarray(needed & ~problem.model.locked[nodes].reshape(needed.shape))


def _touching(increments: Sequence[Increment]) -> BoolArray:
    ever = np.array([increment.multiplier[:, 0] > 0.0 for increment in increments])
    return np.asarray(ever.any(axis=0))


def path_rates(
    problem: ContactProblem,
    increments: Sequence[Increment],
    nodes: IntArray,
    explicit: Array,
    friction: Array,
) -> PathRates:
    """Rates of forces and motions, given those that the parameters cause under fixed forces.

    explicit (K, n, dim, P): of the local displacements y, mm; friction (P,): of the coefficient.
    Raises SolverError where an increment's tangent is singular.
    """
    dim = problem.shape[1]
    dofs = (nodes[:, None] * dim + np.arange(dim)).ravel()
    compliance = problem.compliance[np.ix_(dofs, dofs)]
    multiplier, local = np.zeros_like(explicit), np.empty_like(explicit)
    on_kink = np.zeros(len(increments))
    before = np.zeros_like(explicit[0])
    for k, increment in enumerate(increments):
        point = _Point(problem, increment, nodes)
        multiplier[k] = point.forces(compliance, explicit[k], before, friction)
        local[k] = explicit[k]
        local[k] += (compliance @ multiplier[k].reshape(len(dofs), -1)).reshape(local[k].shape)
        on_kink[k] = point.on_kink
        before = local[k]
    return PathRates(nodes, multiplier, local, on_kink)


class _Point:
    """The laws of one increment, linearised at its answer."""

    def __init__(self, problem: ContactProblem, increment: Increment, nodes: IntArray) -> None:
        self.friction = problem.friction_coefficient
        self.multiplier = increment.multiplier[nodes]
        slip = increment.slip_increment[nodes]
        size, own = lengths(slip), problem.self_compliance[nodes]
        normal, self.status = self.multiplier[:, 0], increment.status[nodes].copy()
        self.status[normal <= 0.0] = OPEN
        reach = _KINK * own * max(float(normal.max(initial=0.0)), 1e-300)
        self.on_kink = self._kinks(increment.gap[nodes], size, reach, own)
        # A node that stays on its limit without a slip would slip against its friction force.
        pull = lengths(self.multiplier[:, 1:])
        moving = size > 1e-3 * reach
        with np.errstate(divide="ignore", invalid="ignore"):
            against = -self.multiplier[:, 1:] / pull[:, None]
            self.way = np.where(moving[:, None], slip / size[:, None], against)
        self.status[(self.status == SLIP) & ~moving & ~(pull > 0.0)] = STICK
        self.size = np.maximum(size, 1e-3 * reach)

    def _kinks(self, gap: Array, slip: Array, reach: Array, own: Array) -> float:
        """Share of the normal force on nodes between two statuses."""
        normal = self.multiplier[:, 0]
        force = reach / own
        bound = self.friction * normal
        pull = lengths(self.multiplier[:, 1:])
        border = (self.status == OPEN) & (np.abs(gap) < reach) | (self.status != OPEN) & (
            normal < force
        )
        limit = (self.status != OPEN) & (bound - pull < force) & (slip < reach) & (bound > 0.0)
        total = float(normal.sum())
        if total <= 0.0:
            return float(border.any())
        # A node without force counts as one of the mean force: its neighbours share in its kink.
        share = np.where(border, total / max(int((normal > 0.0).sum()), 1), normal)
        return min(1.0, float(share[border | limit].sum()) / total)

    def forces(self, compliance: Array, explicit: Array, before: Array, friction: Array) -> Array:
        """Rates (n, dim, P) of the multipliers; compliance (n dim, n dim), before: y's rates at
        the increment before."""
        found = np.zeros_like(explicit)
        closed = np.flatnonzero(self.status != OPEN)
        if not len(closed):
            return found
        dim = explicit.shape[1]
        rows = (closed[:, None] * dim + np.arange(dim)).ravel()
        matrix = compliance[np.ix_(rows, rows)].reshape(len(closed), dim, len(rows))
        load = -explicit[closed]
        load[:, 1:] += before[closed, 1:]
        sliding = np.flatnonzero(self.status[closed] == SLIP)
        way, size = self.way[closed[sliding]], self.size[closed[sliding]]
        normal = self.multiplier[closed[sliding], 0]
        # |d| (lambda_t + mu lambda_n e)' = |d| (lambda_t' + mu e lambda_n') + mu lambda_n P dd
        across = np.eye(dim - 1) - way[:, :, None] * way[:, None, :]
        turning = (self.friction * normal)[:, None, None] * across
        length = size if dim == 3 else np.ones(len(sliding))
        matrix[sliding, 1:] = turning @ matrix[sliding, 1:]
        load[sliding, 1:] = turning @ load[sliding, 1:]
        for i in range(dim - 1):
            matrix[sliding, 1 + i, sliding * dim + 1 + i] += length
            matrix[sliding, 1 + i, sliding * dim] += length * self.friction * way[:, i]
        push = (length * normal)[:, None] * way
        load[sliding, 1:] -= push[:, :, None] * friction
        square = matrix.reshape(len(rows), len(rows))
        scale = 1.0 / np.abs(square).max(axis=1)
        try:
            solved = np.linalg.solve(
                scale[:, None] * square, scale[:, None] * load.reshape(len(rows), -1)
            )
        except np.linalg.LinAlgError as error:
            raise SolverError("an increment's tangent is singular: no derivative") from error
        found[closed] = solved.reshape(len(closed), dim, -1)
        return found
