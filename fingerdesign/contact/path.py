"""A path of motions, increment by increment (numpy only)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from fingerdesign.contact.increment import ContactState, Increment, Workspace, solve_increment
from fingerdesign.contact.measures import Measures, measure
from fingerdesign.contact.problem import ContactProblem, Motion


@dataclass(frozen=True)
class Step:
    """A solved increment and what it amounts to."""

    increment: Increment
    measures: Measures


def follow(
    problem: ContactProblem,
    motions: Iterable[Motion],
    state: ContactState | None = None,
    substeps: int = 1,
) -> Iterator[Step]:
    """Yield one Step per motion, each from the last one's state.

    ``substeps`` cuts each row into equal increments, friction history moving with each; the last of
    them is yielded. Raises SolverError at the first motion without an accepted answer.
    """
    state = ContactState.untouched(problem) if state is None else state
    workspace = Workspace()
    for motion in motions:
        before = state.motion
        for part in range(1, substeps + 1):
            # The last one to the last digit.
            target = before.toward(motion, part / substeps) if part < substeps else motion
            increment = solve_increment(problem, state, target, workspace)
            state = increment.state
        yield Step(increment, measure(problem, increment))
