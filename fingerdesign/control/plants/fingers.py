"""Two fingers that hold one rigid object between them, moved alike (numpy only).

Both bases close by the same way and are sheared alike against the object. Where the opposite
finger is a mirror image, the object stays in the middle and each finger has exactly half of all
forces: one model serves both. Where it is another finger, the object floats to where both press
alike,

    approach = closing + drift   of the finger with gages,   closing - drift   of the other,
    F_n (closing + drift, shear) = F_n' (closing - drift, shear)

The object keeps its direction: its tilting under different tangential forces is left out. A pair
gives any number of answers from one state: ``accept`` alone moves the friction history
on, ``passed`` what the rubber remembers (contact/memory.py) and how warm it is, once a control
step.
"""

from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass, replace
from math import expm1, inf

from fingerdesign.contact.balance import (
    Attempts,
    ForceSlope,
    OutOfReach,
    predicted_shear,
    rising_root,
    solve_shear,
)
from fingerdesign.contact.force_control import NoEquilibrium
from fingerdesign.contact.history import FrictionHistory
from fingerdesign.contact.increment import Increment, solve_increment
from fingerdesign.contact.memory import Rubber, RubberHistory
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.contact.tangent import stiffness
from fingerdesign.errors import SolverError

_FRICTION_STEP = 0.002  # of the friction, as rubber that relaxes changes it
_REACH = 4.0  # times (1 + mu) F_n: more than friction carries on any slope that a finger touches


@dataclass(frozen=True)
class PairState:
    """State of two fingers at some closing and shear; forces N, mm.

    increment: of the finger with gages, other: of the opposite one (the same where it is a mirror
    image). carried: F_t of both together. drift: the object's way off the middle. relaxation: the
    factor of the increments' forces (contact/memory.py); 1 of rubber without a memory.
    slid: how far the whole contact has slid in it, mm: the way of the nodes that began last.
    """

    increment: Increment
    other: Increment
    carried: float
    drift: float = 0.0
    relaxation: float = 1.0
    slid: float = 0.0

    @property
    def shear(self) -> float:
        """Shear of both, mm in all."""
        return self.increment.motion.shear


@dataclass(frozen=True)
class Warming:
    """Fingers become ``kelvin`` warmer from the touch on, T = kelvin (1 - exp(-t / time)), and
    expand evenly; time: s; rate: moves a second."""

    kelvin: float
    time: float
    rate: float

    def after(self, moves: int) -> float:
        """T after so many moves, K."""
        return -self.kelvin * expm1(-moves / (self.rate * self.time))


@dataclass(frozen=True)
class Kind:
    """Properties of the fingers other than elastic. kinetic_share: of the friction
    coefficient, what is left where the contact slides (contact/history.py)."""

    rubber: Rubber | None = None
    kinetic_share: float = 1.0
    warming: Warming | None = None


class _Finger:
    """One finger's friction history, what its rubber remembers, and how warm it is."""

    def __init__(self, problem: ContactProblem, kind: Kind) -> None:
        self.history = FrictionHistory(problem, kind.kinetic_share)
        self._memory = None if kind.rubber is None else RubberHistory(kind.rubber, problem)
        self._warming, self._warmed = kind.warming, problem.modes[4].copy()  # by one kelvin
        self._moves = 0
        self._displace()

    @property
    def settled(self) -> bool:
        return self.history.settled and self._memory is None and self._warming is None

    def solve(self, approach: float, shear: float) -> Increment:
        history = self.history
        motion = replace(history.state.motion, approach=approach, shear=shear)
        return solve_increment(history.problem, history.state, motion, history.workspace)

    def attempts(self) -> Attempts:
        history = self.history
        return Attempts(history.problem, history.state, history.workspace)

    def start(self, approach: float, tangential: float) -> float | None:
        """A shear that may well carry ``tangential`` N over ``PairState.relaxation``."""
        history, before = self.history, self.history.last
        if before is None:
            return None
        if self._memory is not None:
            before = replace(before, force=self._memory.rest_force)
        own = (approach, tangential, history.workspace)
        return predicted_shear(history.problem, before, *own)

    def relax(self, left: float) -> None:
        """All forces are ``left`` times those of the problem, from here on.

        Friction p^-n is then left^-n times as large at the same motions. It changes in small steps,
        for each change costs new factors.
        """
        if exponent := self.history.problem.law.exponent:
            self.history.strengthen(
                1.0 + _FRICTION_STEP * round((left**-exponent - 1.0) / _FRICTION_STEP)
            )

    def stiffness(self) -> float:
        """Against shear at the last increment, what slides taken to stick, over ``relaxation``."""
        history = self.history
        if history.last is None:
            return 0.0
        found = stiffness(history.problem, history.last, history.workspace, turning_back=True)
        return float(found[1, 1])

    def slid(self, increment: Increment) -> float:
        """The shortest slip of those that touch and slide in an increment, mm; 0 if one sticks."""
        touching = increment.multiplier[:, 0] > 0.0
        return float(increment.state.sliding[touching].min()) if touching.any() else 0.0

    def passed(self) -> None:
        """A control step is over."""
        last = self.history.last
        self._moves += 1
        if self._memory is not None and last is not None:
            self._memory.record(last.multiplier)
        self._displace()

    def _displace(self) -> None:
        """For the next control step: what the past and the temperature do to the surface."""
        lags = [] if self._memory is None else [self._memory.lag]
        if self._warming is not None:
            lags.append(self._warming.after(self._moves + 1) * self._warmed)
        if lags:
            self.history.displace(sum(lags[1:], start=lags[0]))


class _Pair:
    """Two fingers of one rubber, by those that are solved: one that both are like, or each."""

    def __init__(self, kind: Kind, *problems: ContactProblem) -> None:
        self._fingers = tuple(_Finger(each, kind) for each in problems)
        self._like = 2.0 / len(problems)  # how many each of them stands for
        self._relaxation = 1.0 if kind.rubber is None else kind.rubber.relaxation_factor

    @property
    def problem(self) -> ContactProblem:
        """The problem of the next increment of the finger with gages."""
        return self._fingers[0].history.problem

    @property
    def settled(self) -> bool:
        """True where the same motion once more would leave all forces as they are."""
        return all(finger.settled for finger in self._fingers)

    def relax(self, left: float) -> None:
        """All forces are ``left`` times the problem's, whose law is Coulomb's or p^-n."""
        for finger in self._fingers:
            finger.relax(left)

    def stiffness(self) -> float:
        """Stiffness of both against shear as last accepted, as if nothing more slid, N/mm."""
        return self._like * self._relaxation * sum(each.stiffness() for each in self._fingers)

    def passed(self) -> None:
        """A control step is over."""
        for finger in self._fingers:
            finger.passed()


class MirrorPair(_Pair):
    """A finger and its mirror image: half of all forces each, exactly."""

    def __init__(self, problem: ContactProblem, kind: Kind = Kind()) -> None:
        super().__init__(kind, problem)
        (self._finger,) = self._fingers

    def stand(self, closing: float, shear: float) -> PairState:
        """Both moved to ``closing`` and ``shear``, mm in all."""
        return self._held(self._finger.solve(closing, shear))

    def hang(self, closing: float, weight: float, most: float = inf) -> PairState:
        """Closed by ``closing`` mm in all, together carrying ``weight`` N: the shear is found.

        most: a shear at which they are known to carry more. Raises NoEquilibrium where friction
        cannot carry it.
        """
        history, half = self._finger.history, 0.5 * weight / self._relaxation
        start = self._finger.start(closing, half)
        found = solve_shear(
            history.problem, history.state, closing, half, history.workspace, start, most
        )
        return self._held(found)

    def slide(self, closing: float) -> PairState:
        """Sheared until the whole contact slides; ``carried`` is then what friction carries."""
        trials = self._finger.attempts()

        def evaluate(shear: float) -> ForceSlope | None:
            if trials.at(closing, shear) is None:
                return None
            normal, carried = (float(force) for force in trials.forces())
            if not normal > 0.0:
                raise OutOfReach(0.0)
            return ForceSlope(carried, float(trials.stiffness()[1, 1]), normal, trials.limit())

        here, friction = trials.state.motion.shear, trials.problem.law.steepest
        _until_sliding(evaluate, here, trials.softest, friction)
        return self._held(trials.last)

    def accept(self, held: PairState) -> None:
        """Go on from ``held``."""
        self._finger.history.accept(held.increment)

    def _held(self, increment: Increment) -> PairState:
        carried = 2.0 * self._relaxation * float(self.problem.model.total_force(increment.force)[0])
        slid = self._finger.slid(increment)
        return PairState(increment, increment, carried, relaxation=self._relaxation, slid=slid)


class _Between:
    """The drift at which both fingers press alike, for one closing and any shear."""

    def __init__(
        self, first: Attempts, second: Attempts, closing: float, drift: float, relaxation: float
    ) -> None:
        self._first, self._second = first, second
        self._closing, self._drift, self._relaxation = closing, drift, relaxation
        self.softest = max(first.softest, second.softest)

    def at(self, shear: float) -> PairState:
        def evaluate(drift: float) -> ForceSlope | None:
            found = self._first.at(self._closing + drift, shear)
            other = self._second.at(self._closing - drift, shear)
            if found is None or other is None:
                return None
            pressed, against = self._first.forces()[0], self._second.forces()[0]
            slope = self._first.stiffness()[0, 0] + self._second.stiffness()[0, 0]
            return ForceSlope(float(pressed - against), float(slope), float(max(pressed, against)))

        self._drift = rising_root(evaluate, 0.0, self._drift, self._drift, self.softest)
        return self.held()

    def held(self) -> PairState:
        """The last balance."""
        carried = self._relaxation * float(self._first.forces()[1] + self._second.forces()[1])
        return PairState(
            self._first.last, self._second.last, carried, self._drift, self._relaxation
        )

    def carried_at(self, shear: float) -> ForceSlope:
        """F_t of both, over ``relaxation``, against the shear, the drift following it."""
        self.at(shear)
        (normal, pulled), (against, opposed) = self._first.forces(), self._second.forces()
        if not (normal > 0.0 and against > 0.0):
            raise OutOfReach(0.0)
        here, there = self._first.stiffness(), self._second.stiffness()
        follows = (there[0, 1] - here[0, 1]) / (here[0, 0] + there[0, 0])
        slope = here[1, 1] + there[1, 1] + (here[1, 0] - there[1, 0]) * follows
        limits = {self._first.limit(), self._second.limit()}
        limit = limits.pop() if len(limits) == 1 else 0
        return ForceSlope(float(pulled + opposed), float(slope), float(normal), limit)


class DifferentPair(_Pair):
    """Two different fingers of one rubber; the object floats between them."""

    def __init__(
        self, problem: ContactProblem, opposite: ContactProblem, kind: Kind = Kind()
    ) -> None:
        super().__init__(kind, problem, opposite)
        self._shear = self._drift = 0.0

    def stand(self, closing: float, shear: float) -> PairState:
        return self._held(self._between(closing).at(shear))

    def hang(self, closing: float, weight: float, most: float = inf) -> PairState:
        between = self._between(closing)
        try:
            here = self._shear
            target = weight / self._relaxation
            rising_root(between.carried_at, target, here, here, between.softest, most)
        except OutOfReach as reached:
            raise NoEquilibrium(
                f"no shear makes the two fingers carry {weight:g} N, closed by {closing:g} mm: "
                f"complete slip at {reached.most * self._relaxation:.4g} N"
            ) from None
        return self._held(between.held())

    def slide(self, closing: float) -> PairState:
        between = self._between(closing)
        friction = self.problem.law.steepest
        _until_sliding(between.carried_at, self._shear, between.softest, friction)
        return self._held(between.held())

    def accept(self, held: PairState) -> None:
        for finger, increment in zip(self._fingers, (held.increment, held.other), strict=True):
            finger.history.accept(increment)
        self._shear, self._drift = held.shear, held.drift

    def _between(self, closing: float) -> _Between:
        first, second = (finger.attempts() for finger in self._fingers)
        return _Between(first, second, closing, self._drift, self._relaxation)

    def _held(self, held: PairState) -> PairState:
        both = zip(self._fingers, (held.increment, held.other), strict=True)
        return replace(held, slid=min(finger.slid(increment) for finger, increment in both))


def _until_sliding(
    evaluate: Callable[[float], ForceSlope | None], here: float, softest: float, friction: float
) -> None:
    """Shear on from ``here`` until all slides toward +x, or nothing is touched: the last trial.

    friction: the most that a node carries over its normal force.
    """
    with suppress(OutOfReach):
        first = evaluate(here)
        if first is None:
            raise SolverError("the fingers' answer to a closing was not found: close less a step")
        most = _REACH * (1.0 + friction) * first.scale
        rising_root(evaluate, most, here, here, softest)
        raise SolverError(f"friction carries {most:.4g} N and more: no slide can be followed")
