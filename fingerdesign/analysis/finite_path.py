"""A scene's path at finite strain: Design + Mesh + Scene -> what each row reads.

The same finger, mesh, object and friction law as the small-strain model; what differs is the
rubber's law (fem.finite.body), that equilibrium holds on the deformed body, and that lengths and
areas are those of the deformed body.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.fidelity.readings import Readings, readings_of
from fingerdesign.analysis.path import object_at_touch, targets
from fingerdesign.arrays import Array
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.measures import Measures, measure
from fingerdesign.contact.path import Forces
from fingerdesign.contact.problem import Motion
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.fem.finite.body import finite_body
from fingerdesign.fem.finite.row import Facing, Follower, Row, facing, gage_lines, untouched
from fingerdesign.fem.model import body_of, candidate_facets, free_ends
from fingerdesign.fem.trace import contact_trace
from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.types import Mesh


@dataclass(frozen=True)
class FiniteRow:
    """One row of the path. Whole finger, N, mm, MPa; strains plain.

    measures: as at small strain, but widths, areas and pressures are those of the deformed finger,
    and gages (plates, 2: upper, lower) their lines' elongation. balance: supports' force plus
    contact force over the latter; residual: largest nodal force out of balance over it.
    """

    motion: Motion
    measures: Measures
    tangents: int
    residual: float
    balance: float


@dataclass(frozen=True)
class FiniteHistory:
    """All rows, what is read on the deformed finger, and the number of equations."""

    rows: tuple[FiniteRow, ...]
    readings: Readings
    dofs: int


def finite_readings(design: Design, mesh: Mesh, zone: Zone, scene: Scene) -> FiniteHistory:
    """Follow the scene's path on ``mesh`` (2-D: plane strain) with contact candidates in ``zone``.

    Raises DesignError for what finite strain does not know (sheets, linear elements, twist),
    ZoneExhausted where the contact outgrows the zone, SolverError where a row fails.
    """
    refuse_finite(design, scene)
    lines = gage_lines(mesh, plate_frames(design), design.gages, design.gage_weights)
    contact = candidate_facets(mesh, zone.half_width, zone.half_depth)
    if not len(contact):
        raise ZoneExhausted(f"no whole contact facet lies in the candidate zone ({zone})")
    body = finite_body(
        body_of(design, mesh, contact), free_ends(design.body, mesh), design.body.depth_mm
    )
    face = facing(
        body, object_at_touch(scene.object, design.body), scene.object.friction_coefficient
    )
    rows: list[FiniteRow] = []
    path = scene.path
    try:
        for row in _follow(face, targets(path), path.substeps):
            strains = lines.strains(body.system.displacement(row.past.values))
            rows.append(_read(face, row, strains))
    except ZoneExhausted:
        raise
    except SolverError as error:
        where = f"row {len(rows) + 1} of {len(path.rows)} ({path.key}[{len(rows)}])"
        raise SolverError(f"{where}: {error}") from error
    readings = readings_of(rows, design.gages.face)
    return FiniteHistory(tuple(rows), readings, body.system.dofs)


def refuse_finite(design: Design, scene: Scene) -> None:
    """Raise DesignError with all that finite strain does not know."""
    faults = []
    if design.plates.model == "sheet":
        bound = "'solid' or 'none' at finite strain"
        faults.append(Fault("plates.model", "sheet", bound, "set plates.model = 'solid'"))
    if design.mesh.element == "P1":
        bound = "'auto', 'P2' or 'mixed' at finite strain"
        faults.append(Fault("mesh.element", "P1", bound, "set mesh.element = 'auto'"))
    if any(len(row) > 3 and row[3] != 0.0 for row in scene.path.rows):
        bound = "without twist_deg at finite strain"
        faults.append(Fault(f"path.{scene.path.key}", "rows that twist", bound, "leave it at 0"))
    if faults:
        raise DesignError(faults)


def _follow(face: Facing, path: list[Motion | Forces], substeps: int) -> Iterator[Row]:
    """The rows of a path, each from the last one's state; friction moves ``substeps`` times."""
    follower, past = Follower(face), untouched(face)
    for target in path:
        for piece in follower.pieces(past, target, substeps):
            row = follower.row(past, piece)
            past = row.past
        yield row


def _read(face: Facing, row: Row, strains: Array) -> FiniteRow:
    """What the row amounts to, on the deformed finger."""
    body, past = face.body, row.past
    mesh = body.system.body.mesh
    moved = body.system.displacement(past.values)
    now = contact_trace(mesh.points + moved, body.system.body.contact, body.system.body.thickness)
    model = row.problem.model
    points = model.points.copy()
    points[:, 0] += moved[now.nodes, 0]
    there = replace(model, points=points, areas=now.areas, facet_areas=now.facet_areas)
    found = measure(replace(row.problem, model=there), row.increment)
    total = past.force.sum(axis=0)
    free = ~model.locked.any(axis=0)
    off = float(np.abs(body.supports(past.values) + total)[free].max())
    scale = float(np.abs(past.force).sum())
    return FiniteRow(
        motion=replace(past.motion, load=0.0),
        measures=replace(found, gages=strains),
        tangents=row.tangents,
        residual=row.residual,
        balance=off / scale if scale > 0.0 else 0.0,
    )
