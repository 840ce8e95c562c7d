"""Two fingers that hold one rigid object between them, moved alike (numpy only).

Both bases close by the same way and are sheared alike against the object. Where the opposite finger
is a mirror image, the object stays in the middle and each finger has exactly half of all forces:
one model serves both. Where it is another finger, the object floats to where both press alike,

    approach = closing + drift   of the finger with gages,   closing - drift   of the other,
    F_n (closing + drift, shear) = F_n' (closing - drift, shear)

The object keeps its direction: its tilting under unlike tangential forces is left out.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Protocol

from fingerdesign.contact.balance import (
    OutOfReach,
    Trial,
    Trials,
    predicted_shear,
    rising_root,
    solve_shear,
)
from fingerdesign.contact.force_control import NoEquilibrium
from fingerdesign.contact.increment import ContactState, Increment, Workspace, solve_increment
from fingerdesign.contact.problem import ContactProblem, Motion


@dataclass(frozen=True)
class Held:
    """What two fingers do at some closing and shear; forces N, mm.

    increment: of the finger with gages, other: of the opposite one (the same where it is a mirror
    image). carried: F_t of both together. drift: the object's way off the middle.
    """

    increment: Increment
    other: Increment
    shear: float
    carried: float
    drift: float = 0.0


class Pair(Protocol):
    """Two fingers and their friction history, which ``accept`` alone moves on."""

    def stand(self, closing: float, shear: float) -> Held:
        """Both moved to ``closing`` and ``shear``, mm in all."""
        ...

    def hang(self, closing: float, weight: float, most: float = inf) -> Held:
        """Closed by ``closing`` mm in all, together carrying ``weight`` N: the shear is found.

        most: a shear at which they are known to carry more. Raises NoEquilibrium where friction
        cannot carry it.
        """
        ...

    def accept(self, held: Held) -> None:
        """Go on from ``held``."""
        ...


class MirrorPair:
    """A finger and its mirror image: half of all forces each, exactly."""

    def __init__(self, problem: ContactProblem) -> None:
        self._problem = problem
        self._state = ContactState.untouched(problem)
        self._workspace = Workspace()
        self._before: Increment | None = None

    def stand(self, closing: float, shear: float) -> Held:
        """See :class:`Pair`."""
        motion = Motion(closing, shear)
        return self._held(solve_increment(self._problem, self._state, motion, self._workspace))

    def hang(self, closing: float, weight: float, most: float = inf) -> Held:
        """See :class:`Pair`."""
        start = None
        if self._before is not None:
            start = predicted_shear(
                self._problem, self._before, closing, 0.5 * weight, self._workspace
            )
        found = solve_shear(
            self._problem, self._state, closing, 0.5 * weight, self._workspace, start, most
        )
        return self._held(found)

    def accept(self, held: Held) -> None:
        """See :class:`Pair`."""
        self._state = held.increment.state
        self._before = held.increment

    def _held(self, increment: Increment) -> Held:
        carried = 2.0 * float(self._problem.model.total_force(increment.force)[0])
        return Held(increment, increment, increment.motion.shear, carried)


class UnlikePair:
    """Two different fingers; the object floats between them."""

    def __init__(self, problem: ContactProblem, opposite: ContactProblem) -> None:
        self._problems = (problem, opposite)
        self._states = (ContactState.untouched(problem), ContactState.untouched(opposite))
        self._workspaces = (Workspace(), Workspace())
        self._shear = self._drift = 0.0

    def stand(self, closing: float, shear: float) -> Held:
        """See :class:`Pair`."""
        return self._between(closing).at(shear)

    def hang(self, closing: float, weight: float, most: float = inf) -> Held:
        """See :class:`Pair`."""
        between = self._between(closing)

        def evaluate(shear: float) -> Trial:
            between.at(shear)
            return between.carried()

        try:
            here = self._shear
            shear = rising_root(evaluate, weight, here, here, between.softest, most)
        except OutOfReach as reached:
            raise NoEquilibrium(
                f"no shear makes the two fingers carry {weight:g} N, closed by {closing:g} mm: "
                f"complete slip at {reached.most:.4g} N"
            ) from None
        return between.held(shear)

    def accept(self, held: Held) -> None:
        """See :class:`Pair`."""
        for workspace, state, increment in zip(
            self._workspaces, self._states, (held.increment, held.other), strict=True
        ):
            workspace.passed(state, increment.state)
        self._states = (held.increment.state, held.other.state)
        self._shear, self._drift = held.shear, held.drift

    def _between(self, closing: float) -> _Between:
        first, second = (
            Trials(*each)
            for each in zip(self._problems, self._states, self._workspaces, strict=True)
        )
        return _Between(first, second, closing, self._drift)


class _Between:
    """The drift at which both fingers press alike, for one closing and any shear."""

    def __init__(self, first: Trials, second: Trials, closing: float, drift: float) -> None:
        self._first, self._second = first, second
        self._closing, self._drift = closing, drift
        self.softest = max(first.softest, second.softest)

    def at(self, shear: float) -> Held:
        def evaluate(drift: float) -> Trial | None:
            found = self._first.at(self._closing + drift, shear)
            other = self._second.at(self._closing - drift, shear)
            if found is None or other is None:
                return None
            pressed, against = self._first.forces()[0], self._second.forces()[0]
            slope = self._first.stiffness()[0, 0] + self._second.stiffness()[0, 0]
            return Trial(float(pressed - against), float(slope), float(max(pressed, against)))

        self._drift = rising_root(evaluate, 0.0, self._drift, self._drift, self.softest)
        return self.held(shear)

    def held(self, shear: float) -> Held:
        """The last balance, found at ``shear``."""
        carried = float(self._first.forces()[1] + self._second.forces()[1])
        return Held(self._first.last, self._second.last, shear, carried, self._drift)

    def carried(self) -> Trial:
        """F_t of both against the shear, the drift following it."""
        (normal, pulled), (against, opposed) = self._first.forces(), self._second.forces()
        if not (normal > 0.0 and against > 0.0):
            raise OutOfReach(0.0)
        here, there = self._first.stiffness(), self._second.stiffness()
        follows = (there[0, 1] - here[0, 1]) / (here[0, 0] + there[0, 0])
        slope = here[1, 1] + there[1, 1] + (here[1, 0] - there[1, 0]) * follows
        limits = {self._first.limit(), self._second.limit()}
        limit = limits.pop() if len(limits) == 1 else 0
        return Trial(float(pulled + opposed), float(slope), float(normal), limit)
