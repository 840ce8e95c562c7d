"""One case of the stability map through each method, increment by increment, and its verdict."""

from __future__ import annotations

import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from enum import StrEnum
from types import FrameType

import numpy as np
from numpy.typing import NDArray

from fingerdesign.bench.rivals import RIVALS, Rival
from fingerdesign.bench.stability_cases import Case
from fingerdesign.bench.stability_judge import LOOSE, SHARP, Judge, Past, same_total
from fingerdesign.contact.increment import ContactState, Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.problem import ContactProblem, Motion, contact_problem
from fingerdesign.errors import SolverError
from fingerdesign.reduced import ReducedModel

Array = NDArray[np.float64]

PRODUCTION = "production"
METHODS = (PRODUCTION, *(rival.name for rival in RIVALS))
_PRODUCTION_CLAIM = 1e-7
_SECONDS = 5.0  # for one increment; then the method counts as hanging
_GRACE = 2.0  # a rival ends itself before it is ended


class Verdict(StrEnum):
    """From best to worst."""

    RIGHT = "right"
    OTHER = "right, not unique"
    REFUSED = "refused rightly"
    FAILED = "failed"
    HANG = "hang"
    WRONG = "wrong"


_ORDER = list(Verdict)


@dataclass(frozen=True)
class Outcome:
    """How a method did on a case: the worst verdict over its increments, at which it ends."""

    body: str
    group: str
    family: str
    friction: float
    method: str
    verdict: Verdict
    reason: str
    increments: int  # judged, of ``asked``
    asked: int
    violation: float  # the worst of its accepted answers
    confirmed: int  # increments at which a second method gave the same answer
    seconds: float


class TimeIsUp(Exception):
    """An increment took longer than its limit."""


# A step of a path: forces (m, dim) N in global axes after a motion. Raises SolverError.
Stepper = Callable[[Motion], Array]


def run_case(case: Case, model: ReducedModel) -> list[Outcome]:
    """The outcome of every method on one case."""
    problem = contact_problem(model, case.indenter, case.friction)
    judge = Judge(model, case.indenter, case.friction)
    second = _SecondAnswers(judge)
    steppers = [(PRODUCTION, _production(problem), _PRODUCTION_CLAIM)]
    steppers += [(rival.name, _rival(problem, rival), rival.claim) for rival in RIVALS]
    return [_follow(case, *each, judge, second) for each in steppers]


def _production(problem: ContactProblem) -> Stepper:
    state, workspace = ContactState.untouched(problem), Workspace()

    def step(motion: Motion) -> Array:
        nonlocal state
        increment = solve_increment(problem, state, motion, workspace)
        state = increment.state
        return increment.force

    return step


def _rival(problem: ContactProblem, rival: Rival) -> Stepper:
    """The rival with a friction history of its own, and the zone's check that all methods get."""
    m, dim = problem.shape
    slip, force = np.zeros((m, dim - 1)), np.zeros((m, dim))

    def step(motion: Motion) -> Array:
        nonlocal slip, force
        offset = problem.offset(motion, slip)
        force = rival.solve(
            problem.compliance, offset, problem.friction_coefficient, force, _SECONDS - _GRACE
        )
        if (force[problem.model.rim, 0] > 1e-9 * np.abs(force).max()).any():
            raise ZoneExhausted("the contact reaches the end of the candidate zone")
        moved = (problem.compliance @ force.ravel()).reshape(m, dim) + offset
        slip = slip + moved[:, 1:]
        return problem.to_global(force)

    return step


class _SecondAnswers:
    """Second answers of one case, kept for methods whose past is the same."""

    def __init__(self, judge: Judge) -> None:
        self._judge = judge
        self._kept: list[tuple[Past, Motion, Array | None]] = []

    def to(self, past: Past, motion: Motion) -> Array | None:
        for kept, moved, answer in self._kept:
            if moved == motion and kept.motion == past.motion:
                scale = float(np.abs(kept.force).max())
                if float(np.abs(kept.force - past.force).max()) <= 1e-12 * scale:
                    return answer
        answer = self._judge.second_answer(past, motion)
        self._kept.append((past, motion, answer))
        return answer


def _follow(
    case: Case, name: str, step: Stepper, claim: float, judge: Judge, second: _SecondAnswers
) -> Outcome:
    past, worst, reason = judge.untouched(), Verdict.RIGHT, ""
    violation, confirmed, judged, spent = 0.0, 0, 0, 0.0
    for motion in case.motions:
        judged += 1
        start = time.perf_counter()
        try:
            with time_limit(_SECONDS):
                force = step(motion)
        except TimeIsUp:
            verdict, why = Verdict.HANG, f"no answer in {_SECONDS:g} s"
            force = None
        except ZoneExhausted as error:
            answer = second.to(past, motion)
            rightly = answer is not None and judge.at_rim(answer)
            verdict = Verdict.REFUSED if rightly else Verdict.FAILED
            why, force = f"zone exhausted: {error}", None
        except SolverError as error:
            verdict, why, force = Verdict.FAILED, str(error), None
        except Exception as error:  # a crash is a failure of the method, not of the map
            verdict, why, force = Verdict.FAILED, f"{type(error).__name__}: {error}", None
        spent += time.perf_counter() - start
        if force is not None:
            answer = second.to(past, motion)
            size = judge.violation(force, past, motion)
            violation = max(violation, size)
            verdict, why = _of_answer(judge, force, answer, size, claim, past, motion)
            confirmed += verdict == Verdict.RIGHT and answer is not None
        if _ORDER.index(verdict) > _ORDER.index(worst):
            worst, reason = verdict, f"{motion}: {why}" if why else ""
        if force is None or verdict == Verdict.WRONG:
            break
        past = Past(force, motion)
    return Outcome(
        case.body,
        case.group,
        case.family,
        case.friction,
        name,
        worst,
        reason,
        judged,
        len(case.motions),
        violation,
        confirmed,
        spent,
    )


def _of_answer(
    judge: Judge,
    force: Array,
    answer: Array | None,
    size: float,
    claim: float,
    past: Past,
    motion: Motion,
) -> tuple[Verdict, str]:
    """Right, right but not unique, or wrong, with the reason."""
    if judge.at_rim(force):
        return Verdict.WRONG, "answered although the candidate zone is exhausted"
    if claim >= LOOSE:
        return _of_loose_answer(judge, force, answer, size, claim, past, motion)
    if size > claim:
        return Verdict.WRONG, f"breaks the laws of contact by {size:.0e}"
    if answer is None or judge.same(force, answer, motion):
        return Verdict.RIGHT, ""
    if size <= SHARP:
        return Verdict.OTHER, "another answer obeys the laws as well"
    near = judge.nearest_answer(force, past, motion)
    if near is not None and judge.same(near, force, motion):
        return Verdict.OTHER, "another answer obeys the laws as well"
    return Verdict.WRONG, "the laws nearly hold, but the sharp answer is elsewhere"


def _of_loose_answer(
    judge: Judge,
    force: Array,
    answer: Array | None,
    size: float,
    claim: float,
    past: Past,
    motion: Motion,
) -> tuple[Verdict, str]:
    """A regularised answer: its total force is held to its claim, its laws to ten times that."""
    if size > 10.0 * claim:
        return Verdict.WRONG, f"breaks the laws of contact by {size:.0e}"
    if answer is not None and same_total(force, answer, claim):
        return Verdict.RIGHT, ""
    near = judge.nearest_answer(force, past, motion)
    if near is None:
        return Verdict.FAILED, "no sharp answer was found near it to judge it by"
    if not same_total(force, near, claim):
        return Verdict.WRONG, f"the total force is off by more than {claim:.0%}"
    return (Verdict.RIGHT if answer is None else Verdict.OTHER), ""


@contextmanager
def time_limit(seconds: float) -> Iterator[None]:
    """Raise TimeIsUp in what takes longer; without POSIX signals nothing is interrupted."""
    if not hasattr(signal, "setitimer") or threading.current_thread() is not (
        threading.main_thread()
    ):
        yield
        return

    def ring(number: int, frame: FrameType | None) -> None:
        raise TimeIsUp

    before = signal.signal(signal.SIGALRM, ring)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, before)
