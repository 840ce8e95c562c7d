"""One row of the path at finite strain: Newton about the last tangent, contact solved in full.

Each iteration solves the contact problem of the linearised body (body.py) with the friction history
of the last row, then moves the body accordingly. The tangent is used again while it still reduces
the residual tenfold, and is computed again where it does not; far from the answer that is Newton's
method. Where an iteration fails, half of the way is gone first. That way carries the iterate alone:
the friction history moves once a row.
"""

from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, NoEquilibrium, solve_forces
from fingerdesign.contact.increment import Increment, Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion
from fingerdesign.errors import SolverError
from fingerdesign.fem.finite.body import Linearised
from fingerdesign.fem.finite.facing import Facing
from fingerdesign.runtime.threads import blas_libraries

# The largest nodal force out of balance, relative to the contact force.
_TOLERANCE = 1e-9
# The error of a curved object's gaps, relative to the motion; condensing leaves up to 1e-8.
_GAP = 1e-7
_LEAST = 1e-3  # N. Below it the contact force is no measure.
# A tangent is used again while each iteration leaves less than this fraction of the residual ...
_REUSE = 0.3
# ... and from this residual on; farther away a new one, three times as dear, brings far more.
_NEAR = 1e-4
_SAME_WAY = 0.5  # The least cosine between two motions of which one predicts the other.
_ITERATIONS = 25
_SHORTEST = 1.0 / 32.0  # The shortest piece of a row.


@dataclass(frozen=True)
class Past:
    """State after the last row.

    values (count,); force (m, dim) N in x, y(, z); relative motion rel (m, dim) mm; the object's
    motion; per node the way slid and the last slip (ContactState); before: values and motion of
    the answer before this one.
    """

    values: Array
    force: Array
    relative: Array
    motion: Motion
    travelled: Array
    sliding: Array
    before: tuple[Array, Motion] | None = None

    def ahead(self, target: Motion | Forces) -> Array:
        """Values (count,) to start from toward ``target``: onward as far as the motion goes on,
        where it goes on the same way; else those of this row."""
        if self.before is None or not isinstance(target, Motion):
            return self.values
        values, motion = self.before
        last = (self.motion.amplitudes - motion.amplitudes)[:4]
        now = (target.amplitudes - self.motion.amplitudes)[:4]
        along, size = float(now @ last), float(last @ last)
        if along <= _SAME_WAY * np.sqrt(size * float(now @ now)):
            return self.values
        return np.asarray(self.values + along / size * (self.values - values))

    def state(self, problem: ContactProblem, guess: Array) -> ContactState:
        """This past in a problem's own components, with forces (m, dim) N to start from."""
        slip = np.einsum("mab,mb->ma", problem.frames[:, 1:], self.relative)
        multiplier = np.einsum("mab,mb->ma", problem.frames, guess)
        motion = replace(self.motion, load=1.0)
        return ContactState(slip, multiplier, motion, self.travelled, self.sliding)


def untouched(facing: Facing) -> Past:
    """Before the first row."""
    m, dim = len(facing.body.at_rest.trace.nodes), facing.body.system.body.mesh.dimension
    values = facing.body.system.at_rest
    none = np.zeros((m, dim))
    return Past(values, none, none, Motion(0.0, 0.0), np.zeros(m), np.zeros(m))


@dataclass(frozen=True)
class Row:
    """A solved row: the increment that holds at ``values`` (count,), its problem, what comes after.

    iterations: all, those of pieces of the way among them; tangents: factorisations; residuals:
    largest nodal force out of balance over the contact force, after each of the last iterations.
    """

    increment: Increment
    problem: ContactProblem
    past: Past
    iterations: int
    tangents: int
    residuals: tuple[float, ...]


class Follower:
    """Solves rows one after the other.

    Each starts where the last two lead to, with the tangent there; thin plates that a step turns
    are far from that start, so where it leads nowhere the row starts from the last answer, and
    after that goes in halves.
    """

    def __init__(self, facing: Facing) -> None:
        self.facing = facing
        self._threads = blas_libraries()
        self._tangent: Linearised | None = None  # the last, in use or spent
        self._iterations = self._tangents = 0

    def row(self, past: Past, target: Motion | Forces) -> Row:
        """The row to ``target``. Raises ZoneExhausted, NoEquilibrium, or SolverError with the
        place on the way and the reason."""
        self._iterations = self._tangents = 0
        last, done, step = past, 0.0, 1.0
        while True:
            share = min(1.0, done + step)
            goal = _on_the_way(past, target, share, self.facing)
            try:
                found = self._newton(past, goal, last, last.ahead(goal))
            except (ZoneExhausted, NoEquilibrium):
                raise
            except SolverError as error:
                if last.before is not None:
                    last = replace(last, before=None)
                    continue
                step *= 0.5
                if step < _SHORTEST:
                    reason = str(error).replace(", load 1", "")
                    raise SolverError(
                        f"finite strain: no answer beyond {done:.0%} of the way to {target}: "
                        f"{reason}; use smaller increments or a finer mesh, or ask for less"
                    ) from error
                continue
            if share == 1.0:
                return found
            done, last = share, found.past

    def pieces(self, past: Past, target: Motion | Forces, ends: Array) -> list[Motion | Forces]:
        """Targets of a row's increments, between which friction history moves; ends: row_ends."""
        way = [_on_the_way(past, target, float(end), self.facing) for end in ends[:-1]]
        return [*way, target]

    def _newton(self, past: Past, target: Motion | Forces, last: Past, values: Array) -> Row:
        """Iterations from ``values``, where ``last`` was solved, with the history of ``past``."""
        facing, system = self.facing, self.facing.body.system
        motion, force, workspace = last.motion, last.force, Workspace()
        forces, residuals, renew = system.forces(values), [1.0], True
        before = last.values  # where the step to the present values began
        problem: ContactProblem | None = None
        for _ in range(_ITERATIONS):
            self._iterations += 1
            if renew or self._tangent is None:
                self._tangents += 1
                spent, self._tangent = self._tangent, None
                self._tangent = facing.body.linearised(values, before, spent)
                workspace, problem = Workspace(), None
            tangent = self._tangent
            free = tangent.response(-forces[system.free])
            offset = facing.body.contact_displacement(values + free)
            problem = facing.problem(tangent, values, motion, offset, problem)
            state = past.state(problem, force)
            with self._threads.limit(limits=1, user_api="blas"):  # small: threads would only wait
                if isinstance(target, Motion):
                    increment = solve_increment(problem, state, target, workspace)
                else:
                    state = replace(state, motion=motion)
                    increment = solve_forces(problem, state, target, workspace)
            force, motion = increment.force, increment.motion
            loads = facing.body.loads(force)
            before, values = values, values + free + tangent.response(loads)
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
                came = (last.values, last.motion)
                now = Past(values, force, relative, motion, after.travelled, after.sliding, came)
                residuals.append(residual)
                counts = self._iterations, self._tangents
                return Row(increment, problem, now, *counts, tuple(residuals[1:]))
            renew = residual > min(_REUSE * residuals[-1], _NEAR)
            residuals.append(residual)
        raise SolverError(
            f"the residual is {residual:.1e} of the contact force after {_ITERATIONS} iterations"
        )


def _on_the_way(
    past: Past, target: Motion | Forces, share: float, facing: Facing
) -> Motion | Forces:
    """Interpolate between the last row and its target, both motions or forces."""
    if isinstance(target, Motion):
        return replace(past.motion.toward(target, share) if share < 1.0 else target, load=1.0)
    if share < 1.0:
        factor = 2 if facing.body.system.body.mesh.symmetric else 1
        total = factor * past.force.sum(axis=0)
        target = Forces(-float(total[1]), float(total[0]), past.motion).toward(target, share)
    return replace(target, held=replace(target.held, load=1.0))
