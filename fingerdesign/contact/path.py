"""A path of motions or forces, increment by increment (numpy only)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, solve_forces
from fingerdesign.contact.increment import Increment, Workspace, solve_increment
from fingerdesign.contact.measures import Measures, measure
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion


@dataclass(frozen=True)
class Step:
    """A solved increment and what it amounts to.

    areas (m,) mm^2 and displacement (n, dim) mm of the body's nodes: at finite strain, where areas
    are those of the deformed body and no displacement follows from the forces alone; else None.
    """

    increment: Increment
    measures: Measures
    areas: Array | None = None
    displacement: Array | None = None


def follow(
    problem: ContactProblem,
    path: Iterable[Motion | Forces],
    substeps: int = 1,
) -> Iterator[Step]:
    """Yield one Step per row of ``path``, from touch on, each from the last one's state.

    A row is the object's motion or the forces to reach. ``substeps`` cuts each row
    into equal increments, friction history moving with each; the last of them is yielded. Raises
    SolverError at the first row without an accepted answer.
    """
    if substeps < 1:
        raise ValueError(f"substeps = {substeps} must be at least 1")
    state, workspace = ContactState.untouched(problem), Workspace()
    for row in path:
        for target in _pieces(problem, state, row, substeps):
            if isinstance(target, Motion):
                increment = solve_increment(problem, state, target, workspace)
            else:
                increment = solve_forces(problem, state, target, workspace)
            state = increment.state
        yield Step(increment, measure(problem, increment))


def _pieces(
    problem: ContactProblem, state: ContactState, row: Motion | Forces, substeps: int
) -> list[Motion | Forces]:
    """Targets of a row's increments; the last one is the row itself, to the last digit."""
    shares = [part / substeps for part in range(1, substeps)]
    if isinstance(row, Motion):
        return [*(state.motion.toward(row, share) for share in shares), row]
    force = problem.model.total_force(problem.to_global(state.multiplier))
    now = Forces(-float(force[1]), float(force[0]), state.motion)
    return [*(now.toward(row, share) for share in shares), row]
