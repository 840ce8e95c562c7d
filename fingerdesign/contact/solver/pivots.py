"""Plane friction by complementary pivots: the last resort that always ends (numpy only).

In two dimensions Coulomb's law is linear on either side: with p the normal force, t the tangential
one, b = mu p + tau beta the bound and a - c the slip,

    p, gap >= 0, p gap = 0;   r = t + b, a >= 0, r a = 0;   s = b - t, c >= 0, s c = 0.

For tau large enough every node sticks, and that answer is the only one. The forces being bounded by
the motion alone (C is positive definite), the answers for all tau >= 0 form a path that can end at
tau = 0 only: Lemke's path, followed from sticking rather than from nothing. So there is an answer
for every friction coefficient, and this finds one, where Lemke's own start may run off along a ray
(Klarbring, Ingenieur-Archiv 60 (1990) 529, sets up the pairs; Cottle, Pang, Stone, The Linear
Complementarity Problem, 1992, 4.4-4.5, the pivots).
"""

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.contact.friction import Coulomb
from fingerdesign.contact.solver.newton import NewtonResult, relative_residual

_SEED = 1990
_SMALL = 1e-11  # relative: a smaller pivot is rounding
# Exchanges that wait to be made in one matrix product, which is 15 times as fast as one by one.
_WAITING = 48
_ACCEPTED = 1e-10  # natural residual; the caller's certificate is the judge


def friction_pivots(
    compliance: Array, offset: Array, friction: Coulomb, seed: int = 0, limit: int = 4000
) -> NewtonResult:
    """Forces (m, 2) of an increment in the plane; ``iterations`` are pivots.

    compliance (2 m, 2 m), offset (m, 2) as in newton.newton. ``seed`` draws beta: where there are
    several answers, another path may lead to another one. converged = False, with no forces, where
    ``limit`` pivots or the precision of doubles did not suffice.
    """
    m = len(offset)
    friction_of = np.broadcast_to(np.asarray(friction.coefficient, dtype=float), m)
    nothing = NewtonResult(np.zeros((m, 2)), np.inf, limit, False)
    unit = float(np.median(np.diag(compliance)))
    length = max(float(np.abs(offset).max()), 1e-300)
    table = _Table(compliance / unit, offset / length, friction_of, seed)
    try:
        ended = table.stick() and table.release(limit)
        if not ended:
            return nothing
        force = _on_status(compliance, offset, friction_of, *table.status())
    except (np.linalg.LinAlgError, FloatingPointError):
        return nothing
    motion = (compliance @ force.reshape(-1)).reshape(m, 2) + offset
    own = np.diag(compliance)[::2]
    residual = relative_residual(force, motion, own, friction)
    return NewtonResult(force, residual, table.pivots, residual <= _ACCEPTED)


class _Table:
    """Basic variables as affine functions of the others, in units of one.

    Variable k < 3 m is one of z = (p, r, c), k + 3 m its partner in w = (gap, a, s). Column 3 m
    belongs to tau (variable 6 m) until that becomes basic, the next is constant, the last theta's.
    An exchange adds a product of a column and a row; the table is ``body`` + ``left @ right``.
    """

    def __init__(self, compliance: Array, offset: Array, friction: Array, seed: int) -> None:
        m = self.m = len(offset)
        nn, nt = compliance[::2, ::2], compliance[::2, 1::2]
        tn, tt = compliance[1::2, ::2], compliance[1::2, 1::2]
        # Drawn at random, so that no two variables vanish at once and send the pivots round.
        beta = np.random.default_rng([_SEED, seed]).uniform(1.0, 2.0, m)
        eye, none, one, zero = np.eye(m), np.zeros((m, m)), np.ones((m, 1)), np.zeros((m, 1))
        self.body = np.block(
            [
                [nn - nt * friction, nt, none, -(nt @ beta)[:, None], offset[:, :1], one],
                [tn - tt * friction, tt, eye, -(tt @ beta)[:, None], offset[:, 1:], zero],
                [2.0 * np.diag(friction), -eye, none, 2.0 * beta[:, None], zero, zero],
            ]
        )
        self.left = np.empty((3 * m, _WAITING))
        self.right = np.empty((_WAITING, 3 * m + 3))
        self.waiting = 0
        self.basic = np.arange(3 * m, 6 * m)
        self.others = np.append(np.arange(3 * m), 6 * m)
        self.pivots = 0

    def stick(self) -> bool:
        """Go to the answer for large tau: no slip, and the normal forces that belong to it.

        Those solve a positive definite problem, whose answers for gap + theta, theta from infinity
        to 0, change at one node at a time.
        """
        m = self.m
        for node in range(m):
            self._exchange(m + node, m + node)  # r against a
        for _ in range(20 * m):
            held, slope = self._column(-2)[:m], self._column(-1)[:m]
            falls = slope > _SMALL
            if not falls.any():
                return bool((held >= -_SMALL).all())
            at = np.where(falls, -held / np.where(falls, slope, 1.0), -np.inf)
            node = int(np.argmax(at))
            if at[node] <= 0.0:
                return True
            self._exchange(node, node)
        return False

    def release(self, limit: int) -> bool:
        """Lower tau from where the first node slides to 0; True where it arrives."""
        m = self.m
        slope, held = self._column(3 * m), self._column(-2)
        falls = slope > _SMALL
        at = np.where(falls, -held / np.where(falls, slope, 1.0), -np.inf)
        row = int(np.argmax(at))
        if at[row] <= 0.0:
            return True
        leaving = int(self.basic[row])
        self._exchange(row, 3 * m)
        while self.pivots < limit:
            last = int(np.flatnonzero(self.basic == 6 * m)[0])
            held = self._column(-2)
            if held[last] <= _SMALL:
                return True
            entering = (leaving + 3 * m) % (6 * m)
            column = int(np.flatnonzero(self.others == entering)[0])
            rates = self._column(column)
            falls = rates < -_SMALL
            if not falls.any():
                return False
            reach = np.where(falls, np.maximum(held, 0.0) / np.where(falls, -rates, 1.0), np.inf)
            row = int(np.argmin(reach))
            if reach[last] <= reach[row] * (1.0 + 1e-9) + 1e-14:
                self._exchange(last, column)
                return True
            leaving = int(self.basic[row])
            self._exchange(row, column)
        return False

    def status(self) -> tuple[BoolArray, IntArray]:
        """Closed nodes (m,), and the sign (m,) of the slip of each: 0 where it sticks."""
        m = self.m
        inside = np.zeros(6 * m + 1, dtype=bool)
        inside[self.basic] = True
        forward, back = inside[4 * m : 5 * m], inside[2 * m : 3 * m]
        return inside[:m], forward.astype(np.int64) - (back & ~forward)

    def _column(self, column: int) -> Array:
        """A column (3 m,) of the table."""
        waiting = self.waiting
        product = self.left[:, :waiting] @ self.right[:waiting, column]
        return np.asarray(self.body[:, column] + product)

    def _exchange(self, row: int, column: int) -> None:
        """Exchange the basic variable of ``row`` for the other of ``column``.

        With e unit vectors and pivot T_rc: T <- T - (T_:c + e_r) (T_r: - e_c) / T_rc.
        """
        waiting, across = self.waiting, self._column(column)
        pivot = across[row]
        if not abs(pivot) > _SMALL:
            raise FloatingPointError("a pivot vanished")
        line = self.body[row] + self.left[row, :waiting] @ self.right[:waiting]
        across[row] += 1.0
        line[column] -= 1.0
        self.left[:, waiting], self.right[waiting] = across, line / -pivot
        self.waiting += 1
        if self.waiting == _WAITING:
            self.body += self.left @ self.right
            self.waiting = 0
        self.basic[row], self.others[column] = self.others[column], self.basic[row]
        self.pivots += 1


def _on_status(
    compliance: Array,
    offset: Array,
    friction: Array,
    closed: BoolArray,
    direction: IntArray,
) -> Array:
    """Forces (m, 2) of the linear system of a status, free of the rounding of the pivots."""
    m = len(offset)
    nodes = np.flatnonzero(closed)
    stuck = np.flatnonzero(closed & (direction == 0))
    # f = shape @ x: normal forces of closed nodes, then tangential ones of stuck nodes.
    shape = np.zeros((2 * m, len(nodes) + len(stuck)))
    shape[2 * nodes, np.arange(len(nodes))] = 1.0
    shape[2 * nodes + 1, np.arange(len(nodes))] = -friction[nodes] * direction[nodes]
    shape[2 * stuck + 1, len(nodes) + np.arange(len(stuck))] = 1.0
    rows = np.concatenate([2 * nodes, 2 * stuck + 1])
    found = np.linalg.solve(compliance[rows] @ shape, -offset.reshape(-1)[rows])
    return np.asarray((shape @ found).reshape(m, 2))
