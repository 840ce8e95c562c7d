"""Any elastic body, condensed onto its contact facets: a finger, a block, a soft object.

    K u = R^T f        f contact forces (N)
    R u = C f          C = R K^-1 R^T compliance

R holds the contact trace, the caller's readouts and the sums of the supports' forces, so that one
factorisation gives every answer; they are kept. A readout of a body's own loads l, rows
l^T, gives the contact displacement under them.
"""

from __future__ import annotations

import hashlib
import time
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from threading import Lock, Thread
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.errors import SolverError
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.system import Body, System, assemble_system
from fingerdesign.fem.trace import ContactTrace, contact_trace, owners
from fingerdesign.reduced import ReducedModel
from fingerdesign.runtime.cache import GARBLED, Cache, code_digest
from fingerdesign.version import __version__

# What condensing a body gave, kept by content: the same body is never condensed twice.
#
# A body is what its mesh, held dofs, contact facets, functionals and *relative* moduli are: one
# factor on all moduli divides compliance and readouts, and changes nothing else. Friction, object,
# path and controller are no part of it.

# A model of 480 nodes in 3-D takes 8 MB, one of a section 0.2 MB.
KEPT, KEPT_MB = 1000, 1000.0
_DIGITS = 12  # of relative moduli: the factor's own rounding is no difference

# Of CondensedBody, what one factorisation answers; these are divided by the moduli.
_DIVIDED = ("compliance", "readouts", "between")
Answers = dict[str, Array]


def key_of(words: str, moduli: Array, parts: Iterable[Array | sp.csr_matrix | None]) -> str:
    """SHA-256, in hexadecimal, of what answers depend on: relative moduli, arrays, words."""
    code = code_digest(Path(__file__).parent)
    content = hashlib.sha256(f"{code} {__version__} {words}".encode())
    values, place = np.unique(moduli, return_inverse=True)
    rounded = np.array([float(f"{value:.{_DIGITS}g}") for value in values])[place]
    arrays: list[NDArray[Any] | None] = [rounded]
    for part in parts:
        if isinstance(part, sp.csr_matrix):
            arrays += [part.data, part.indices, part.indptr]
        else:
            arrays.append(part)
    for array in arrays:
        whole = np.ascontiguousarray(np.empty(0) if array is None else array)
        content.update(f"{array is None} {whole.dtype} {whole.shape}".encode())
        content.update(whole.tobytes())
    return content.hexdigest()


def load_answers(key: str, modulus: float) -> tuple[Answers, int] | None:
    """The answers kept under a key, where moduli are relative to ``modulus`` (MPa), and how many
    equations there were; None: nothing kept that can be read."""
    found = _kept().arrays(f"{key}.npz")
    if found is None:
        return None
    data, about = found
    try:
        size = data["readouts"].shape[1]
        lower = np.zeros((size, size))
        lower[_lower(size)] = data.pop("compliance")
        data["compliance"] = lower + np.tril(lower, -1).T
        factor = about["modulus"] / modulus
        for name in _DIVIDED:
            data[name] = factor * data[name]
        return data, int(about["dofs"])
    except GARBLED:
        return None


def keep_answers(key: str, modulus: float, answers: Answers, dofs: int) -> bool:
    """Keep answers under a key; False where the folder cannot be written (the work goes on)."""
    compliance = answers["compliance"]
    arrays = answers | {"compliance": compliance[_lower(len(compliance))]}
    about = {"modulus": modulus, "dofs": dofs}
    return _kept().put_arrays(f"{key}.npz", arrays, about, packed=False)


def _lower(size: int) -> NDArray[np.bool_]:
    return np.tri(size, dtype=bool)


def _kept() -> Cache:
    return Cache("models", KEPT, most_MB=KEPT_MB)


# Of a contact force: what a body that can still move as a whole loses at the least.
_NOT_HELD = 0.1
# Support against contact force: rounding leaves 1e-10 to 2e-8 (plates 27,000 times stiffer than the
# body); a model that loses force is wrong in the first digits.
_BALANCE = 1e-6


@dataclass(frozen=True)
class CondensedBody:
    """What one factorisation tells of a body; forces f are those on its m contact nodes.

    compliance         (m dim, m dim) mm/N; motions that are held answer nothing (zero rows)
    readouts           one (r, m dim) per block of rows asked for: value per unit contact force
    between            (r, r) of all these rows: value of one per unit of another's nodal forces
    reaction           (dim, m dim): sum of the supports' forces on the body per contact force
    load_displacement  (m dim,) mm, contact displacement without contact forces; None: zero
    factors            the equations (``dofs`` of them) and their factorisation; it is made when
                       first asked for where the answers were kept
    """

    body: Body
    trace: ContactTrace
    dofs: int
    factors: Callable[[], tuple[System, Condensation]]
    compliance: Array
    readouts: tuple[Array, ...]
    between: Array
    reaction: Array
    timings: dict[str, float]
    load_displacement: Array | None = None

    def prepare_fields(self, wanted: bool) -> None:
        """Begin to factor, beside other work, where answers were kept and fields are ``wanted``;
        what fails is raised by :meth:`displacement_fields`."""

        def begin() -> None:
            with suppress(SolverError):
                self.factors()

        if wanted:
            Thread(target=begin, daemon=True).start()

    def displacement_fields(self, forces: Array, loads: Array | float = 0.0) -> Array:
        """Nodal displacements (k, n, dim) mm for contact forces (k, m, dim) N and nodal forces of
        the body's own, (n dim, 1) N."""
        loads = self.trace.operator.T @ forces.reshape(len(forces), -1).T + loads
        system, condensation = self.factors()
        fields = system.lift @ condensation.solve(system.lift.T @ loads)
        return np.asarray(fields.T).reshape(len(forces), *self.body.mesh.points.shape)


def condense_body(
    body: Body, readouts: Sequence[sp.csr_matrix] = (), keep: bool = False
) -> CondensedBody:
    """Assemble, factor once, and read everything off; or read off what has been kept.

    readouts: blocks of rows (r, n dim), each a linear functional of the nodal displacements; keep:
    look among kept answers, and keep these. Raises SolverError where the body is not held, has no
    contact facet, or is unsound itself.
    """
    check_sound(body)
    start = time.perf_counter()
    trace = contact_trace(body.mesh.points, body.contact, body.thickness)
    if body.project is not None:  # gaps are measured from the exact surface
        points = body.project(trace.surface.points)
        trace = replace(trace, surface=replace(trace.surface, points=points))
    rows = [trace.operator, *readouts]
    modulus = float(body.youngs_modulus[0]) if body.attached is None else 1.0  # sheets: their own
    key = _key(body, modulus, rows) if keep else ""
    kept = load_answers(key, modulus) if keep else None
    factors: Callable[[], tuple[System, Condensation]]
    if kept is None:
        answers, pair, timings = _answered(body, rows)
        dofs, factors = pair[0].dofs, lambda: pair
        if keep:
            keep_answers(key, modulus, answers, dofs)
    else:
        (answers, dofs), factors = kept, _once(lambda: _factored(body))
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
    )


def _answered(
    body: Body, rows: Sequence[sp.csr_matrix]
) -> tuple[Answers, tuple[System, Condensation], dict[str, float]]:
    """What a body answers to the contact trace and the readouts, ``rows``, and how it was found."""
    size = rows[0].shape[0]
    system, condensation, blocks, timings = condensed_rows(body, rows)
    by_force = [block[:, :size].copy() for block in blocks]
    read = size + sum(part.shape[0] for part in rows[1:])
    answers = {
        "compliance": by_force[0],
        "readouts": np.vstack([np.empty((0, size)), *by_force[1:-1]]),
        "between": np.vstack([block[:, size:read] for block in (blocks[0][:0], *blocks[1:-1])]),
        # What acts on held dofs goes into the supports at once.
        "reaction": by_force[-1] - (rows[0] @ system.held).toarray().T,
    }
    return answers, (system, condensation), timings


def _key(body: Body, modulus: float, rows: Sequence[sp.csr_matrix]) -> str:
    """The name of the answers to rows of a body whose moduli are relative to ``modulus``."""
    mesh = body.mesh
    parts = [body.poissons_ratio, body.fixed, mesh.points, mesh.cells, body.contact]
    words = f"{body.element} {body.thickness}"
    relative = body.youngs_modulus / modulus
    return key_of(words, relative, [*parts, body.pressure_cells, body.attached, *rows])


def _once(
    make: Callable[[], tuple[System, Condensation]],
) -> Callable[[], tuple[System, Condensation]]:
    """The same, made by whichever thread asks first; others wait for it."""
    kept, lock = cache(make), Lock()

    def once() -> tuple[System, Condensation]:
        with lock:
            return kept()

    return once


def _factored(body: Body) -> tuple[System, Condensation]:
    """The equations of a body and their factorisation alone."""
    system = assemble_system(body)
    return system, Condensation(system.stiffness, system.support[:1], system.pressures)


def check_sound(body: Body) -> None:
    """SolverError, by name, where a body's arrays do not fit its mesh, or have values that no body
    has."""
    cells, shape = len(body.mesh.cells), (body.mesh.points.size,)
    if len(body.contact) == 0:
        raise SolverError("the body has no contact facet: widen the zone or name its facets")
    if body.fixed.shape != shape:
        raise SolverError(f"fixed has the shape {body.fixed.shape}, the mesh asks for {shape}")
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
                f"{name} has the shape {np.shape(values)}: one for each of {cells} cells is asked"
            )
        wrong = values[~((values > low) & (values < high))]
        if len(wrong):
            raise SolverError(
                f"{name} of {wrong[0]:g}{unit} in {len(wrong)} cells: must be {bound}"
            )
    owners(body.mesh, body.contact)


def condensed_rows(
    body: Body, rows: Sequence[sp.csr_matrix]
) -> tuple[System, Condensation, list[Array], dict[str, float]]:
    """Condense a body onto functionals (r, n dim) of its displacements and onto its supports.

    The third: rows of R K^-1 R^T, one array a block of R; the supports' rows come last.
    """
    start = time.perf_counter()
    system = assemble_system(body)
    assembled = time.perf_counter()
    parts = [*(part @ system.lift for part in rows), system.support]
    bordering = sp.vstack(parts, format="csr")
    bordering.sort_indices()
    silent = np.diff(bordering.indptr) == 0  # motions that are held
    condensation = Condensation(system.stiffness, bordering[~silent].tocsr(), system.pressures)
    matrix = np.zeros((len(silent), len(silent)))
    matrix[np.ix_(~silent, ~silent)] = condensation.matrix
    blocks = np.split(matrix, np.cumsum([part.shape[0] for part in parts])[:-1])
    done = time.perf_counter()
    timings = {"assemble": assembled - start, "condense": done - assembled}
    return system, condensation, blocks, timings


def body_model(body: Body) -> ReducedModel:
    """The reduced model of a body without plates or gages."""
    return reduced_model(condense_body(body))


def reduced_model(
    condensed: CondensedBody,
    gage_readout: Array | None = None,
    point_readout: Array | None = None,
    gage_positions: Array | None = None,
    free_ends: tuple[float, float] | None = None,
    depth: float | None = None,
    load_gage_strain: Array | None = None,
) -> ReducedModel:
    """The model that contact sees, of a condensed body and the readouts it was asked for.

    gage_positions (plates, 3): the gages' centres, mm; free_ends: z (mm) below the first and above
    the second of which nodes count as at a free end (None: nowhere); depth: mm, for plane strain
    the thickness by default, in 3-D the extent in z; load_gage_strain (plates, 2): under the loads
    of its own. Raises SolverError where the supports do not
    carry every contact force.
    """
    body, trace = condensed.body, condensed.trace
    mesh, nodes = body.mesh, len(trace.nodes)
    where = mesh.points[trace.nodes]
    locked = body.fixed.reshape(mesh.points.shape)[trace.nodes]  # no motion of their own
    if locked.all():
        raise SolverError("every contact node is held: none can yield to a contact force")
    compliance = condensed.compliance.copy()
    _decouple(compliance, locked.reshape(-1))
    check_balance(condensed.reaction, locked, nodes)
    factor = 2 if mesh.symmetric else 1
    if depth is None:
        depth = body.thickness if mesh.dimension == 2 else factor * float(np.ptp(mesh.points[:, 2]))
    ends = np.zeros(nodes, dtype=bool)
    if free_ends is not None and mesh.dimension == 3:
        ends = (where[:, 2] < free_ends[0]) | (where[:, 2] > free_ends[1])
    gages = np.empty((0, 3)) if gage_positions is None else gage_positions
    none = np.empty((0, where.size))
    moved = condensed.load_displacement
    return ReducedModel(
        points=where,
        facets=trace.facets,
        facet_areas=trace.facet_areas,
        areas=trace.areas,
        compliance=compliance,
        gage_readout=none if gage_readout is None else gage_readout,
        point_readout=none if point_readout is None else point_readout,
        reaction_readout=condensed.reaction,
        surface=trace.surface,
        rim=_rim(body, trace),
        free_end=ends,
        locked=locked,
        depth=depth,
        symmetry_factor=factor,
        gage_x=gages[:, 0],
        gage_positions=gages,
        load_displacement=None if moved is None else moved.reshape(where.shape),
        load_gage_strain=load_gage_strain,
    )


def _decouple(compliance: Array, locked: BoolArray) -> None:
    """Give locked components a compliance of their own, so that their force comes out zero."""
    compliance[locked] = 0.0
    compliance[:, locked] = 0.0
    index = np.flatnonzero(locked)
    compliance[index, index] = np.diag(compliance)[~locked].mean()


def check_balance(reaction: Array, locked: BoolArray, nodes: int) -> None:
    """Every unit contact force must come out at the supports (of free components)."""
    expected = -np.tile(np.eye(reaction.shape[0]), nodes)
    free = ~locked.reshape(-1)
    error = float(np.abs(reaction - expected)[:, free].max())
    if error > _NOT_HELD:
        raise SolverError(
            "the body is not held against every rigid motion: its supports do not bear the contact "
            "forces; hold more of it"
        )
    if not error < _BALANCE:
        raise SolverError(
            f"the condensed model loses {error:.1e} of each contact force: stiffnesses or lengths "
            "differ by more than double precision can carry; bring the moduli closer together or "
            "the body's height closer to its width"
        )


def _rim(body: Body, trace: ContactTrace) -> BoolArray:
    """Nodes that also belong to contact facets of the mesh outside the candidates."""
    mesh = body.mesh
    facets = mesh.facets.get("contact", body.contact)[:, : mesh.dimension]
    count_all = np.bincount(facets.ravel(), minlength=len(mesh.points))
    count_zone = np.bincount(trace.nodes[trace.facets].ravel(), minlength=len(mesh.points))
    return np.asarray((count_all > count_zone)[trace.nodes])
