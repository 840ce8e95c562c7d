"""The shear at which a finger held at an approach carries a given tangential force (numpy only).

    F_t(approach, shear) = tangential        (whole finger; unknown: the shear)

At a held approach F_t grows with the shear, ever slower, until the whole contact slides: so a
weight hanging on the finger finds its shear. Newton with the increments' own tangent stays between
a shear that carries too little and one that carries too much. Every trial starts from the same
frozen state: friction history moves once, with the accepted increment.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import NoEquilibrium
from fingerdesign.contact.increment import Increment, Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState
from fingerdesign.contact.tangent import stiffness
from fingerdesign.errors import SolverError

_TOLERANCE = 1e-9  # of the largest force in the balance
_ITERATIONS = 100
_GROWTH = 4.0  # times the last step, or times what the softest spring would need
_STRAIGHT = 1e-9  # of the bracket: narrower than this it holds nothing more


@dataclass(frozen=True)
class ForceSlope:
    """A force at some motion: ``value`` N and ``slope`` N/mm.

    scale: N, what the balance is accurate against. limit: +1 or -1 where going on that way changes
    nothing, because all slides or nothing is touched; else 0.
    """

    value: float
    slope: float
    scale: float
    limit: int = 0


class OutOfReach(SolverError):
    """The force never reaches the target; it stays at ``most`` N."""

    def __init__(self, most: float) -> None:
        super().__init__(f"the force stays at {most:.4g} N")
        self.most = most


def rising_root(
    evaluate: Callable[[float], ForceSlope | None],
    target: float,
    start: float,
    last: float,
    softest: float,
    most: float = np.inf,
) -> float:
    """Find the motion at which a rising force reaches ``target``; it was evaluated there last.

    evaluate gives None where the model has no answer. start: the first try, mm; last: a place near
    it where the model has an answer; softest: mm/N, a spring softer than any without slip; most: a
    motion known to give more than the target. Raises OutOfReach where the force stays short of the
    target, SolverError where nothing was found.
    """
    low, high = -np.inf, most
    here, good, step = start, last, 0.0
    for _ in range(_ITERATIONS):
        trial = evaluate(here)
        if trial is None:
            if abs(here - good) <= _STRAIGHT * abs(start - last):
                break
            here = 0.5 * (here + good)
            continue
        missing = target - trial.value
        if abs(missing) <= _TOLERANCE * max(trial.scale, abs(target)):
            return here
        if missing * trial.limit > 0.0 and not np.isfinite(high if missing > 0.0 else low):
            raise OutOfReach(trial.value)
        good = here
        low, high = (here, high) if missing > 0.0 else (low, here)
        longest = _GROWTH * max(softest * abs(missing), abs(step))
        step = float(np.sign(missing)) * longest
        if trial.slope * longest > abs(missing):
            step = missing / trial.slope
        here += step
        if not low < here < high:
            here = 0.5 * (low + high)
            if high - low <= _STRAIGHT * softest * abs(missing):
                break
    raise SolverError("no motion was found that balances the forces: use smaller increments")


class Attempts:
    """Increments from one frozen state; each trial starts from the forces of the one before."""

    def __init__(
        self, problem: ContactProblem, state: ContactState, workspace: Workspace | None = None
    ) -> None:
        self.problem, self.state = problem, state
        self.workspace = workspace or Workspace()
        self._guess = state
        self._last: Increment | None = None

    @property
    def last(self) -> Increment:
        """The last increment that was accepted. Raises SolverError where none was."""
        if self._last is None:
            raise SolverError("no increment was accepted: use smaller increments")
        return self._last

    def at(self, approach: float, shear: float) -> Increment | None:
        """The increment to a motion, None where it has no accepted answer. Raises ZoneExhausted
        where the contact outgrows its candidates."""
        motion = replace(self.state.motion, approach=approach, shear=shear)
        try:  # one of many trials, which need not succeed
            found = solve_increment(
                self.problem, self._guess, motion, self.workspace, try_slow_methods=False
            )
        except ZoneExhausted:
            raise
        except SolverError:
            self.workspace.inverse = None
            return None
        self._guess = replace(self.state, multiplier=found.multiplier, motion=motion)
        self._last = found
        return found

    def forces(self) -> Array:
        """(F_n, F_t) of the last increment, N, whole finger."""
        return self.problem.resultant(self.last.force)

    def stiffness(self) -> Array:
        """d(F_n, F_t) / d(approach, shear) (2, 2) at the last increment, N/mm."""
        return stiffness(self.problem, self.last, self.workspace)

    def limit(self) -> int:
        """+1 or -1 where the whole contact slides that way, else 0."""
        touching = self.last.multiplier[:, 0] > 0.0
        if not (self.last.state.sliding[touching] > 0.0).all():
            return 0
        return int(np.sign(self.last.multiplier[:, 1].sum()))

    @property
    def softest(self) -> float:
        """mm/N: a node's own compliance is more than that of a contact of many."""
        model = self.problem.model
        return float(self.problem.self_compliance.max()) / model.symmetry_factor


def predicted_shear(
    problem: ContactProblem,
    before: Increment,
    approach: float,
    tangential: float,
    workspace: Workspace | None = None,
) -> float:
    """Shear, mm, at which ``before``'s tangent carries ``tangential`` N at another approach."""
    motion, (_, carried) = before.motion, problem.resultant(before.force).tolist()
    crossed, slope = stiffness(problem, before, workspace)[1].tolist()
    missing = tangential - carried - crossed * (approach - motion.approach)
    most = _GROWTH * float(problem.self_compliance.max()) * abs(missing)
    return motion.shear + missing / slope if slope * most > abs(missing) else motion.shear


def solve_shear(
    problem: ContactProblem,
    state: ContactState,
    approach: float,
    tangential: float,
    workspace: Workspace | None = None,
    start: float | None = None,
    most: float = np.inf,
) -> Increment:
    """The increment to ``approach`` (mm) that carries ``tangential`` (N): its shear is the answer.

    start: a shear to begin at, mm; without one the state's. most: a shear known to carry more (in
    3-D F_t grows a little even while all slides, its directions turning). Raises NoEquilibrium
    where friction cannot carry the force or nothing is touched, ZoneExhausted where the contact
    outgrows the candidates, SolverError where no shear was found.
    """
    if not np.isfinite([approach, tangential]).all():
        raise SolverError(f"approach {approach} mm and force {tangential} N must be finite")
    trials = Attempts(problem, state, workspace)

    def evaluate(shear: float) -> ForceSlope | None:
        if trials.at(approach, shear) is None:
            return None
        normal, carried = trials.forces().tolist()
        if not normal > 0.0:
            raise OutOfReach(0.0)
        near = abs(tangential - carried) <= _TOLERANCE * max(normal, abs(tangential))
        slope = 0.0 if near else float(trials.stiffness()[1, 1])
        return ForceSlope(carried, slope, normal, trials.limit())

    here = state.motion.shear
    start = here if start is None else start
    try:
        rising_root(evaluate, tangential, start, here, trials.softest, most)
    except OutOfReach as reached:
        raise NoEquilibrium(
            f"no shear gives {tangential:g} N tangential at an approach of {approach:g} mm: "
            f"complete slip. At friction {problem.law} the contact carries "
            f"{reached.most:.4g} N there; ask for less or press harder"
        ) from None
    trials.workspace.record(state, trials.last.state)
    return trials.last
