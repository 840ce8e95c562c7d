"""``fingerdesign bench hexahedra``: tetrahedra or hexahedra for the extruded finger?

The paper's kind of case on one finger with plates (half of it, nu = 0.49): pressed against a plane,
then sheared into partial slip. Each mesh is a section swept through layers: prisms cut into three
tetrahedra, or each triangle of a section twice as coarse cut into three quadrilaterals. All is
condensed and solved as an analysis does. The measure of cost is the arithmetic of that, counted,
not timed: it is the same on any machine.
"""

from __future__ import annotations

import json
import time
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.checks.load import parse_design, with_values
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.schema import Design
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.system import Body, System, assemble_system
from fingerdesign.fem.trace import ContactTrace, contact_trace
from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.surface import surface_of
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.extrude import extrude, layer_heights
from fingerdesign.mesh.section.section import mesh_section
from fingerdesign.mesh.types import Mesh
from fingerdesign.reduced import ReducedModel
from fingerdesign.report.style import GRID, PAPER, SERIES, canvas, house_style
from fingerdesign.runtime.progress import Report
from fingerdesign.shapes.objects import Plane
from fingerdesign_bench.accuracy.hexahedral_model import (
    HexMesh,
    extruded_hexahedra,
    hex_system,
    hex_trace,
)
from fingerdesign_bench.machine import caption, machine
from fingerdesign_bench.speed.growth import tick

# The picture of ``bench hexahedra``: errors against arithmetic and against size, a line a cell.

_WHAT = ((0, "forces, of the normal force"), (1, "stick ratio"), (2, "gages, of the largest"))
_ACROSS = (("gigaflop", "factorisation and condensation (Gflop)"), ("dofs", "equations"))


def draw_hexahedra(found: Hexahedra, path: Path) -> None:
    """Errors against the finest mixed mesh of the other kind of cell; grey: where both differ."""
    band = found.band()
    with house_style():
        figure = canvas(12.5, 8.2)
        parts: Any = figure.subfigures(2, 1, height_ratios=[7.0, 1.0])
        panels = parts[0].subplots(2, len(_WHAT))
        for row, (cost, words) in zip(panels, _ACROSS, strict=True):
            for axes, (which, title) in zip(row, _WHAT, strict=True):
                for line, (colour, dashes, marker) in zip(LINES, SERIES, strict=False):
                    mine = [p for p in found.points if p.line == line]
                    shown = [p for p in mine if p is not found.reference(_other(line))]
                    axes.plot(
                        [getattr(p, cost) for p in shown],
                        [max(found.errors(p)[which], 1e-6) for p in shown],
                        color=colour,
                        ls=dashes,
                        marker=marker,
                        label=line,
                    )
                axes.set_xscale("log")
                axes.set_yscale("log")
                axes.axhspan(axes.get_ylim()[0], max(band[which], 1e-6), color=GRID, zorder=0)
                tick(axes.xaxis)
                axes.set(xlabel=words, ylabel="worst error over the increments", title=title)
        panels[0, 0].legend(loc="best", fontsize=8)
        text = (
            "Half of an extruded finger with three plates, nu = 0.49, pressed and sheared. Each "
            "line is measured against the finest mixed mesh of the other\nkind of cell; in the "
            "grey these two references differ, and nothing can be read.\n" + caption(found.machine)
        )
        parts[1].text(0.008, 0.95, text, va="top", fontsize=7.5, linespacing=1.3)
        figure.savefig(path, dpi=110, facecolor=PAPER)


def _other(line: str) -> str:
    """A line of the other kind of cell, whose reference is this kind's."""
    return "mixed hexahedra" if "tetrahedra" in line else "mixed tetrahedra"


FINGER = """
design.name = "hexahedra"
body.width_mm = 12.0
body.base_height_mm = 6.0
body.arc_radius_mm = 10.0
body.depth_mm = 6.0
plates.count = 3
plates.pitch_mm = 1.5
plates.cover_mm = 1.5
plates.length_mm = 1.5
gages.length_mm = 0.8
"""
ZONE = 2.0  # mm, of the contact candidates
PATH = ((0.06, 0.0), (0.12, 0.0), (0.12, 0.02), (0.12, 0.04), (0.12, 0.06))
FRICTION = 0.5
LINES = ("P2 tetrahedra", "mixed tetrahedra", "triquadratic hexahedra", "mixed hexahedra")
# Relative to the sizes below, which are those of the faces in contact, of plates, of the rubber.
TETRAHEDRA = (1.6, 1.2, 0.9, 0.7, 0.55, 0.45)
HEXAHEDRA = (2.4, 1.8, 1.35, 1.0, 0.8)
QUICK = 3  # sizes of each
_COARSER = 2.0  # a hexahedron's section, before its triangles are cut: edges are halved
_CONTACT, _PLATE, _END, _FAR = 0.3, 0.3, 0.1, 1.5
_LAYERS = 4.0


@dataclass(frozen=True)
class HexPoint:
    """One mesh and element: its size, its cost, and what it answers increment by increment.

    gigaflop: of the factorisation with its border; NaN without PARDISO. forces (k, 2) N: normal and
    tangential; stick (k,); gages (k, plates x 2): strains.
    """

    line: str
    size: float
    dofs: int
    contact_nodes: int
    gigaflop: float
    assemble_s: float
    condense_s: float
    forces: tuple[tuple[float, float], ...]
    stick: tuple[float, ...]
    gages: tuple[tuple[float, ...], ...]


@dataclass
class Hexahedra:
    """All points, and the machine."""

    points: list[HexPoint]
    machine: dict[str, Any] = field(default_factory=dict)

    def reference(self, line: str) -> HexPoint:
        """What a line's errors are against: the finest mixed mesh of the other kind of cell."""
        other = LINES[3] if "tetrahedra" in line else LINES[1]
        return max((p for p in self.points if p.line == other), key=lambda p: p.dofs)

    def errors(self, point: HexPoint) -> tuple[float, float, float]:
        """Worst errors over the increments: of both forces by the normal force, of the stick ratio,
        of the gages by the increment's largest."""
        truth = self.reference(point.line)
        forces, true = np.array(point.forces), np.array(truth.forces)
        gages, wanted = np.array(point.gages), np.array(truth.gages)
        strains = np.abs(gages - wanted).max(axis=1) / np.abs(wanted).max(axis=1)
        return (
            float((np.abs(forces - true) / true[:, :1]).max()),
            float(np.abs(np.array(point.stick) - np.array(truth.stick)).max()),
            float(strains.max()),
        )

    def band(self) -> tuple[float, float, float]:
        """How far the two references differ: errors below it cannot be read."""
        return self.errors(self.reference(LINES[1]))

    def cost_at(self, line: str, error: float, which: int) -> float | None:
        """Gigaflop at which a line first has an error of ``error``, along its fit in logarithms."""
        mine = sorted((p for p in self.points if p.line == line), key=lambda p: p.gigaflop)
        x = np.log([p.gigaflop for p in mine])
        y = np.log([max(self.errors(p)[which], 1e-12) for p in mine])
        slope, level = np.polyfit(x, y, 1)
        return float(np.exp((np.log(error) - level) / slope)) if slope < 0.0 else None


def measure_hexahedra(report: Report = lambda message: None, quick: bool = False) -> Hexahedra:
    """Every line at every size; some four minutes on two cores, half a minute quick."""
    found = Hexahedra([], machine())
    design = parse_design(FINGER)
    for sizes, kind in ((TETRAHEDRA, "tetrahedra"), (HEXAHEDRA, "hexahedra")):
        for size in sizes[:QUICK] if quick else sizes:
            for mixed in (False, True):
                report(f"{kind}, size {size:g}{', mixed' if mixed else ''}")
                made = _tetrahedra if kind == "tetrahedra" else _hexahedra
                found.points.append(made(design, size, mixed))
    return found


def _tetrahedra(design: Design, size: float, mixed: bool) -> HexPoint:
    layered = with_values(design, {"mesh.layers": _layers(size)})
    mesh = extrude(layered, Zone(ZONE), True, _sizes(size))
    start = time.perf_counter()
    young, poisson = _materials(design, mesh)
    facets, fixed = mesh.facets["contact"], _fixed(mesh.points)
    body = Body(mesh, young, poisson, fixed, facets, pressure_cells=mesh.regions == 0)
    system = assemble_system(replace(body, element="mixed" if mixed else "P2"))
    inside = np.abs(mesh.points[facets[:, :3], 0]).max(axis=1) <= ZONE
    trace = contact_trace(mesh.points, facets[inside])
    spent = time.perf_counter() - start
    return _solve(design, LINES[mixed], size, mesh.points, trace, system, spent)


def _hexahedra(design: Design, size: float, mixed: bool) -> HexPoint:
    section = mesh_section(design, ZONE, _sizes(_COARSER * size))
    heights = layer_heights(0.5 * design.body.depth_mm, _layers(size), design.mesh.layer_growth)
    mesh = extruded_hexahedra(section, heights, surface_of(design.body).project)
    start = time.perf_counter()
    young, poisson = _materials(design, mesh)
    system = hex_system(
        mesh, young, poisson, _fixed(mesh.points), mesh.regions == 0 if mixed else None
    )
    inside = np.abs(mesh.points[mesh.contact[:, [0, 2, 6, 8]], 0]).max(axis=1) <= ZONE
    trace = hex_trace(mesh.points, mesh.contact[inside])
    spent = time.perf_counter() - start
    return _solve(design, LINES[2 + mixed], size, mesh.points, trace, system, spent)


def _solve(
    design: Design,
    line: str,
    size: float,
    points: Array,
    trace: ContactTrace,
    system: System,
    assemble_s: float,
) -> HexPoint:
    """Condense onto the contact nodes and the gages, follow the path, read off."""
    start = time.perf_counter()
    rows = sp.csr_matrix(sp.vstack([trace.operator, _gages(design, points)]) @ system.lift)
    rows.sort_indices()
    moving = np.diff(rows.indptr) > 0  # not z on the mirror plane
    condensed = Condensation(system.stiffness, rows[moving].tocsr(), system.pressures)
    matrix = np.zeros((len(moving), len(moving)))
    matrix[np.ix_(moving, moving)] = condensed.matrix
    spent = time.perf_counter() - start
    model = _model(design, points[trace.nodes], trace, matrix, ~moving)
    plane = Plane(surface_of(design.body).crest)
    problem = contact_problem(model, plane, FRICTION)
    steps = [step.measures for step in follow(problem, [Motion(*row) for row in PATH])]
    return HexPoint(
        line=line,
        size=size,
        dofs=system.dofs,
        contact_nodes=model.nodes,
        gigaflop=1e-9 * condensed.operations,
        assemble_s=assemble_s,
        condense_s=spent,
        forces=tuple((step.normal_force, step.tangential_force) for step in steps),
        stick=tuple(float(step.stick_ratio or 0.0) for step in steps),
        gages=tuple(tuple(step.gages.ravel().tolist()) for step in steps),
    )


def _model(
    design: Design, nodes: Array, trace: ContactTrace, matrix: Array, silent: BoolArray
) -> ReducedModel:
    """The reduced model of a condensed mesh of either kind."""
    size = nodes.size
    locked = silent[:size]
    compliance = matrix[:size, :size].copy()
    own = np.flatnonzero(locked)
    compliance[own, own] = np.diag(compliance)[~locked].mean()
    surface = surface_of(design.body)
    exact = replace(trace.surface, points=surface.project(trace.surface.points))
    end = 0.5 * design.body.depth_mm - 0.5
    return ReducedModel(
        points=nodes,
        facets=trace.facets,
        facet_areas=trace.facet_areas,
        areas=trace.areas,
        compliance=compliance,
        gage_readout=matrix[size:, :size],
        point_readout=np.empty((0, size)),
        reaction_readout=-np.tile(np.eye(3), len(nodes)),
        surface=exact,
        rim=np.zeros(len(nodes), dtype=bool),  # the zone is known to be wide enough
        free_end=nodes[:, 2] > end,
        locked=locked.reshape(nodes.shape),
        depth=design.body.depth_mm,
        symmetry_factor=2,
    )


def _gages(design: Design, points: Array) -> sp.csr_matrix:
    """Rows (2 plates, n 3): strain over each gage at z = 0, where its ends are nodes."""
    low = np.flatnonzero(np.abs(points[:, 2]) < 1e-9)
    half, length = 0.5 * design.gages.length_mm, design.gages.length_mm
    row, column, value = [], [], []
    for number, (frame, side) in enumerate(
        (frame, side) for frame in plate_frames(design) for side in (0.5, -0.5)
    ):
        for end in (1.0, -1.0):
            place = frame.from_local(end * half, side * frame.thickness)[0]
            away = np.linalg.norm(points[low, :2] - place, axis=1)
            if away.min() > 1e-6:
                raise ValueError(f"the mesh has no node at the end of gage {number}")
            node = int(low[np.argmin(away)])
            row += [number, number]
            column += [3 * node, 3 * node + 1]
            value += (end / length * frame.axis).tolist()
    return sp.csr_matrix((value, (row, column)), shape=(number + 1, points.size))


def _sizes(factor: float) -> SectionMesh:
    return SectionMesh(
        contact_size_mm=_CONTACT * factor,
        plate_size_mm=_PLATE * factor,
        plate_end_size_mm=_END * factor,
        far_size_mm=_FAR * factor,
        gradation=0.4,
    )


def _layers(size: float) -> int:
    return max(2, round(_LAYERS / size))


def _materials(design: Design, mesh: Mesh | HexMesh) -> tuple[Array, Array]:
    soft = mesh.regions == 0
    body, plate = design.material_of("body"), design.material_of("plates")
    return (
        np.where(soft, body.youngs_modulus_MPa, plate.youngs_modulus_MPa),
        np.where(soft, body.poissons_ratio, plate.poissons_ratio),
    )


def _fixed(points: Array) -> NDArray[np.bool_]:
    fixed = np.zeros(points.shape, dtype=bool)
    fixed[points[:, 1] < 1e-9] = True
    fixed[np.abs(points[:, 2]) < 1e-9, 2] = True
    return fixed.reshape(-1)


def write_hexahedra(found: Hexahedra, folder: Path) -> list[Path]:
    """hexahedra.json and the chart."""
    record = {
        "machine": found.machine,
        "references_differ_by": found.band(),
        "points": [{**asdict(point), "errors": found.errors(point)} for point in found.points],
    }
    folder.mkdir(parents=True, exist_ok=True)
    paths = [folder / "hexahedra.json", folder / "hexahedra.png"]
    paths[0].write_text(json.dumps(record, indent=1), encoding="utf-8")
    draw_hexahedra(found, paths[1])
    return paths
