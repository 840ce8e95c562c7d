"""One case of the stability map through each method, increment by increment, and its verdict."""

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from enum import StrEnum
from types import FrameType

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, NoEquilibrium, solve_forces
from fingerdesign.contact.increment import Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion, contact_problem
from fingerdesign.errors import SolverError
from fingerdesign.reduced import ReducedModel
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign_bench.stability.cases import Case
from fingerdesign_bench.stability.judge import LOOSE, SHARP, Judge, Past, same_total
from fingerdesign_bench.stability.rivals import Rival, penalty, plain_newton, sweeps

Row = Motion | Forces
# A step of a path: forces (m, dim) N in global axes, and the motion. Raises SolverError.
Stepper = Callable[[Row], tuple[Array, Motion]]
RIVALS = (
    Rival("plain semi-smooth Newton", plain_newton, 1e-5),
    Rival("penalty", penalty, 1e-2),
    Rival("Gauss-Seidel", sweeps, 1e-5),
)
PRODUCTION = "production"
METHODS = (PRODUCTION, *(rival.name for rival in RIVALS))
_PRODUCTION_CLAIM = 1e-7
_SECONDS = 5.0  # of processor time for one increment; then the method counts as hanging
_GRACE = 2.0  # a rival ends itself before it is ended


class Verdict(StrEnum):
    """From best to worst."""

    RIGHT = "right"
    OTHER = "right, not unique"
    REFUSED = "refused rightly"
    FAILED = "failed"
    HANG = "hang"
    WRONG = "wrong"

    @property
    def rank(self) -> int:
        """0 of the best."""
        return list(Verdict).index(self)


@dataclass(frozen=True)
class CaseResult:
    """A method's result on a case: the worst verdict over its increments, at which it ends."""

    body: str
    group: str
    family: str
    friction: float
    method: str
    verdict: Verdict
    reason: str
    increments: int  # judged, of ``planned``
    planned: int
    violation: float  # the worst of its accepted answers
    confirmed: int  # increments at which a second method gave the same answer
    seconds: float  # of processor time


class Witnessed(ZoneExhausted):
    """A refusal with the answer (m, dim) N that reaches the rim, for the judge to look at."""

    def __init__(self, message: str, force: Array) -> None:
        super().__init__(message)
        self.force = force


class TimeIsUp(Exception):
    """An increment took longer than its limit."""


@dataclass(frozen=True)
class Trial:
    """Verdicts on one method, by its ``claim`` of accuracy; ``stored``: second answers of the case,
    for methods whose past is the same."""

    judge: Judge
    claim: float
    stored: list[tuple[Past, Motion, Array | None]]

    def second(self, past: Past, motion: Motion) -> Array | None:
        """Another method's answer."""
        for earlier, moved, answer in self.stored:
            if moved == motion and earlier.motion == past.motion:
                scale = float(np.abs(earlier.force).max())
                if float(np.abs(earlier.force - past.force).max()) <= 1e-12 * scale:
                    return answer
        answer = self.judge.second_answer(past, motion)
        self.stored.append((past, motion, answer))
        return answer

    def of_refusal(
        self, error: Exception, past: Past, row: Row, solvable: bool
    ) -> tuple[Verdict, str]:
        """Refused rightly where there is no answer, or none inside the zone; failed otherwise."""
        if isinstance(error, TimeIsUp):
            return Verdict.HANG, f"no answer in {_SECONDS:g} s of processor time"
        if not isinstance(error, SolverError):
            return Verdict.FAILED, f"{type(error).__name__}: {error}"
        rightly = not solvable and isinstance(error, NoEquilibrium)
        if isinstance(error, ZoneExhausted) and isinstance(row, Motion):
            rightly = rightly or self._leaves_the_zone(error, past, row)
        return (Verdict.REFUSED if rightly else Verdict.FAILED), str(error)

    def _leaves_the_zone(self, error: ZoneExhausted, past: Past, motion: Motion) -> bool:
        answers = [self.second(past, motion)]
        force = error.force if isinstance(error, Witnessed) else None
        if force is not None and self.judge.violation(force, past, motion) <= SHARP:
            answers.append(force)
        return any(answer is not None and self.judge.at_rim(answer) for answer in answers)

    def of_answer(self, found: tuple[Array, Motion], past: Past) -> tuple[Verdict, str]:
        """Right, right but not unique, or wrong, with the reason."""
        (force, motion), judge = found, self.judge
        size, answer = judge.violation(force, past, motion), self.second(past, motion)
        if judge.at_rim(force):
            return Verdict.WRONG, "answered although the candidate zone is exhausted"
        loose = self.claim >= LOOSE
        if size > (10.0 * self.claim if loose else self.claim):
            return Verdict.WRONG, f"breaks the laws of contact by {size:.0e}"
        if loose:
            return self._of_loose_answer(force, answer, past, motion)
        if answer is None or judge.same(force, answer, motion):
            return Verdict.RIGHT, ""
        near = force if size <= SHARP else judge.nearest_answer(force, past, motion)
        if near is not None and judge.same(near, force, motion):
            return Verdict.OTHER, "another answer obeys the laws as well"
        return Verdict.WRONG, "the laws nearly hold, but the sharp answer is elsewhere"

    def _of_loose_answer(
        self, force: Array, answer: Array | None, past: Past, motion: Motion
    ) -> tuple[Verdict, str]:
        """A regularised answer: its total force is held to its claim, its laws to ten times it."""
        if answer is not None and same_total(force, answer, self.claim):
            return Verdict.RIGHT, ""
        near = self.judge.nearest_answer(force, past, motion)
        if near is None:
            return Verdict.FAILED, "no sharp answer was found near it to judge it by"
        if not same_total(force, near, self.claim):
            return Verdict.WRONG, f"the total force is off by more than {self.claim:.0%}"
        return (Verdict.RIGHT if answer is None else Verdict.OTHER), ""


def run_case(case: Case, model: ReducedModel) -> list[CaseResult]:
    """The outcome of every method on one case."""
    problem = contact_problem(model, case.indenter, case.friction)
    judge = Judge(model, case.indenter, problem.law)
    stored: list[tuple[Past, Motion, Array | None]] = []
    steppers = [(PRODUCTION, _production(problem), _PRODUCTION_CLAIM)]
    if not case.under_force:
        steppers += [(rival.name, _rival(problem, rival), rival.claim) for rival in RIVALS]
    return [
        _follow(case, name, step, Trial(judge, claim, stored)) for name, step, claim in steppers
    ]


def run_production(case: Case, model: ReducedModel, law: FrictionLaw) -> CaseResult:
    """The outcome of the production solver on one case, under another law of friction."""
    problem = contact_problem(model, case.indenter, law)
    trial = Trial(Judge(model, case.indenter, law), _PRODUCTION_CLAIM, [])
    return _follow(case, PRODUCTION, _production(problem), trial)


def _production(problem: ContactProblem) -> Stepper:
    state, workspace = ContactState.untouched(problem), Workspace()

    endless = replace(problem, model=replace(problem.model, rim=np.zeros_like(problem.model.rim)))

    def step(row: Row) -> tuple[Array, Motion]:
        nonlocal state
        try:
            if isinstance(row, Forces):
                increment = solve_forces(problem, state, row, workspace)
            else:
                increment = solve_increment(problem, state, row, workspace)
        except ZoneExhausted as error:
            if isinstance(row, Forces):
                raise
            witness = solve_increment(endless, state, row).force
            raise Witnessed(str(error), witness) from error
        state = increment.state
        return increment.force, increment.motion

    return step


def _rival(problem: ContactProblem, rival: Rival) -> Stepper:
    """The rival with a friction history of its own, and the zone's check that all methods get."""
    m, dim = problem.shape
    slip, force = np.zeros((m, dim - 1)), np.zeros((m, dim))

    def step(row: Row) -> tuple[Array, Motion]:
        nonlocal slip, force
        if isinstance(row, Forces):
            raise SolverError("forces cannot be prescribed to this method")
        offset = problem.offset(row, slip)
        force = rival.solve(
            problem.compliance, offset, problem.friction_coefficient, force, _SECONDS - _GRACE
        )
        if (force[problem.model.rim, 0] > 1e-9 * np.abs(force).max()).any():
            raise ZoneExhausted("the contact reaches the end of the candidate zone")
        moved = (problem.compliance @ force.ravel()).reshape(m, dim) + offset
        slip = slip + moved[:, 1:]
        return problem.to_global(force), row

    return step


def _follow(case: Case, name: str, step: Stepper, trial: Trial) -> CaseResult:
    """One method along the case's rows, up to its first refusal or wrong answer."""
    judge = trial.judge
    past, worst, reason = judge.untouched(), Verdict.RIGHT, ""
    violation, confirmed, judged, spent = 0.0, 0, 0, 0.0
    for number, row in enumerate(case.rows):
        judged += 1
        start = time.process_time()
        found = _attempt(step, row)
        spent += time.process_time() - start
        if isinstance(found, Exception):
            verdict, why = trial.of_refusal(found, past, row, number < case.solvable)
        else:
            force, motion = found
            violation = max(violation, judge.violation(force, past, motion))
            verdict, why = trial.of_answer(found, past)
            if isinstance(row, Forces) and not judge.carries(force, row.normal, row.tangential):
                verdict, why = Verdict.WRONG, "the forces are not those prescribed"
            confirmed += verdict == Verdict.RIGHT and trial.second(past, motion) is not None
        if verdict.rank > worst.rank:
            worst, reason = verdict, f"{row}: {why}" if why else ""
        if isinstance(found, Exception) or verdict == Verdict.WRONG:
            break
        past = Past(*found)
    what = (case.body, case.group, case.family, case.friction, name, worst, reason)
    return CaseResult(*what, judged, len(case.rows), violation, confirmed, spent)


def _attempt(step: Stepper, row: Row) -> tuple[Array, Motion] | Exception:
    try:
        with time_limit(_SECONDS):
            return step(row)
    except Exception as error:  # a crash is a failure of the method, not of the map
        return error


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TimeIsUp in what takes more processor time; nothing is interrupted without POSIX."""
    if not hasattr(signal, "setitimer") or threading.current_thread() is not (
        threading.main_thread()
    ):
        yield
        return

    def ring(number: int, frame: FrameType | None) -> None:
        raise TimeIsUp

    before = signal.signal(signal.SIGPROF, ring)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)
