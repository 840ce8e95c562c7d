"""One row of the path at finite strain: Newton about the last tangent, contact solved in full.

Each iteration solves the contact problem of the linearised body (body.py) with
the friction history of the last row, and moves the body by what it says. The tangent is kept while
it still brings the residual down tenfold, and taken anew where it does not: far from the answer
that is Newton's method. Where an iteration fails, half of the way is gone first; that way carries
the iterate alone: friction history moves once a row.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces, NoEquilibrium, solve_forces
from fingerdesign.contact.increment import Increment, Workspace, ZoneExhausted, solve_increment
from fingerdesign.contact.problem import ContactProblem, ContactState, Motion, contact_problem
from fingerdesign.design.gages import Gages
from fingerdesign.errors import SolverError
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.finite.body import FiniteBody, Linearised
from fingerdesign.fem.readout import gage_crossing, gage_heights, pairing, plate_displacements
from fingerdesign.fem.trace import TRACE_ORDER
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mesh.types import Mesh
from fingerdesign.shapes.objects import Indenter

# What a gage reads at finite strain: how much longer its own lines on the plate have become.
#
#     strain = mean over the lines of (length now / length at rest) - 1
#
# for lines between the gage's two ends on the plate's face, spread over its width; along a bent
# plate a line is a chain of chords. Strain across the plate is that of lines across it. A turned
# plate reads nothing. To first order this is the small-strain reading of
# :func:`fingerdesign.fem.readout.gage_rows` (of a bent plate to 1e-6 of it: chords for arcs).

_CHORDS = 12  # of a bent plate's line


@dataclass(frozen=True)
class _Lines:
    """Lines (g, k, chords + 1) of points on the plates' faces, along them or across.

    places (g k p, dim) mm at rest; rows (g k p dim, n dim): their displacements; weights (k,):
    what a gage's lines count in its reading; shape (g, k, p), g = 2 plates: upper, lower of each.
    """

    places: Array
    rows: sp.csr_matrix
    weights: Array
    shape: tuple[int, int, int]

    def strains(self, displacement: Array) -> Array:
        """Weighted strains (g,) at nodal displacements (n, dim), mm."""
        return self.elongation(np.asarray(self.rows @ displacement.ravel()))

    def elongation(self, moved: Array) -> Array:
        """Weighted strains (g,) where the lines' points have moved by ``moved``, mm."""
        moved = moved.reshape(self.places.shape)
        start = np.diff(self.places.reshape(*self.shape, self.places.shape[1]), axis=2)
        change = np.diff(moved.reshape(*self.shape, self.places.shape[1]), axis=2)
        before = np.linalg.norm(start, axis=-1)
        # |a + b| - |a| without a difference of nearly equal numbers
        after = np.linalg.norm(start + change, axis=-1)
        longer = np.sum(change * (2.0 * start + change), axis=-1) / (after + before)
        strain = longer.sum(axis=2) / before.sum(axis=2)
        return np.asarray(strain @ self.weights)


@dataclass(frozen=True)
class GageLines:
    """All lines whose strains add up to the plates' readings; pairs: see readout.pairing."""

    parts: tuple[_Lines, ...]
    pairs: sp.csr_matrix | None

    def strains(self, displacement: Array) -> Array:
        """Plain readings (plates, 2), upper and lower, at nodal displacements (n, dim), mm."""
        found = sum(part.strains(displacement) for part in self.parts)
        return np.asarray(found if self.pairs is None else self.pairs @ found).reshape(-1, 2)


def gage_lines(
    mesh: Mesh, frames: Sequence[PlateFrame], gages: Gages, weights: tuple[float, float]
) -> GageLines:
    """The lines of all plates' gages; weights: of strain along and across the plates. Raises
    SolverError for plates that are modelled as sheets."""
    if any(name.startswith("plate_") for name in mesh.facets):
        raise SolverError(
            'plates.model = "sheet": finite strain reads gages on solid plates; '
            'set plates.model = "solid"'
        )
    solid = mesh.dimension == 3
    offsets, heights = gage_heights(gages) if solid else (np.zeros(1), np.ones(1))
    pieces = 1 if all(frame.bend_radius is None for frame in frames) else _CHORDS
    along, across = [], []
    for frame in frames:
        for v in (0.5 * frame.thickness, -0.5 * frame.thickness):
            line = _line(frame, gages.length_mm, v, pieces)
            at = frame.middle + offsets
            along.append(np.array([frame.to_space(line, z) for z in at] if solid else [line]))
            across.append(gage_crossing(frame, gages, v)[0].swapaxes(0, 1))
    parts = [_lines(mesh, frames, along, weights[0] * heights)]
    if solid and weights[1] != 0.0 and frames:
        shares = gage_crossing(frames[0], gages, 0.0)[1]
        parts.append(_lines(mesh, frames, across, weights[1] * shares))
    return GageLines(tuple(parts), pairing(frames, gages))


def _lines(
    mesh: Mesh, frames: Sequence[PlateFrame], places: Sequence[Array], weights: Array
) -> _Lines:
    """Lines of points (k, p, dim), one array a face of each plate."""
    rows = [sp.csr_matrix((0, mesh.points.size))]
    for number, lines in enumerate(places):
        flat = lines.reshape(-1, mesh.dimension)
        rows.append(plate_displacements(mesh, frames[number // 2], flat, 0.0))
    points = np.array(places).reshape(-1, mesh.dimension)
    count = points.shape[0] // max(len(places) * len(weights), 1)
    shape = (len(places), len(weights), count)
    return _Lines(points, sp.vstack(rows, format="csr"), weights, shape)


def _line(frame: PlateFrame, length: float, v: float, pieces: int) -> Array:
    """Points (pieces + 1, 2) of a gage of ``length`` mm on the face at ``v``, in its section."""
    if frame.bend_radius is not None:  # s is measured along the mid-surface
        length *= frame.bend_radius / (frame.bend_radius + v)
    return frame.from_local(np.linspace(-0.5, 0.5, pieces + 1) * length, v)


# A deformed finger faces a rigid object: the contact problem about where both are now.
#
# With rel = u - U the motion of a point of the finger relative to the object (U the object's own),
# the object is left where it stood, and the finger's points are at X + rel:
#
#     gap = mean of distance(X + rel) + n . (change of rel),      slip = t . (rel - rel of last row)
#
# n the object's normal where the finger is now. For a plane this is exact at once; about a cylinder
# or a sphere it becomes so as the iteration ends (``gap_error``).


@dataclass(frozen=True)
class Facing:
    """A finger and the object it faces; rows (q dim, n dim): displacements at the points on the
    exact surface where gaps are measured."""

    body: FiniteBody
    rigid: Indenter
    friction_coefficient: float
    rows: sp.csr_matrix

    def relative(self, values: Array, motion: Motion) -> Array:
        """rel (m, dim) mm of the contact nodes; zero where they have no motion of their own."""
        moved = self.body.contact_displacement(values)
        moved -= _shift(motion, moved.shape[1])
        body = self.body.system.body
        moved[body.fixed.reshape(body.mesh.points.shape)[self.body.at_rest.trace.nodes]] = 0.0
        return moved

    def gap(self, values: Array, motion: Motion) -> Array:
        """Gaps (m,) mm, true to the object's shape."""
        trace = self.body.at_rest.trace
        return trace.surface.mean(
            self.rigid.distance(self._points(values, motion)), len(trace.nodes)
        )

    def problem(
        self,
        tangent: Linearised,
        values: Array,
        motion: Motion,
        offset: Array,
        like: ContactProblem | None = None,
    ) -> ContactProblem:
        """The contact problem about ``values`` and the object at ``motion``; offset (m, dim) mm:
        contact displacements that the tangent gives at no force; like: the last one on it."""
        model = tangent.model(offset)
        relative = self.relative(values, motion)
        surface = replace(model.surface, points=self._points(values, motion))
        there = replace(model, points=model.points + relative, surface=surface)
        problem = contact_problem(there, self.rigid, self.friction_coefficient, like=like)
        gap0 = problem.gap0 - np.sum(problem.frames[:, 0] * relative, axis=1)
        return replace(problem, model=model, gap0=gap0)

    def _points(self, values: Array, motion: Motion) -> Array:
        points = self.body.at_rest.trace.surface.points
        size = self.body.system.body.mesh.points.size
        moved = np.asarray(self.rows @ values[:size]).reshape(points.shape)
        return np.asarray(points + moved - _shift(motion, points.shape[1]))


@dataclass(frozen=True)
class Past:
    """What the last row left: values (count,), contact forces (m, dim) N in x, y(, z), rel (m, dim)
    mm, the object's motion, and per node the way slid and the last slip (ContactState); before:
    values and motion of the answer before this one."""

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


def facing(body: FiniteBody, rigid: Indenter, friction_coefficient: float) -> Facing:
    """The finger facing ``rigid``, which stands where it first touches the finger at rest."""
    mesh, facets = body.system.body.mesh, body.system.body.contact
    dim = mesh.dimension
    table = tabulate(dim - 1, quadrature(dim - 1, TRACE_ORDER)[0])
    count = table.value.shape[1]
    row = np.arange(len(facets) * count).reshape(len(facets), count)
    value = np.broadcast_to(table.value, (len(facets), *table.value.shape))
    rows = np.broadcast_to(row[:, None, :], value.shape)
    columns = np.broadcast_to(facets[:, :, None], value.shape)
    entries = (value.ravel(), (rows.ravel(), columns.ravel()))
    scalar = sp.csr_matrix(entries, shape=(row.size, len(mesh.points)))
    return Facing(body, rigid, friction_coefficient, sp.kron(scalar, sp.identity(dim), "csr"))


def _shift(motion: Motion, dim: int) -> Array:
    """The object's own displacement U (dim,), mm."""
    return np.array([motion.shear, -motion.approach, motion.shear_z])[:dim]


_TOLERANCE = 1e-9  # of the contact force: the largest nodal force out of balance
_GAP = 1e-7  # of the motion: error of a curved object's gaps (condensing leaves up to 1e-8)
_LEAST = 1e-3  # N: below it the contact force is no measure
_KEEP = 0.3  # a tangent is kept while each iteration leaves less of the residual,
_NEAR = 1e-4  # from this residual on: farther away a new one, thrice as dear, brings far more
_SAME_WAY = 0.5  # cosine between two motions of which one foretells the other
_ITERATIONS = 25
_SHORTEST = 1.0 / 32.0  # of a row


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
    """Rows one after the other.

    Each starts where the last two lead to, with the tangent there; thin plates that a step turns
    are far from that start, so where it leads nowhere the row starts from the last answer, and
    after that goes in halves.
    """

    def __init__(self, facing: Facing) -> None:
        from threadpoolctl import ThreadpoolController

        self.facing = facing
        self._threads = ThreadpoolController()
        self._tangent: Linearised | None = None  # the last, in use or spent
        self._iterations = self._tangents = 0

    def row(self, past: Past, target: Motion | Forces) -> Row:
        """The row to ``target``. Raises ZoneExhausted, NoEquilibrium, or SolverError that says
        where on the way and why."""
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

    def pieces(self, past: Past, target: Motion | Forces, substeps: int) -> list[Motion | Forces]:
        """Targets of a row's increments, between which friction history moves."""
        shares = [part / substeps for part in range(1, substeps)]
        return [*(_on_the_way(past, target, share, self.facing) for share in shares), target]

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
            free = tangent.answer(-forces[system.free])
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
                came = (last.values, last.motion)
                now = Past(values, force, relative, motion, after.travelled, after.sliding, came)
                residuals.append(residual)
                counts = self._iterations, self._tangents
                return Row(increment, problem, now, *counts, tuple(residuals[1:]))
            renew = residual > min(_KEEP * residuals[-1], _NEAR)
            residuals.append(residual)
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
