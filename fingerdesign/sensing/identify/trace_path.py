"""The path of a recorded trace, thinned to one increment a point, and played on a model.

Rows that move stay (of very many every k-th), rows at rest are gathered into bins whose widths grow
with the time since the last move: a tenth of it, so that what relaxes hardly bends within one.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.contact.history import FrictionHistory
from fingerdesign.contact.increment import solve_increment
from fingerdesign.contact.memory import Rubber, RubberHistory
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.signals import gage_readings
from fingerdesign.control.trace import Trace

MOST_MOVES = 100  # Of a longer trace only every k-th moving row is played.
_BIN = 0.1  # The width of a bin over the time at rest so far.


@dataclass(frozen=True)
class TracePath:
    """k points of a trace: time (k,) s, approach and shear (k,) mm as the stage reports them,
    forces (k, 2) N (F_n, F_t), readings (k, g) microstrain, temperature (k,) K or None; samples
    (k,): the number of rows whose mean each point is."""

    time: Array
    approach: Array
    shear: Array
    forces: Array
    readings: Array
    samples: Array
    temperature: Array | None = None

    @classmethod
    def every(cls, trace: Trace) -> Self:
        """Every row of a trace."""
        return cls(
            time=trace.time,
            approach=np.cumsum(trace.dy),
            shear=np.cumsum(trace.dx),
            forces=np.column_stack([trace.normal_force, trace.tangential_force]),
            readings=trace.readings,
            samples=np.ones(len(trace)),
            temperature=trace.temperature,
        )

    @classmethod
    def of(cls, trace: Trace) -> Self:
        """The points of a trace."""
        whole, points = cls.every(trace), Points(trace)
        heated = whole.temperature
        return cls(
            time=points.mean(whole.time),
            approach=whole.approach[points.last],
            shear=whole.shear[points.last],
            forces=points.mean(whole.forces),
            readings=points.mean(whole.readings),
            samples=points.weight[points.compared].astype(float),
            temperature=None if heated is None else points.mean(heated),
        )

    @property
    def steps(self) -> Array:
        """Seconds (k,) since the point before; of the first as of the second."""
        return np.diff(self.time, prepend=2.0 * self.time[0] - self.time[1])

    @property
    def rest(self) -> float:
        """The longest time without a move, s."""
        still = (np.diff(self.approach) == 0.0) & (np.diff(self.shear) == 0.0)
        longest = since = 0.0
        for step, rests in zip(np.diff(self.time), still, strict=True):
            since = since + float(step) if rests else 0.0
            longest = max(longest, since)
        return longest


class Points:
    """Which rows (n,) of a trace make which points: bins (n,) numbers, weight: rows of each,
    compared: numbers of those that are compared, last: their last rows."""

    def __init__(self, trace: Trace) -> None:
        moved = (trace.dx != 0.0) | (trace.dy != 0.0)
        self.bins = _bins(moved)
        self.weight = np.bincount(self.bins)
        last = np.cumsum(self.weight) - 1
        chosen, moving = np.ones(len(last), dtype=bool), np.flatnonzero(moved[last])
        if len(moving) > MOST_MOVES:
            chosen[moving] = False
            every = np.linspace(0, len(moving) - 1, MOST_MOVES).round().astype(int)
            chosen[moving[every]] = True
        self.compared, self.last = np.flatnonzero(chosen), last[chosen]

    def mean(self, values: Array) -> Array:
        """The means of values (n, ...) over the rows of each point that is compared."""
        columns = values.reshape(len(values), -1).T
        sums = np.array([np.bincount(self.bins, column) for column in columns]).T
        found = (sums / self.weight[:, None]).reshape(-1, *values.shape[1:])
        return np.asarray(found[self.compared])


def _bins(moved: Array) -> IntArray:
    """A number for each row, the same in rows at rest that are gathered."""
    found, number, rested, left = [], -1, 0, 0
    for moves in moved:
        if moves or left == 0:
            number += 1
            rested = 0 if moves else rested
            left = 0 if moves else max(1, int(_BIN * rested))
        if not moves:
            rested, left = rested + 1, left - 1
        found.append(number)
    return np.array(found, dtype=np.int64)


def played(
    problem: ContactProblem,
    face: str,
    path: TracePath,
    memory: Sequence[tuple[float, float]] = (),
    touch: float = 0.0,
) -> Array:
    """Play a path on the model, (k, 2 + g): F_n and F_t in N, readings in microstrain.

    memory: shares and times (s) of the rubber's Prony series; touch: mm by which the surface is met
    before the stage says 0. Raises SolverError where an increment has no answer.
    """
    history, found = FrictionHistory(problem), []
    shares, times = (tuple(each) for each in zip(*memory, strict=True)) if memory else ((), ())
    remembered: RubberHistory | None = None
    for approach, shear, step in zip(path.approach + touch, path.shear, path.steps, strict=True):
        factor = 1.0
        if memory:
            rubber = Rubber(shares, times, float(step))
            if remembered is None:
                remembered = RubberHistory(rubber, problem)
            remembered.rubber, factor = rubber, rubber.relaxation_factor
            history.displace(remembered.lag)
        motion = replace(history.state.motion, approach=float(approach), shear=float(shear))
        increment = solve_increment(history.problem, history.state, motion, history.workspace)
        history.accept(increment)
        if remembered is not None:
            remembered.record(increment.multiplier)
        force = problem.model.total_force(increment.force)
        readings = gage_readings(problem.model.gage_strain(increment.force), face)
        found.append(factor * np.array([-force[1], force[0], *readings]))
    return np.array(found)
