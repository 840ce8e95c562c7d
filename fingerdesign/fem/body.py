"""Any elastic body, condensed onto its contact facets: a finger, a block, a soft object.

    K u = R^T f        f contact forces (N)
    R u = C f          C = R K^-1 R^T compliance

R holds the contact trace, the caller's readouts and the sums of the supports' forces, so that one
factorisation gives every answer; answers are stored (answers.py). A readout of a body's own loads
l, rows l^T, gives the contact displacement under them.
"""

import time
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from threading import Lock, Thread

import numpy as np
import scipy.sparse as sp

from fingerdesign.arrays import Array
from fingerdesign.errors import SolverError
from fingerdesign.fem.answers import (
    Answers,
    has_fields,
    key_of,
    load_answers,
    load_fields,
    store_answers,
    store_fields,
)
from fingerdesign.fem.mirror import Factors, factored
from fingerdesign.fem.system import Body, System, assemble_system
from fingerdesign.fem.trace import ContactTrace, contact_trace, owners


@dataclass(frozen=True)
class CondensedBody:
    """A body after one factorisation; forces f are those on its m contact nodes.

    compliance         (m dim, m dim) mm/N; constrained motions have zero rows
    readouts           one (r, m dim) per requested block of rows: value per unit contact force
    between            (r, r) of all these rows: value of one per unit of another's nodal forces
    reaction           (dim, m dim): sum of the supports' forces on the body per contact force
    load_displacement  (m dim,) mm, contact displacement without contact forces; None: zero
    stored             key and modulus that answers and fields are stored under; no key: nowhere
    factors            the equations (``dofs`` of them) and their factorisation; it is made at
                       the first use where the answers were stored
    """

    body: Body
    trace: ContactTrace
    dofs: int
    factors: Callable[[], tuple[System, Factors]]
    compliance: Array
    readouts: tuple[Array, ...]
    between: Array
    reaction: Array
    timings: dict[str, float]
    load_displacement: Array | None = None
    stored: tuple[str, float] = ("", 1.0)

    def prepare_fields(self, needed: bool) -> None:
        """Begin to factor, concurrently with other work, where fields are ``needed``.

        Not where fields are stored: those of the same path are, whatever the grips. An error is
        raised later, by :meth:`displacement_fields`.
        """

        def begin() -> None:
            with suppress(SolverError):
                self.factors()

        if needed and not has_fields(self.stored[0]):
            Thread(target=begin, daemon=True).start()

    def displacement_fields(self, forces: Array, loads: Array | float = 0.0) -> Array:
        """Nodal displacements (k, n, dim) mm for contact forces (k, m, dim) N and nodal forces of
        the body's own, (n dim, 1) N."""
        forces = forces.reshape(len(forces), -1)
        by_forces = bool(self.stored[0]) and not np.any(loads)
        fields = load_fields(*self.stored, forces) if by_forces else None
        if fields is None:
            system, condensation = self.factors()
            loads = self.trace.operator.T @ forces.T + loads
            fields = (system.lift @ condensation.solve(system.lift.T @ loads)).T
            if by_forces:
                store_fields(*self.stored, forces, fields)
        return np.asarray(fields).reshape(len(forces), *self.body.mesh.points.shape)


def condense_body(
    body: Body,
    readouts: Sequence[sp.csr_matrix] = (),
    store: bool = False,
    trace: ContactTrace | None = None,
) -> CondensedBody:
    """Assemble, factor once and read off all answers, or load stored ones.

    readouts: blocks of rows (r, n dim), each a linear functional of the nodal displacements; store:
    use stored answers and store these; trace: on which, by default that of the body's own contact
    facets. Raises SolverError where the body can move as a whole, has
    no contact facet, or is unsound itself.
    """
    check_sound(body)
    start = time.perf_counter()
    if trace is None:
        trace = contact_trace(body.mesh.points, body.contact, body.thickness)
        if body.project is not None:  # Gaps are measured from the exact surface.
            points = body.project(trace.surface.points)
            trace = replace(trace, surface=replace(trace.surface, points=points))
    rows = [trace.operator, *readouts]
    modulus = float(body.youngs_modulus[0]) if body.attached is None else 1.0  # sheets: their own
    key = _key(body, modulus, rows) if store else ""
    stored = load_answers(key, modulus) if store else None
    factors: Callable[[], tuple[System, Factors]]
    if stored is None:
        answers, pair, timings = _answered(body, rows)
        dofs, factors = pair[0].dofs, lambda: pair
        if store:
            store_answers(key, modulus, answers, dofs)
    else:
        (answers, dofs), factors = stored, _once(lambda: condensed_rows(body, rows)[:2])
        timings = {"assemble": 0.0, "condense": time.perf_counter() - start}
    ends = np.cumsum([part.shape[0] for part in readouts])
    return CondensedBody(
        body=body,
        trace=trace,
        dofs=dofs,
        factors=factors,
        compliance=answers["compliance"],
        readouts=tuple(np.split(answers["readouts"], ends)[:-1]),
        between=answers["between"],
        reaction=answers["reaction"],
        timings=timings,
        stored=(key, modulus),
    )


def _answered(
    body: Body, rows: Sequence[sp.csr_matrix]
) -> tuple[Answers, tuple[System, Factors], dict[str, float]]:
    """Compute the answers to ``rows`` (contact trace, readouts), with the factors and timings."""
    size = rows[0].shape[0]
    system, condensation, blocks, timings = condensed_rows(body, rows)
    by_force = [block[:, :size].copy() for block in blocks]
    read = size + sum(part.shape[0] for part in rows[1:])
    answers = {
        "compliance": by_force[0],
        "readouts": np.vstack([np.empty((0, size)), *by_force[1:-1]]),
        "between": np.vstack([block[:, size:read] for block in (blocks[0][:0], *blocks[1:-1])]),
        # A force on a fixed dof goes into the supports at once.
        "reaction": by_force[-1] - (rows[0] @ system.held).toarray().T,
    }
    return answers, (system, condensation), timings


def _key(body: Body, modulus: float, rows: Sequence[sp.csr_matrix]) -> str:
    """Name the answers of a body whose moduli are relative to ``modulus`` by their content."""
    mesh = body.mesh
    parts = [body.poissons_ratio, body.fixed, mesh.points, mesh.cells, body.contact]
    words = f"{body.element} {body.thickness}"
    relative = body.youngs_modulus / modulus
    return key_of(words, relative, [*parts, body.pressure_cells, body.attached, *rows])


def _once(
    make: Callable[[], tuple[System, Factors]],
) -> Callable[[], tuple[System, Factors]]:
    """Wrap ``make`` so that the first thread makes the pair and the others wait for it."""
    made, lock = cache(make), Lock()

    def once() -> tuple[System, Factors]:
        with lock:
            return made()

    return once


def check_sound(body: Body) -> None:
    """Raise SolverError where a body's arrays do not fit its mesh or hold impossible values."""
    cells, shape = len(body.mesh.cells), (body.mesh.points.size,)
    if len(body.contact) == 0:
        raise SolverError("the body has no contact facet: widen the zone or name its facets")
    if body.fixed.shape != shape:
        raise SolverError(f"fixed has the shape {body.fixed.shape}, the mesh needs {shape}")
    if not np.isfinite(body.mesh.points).all():
        raise SolverError("the mesh has points that are NaN or infinite")
    if not 0.0 < body.thickness < np.inf:
        raise SolverError(f"thickness = {body.thickness} mm: must be more than 0")
    for name, values, unit, low, high, bound in (
        ("Young's modulus", body.youngs_modulus, " MPa", 0.0, np.inf, "more than 0"),
        ("Poisson's ratio", body.poissons_ratio, "", -1.0, 0.5, "more than -1 and less than 0.5"),
    ):
        if np.shape(values) != (cells,):
            raise SolverError(
                f"{name} has the shape {np.shape(values)}: it needs one for each of {cells} cells"
            )
        wrong = values[~((values > low) & (values < high))]
        if len(wrong):
            raise SolverError(
                f"{name} of {wrong[0]:g}{unit} in {len(wrong)} cells: must be {bound}"
            )
    owners(body.mesh, body.contact)


def condensed_rows(
    body: Body, rows: Sequence[sp.csr_matrix]
) -> tuple[System, Factors, list[Array], dict[str, float]]:
    """Condense a body onto functionals (r, n dim) of its displacements and onto its supports.

    The first: the system, of its stiffness only the shape. The third: rows of R K^-1 R^T, one array
    a block of R; the supports' rows come last.
    """
    start = time.perf_counter()
    system = assemble_system(body)
    assembled = time.perf_counter()
    parts = [*(part @ system.lift for part in rows), system.support]
    bordering = sp.vstack(parts, format="csr")
    bordering.sort_indices()
    condensation = factored(system, bordering, body.mesh.points)
    ends = np.cumsum([part.shape[0] for part in parts])[:-1]
    blocks = np.split(condensation.matrix, ends)
    done = time.perf_counter()
    timings = {"assemble": assembled - start, "condense": done - assembled}
    # The factors have their own copy: 140 MB of 120k dofs.
    system = replace(system, stiffness=sp.csr_matrix(system.stiffness.shape))
    return system, condensation, blocks, timings
