"""A scene's path at finite strain: Design + Mesh + Scene -> what each row reads.

The same finger, mesh, object and friction law as the small-strain model; what differs is the
rubber's law (fem.finite.body), that equilibrium holds on the deformed body, and that lengths and
areas are those of the deformed body.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.fidelity.readings import Readings, readings_of
from fingerdesign.analysis.path import all_steps, object_at_touch, targets
from fingerdesign.arrays import Array
from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.measures import measure
from fingerdesign.contact.path import Step, row_ends, with_slip_of_row
from fingerdesign.contact.problem import Motion
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.fem.body import CondensedBody, condense_body
from fingerdesign.fem.finite.body import finite_body
from fingerdesign.fem.finite.facing import Facing, facing
from fingerdesign.fem.finite.gage_lines import gage_lines
from fingerdesign.fem.finite.row import Follower, Row, untouched
from fingerdesign.fem.model import body_of, candidate_facets, free_ends
from fingerdesign.fem.trace import contact_trace
from fingerdesign.layout.pressure import (
    greatest_approach_at,
    greatest_possible,
    greatest_pressure,
    sound_pressure,
)
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.types import Mesh


@dataclass(frozen=True)
class FiniteRow(Step):
    """One row of the path. Whole finger, N, mm, MPa; strains plain.

    measures: as at small strain, but widths, areas and pressures are those of the deformed finger,
    and gages (plates, 2: upper, lower) their lines' elongation. tangents: factorisations; residual:
    largest nodal force out of balance over the contact force; balance: supports' force plus contact
    force over the latter.
    """

    tangents: int = 0
    residual: float = 0.0
    balance: float = 0.0

    @property
    def motion(self) -> Motion:
        """The object's."""
        return replace(self.increment.motion, load=0.0)


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
    if faults := finite_faults(design, scene):
        raise DesignError(faults)
    contact = candidate_facets(mesh, zone.half_width, zone.half_depth)
    if not len(contact):
        raise ZoneExhausted(f"no whole contact facet lies in the candidate zone ({zone})")
    at_rest = condense_body(body_of(design, mesh, contact))
    rows = finite_steps(design, at_rest, scene)
    return FiniteHistory(tuple(rows), readings_of(rows, design.gages.face), at_rest.dofs)


def finite_steps(design: Design, at_rest: CondensedBody, scene: Scene) -> list[FiniteRow]:
    """One step a row of the scene's path; at_rest: the finger condensed at small strain.

    Errors as of :func:`~fingerdesign.analysis.path.all_steps`.
    """
    mesh = at_rest.body.mesh
    lines = gage_lines(mesh, plate_frames(design), design.gages, design.gage_weights)
    ends, depth = free_ends(design.body, mesh), design.body.depth_mm
    body = finite_body(at_rest.body, ends, depth, at_rest)
    face = facing(
        body, object_at_touch(scene.object, design.body), scene.object.friction_coefficient
    )
    rows = (
        _read(face, row, lines.strains(body.system.displacement(row.past.values)))
        for row in _follow(face, targets(scene.path), scene.path.substeps)
    )
    return all_steps(rows, scene.path, design.gages.face)


def finite_faults(design: Design, scene: Scene) -> list[Fault]:
    """All that finite strain does not know of a design in a scene."""
    faults = []
    if not scene.object.law.is_coulomb:
        law, bound = scene.object.friction_law, "'coulomb' at finite strain"
        remedy = "set object.friction_law = 'coulomb', or take a model of small strain"
        faults.append(Fault("object.friction_law", f"'{law}'", bound, remedy))
    if design.plates.model == "sheet":
        bound = "'solid' or 'none' at finite strain"
        faults.append(Fault("plates.model", "sheet", bound, "set plates.model = 'solid'"))
    if design.mesh.element == "P1":
        bound = "'auto', 'P2' or 'mixed' at finite strain"
        faults.append(Fault("mesh.element", "P1", bound, "set mesh.element = 'auto'"))
    if any(len(row) > 3 and row[3] != 0.0 for row in scene.path.rows):
        bound = "without twist_deg at finite strain"
        faults.append(Fault(scene.path.key, "rows that twist", bound, "leave it at 0"))
    if scene.readout.points_mm:
        bound = "left out at finite strain"
        faults.append(
            Fault("readout.points_mm", scene.readout.points_mm, bound, "take --fidelity 3d")
        )
    return faults + _pressure_faults(design, scene)


def _pressure_faults(design: Design, scene: Scene) -> list[Fault]:
    """The row whose forecast contact pressure is beyond what finite strain can follow."""
    most, forecast = greatest_possible(design), greatest_pressure(design, scene)
    if forecast <= most:
        return []
    worst = max(range(len(scene.path.rows)), key=lambda k: scene.path.rows[k][0])
    bound = (
        f"less at finite strain: the forecast mean contact pressure is {forecast:.2g} shear "
        f"moduli of the body, and beyond {most:.2g} the deformed body gives way"
    )
    remedy = "press less, take --fidelity 3d (small strain), or a wider body or harder rubber"
    if scene.path.control != "force":
        less = greatest_approach_at(design, scene.object, most)
        remedy = (
            f"press {less:.3g} mm or less, take --fidelity 3d (small strain), or a thicker body"
        )
    value = float(scene.path.rows[worst][0])
    return [Fault(f"{scene.path.key}[{worst}][0]", value, bound, remedy)]


def pressure_note(design: Design, scene: Scene) -> str:
    """A note on a scene that finite strain may not follow to its end; empty where it will."""
    for fault in _pressure_faults(design, scene):
        return f"sound at small strain only: {fault.key} = {fault.value} must be {fault.bound}"
    least, forecast = sound_pressure(design), greatest_pressure(design, scene)
    if forecast <= least:
        return ""
    return (
        f"the forecast mean contact pressure is {forecast:.2g} shear moduli of the body: at finite "
        f"strain every row has an answer up to {least:.2g}, and none beyond "
        f"{greatest_possible(design):.2g}; between them a row may fail"
    )


def _follow(face: Facing, path: list[Motion | Forces], substeps: int | None) -> Iterator[Row]:
    """The rows of a path, each from the last one's state; friction moves with each increment.

    Without ``substeps`` a row is one increment: each increment takes factorisations of its own,
    and below about 0.001 mm the rounding of the deformed body's forces leaves no answer.
    """
    follower, past = Follower(face), untouched(face)
    ends = row_ends(substeps or 1)
    for target in path:
        for number, piece in enumerate(follower.pieces(past, target, ends)):
            row = follower.row(past, piece)
            if number:
                increment = with_slip_of_row(row.increment, past.sliding)
                now = replace(row.past, sliding=increment.state.sliding)
                row = replace(row, increment=increment, past=now)
            past = row.past
        yield row


def _read(face: Facing, row: Row, strains: Array) -> FiniteRow:
    """Measure the row, on the deformed finger."""
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
        row.increment,
        replace(found, gages=strains),
        now.areas,
        moved,
        tangents=row.tangents,
        residual=row.residuals[-1],
        balance=off / scale if scale > 0.0 else 0.0,
    )
