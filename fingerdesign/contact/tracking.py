"""An increment near a solved one: Newton on few unknowns (numpy and LAPACK only).

A grip moves by small steps, and from step to step few nodes change their status. Known are forces
f*, their motion C f* and the statuses of an increment before; wanted is the answer at another
offset w. Of the base B, closed nodes and a ring of open ones about them, the inverse G = C_BB^-1 is
kept. With u what nodes of the base move beyond where f* and w put them,

    f = f* - G (C f* + w)_closed + G u,        v = (C f* + w)_open + u,

u is zero at sticking nodes, the slip at sliding ones, free at open ones. So Newton's unknowns are
the slips and the motions of the ring's open nodes alone, and no product with C is needed before the
answer: then one, of the symmetric half, for the certificate. Equations, with the trial forces
f - rho v and their direction e, t across it, q = mu f_n / |trial|:

    sliding: e.f_t - mu f_n = 0,  t.f_t = 0;  derivative of the latter (1 - q) t.G + rho q t;
    open:    f = 0.

Where this does not lead to an answer (many changes at once, a singular matrix) there is none, and
the caller solves anew; what it does give is certified like any other.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg.blas import dsymv
from scipy.linalg.lapack import dgetrf, dgetrs

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.laws import OPEN, SLIP, STICK, lengths
from fingerdesign.contact.newton import ActiveInverse

BoolArray = NDArray[np.bool_]

_TOLERANCE = 1e-10  # of the largest normal force, as in newton.py
_OPPOSED = 1e-8  # of it: friction off a slip's opposite; the residual hardly sees short slips
_MOST = 15  # iterations: of 514 steps of two grips three took as many; 95 in 100 take up to 9
_RING, _LEAST = 0.08, 12  # open nodes in the base: of those closed; at least
_WIDEST = 2.5  # times the ring: with more open nodes than these the base is made anew
_NEAR = 0.9  # of its friction limit: such a node may slide next
_FALL = 0.1  # of the residual: where a step brings less, the directions have turned: factorise
_WORN = 3e-9  # of a length: gaps left at closed nodes that show an inverse carried too far
_OUTSIDE = 3  # times the base grows within an increment
_SHARE, _LONGEST = 0.3, 1.5  # of the last step: when, and how far, its slips are taken on


@dataclass(frozen=True)
class Answer:
    """Forces (m, dim) N, C f and gap and slip increment (m, dim) mm, still to be certified."""

    multiplier: Array
    yielded: Array
    motion: Array
    residual: float
    iterations: int


@dataclass(frozen=True)
class Known:
    """A solved increment: forces, C f, gap and slip (m, dim), statuses (m,) and how it came about.

    change: of the motion's amplitudes; slip, after (m, dim - 1): the history that it started from
    and the one that it left; before (m, dim): C f where it started.
    """

    multiplier: Array
    yielded: Array
    motion: Array
    status: IntArray
    change: Array
    slip: Array
    after: Array
    before: Array


class Base:
    """The inverse on ``nodes`` (k,): those closed and a ring about them."""

    def __init__(self, inverse: ActiveInverse, count: int) -> None:
        self.active = inverse
        self.nodes = inverse.nodes
        self.inverse = inverse.inverse
        self.inside = np.zeros(count, dtype=bool)
        self.inside[self.nodes] = True


class Candidates:
    """Nodes of the base that slide or may, and those that are open or may be: u's dofs.

    dofs (n,) of the base; place (k, dim): their number, -1 where u is zero; rows = G[dofs] (n, k
    dim); square = G[dofs, dofs]; normal: G's rows of normal forces, ``row`` (k,) of which node.
    """

    def __init__(self, inverse: Array, sliding: BoolArray, free: BoolArray, dim: int) -> None:
        chosen = np.repeat((sliding | free)[:, None], dim, axis=1)
        chosen[~free, 0] = False
        self.sliding, self.free = sliding | free, free
        self.dofs = np.flatnonzero(chosen)
        place = np.full(chosen.size, -1)
        place[self.dofs] = np.arange(len(self.dofs))
        self.place = place.reshape(-1, dim)
        self.rows = inverse[self.dofs]
        self.square = self.rows[:, self.dofs]
        nodes = np.flatnonzero(self.sliding)
        self.row = np.cumsum(self.sliding) - 1
        self.normal = self.rows[:, nodes * dim].T.copy()

    def cover(self, status: IntArray) -> bool:
        """Whether all that slides or is open is among them."""
        beyond = ((status == OPEN) & ~self.free) | ((status == SLIP) & ~self.sliding)
        return not beyond.any()


@dataclass(frozen=True)
class Point:
    """Where an iteration stands: forces and motions (k, dim), tangential trial forces, lengths."""

    force: Array
    motion: Array
    tangential: Array
    size: Array
    status: IntArray


class Linear:
    """The linearised laws for one set of statuses, factorised for one set of directions.

    unknown: numbers of u's dofs that are solved for, the two tangential ones of each sliding node
    (all first ones first), then those of open nodes; the others are ``fixed``.
    """

    def __init__(self, candidates: Candidates, status: IntArray, rho: Array) -> None:
        self.status = status
        self.sliding, self.open = np.flatnonzero(status == SLIP), np.flatnonzero(status == OPEN)
        slips = candidates.place[self.sliding, 1:]
        free = candidates.place[self.open]
        self.unknown = np.concatenate([slips.T.reshape(-1), free.reshape(-1)])
        self.fixed = np.ones(len(candidates.dofs), dtype=bool)
        self.fixed[self.unknown] = False
        self._square = candidates.square[self.unknown][:, self.unknown]
        self._normal = candidates.normal[candidates.row[self.sliding]][:, self.unknown]
        self._rho = rho[self.sliding]
        self.factors: tuple[Array, IntArray] | None = None

    def aim(self, point: Point, friction: float) -> None:
        """Take over the directions of ``point``, not yet into the factors."""
        size = np.maximum(point.size[self.sliding], 1e-300)  # none: a singular row, a solve anew
        self.direction = point.tangential[self.sliding] / size[:, None]
        bound = friction * np.maximum(point.force[self.sliding, 0], 0.0)
        self.ratio = np.minimum(bound / size, 1.0)

    def rows(self, force: Array, friction: float, across: Array | float = 1.0) -> Array:
        """The laws' rows of forces (k, dim); ``across``: weight of the part across a direction."""
        sliding, direction = force[self.sliding], self.direction
        along = np.einsum("sa,sa->s", direction, sliding[:, 1:]) - friction * sliding[:, 0]
        parts = [along, force[self.open].reshape(-1)]
        if direction.shape[1] > 1:
            side = direction[:, 0] * sliding[:, 2] - direction[:, 1] * sliding[:, 1]
            parts.insert(1, across * side)
        return np.concatenate(parts)

    def factorise(self, friction: float) -> bool:
        """For the directions at hand. False where the matrix is singular."""
        s, direction, ratio = len(self.sliding), self.direction, self.ratio
        matrix = self._square.copy()
        along, one = matrix[:s], direction[:, :1]
        along *= one
        if direction.shape[1] > 1:
            first, second, two = self._square[:s], self._square[s : 2 * s], direction[:, 1:]
            along += two * second
            across, kept = matrix[s : 2 * s], 1.0 - ratio[:, None]
            np.multiply(second, kept * one, out=across)
            across -= (kept * two) * first
            here, turn = np.arange(s), self._rho * ratio
            across[here, here] -= turn * direction[:, 1]
            across[here, s + here] += turn * direction[:, 0]
        along -= friction * self._normal
        if not len(matrix):
            return True
        lu, pivots, info = dgetrf(matrix.T, overwrite_a=1)  # the transpose is in Fortran's order
        self.factors = (lu, pivots) if info == 0 else None
        return self.factors is not None

    def solve(self, wanted: Array) -> Array:
        """The change of u's unknown dofs."""
        if self.factors is None:
            return wanted
        return np.asarray(dgetrs(*self.factors, wanted, trans=1)[0])


class Tracker:
    """Follows increments on one compliance and friction; each starts from the one known."""

    def __init__(self, compliance: Array, self_compliance: Array, friction: float) -> None:
        self.compliance, self.friction = compliance, friction
        self._half = compliance.T  # in Fortran's order, which BLAS reads; it is symmetric
        self._rho = 0.05 / self_compliance
        self._length = float(np.median(self_compliance))
        self._base: Base | None = None
        self._candidates: Candidates | None = None
        self._linear: Linear | None = None
        self.known: Known | None = None

    def know(
        self, found: Answer, status: IntArray, change: Array, slip: Array, after: Array
    ) -> None:
        """Start the next increment from this accepted one; names as in :class:`Known`."""
        multiplier, motion, known = found.multiplier, found.motion, self.known
        before = found.yielded
        if known is not None and slip is known.after:
            before = known.yielded
        elif known is not None and slip is known.slip:
            before = known.before
        self.known = Known(multiplier, found.yielded, motion, status, change, slip, after, before)
        left = np.abs(motion[status != OPEN, 0]).max(initial=0.0)
        if left > _WORN * self._length * float(multiplier[:, 0].max()):
            self._base = None

    def solve(self, offset: Array, change: Array, slip: Array) -> Answer | None:
        """Forces and motion at ``offset`` (m, dim), or None where they are not found nearby.

        change: of the motion's amplitudes since the state before; slip: that state's history.
        """
        known = self.known
        if known is None or not (slip is known.slip or slip is known.after):
            return None
        status, spent = known.status, 0
        if not (status != OPEN).any():
            return None
        for _ in range(_OUTSIDE):
            try:
                self._bring_base(status, known.motion[:, 0])
            except np.linalg.LinAlgError:
                self.known, self._base = None, None
                return None
            found = self._newton(known, offset, change, slip)
            if found is None:
                return None
            spent += found.iterations
            deepest = _TOLERANCE * self._length * float(found.multiplier[:, 0].max())
            touched = (found.motion[:, 0] < -deepest) & ~self._held.inside
            if not touched.any():
                return replace(found, iterations=spent)
            status = np.where(touched, STICK, status)
        return None

    @property
    def inverse(self) -> ActiveInverse | None:
        """Of the compliance on the base's nodes, for others who need one."""
        return None if self._base is None else self._base.active

    @property
    def _held(self) -> Base:
        assert self._base is not None
        return self._base

    def _bring_base(self, status: IntArray, gap: Array) -> None:
        """See that the base holds all closed nodes, and not too many others."""
        closed = status != OPEN
        count = int(np.count_nonzero(closed))
        ring = max(_LEAST, int(_RING * count))
        base = self._base
        enough = base is not None and not (closed & ~base.inside).any()
        if base is not None and enough and len(base.nodes) - count <= _WIDEST * ring:
            return
        dim = len(self.compliance) // len(status)
        nodes = np.sort(np.argsort(np.where(closed, -np.inf, gap))[: count + ring])
        if base is None:
            inverse = ActiveInverse.of(self.compliance, nodes, dim)
        else:
            inverse = base.active.moved_to(self.compliance, nodes, dim)
        self._base, self._candidates, self._linear = Base(inverse, len(status)), None, None

    def _newton(self, known: Known, offset: Array, change: Array, slip: Array) -> Answer | None:
        """Newton from the statuses known; None where it does not settle."""
        base, friction = self._held, self.friction
        nodes = base.nodes
        status, before = known.status[nodes], known.multiplier[nodes]
        here = known.yielded[nodes] + offset[nodes]
        rest = np.where((status == OPEN)[:, None], here, 0.0)
        start = before.reshape(-1) - base.inverse @ (here - rest).reshape(-1)
        guess = _guess(known, nodes, status, change, slip)
        candidates = self._chosen(before, status)
        u = np.zeros(len(candidates.dofs)) if guess is None else guess.take(candidates.dofs)
        rho, scale, last = self._rho[nodes], float(before[:, 0].max()), np.inf
        for iteration in range(_MOST):
            blind = guess is None and iteration == 0
            point = self._at(start, rest, u, rho)
            if blind:  # nothing is known of the slips: statuses and directions stay
                trial = before[:, 1:] - rho[:, None] * known.motion[nodes, 1:]
                point = replace(point, tangential=trial, size=lengths(trial), status=status)
            if not candidates.cover(point.status):
                whole = np.zeros(rest.size)
                whole[candidates.dofs] = u
                candidates = self._chosen(point.force, point.status)
                u = whole[candidates.dofs]
            linear = self._linearised(candidates, point, rho)
            wanted = linear.rows(point.force, friction)
            residual = float(np.abs(wanted).max(initial=0.0)) / scale
            astray = np.flatnonzero(linear.fixed & (u != -rest.take(candidates.dofs)))
            settled = residual <= _TOLERANCE and not len(astray) and not blind
            if settled and self._opposed(linear, point, scale):
                return self._whole(point, offset, residual, iteration)
            if not np.isfinite(residual):
                return None
            if len(astray):  # nodes that stick, or close, now: what they moved is taken back
                gone = u[astray] + rest.take(candidates.dofs[astray])
                force = (gone @ candidates.rows[astray]).reshape(rest.shape)
                wanted -= linear.rows(force, friction, 1.0 - linear.ratio)
                u[astray] -= gone
            stale = linear.factors is None or residual > _FALL * last
            if stale and not linear.factorise(friction):
                return None
            u[linear.unknown] -= linear.solve(wanted)
            last = residual
        return None

    def _linearised(self, candidates: Candidates, point: Point, rho: Array) -> Linear:
        """The laws' system at ``point``: the one at hand while no status changes."""
        linear = self._linear
        if linear is None or not np.array_equal(linear.status, point.status):
            linear = self._linear = Linear(candidates, point.status, rho)
        linear.aim(point, self.friction)
        return linear

    def _at(self, start: Array, rest: Array, u: Array, rho: Array) -> Point:
        """Forces and statuses at ``u``."""
        candidates = self._candidates
        assert candidates is not None
        force = (start + u @ candidates.rows).reshape(rest.shape)
        motion = rest.reshape(-1).copy()
        motion[candidates.dofs] += u
        moved = motion.reshape(rest.shape)
        trial = force - rho[:, None] * moved
        size = lengths(trial[:, 1:])
        status = np.where(size > self.friction * trial[:, 0], SLIP, STICK)
        status[trial[:, 0] <= 0.0] = OPEN
        return Point(force, moved, trial[:, 1:], size, status)

    def _opposed(self, linear: Linear, point: Point, scale: float) -> bool:
        """Whether friction is against each slip, or the slip as good as none."""
        slip = point.motion[linear.sliding, 1:]
        if slip.shape[1] == 1:
            return True
        length, force = lengths(slip), point.force[linear.sliding]
        bound = self.friction * force[:, :1]
        astray = lengths(force[:, 1:] + bound * slip / np.maximum(length, 1e-300)[:, None])
        short = length / self._length
        return bool(np.minimum(astray, short).max(initial=0.0) <= _OPPOSED * scale)

    def _chosen(self, force: Array, status: IntArray) -> Candidates:
        """Candidates that cover ``status``: those at hand, or more of them."""
        held = self._candidates
        if held is not None and held.cover(status):
            return held
        free = status == OPEN
        near = lengths(force[:, 1:]) > _NEAR * self.friction * force[:, 0]
        near = (near & ~free) | (status == SLIP)
        if held is not None:
            near, free = near | held.sliding, free | held.free
        chosen = Candidates(self._held.inverse, near, free, force.shape[1])
        self._candidates, self._linear = chosen, None
        return chosen

    def _whole(self, point: Point, offset: Array, residual: float, iteration: int) -> Answer:
        """The answer on all nodes, its motion by the one product."""
        multiplier = np.zeros_like(offset)
        multiplier[self._held.nodes] = np.where((point.status == OPEN)[:, None], 0.0, point.force)
        yielded = dsymv(1.0, self._half, multiplier.reshape(-1)).reshape(offset.shape)
        return Answer(multiplier, yielded, yielded + offset, residual, iteration)


def _guess(
    known: Known, nodes: IntArray, status: IntArray, change: Array, slip: Array
) -> Array | None:
    """Motions (k, dim) to begin with: the slips known, or a step onward like the last one."""
    share = 1.0
    if slip is not known.slip:
        length = float(known.change @ known.change)
        share = min(float(known.change @ change) / length, _LONGEST) if length > 0.0 else 0.0
        if share < _SHARE:
            return None
    guess = np.zeros((len(nodes), known.motion.shape[1]))
    sliding = status == SLIP
    guess[sliding, 1:] = share * known.motion[nodes[sliding], 1:]
    if slip is not known.slip:
        free = status == OPEN
        guess[free] = share * (known.yielded - known.before)[nodes[free]]
    return guess
