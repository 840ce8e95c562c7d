"""The laws of a few nodes, linearised, and factors that are used again (LAPACK).

Rows of a node's laws, with trial forces f - rho v, their direction e, and t across it:

    sticking: v = 0;        open: f = 0;
    sliding:  v_n = 0,      e.f_t - b(f_n) = 0,      t.f_t = 0.

e turns with the trial force, so that the last row's derivative is (1 - q) t.df + rho q t.dv with
q = b(f_n) / |trial|, b the friction bound. Sticking needs no unknown, sliding two (one in the
plane), an open node all.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.lapack import dgetrf, dgetrs, sgetrf, sgetrs

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.friction import Friction
from fingerdesign.contact.laws import OPEN, SLIP, coded, lengths
from fingerdesign.contact.solver.active_inverse import Scratch, dofs_of

TOLERANCE = 1e-10  # Relative to the largest normal force, as in newton.py.
_FEW = 3.0  # Steps with old factors that cost as much as new factors of a small system.
_TURNED = np.array([-1.0, 1.0])  # Takes (e2, e1) to the direction across e.
# Within this part of the bound, q follows from the force itself, e.f_t, not from the bound.
_CLOSE = 0.1
# By dimension and status (OPEN, STICK, SLIP): True for components of the motion that the laws fix.
_FIXED = {
    dim: np.array([dim * [False], dim * [True], [True] + (dim - 1) * [False]]) for dim in (2, 3)
}


@dataclass
class Point:
    """The state of an iteration for c nodes: the laws' rows (c, dim) N, forces, motions, statuses.

    sliding (s,): which slide; direction (s, dim - 1) and size (s,) N of their trial forces.
    """

    rows: Array
    force: Array
    motion: Array
    status: IntArray
    sliding: IntArray
    direction: Array
    size: Array


class System:
    """The laws of c candidates, ``nodes`` (c,) of the base whose inverse compliance is given.

    Unknown are their motions x (c dim,), which make forces start + response @ x. rho (k,): of the
    base's nodes, as is friction.
    """

    def __init__(
        self,
        inverse: Array,
        nodes: IntArray,
        rho: Array,
        friction: Friction,
        scratch: Scratch = np.empty,
    ) -> None:
        self.nodes, self.friction, self.rho = nodes, friction.at(nodes), rho[nodes]
        self.dim = len(inverse) // len(rho)
        self.stiffness = float(rho.mean())  # N/mm: makes forces of motions
        self.dofs = dofs_of(nodes, self.dim)
        self.numbers = np.arange(len(self.dofs)).reshape(-1, self.dim)
        c = len(self.dofs)
        self.response = inverse
        if len(nodes) < len(rho):
            rows = inverse.take(self.dofs, 0, out=scratch((c, len(inverse))), mode="clip")
            self.response = rows.take(self.dofs, 1, out=scratch((c, c)), mode="clip")
        # Steps are corrected by the next one: single precision is as good, and twice as fast. In
        # the plane all is linear, and one step should do.
        self.coarse = self.response
        if self.dim == 3:
            self.coarse = scratch((c, c), dtype=np.float32)
            self.coarse[:] = self.response
        self.factors: Factors | None = None
        self._trial_per_motion = np.repeat(-self.rho, self.dim)

    def is_factored(self, point: Point, residual: float, last: float) -> bool:
        """True if the factors at hand suit the point's statuses, and further steps at the rate of
        the last one are cheaper than new factors."""
        factors = self.factors
        if factors is None or (factors.status != point.status).any():
            return False
        few = _FEW + (len(factors.free) / 200.0) ** 2
        return not residual * (residual / last) ** few > TOLERANCE

    def factorise(self, point: Point) -> None:
        """Factor the derivative at a point; no factors where it is singular."""
        factors = Factors(self, point)
        self.factors = factors if factors.sound else None

    def at(self, force: Array, motion: Array, status: IntArray | None = None) -> Point:
        """The point at these forces and motions (c dim,).

        status (c,): those to keep to, where they are not to follow from both.
        """
        dim, friction = self.dim, self.friction
        tried = self._trial_per_motion * motion
        tried += force
        tried = tried.reshape(-1, dim)
        tangential = tried[:, 1:]
        size = lengths(tangential)
        if status is None:
            pressed = tried[:, 0]
            status = coded(size > friction.bound(pressed), pressed > 0.0)
        # By the status: the force of open nodes, the motion of sticking ones, of sliding ones the
        # normal part of it.
        fixed = _FIXED[dim].take(status, 0).reshape(-1)
        rows = np.where(fixed, self.stiffness * motion, force).reshape(-1, dim)
        force, motion = force.reshape(-1, dim), motion.reshape(-1, dim)
        s = (status == SLIP).nonzero()[0]
        size = np.maximum(size.take(s), 1e-300)
        direction, slid = tangential.take(s, 0) / size[:, None], force.take(s, 0)
        bound = friction.at(s).bound(slid[:, 0])
        if dim == 2:
            rows[s, 1] = direction[:, 0] * slid[:, 1] - bound
        else:
            (one, two), (_, first, second) = direction.T, slid.T
            rows[s, 1] = one * first + two * second - bound
            rows[s, 2] = one * second - two * first
        return Point(rows, force, motion, status, s, direction, size)


class Factors:
    """LU factors of a system's derivative at one point, in terms of the unknowns ``free``.

    held (c dim,): motions that the laws fix. sound: False where the matrix is singular.
    """

    def __init__(self, system: System, point: Point) -> None:
        self.system, self.status = system, point.status
        dim, sliding, s = system.dim, point.sliding, len(point.sliding)
        dofs = system.numbers.take(sliding, 0)
        opened = system.numbers[point.status == OPEN].reshape(-1)
        self.free = np.concatenate([dofs[:, 1:].reshape(-1), opened])
        self._dofs, self._opened = dofs.reshape(-1), opened
        self.held = np.ones(len(system.dofs), dtype=bool)
        self.held[self.free] = False
        n, slips = len(self.free), s * (dim - 1)
        self._weights, turn = self._laws(point)
        coarse = system.coarse
        matrix = np.empty((n, n), dtype=coarse.dtype)
        part = coarse.take(self._dofs, 0).take(self.free, 1).reshape(s, dim, n)
        weights = self._weights.astype(coarse.dtype)
        np.matmul(weights, part, out=matrix[:slips].reshape(s, dim - 1, n))
        if len(opened):
            matrix[slips:] = coarse.take(opened, 0).take(self.free, 1)
        if dim == 3:
            across = np.arange(1, slips, 2)
            matrix[across, across - 1] += turn[:, 0]
            matrix[across, across] += turn[:, 1]
        self.sound = True
        if n:
            factorise = sgetrf if dim == 3 else dgetrf
            self._lu, self._pivots, info = factorise(matrix.T, overwrite_a=1)  # in Fortran's order
            self.sound = info == 0

    def _laws(self, point: Point) -> tuple[Array, Array]:
        """K (s, dim - 1, dim), D (s, dim - 1): rows change by K df, the last by D dv besides."""
        system, direction = self.system, point.direction
        weights = np.zeros((*direction.shape, system.dim))
        force, friction = point.force.take(point.sliding, 0).T, system.friction.at(point.sliding)
        normal = force[0]
        weights[:, 0, 0] = -friction.slope(normal)
        weights[:, 0, 1:] = direction
        if system.dim == 2:
            return weights, direction
        _, first, second = force
        one, two = direction.T
        bound = friction.bound(np.maximum(normal, 0.0))
        along = one * first + two * second
        # Near the answer 1 - q is small, and right only with the force itself.
        along = np.where(np.abs(along - bound) < _CLOSE * bound, along, bound)
        ratio = np.minimum(np.maximum(along / point.size, 0.0), 1.0)[:, None]
        across = direction[:, ::-1] * _TURNED
        weights[:, 1, 1:] = (1.0 - ratio) * across
        return weights, (system.rho.take(point.sliding)[:, None] * ratio) * across

    def moved(self, force: Array) -> Array:
        """Motions (c dim,) caused by a change of the forces (c dim,); fixed ones stay."""
        found = np.zeros(len(force))
        found[self.free] = self._freed(self._linear(force))
        return found

    def solve(self, rows: Array) -> Array:
        """The step (c dim,) that removes the residual ``rows`` (c dim,)."""
        found = np.where(self.held, rows / -self.system.stiffness, 0.0)
        rest = rows[self.free]
        if found.any():
            rest += self._linear(self.system.response @ found)
        found[self.free] = self._freed(rest)
        return found

    def _linear(self, force: Array) -> Array:
        """The free rows (n,) of a change of the forces (c dim,) alone."""
        sliding = self._weights @ force.take(self._dofs).reshape(-1, self.system.dim, 1)
        return np.concatenate([sliding.reshape(-1), force.take(self._opened)])

    def _freed(self, rows: Array) -> Array:
        """The free unknowns (n,) that remove these rows."""
        if not len(rows):
            return rows
        substitute = sgetrs if self.system.dim == 3 else dgetrs
        return np.asarray(-substitute(self._lu, self._pivots, rows, trans=1)[0])
