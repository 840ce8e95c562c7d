"""One row of the path at finite strain: Newton about the last tangent, contact solved in full.

Each iteration solves the contact problem of the linearised body (fem.finite_body, facing.py) with
the friction history of the last row, and moves the body by what it says. The tangent is kept while
it still brings the residual down tenfold, and taken anew where it does not: far from the answer
that is Newton's method. Where an iteration fails, half of the way is gone first; that way carries
the iterate alone: friction history moves once a row.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, NoEquilibrium, solve_forces
from fingerdesign.contact.increment import (
    Increment,
    Workspace,
    ZoneExhausted,
    solve_increment,
)
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.errors import SolverError
from fingerdesign.fem.finite_body import Linearised
from fingerdesign.finite.facing import Facing, Past

_TOLERANCE = 1e-9  # of the contact force: the largest nodal force out of balance
_GAP = 1e-7  # of the motion: error of a curved object's gaps (condensing leaves up to 1e-8)
_LEAST = 1e-3  # N: below it the contact force is no measure
_KEEP = 0.1  # a tangent is kept while each iteration leaves less of the residual
_ITERATIONS = 25
_SHORTEST = 1.0 / 32.0  # of a row


@dataclass(frozen=True)
class Row:
    """A solved row: the increment that holds at ``values`` (count,), its problem, what comes after.

    iterations: all, those of pieces of the way among them; tangents: factorisations; residual:
    largest nodal force out of balance over the contact force.
    """

    increment: Increment
    problem: ContactProblem
    past: Past
    iterations: int
    tangents: int
    residual: float


class Follower:
    """Rows one after the other; keeps the last tangent, which saves time and changes no answer."""

    def __init__(self, facing: Facing) -> None:
        from threadpoolctl import ThreadpoolController

        self.facing = facing
        self._threads = ThreadpoolController()
        self._tangent: Linearised | None = None
        self._iterations = self._tangents = 0

    def row(self, past: Past, target: Motion | Forces) -> Row:
        """The row to ``target``. Raises ZoneExhausted, NoEquilibrium, or SolverError that says
        where on the way and why."""
        self._iterations = self._tangents = 0
        last, done, step = past, 0.0, 1.0
        while True:
            share = min(1.0, done + step)
            kept = self._tangent is not None
            try:
                found = self._newton(past, _on_the_way(past, target, share, self.facing), last)
            except (ZoneExhausted, NoEquilibrium):
                raise
            except SolverError as error:
                self._tangent = None
                if kept:
                    continue  # an old tangent may be all that was wrong
                step *= 0.5
                if step < _SHORTEST:
                    raise _no_answer(target, done, error) from error
                continue
            if share == 1.0:
                return found
            done, last = share, found.past

    def pieces(self, past: Past, target: Motion | Forces, substeps: int) -> list[Motion | Forces]:
        """Targets of a row's increments, between which friction history moves."""
        shares = [part / substeps for part in range(1, substeps)]
        return [*(_on_the_way(past, target, share, self.facing) for share in shares), target]

    def _newton(self, past: Past, target: Motion | Forces, last: Past) -> Row:
        """Iterations from where ``last`` is, with the history of ``past``."""
        facing, system = self.facing, self.facing.body.system
        values, motion, force, workspace = last.values, last.motion, last.force, Workspace()
        forces, left = system.forces(values), 1.0
        before: Array | None = None  # values where the step to the present ones began
        for _ in range(_ITERATIONS):
            self._iterations += 1
            if self._tangent is None:
                self._tangents += 1
                self._tangent, workspace = facing.body.linearised(values, before), Workspace()
            tangent = self._tangent
            free = tangent.answer(-forces[system.free])
            offset = facing.body.contact_displacement(values + free)
            problem = facing.problem(tangent, values, motion, offset)
            state = past.state(problem, force)
            with self._threads.limit(limits=1, user_api="blas"):  # small: threads would only wait
                if isinstance(target, Motion):
                    increment = solve_increment(problem, state, target, workspace)
                else:
                    state = replace(state, motion=motion)
                    increment = solve_forces(problem, state, target, workspace)
            force, motion = increment.force, increment.motion
            loads = facing.body.loads(force)
            before, values = values, values + free + tangent.answer(loads)
            forces = system.forces(values)
            residual = float(np.abs(loads - forces[system.free]).max())
            residual /= max(float(np.abs(force).sum() + np.abs(past.force).sum()), _LEAST)
            if not np.isfinite(residual):
                raise SolverError("an iteration led to forces that are no numbers")
            relative = facing.relative(values, motion)
            off = float(np.abs(facing.gap(values, motion) - increment.gap).max())
            moved = max(float(np.abs(relative).max()), float(np.abs(past.relative).max()))
            if residual <= _TOLERANCE and off <= _GAP * moved:
                after = increment.state
                now = Past(values, force, relative, motion, after.travelled, after.sliding)
                return Row(increment, problem, now, self._iterations, self._tangents, residual)
            if residual > _KEEP * left:
                self._tangent = None
            left = residual
        raise SolverError(
            f"the residual is {residual:.1e} of the contact force after {_ITERATIONS} iterations"
        )


def _on_the_way(
    past: Past, target: Motion | Forces, share: float, facing: Facing
) -> Motion | Forces:
    """What lies ``share`` of the way from the last row to its target, both motions or forces."""
    if isinstance(target, Motion):
        return replace(past.motion.toward(target, share) if share < 1.0 else target, load=1.0)
    if share < 1.0:
        factor = 2 if facing.body.system.body.mesh.symmetric else 1
        total = factor * past.force.sum(axis=0)
        target = Forces(-float(total[1]), float(total[0]), past.motion).toward(target, share)
    return replace(target, held=replace(target.held, load=1.0))


def _no_answer(target: Motion | Forces, done: float, error: SolverError) -> SolverError:
    reason = str(error).replace(", load 1", "")
    return SolverError(
        f"finite strain: no answer beyond {done:.0%} of the way to {target}: {reason}; use smaller "
        "increments or a finer mesh, or ask for less"
    )
