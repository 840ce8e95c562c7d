"""A path of motions or forces, increment by increment (numpy only)."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import TOLERANCE, Forces, solve_forces
from fingerdesign.contact.increment import Increment, Workspace, solve_increment
from fingerdesign.contact.laws import lengths
from fingerdesign.contact.measures import Measures, measure
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion

# Increments of a row, chosen by measurement (docs/explanation/accuracy.md): with these the stick
# ratio is within 0.01, F_t within 1 % and most gages within 0.5 % of 64 equal increments a row.
_FIRST = 20  # Of a row that begins without contact: F_t is off by a part of 1 / _FIRST of itself.
_LATER = 8  # Of any other row.
# The last increment's length, in those of the longest: in it nodes close, and slip, too late.
_LAST = 0.3
# Relative to the normal force: forces inside a row only lead to its end, which is met exactly.
_ON_THE_WAY = 0.03


@dataclass(frozen=True)
class Step:
    """A solved increment and what it amounts to.

    areas (m,) mm^2 and displacement (n, dim) mm of the body's nodes: at finite strain, where areas
    are those of the deformed body and no displacement follows from the forces alone; else None.
    before: the state that the increment starts from, and row: all increments of the row, the last
    one being ``increment``; at small strain.
    """

    increment: Increment
    measures: Measures
    areas: Array | None = None
    displacement: Array | None = None
    before: ContactState | None = None
    row: tuple[Increment, ...] = ()


def follow(
    problem: ContactProblem,
    path: Iterable[Motion | Forces],
    substeps: int | None = 1,
    coarser: int = 1,
) -> Iterator[Step]:
    """Yield one Step per row of ``path``, from touch on, each from the last one's state.

    A row is the object's motion or the forces to reach. ``substeps`` and ``coarser`` cut each row
    into increments (:func:`row_ends`), friction history moving with each; the last of them is
    yielded. Raises SolverError at the first row without an accepted answer.
    """
    if substeps is not None and substeps < 1:
        raise ValueError(f"substeps = {substeps} must be at least 1")
    state, workspace = ContactState.untouched(problem), Workspace()
    for row in path:
        ends = row_ends(substeps, bool((state.multiplier[:, 0] > 0.0).any()), coarser)
        solved: list[Increment] = []
        for number, target in enumerate(_pieces(problem, state, row, ends)):
            before = state
            if isinstance(target, Motion):
                increment = solve_increment(problem, before, target, workspace)
            else:
                exact = target is row or substeps is not None
                tolerance = TOLERANCE if exact else _ON_THE_WAY
                increment = solve_forces(problem, before, target, workspace, tolerance)
            if number:
                increment = with_slip_of_row(increment, before.sliding)
                workspace.record(before, increment.state)
            state = increment.state
            solved.append(increment)
        yield Step(increment, measure(problem, increment), before=before, row=tuple(solved))


def row_ends(substeps: int | None, touching: bool = True, coarser: int = 1) -> Array:
    """Ends of a row's increments, as parts of the row; the last is 1.

    ``substeps`` equal ones, or where that is None so many as a small error needs. A contact grows
    with about the root of the motion: without contact the first increments are short. coarser:
    divides the number of increments.

    >>> row_ends(4).tolist()
    [0.25, 0.5, 0.75, 1.0]
    >>> row_ends(None, touching=False, coarser=5).round(2).tolist()
    [0.1, 0.38, 0.86, 1.0]
    """
    if substeps is not None:
        sizes = np.ones(max(1, substeps // coarser))
    elif touching:
        sizes = np.linspace(1.0, _LAST, _LATER // coarser)
    else:
        count = _FIRST // coarser
        half = count // 2
        sizes = np.minimum(2.0 * np.arange(count) + 1.0, 2.0 * half + 1.0)
        sizes[half:] *= np.linspace(1.0, _LAST, count - half)
    ends = np.cumsum(sizes)
    return np.asarray(ends / ends[-1])


def with_slip_of_row(increment: Increment, slid: Array) -> Increment:
    """The increment, its nodes' slip counted from the row's first increment on.

    slid (m,): the same of the increment before, 0 at nodes that did not slide.
    The border of stick is found by that slip (measures.py): of a shorter increment it is shorter,
    and the border would move with the number of increments.
    """
    state = increment.state
    slid = np.where(state.sliding > 0.0, slid + lengths(increment.slip_increment), 0.0)
    return replace(increment, state=replace(state, sliding=slid))


def _pieces(
    problem: ContactProblem, state: ContactState, row: Motion | Forces, ends: Array
) -> list[Motion | Forces]:
    """Targets of a row's increments; the last one is the row itself, to the last digit."""
    if isinstance(row, Motion):
        return [*(state.motion.toward(row, float(end)) for end in ends[:-1]), row]
    normal, pulled = problem.resultant(problem.to_global(state.multiplier)).tolist()
    now = Forces(normal, pulled, state.motion)
    return [*(now.toward(row, float(end)) for end in ends[:-1]), row]
