"""Two fingers lift an object off its support; then it hangs, is tugged, changes weight, drops.

Quasi-static, along x alone. W is the object's weight and what tugs at it, toward +x; the hand moves
toward -x, ``hand`` mm in all. While the object stands, the fingers are sheared by all of that,

    shear = hand,          F_t + F_t' <= W                     (the support carries the rest)

and where they would carry more than W, it hangs: they carry W and it rises by what is left,

    F_t + F_t' = W,        rise = hand - shear > 0

A hanging object that friction cannot carry falls back onto its support: complete slip. It can be
gripped anew there. Tilting, the support's own friction and dynamics are left out; an arm that
accelerates by a pulls at the object as m a more does. Rubber that relaxes loses a share of all its
forces since the touch, evenly in the logarithm of time: at the same motions

    f(t) = R(t) f,   R = 1 - r log(1 + t / T) / log(1 + 60 s / T),   T = 0.1 s,

r of it in a minute. Moduli all fall alike, so contact and strains stay; what is pressed later meets
the softer finger too, where a full model of the rubber's memory would let it meet the fresh one.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import inf, isfinite

from fingerdesign.contact.balance import (
    Attempts,
    ForceSlope,
    OutOfReach,
    predicted_shear,
    rising_root,
    solve_shear,
)
from fingerdesign.contact.history import FrictionHistory
from fingerdesign.contact.increment import Increment, solve_increment
from fingerdesign.contact.path import NoEquilibrium
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.control.plants.plant import Truth, felt
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import Grip, Tug, WeightChange, lifting_tugs, pull_at

_RELAXES_s = 0.1  # T

# Two fingers that hold one rigid object between them, moved alike (numpy only).
#
# Both bases close by the same way and are sheared alike against the object. Where the opposite
# finger is a mirror image, the object stays in the middle and each finger has exactly half of all
# forces: one model serves both. Where it is another finger, the object floats to where both press
# alike,
#
#     approach = closing + drift   of the finger with gages,   closing - drift   of the other,
#     F_n (closing + drift, shear) = F_n' (closing - drift, shear)
#
# The object keeps its direction: its tilting under unlike tangential forces is left out.


@dataclass(frozen=True)
class Held:
    """What two fingers do at some closing and shear; forces N, mm.

    increment: of the finger with gages, other: of the opposite one (the same where it is a mirror
    image). carried: F_t of both together. drift: the object's way off the middle.
    """

    increment: Increment
    other: Increment
    carried: float
    drift: float = 0.0

    @property
    def shear(self) -> float:
        """Of both, mm in all."""
        return self.increment.motion.shear


class MirrorPair:
    """A finger and its mirror image: half of all forces each, exactly.

    Of this pair and the other ``accept`` alone moves the friction history on.
    """

    def __init__(self, problem: ContactProblem, kinetic_share: float = 1.0) -> None:
        self._history = FrictionHistory(problem, kinetic_share)

    @property
    def problem(self) -> ContactProblem:
        """What the finger's next increment is solved on."""
        return self._history.problem

    @property
    def settled(self) -> bool:
        """Whether the same motion once more would leave all forces as they are."""
        return self._history.settled

    def stand(self, closing: float, shear: float) -> Held:
        """Both moved to ``closing`` and ``shear``, mm in all."""
        history, motion = self._history, Motion(closing, shear)
        found = solve_increment(history.problem, history.state, motion, history.workspace)
        return self._held(found)

    def hang(self, closing: float, weight: float, most: float = inf) -> Held:
        """Closed by ``closing`` mm in all, together carrying ``weight`` N: the shear is found.

        most: a shear at which they are known to carry more. Raises NoEquilibrium where friction
        cannot carry it.
        """
        start, half, history = None, 0.5 * weight, self._history
        problem, workspace = history.problem, history.workspace
        if history.last is not None:
            start = predicted_shear(problem, history.last, closing, half, workspace)
        return self._held(
            solve_shear(problem, history.state, closing, half, workspace, start, most)
        )

    def accept(self, held: Held) -> None:
        """Go on from ``held``."""
        self._history.accept(held.increment)

    def _held(self, increment: Increment) -> Held:
        carried = 2.0 * float(self.problem.model.total_force(increment.force)[0])
        return Held(increment, increment, carried)


class UnlikePair:
    """Two different fingers; the object floats between them."""

    def __init__(
        self, problem: ContactProblem, opposite: ContactProblem, kinetic_share: float = 1.0
    ) -> None:
        self._histories = tuple(
            FrictionHistory(each, kinetic_share) for each in (problem, opposite)
        )
        self._shear = self._drift = 0.0

    @property
    def problem(self) -> ContactProblem:
        """What the next increment of the finger with gages is solved on."""
        return self._histories[0].problem

    @property
    def settled(self) -> bool:
        return all(each.settled for each in self._histories)

    def stand(self, closing: float, shear: float) -> Held:
        return self._between(closing).at(shear)

    def hang(self, closing: float, weight: float, most: float = inf) -> Held:
        between = self._between(closing)

        def evaluate(shear: float) -> ForceSlope:
            between.at(shear)
            return between.carried()

        try:
            here = self._shear
            rising_root(evaluate, weight, here, here, between.softest, most)
        except OutOfReach as reached:
            raise NoEquilibrium(
                f"no shear makes the two fingers carry {weight:g} N, closed by {closing:g} mm: "
                f"complete slip at {reached.most:.4g} N"
            ) from None
        return between.held()

    def accept(self, held: Held) -> None:
        for history, increment in zip(self._histories, (held.increment, held.other), strict=True):
            history.accept(increment)
        self._shear, self._drift = held.shear, held.drift

    def _between(self, closing: float) -> _Between:
        first, second = (
            Attempts(each.problem, each.state, each.workspace) for each in self._histories
        )
        return _Between(first, second, closing, self._drift)


class _Between:
    """The drift at which both fingers press alike, for one closing and any shear."""

    def __init__(self, first: Attempts, second: Attempts, closing: float, drift: float) -> None:
        self._first, self._second = first, second
        self._closing, self._drift = closing, drift
        self.softest = max(first.softest, second.softest)

    def at(self, shear: float) -> Held:
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

    def held(self) -> Held:
        """The last balance."""
        carried = float(self._first.forces()[1] + self._second.forces()[1])
        return Held(self._first.last, self._second.last, carried, self._drift)

    def carried(self) -> ForceSlope:
        """F_t of both against the shear, the drift following it."""
        (normal, pulled), (against, opposed) = self._first.forces(), self._second.forces()
        if not (normal > 0.0 and against > 0.0):
            raise OutOfReach(0.0)
        here, there = self._first.stiffness(), self._second.stiffness()
        follows = (there[0, 1] - here[0, 1]) / (here[0, 0] + there[0, 0])
        slope = here[1, 1] + there[1, 1] + (here[1, 0] - there[1, 0]) * follows
        limits = {self._first.limit(), self._second.limit()}
        limit = limits.pop() if len(limits) == 1 else 0
        return ForceSlope(float(pulled + opposed), float(slope), float(normal), limit)


class Disturbance(Tug):
    """A tug at the lifted object: ``extra_force_N`` toward +x (down), or up where negative.

    It acts from move ``step_after_lift`` after the one that lifted (1 is the next), for
    ``duration_steps`` moves. Raises ValueError on numbers that cannot be.
    """

    def __init__(self, step_after_lift: int, extra_force_N: float, duration_steps: int = 1) -> None:
        super().__init__(
            step_after_lift=step_after_lift,
            extra_force_N=extra_force_N,
            duration_steps=duration_steps,
        )


@dataclass(frozen=True)
class Relaxation:
    """share: r of the module, of all forces in a minute; rate: moves a second."""

    share: float
    rate: float

    def left(self, moves: int) -> float:
        """R after so many moves."""
        passed, minute = (math.log1p(t / _RELAXES_s) for t in (moves / self.rate, 60.0))
        return 1.0 - self.share * passed / minute

    @staticmethod
    def of(grip: Grip) -> Relaxation | None:
        """As a design's ``[grip]`` table says; None: it does not."""
        share = grip.relaxation_per_minute
        return Relaxation(share, grip.hardware.sample_rate_Hz) if share > 0.0 else None


class LiftPlant:
    """A finger with gages and an opposite one, an object between them on a support.

    dx is the hand's move away from the support, dy what each finger closes by, both mm; a step is
    one move. Forces and truth are those of the finger with gages. opposite: another finger's
    problem, without it a mirror image. The support is where the object is first touched.
    kinetic_share: of either finger's friction, what is left where it slides (contact/history.py).

    Raises ValueError where a tug upward exceeds the weight: nothing would hold the object then.
    """

    def __init__(
        self,
        problem: ContactProblem,
        face: str,
        object_mass_g: float,
        opposite: ContactProblem | None = None,
        disturbances: Sequence[Tug | WeightChange] = (),
        relaxation: Relaxation | None = None,
        kinetic_share: float = 1.0,
    ) -> None:
        if not (isfinite(object_mass_g) and object_mass_g > 0.0):
            raise ValueError(f"a mass of {object_mass_g} g must be over 0")
        self._face = face
        self._fingers: MirrorPair | UnlikePair
        if opposite is None:
            self._fingers = MirrorPair(problem, kinetic_share)
        else:
            self._fingers = UnlikePair(problem, opposite, kinetic_share)
        self._mass = object_mass_g
        self._tugs = [each for each in disturbances if isinstance(each, Tug)]
        self._changes = [each for each in disturbances if isinstance(each, WeightChange)]
        for number, _ in lifting_tugs(object_mass_g, self._tugs, self._changes):
            raise ValueError(
                f"a tug of {self._tugs[number].extra_force_N:g} N lifts the object out of the "
                "fingers; tug less, or use a heavier object"
            )
        self._relaxation, self._moves = relaxation, 0
        self._closing = self._hand = 0.0
        self._since_lift: int | None = None  # moves since the first lift
        self._lifted = False
        self._truth = Truth(0.0, 0.0, 0.0, 0.0, None, 0.0, False, lifted=False)
        self.held: Held | None = None  # what both fingers do after the last move, for the judge
        self._weight = 0.0  # at the last move
        self._sample: Sample

    @staticmethod
    def of(
        grip: Grip,
        problem: ContactProblem,
        face: str,
        friction_coefficient: float,
        object_mass_g: float,
        opposite: ContactProblem | None = None,
    ) -> LiftPlant:
        """As a design's ``[grip]`` table says, both fingers at one friction."""
        return LiftPlant(
            problem.with_friction(friction_coefficient),
            face,
            object_mass_g,
            None if opposite is None else opposite.with_friction(friction_coefficient),
            [*grip.tugs, *grip.weight_changes],
            Relaxation.of(grip),
            grip.kinetic_share,
        )

    def move(self, dx: float, dy: float) -> Sample:
        """Raise the hand by ``dx``, close each finger by ``dy``; see :class:`Plant`."""
        if self._since_lift is not None:
            self._since_lift += 1
        self._moves += 1
        left = 1.0 if self._relaxation is None else self._relaxation.left(self._moves)
        closing, hand = self._closing + dy, self._hand + dx
        weight = self.weight(self._since_lift or 0) / left  # of a finger that has not relaxed
        same = (closing, weight) == (self._closing, self._weight) and self._fingers.settled
        if same and self._lifted and hand > self._truth.shear:  # but for the height
            self._hand = hand
            self._truth = replace(self._truth, rise=hand - self._truth.shear)
            return self._sample
        held, lifted, dropped = self._find(closing, hand, weight)
        truth, sample = felt(self._fingers.problem, held.increment, self._face)
        self._fingers.accept(held)
        self.held = held
        self._closing, self._hand, self._lifted = closing, hand, lifted
        self._weight = weight
        if lifted and self._since_lift is None:
            self._since_lift = 0
        forces = {
            "normal_force": left * truth.normal_force,
            "tangential_force": left * truth.tangential_force,
        }
        self._truth = replace(
            truth,
            **forces,
            stick_ratio=0.0 if dropped else truth.stick_ratio,  # it all slid as it dropped
            complete_slip=truth.complete_slip or dropped,
            lifted=lifted,
            rise=hand - truth.shear if lifted else 0.0,
        )
        self._sample = replace(
            sample,
            normal_force=left * sample.normal_force,
            tangential_force=left * sample.tangential_force,
            lifted=lifted,
        )
        return self._sample

    def truth(self) -> Truth:
        """The state after the last move, for the judge."""
        return self._truth

    def weight(self, step_after_lift: int) -> float:
        """What pulls at the object toward +x that many moves after the lift, N."""
        return pull_at(step_after_lift, self._mass, self._tugs, self._changes)

    def _find(self, closing: float, hand: float, weight: float) -> tuple[Held, bool, bool]:
        """What the fingers do now, whether the object hangs, whether it has dropped."""
        if self._lifted:
            try:
                hanging = self._fingers.hang(closing, weight)
            except NoEquilibrium:
                standing = self._fingers.stand(closing, hand)
                if standing.carried <= weight:
                    return standing, False, True
                return self._fingers.hang(closing, weight, hand), True, False
            if hanging.shear < hand:
                return hanging, True, False
            return self._fingers.stand(closing, hand), False, False  # the hand has set it down
        standing = self._fingers.stand(closing, hand)
        if standing.carried <= weight:
            return standing, False, False
        return self._fingers.hang(closing, weight, hand), True, False
