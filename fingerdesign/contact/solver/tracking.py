"""An increment near a solved one: Newton on few unknowns (numpy and LAPACK only).

A grip moves by small steps, and from step to step few nodes change their status. Given are forces
f*, their motion C f* and the statuses of the last increment; unknown is the answer at another
offset w. The inverse G = C_BB^-1 on the working set B (closed nodes and a few open ones about them)
is stored. With u the motion of its nodes beyond where f* and w put them,

    f = f* - G (C f* + w)_closed + G u,        v = (C f* + w)_open + u,

u is zero at sticking nodes, the slip at sliding ones, free at open ones. Only candidates are solved
for: nodes that slide or nearly do, and open ones (linearised.py). The first iteration keeps the
statuses known, so that the factors at hand serve, or where the motion turns lets all that is
closed stick; most of what changes shows after it. No product with C is needed before the answer:
then one, of the symmetric half, for the certificate.

Where this does not lead to an answer (many changes at once, a singular matrix) there is none, and
the caller solves from the start; an answer found here is certified like any other.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg.blas import dsymv

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.contact.friction import Friction
from fingerdesign.contact.laws import OPEN, SLIP, STICK, lengths
from fingerdesign.contact.outcome import Answer, Outcome, outcome
from fingerdesign.contact.problem import ContactProblem, ContactState
from fingerdesign.contact.solver.active_inverse import ActiveInverse, ScratchBuffers
from fingerdesign.contact.solver.linearised import TOLERANCE, Point, System

# rho C_ii. Ten times that of newton.py, which starts from farther away; from 2 on it cycles.
_FACTOR = 0.5
# Relative to the force: friction may deviate so much from a slip's opposite direction. Residuals
# hardly show it where the slip is short.
_OPPOSED = 1e-8
_MOST = 15  # Iterations on one set of candidates; 95 of 100 need at most 9.
_ROUNDS = 6  # Sets of candidates in an increment.
# Open nodes that the working set includes: a part of the needed ones, and at least so many.
_RING, _LEAST = 0.03, 8
_MORE = 1.5  # If more than so many times the closed nodes would touch, the answer is not near.
_WIDEST = 4  # With more than so many rings of open nodes the working set drops some.
_NEAR = 0.9  # A node above this part of its friction limit may slide next.
_SMALL = 300  # In a working set of fewer dofs every node is a candidate.
_STRAY = 5  # If more nodes than this stop sticking unexpectedly, every node is a candidate.
_LOOSE = 0.3  # Candidates are chosen again if a smaller part of them slides or is open.
_BULK = 0.6  # If more than this part of the set are candidates, every node is one.
# A step continues the last one if this part of its square lies along it; slips are extrapolated.
_ONWARD = 0.9
_LONGEST = 1.5  # The longest extrapolation, in lengths of the last step.


@dataclass(frozen=True)
class LastIncrement:
    """A solved increment: forces, C f (m, dim), statuses (m,) and how it came about.

    ahead (m, dim): motion of the nodes in it beyond sticking, of open ones beyond their place, mm.
    change: of the motion's amplitudes; slip, after (m, dim - 1): the history that it started from
    and the one that it left; before (m, dim): C f where it started. largest: normal force.
    """

    multiplier: Array
    yielded: Array
    status: IntArray
    ahead: Array
    change: Array
    slip: Array
    after: Array
    before: Array
    largest: float


@dataclass(frozen=True)
class Start:
    """First guess of an increment's motion: ``share`` times that of the last increment.

    turned: the motion reverses, so that most nodes that slid stick. trial: another trial of the
    same step, so that its slips alone are taken.
    """

    share: float
    turned: bool = False
    trial: bool = False

    def of(self, known: LastIncrement) -> Array:
        """First guess of the nodes' motion beyond rest (m, dim), mm."""
        if self.turned:
            return np.zeros_like(known.ahead)
        if self.trial:
            return np.where((known.status == SLIP)[:, None], known.ahead, 0.0)
        return self.share * known.ahead


class WorkingSet:
    """The inverse on ``nodes`` (k,): those closed and a ring about them."""

    def __init__(self, inverse: ActiveInverse, count: int) -> None:
        self.active = inverse
        self.nodes = inverse.nodes
        self.inverse = inverse.inverse
        self.half = self.inverse.T  # in Fortran's order, which BLAS reads; it is symmetric
        self.inside = np.zeros(count, dtype=bool)
        self.inside[self.nodes] = True


class Tracker:
    """Follows increments on one compliance; each starts from the one known.

    starts: an increment that cannot be followed starts from a guess (``start``); that pays where
    an iteration costs little more than its arithmetic.
    """

    starts = False

    def __init__(self, compliance: Array, self_compliance: Array, friction: Friction) -> None:
        self.compliance, self.friction = compliance, friction
        self._half = compliance.T
        self._rho = _FACTOR / self_compliance
        self._length = float(np.median(self_compliance))
        most = len(compliance)
        self._inverses, self._systems = ScratchBuffers(most, 2), ScratchBuffers(most, 3)
        self.base: WorkingSet | None = None
        self._system: System | None = None
        self.known: LastIncrement | None = None

    def meet(self, friction: Friction) -> None:
        """Follow the next increments at another friction; what is known holds as before."""
        self.friction, self._system = friction, None

    def outcome(self, problem: ContactProblem, past: ContactState, found: Answer) -> Outcome:
        """Certify an answer from a state."""
        return outcome(problem, past, found, self._before(past.slip, found))

    def _before(self, slip: Array, found: Answer) -> Array:
        """C f (m, dim) where an increment from the history ``slip`` started."""
        known = self.known
        if known is not None and slip is known.after:
            return known.yielded
        return known.before if known is not None and slip is known.slip else found.yielded

    def know(self, found: Answer, outcome: Outcome, change: Array, slip: Array) -> None:
        """Start the next increment from this accepted one; names as in :class:`LastIncrement`."""
        self.known = LastIncrement(
            found.multiplier,
            found.yielded,
            outcome.touching,
            outcome.ahead,
            change,
            slip,
            outcome.slip,
            self._before(slip, found),
            outcome.largest,
        )

    def solve(self, offset: Array, change: Array, slip: Array) -> Answer | None:
        """Forces and motion at ``offset`` (m, dim), or None where they are not found nearby.

        change: of the motion's amplitudes since the state before; slip: that state's history.
        """
        known = self.known
        if known is None or not known.largest > 0.0:
            return None
        if slip is known.after:
            length = float(known.change @ known.change)
            share = float(known.change @ change) / length if length > 0.0 else 0.0
            onward = share > 0.0 and share * share * length >= _ONWARD * float(change @ change)
            start = Start(min(share, _LONGEST), turned=not onward)
        elif slip is known.slip:
            start = Start(1.0, trial=True)
        else:
            return None
        try:
            return self._follow(known, offset, start)
        except np.linalg.LinAlgError:
            self.known, self.base = None, None
            return None

    def start(self, offset: Array, guess: Array) -> Answer | None:
        """Forces and motion at ``offset`` from forces guessed (m, dim), whatever came before."""
        return None

    def _follow(self, known: LastIncrement, offset: Array, begin: Start) -> Answer | None:
        """Newton on one set of candidates after the other, until no other node changes."""
        status, begun, spent = known.status, False, 0
        if begin.turned:
            status = np.minimum(status, STICK)
        here = known.yielded + offset
        rest = here * (status == OPEN)[:, None]
        ahead = begin.of(known)
        gap = here[:, 0] + ahead[:, 0]
        deepest = -TOLERANCE * self._length * known.largest
        astray = np.zeros(len(status), dtype=bool)  # no candidates, but they turned out to be
        for _ in range(_ROUNDS):
            needed = (status != OPEN) | (gap < 0.0)
            if np.count_nonzero(needed) > _MORE * np.count_nonzero(status) + _LEAST:
                return None
            base = self._bring_base(needed, gap)
            nodes = base.nodes
            drift = (here - rest)[nodes].reshape(-1)
            start = known.multiplier[nodes].reshape(-1) - dsymv(1.0, base.half, drift)
            system = self._chosen(base, known, status[nodes], astray)
            mine = nodes[system.nodes]
            still, moved = rest[mine].reshape(-1), ahead[mine].reshape(-1)
            first = None if begun else status[mine]
            found = self._newton(base, system, start, still, moved, first, known.largest)
            if found is None:
                return None
            x, point, residual, iterations = found
            spent, begun = spent + iterations, True
            status = status.copy()
            status[mine] = point.status
            ahead[mine] = x.reshape(-1, here.shape[1])
            force, lost = self._whole(base, system, start, x, point)
            if lost.any():
                astray[nodes[lost]] = True
                continue
            force[status[nodes] == OPEN] = 0.0
            multiplier = np.zeros_like(here)
            multiplier[nodes] = force
            yielded = dsymv(1.0, self._half, multiplier.reshape(-1)).reshape(here.shape)
            motion = yielded + offset
            touched = (motion[:, 0] < deepest) & ~base.inside
            if not touched.any():
                return Answer(multiplier, yielded, motion, residual, spent)
            ahead = np.where((status == OPEN)[:, None], yielded - known.yielded, ahead)
            astray |= touched
            gap, status[touched] = motion[:, 0], STICK
        return None

    def _bring_base(
        self, needed: BoolArray, gap: Array, ring: int | None = None, widen: bool = False
    ) -> WorkingSet:
        """See that the base holds the nodes ``needed`` (m,), and not too many others.

        ring: so many open nodes are taken in besides. widen: also where none is needed yet.
        """
        base, dim = self.base, len(self.compliance) // len(needed)
        if base is not None:
            others = len(base.nodes) - np.count_nonzero(needed)
            if others <= _WIDEST * self._ring(needed):
                if not (widen or (needed & ~base.inside).any()):
                    return base
                needed = needed | base.inside
        ring = self._ring(needed) if ring is None or base is None else ring
        nearest = np.argsort(np.where(needed, np.inf, gap))[:ring]
        needed[nearest] = True
        nodes = needed.nonzero()[0]
        if base is None:
            inverse = ActiveInverse.of(self.compliance, nodes, dim)
        else:
            inverse = self._inverse_on(base, nodes, dim)
        self.base, self._system = WorkingSet(inverse, len(gap)), None
        return self.base

    def _inverse_on(self, base: WorkingSet, nodes: IntArray, dim: int) -> ActiveInverse:
        return base.active.moved_to(self.compliance, nodes, dim, self._inverses)

    @staticmethod
    def _ring(needed: BoolArray) -> int:
        """Number of open nodes that the working set includes in addition to the needed ones."""
        return max(_LEAST, int(_RING * np.count_nonzero(needed)))

    def _chosen(
        self, base: WorkingSet, known: LastIncrement, status: IntArray, astray: BoolArray
    ) -> System:
        """Candidates that cover what may change: those at hand, or others.

        status (k,): of the base's nodes. Every node is one where the base is small or most of them
        are anyway, and where the last choice was far from enough.
        """
        held, small = self._system, len(base.inverse) <= _SMALL
        if held is not None and small:
            return held
        needed = (status != STICK) | astray[base.nodes]
        if held is not None:
            beyond = needed.copy()
            beyond[held.nodes] = False
            if not beyond.any() and np.count_nonzero(needed) > _LOOSE * len(held.nodes):
                return held
        force, rho = known.multiplier[base.nodes], self._rho[base.nodes]
        friction = self.friction.at(base.nodes)
        needed |= lengths(force[:, 1:]) > friction.bound(force[:, 0], _NEAR)
        most = np.count_nonzero(needed) > _BULK * len(status)
        if small or most or np.count_nonzero(astray) > _STRAY:
            needed[:] = True
        nodes = needed.nonzero()[0]
        self._system = System(base.inverse, nodes, rho, friction, self._systems)
        return self._system

    def _whole(
        self, base: WorkingSet, system: System, start: Array, x: Array, point: Point
    ) -> tuple[Array, BoolArray]:
        """Forces (k, dim) of the base, and which of its nodes, no candidates, do not stick."""
        if len(system.nodes) == len(base.nodes):
            return point.force, np.zeros(len(base.nodes), dtype=bool)
        moved = np.zeros(len(start))
        moved[system.dofs] = x
        force = (start + dsymv(1.0, base.half, moved)).reshape(-1, system.dim)
        lost = lengths(force[:, 1:]) > self.friction.at(base.nodes).bound(force[:, 0])
        lost[system.nodes] = False
        return force, np.asarray(lost)

    def _newton(
        self,
        base: WorkingSet,
        system: System,
        start: Array,
        rest: Array,
        x: Array,
        status: IntArray | None,
        scale: float,
    ) -> tuple[Array, Point, float, int] | None:
        """x, the point there, its residual, and iterations; None where it does not settle.

        start (k dim,), rest (n,): forces of the base and motions at x = 0. status: those that the
        first iteration keeps to. It ends early where nodes that are no candidates do not stick.
        """
        last, begin, alone = 1e30, start[system.dofs], len(system.nodes) < len(base.nodes)
        for iteration in range(_MOST):
            point = system.at(begin + system.response @ x, rest + x, status)
            residual = float(np.abs(point.rows).max(initial=0.0)) / scale
            if residual <= TOLERANCE and iteration and self._opposed(system, point, scale):
                return x, point, residual, iteration
            if not np.isfinite(residual):
                return None
            if not system.is_factored(point, residual, last):
                if iteration == 1 and alone and self._whole(base, system, start, x, point)[1].any():
                    return x, point, residual, iteration
                system.factorise(point)
            if (factors := system.factors) is None:
                return None
            x = np.where(factors.held, -rest, x + factors.solve(point.rows.reshape(-1)))
            status, last = None, max(residual, 1e-30)
        return None

    def _opposed(self, system: System, point: Point, scale: float) -> bool:
        """True if friction opposes each slip that is not negligible."""
        if point.force.shape[1] == 2:
            return True
        slip, force = point.motion[point.sliding, 1:], point.force[point.sliding]
        length = lengths(slip)
        bound = system.friction.at(point.sliding).bound(force[:, 0])[:, None]
        astray = lengths(force[:, 1:] + bound * slip / np.maximum(length, 1e-300)[:, None])
        off = np.minimum(astray, length / self._length)
        return bool(off.max(initial=0.0) <= _OPPOSED * scale)
