"""``fingerdesign bench hexahedra``: tetrahedra or hexahedra for the extruded finger?

One finger with plates, half of it, nearly incompressible (nu = 0.49), under a given traction over a
strip, as contact leaves it: a smooth pressure, then the same as shear. Each mesh is a section swept
through layers: prisms cut into three tetrahedra, or each triangle cut into three quadrilaterals.
Errors are of what contact and gages see: the work-conjugate displacements under the strip, and the
strains of the gages at z = 0. All is condensed onto the contact nodes as an analysis does. The
measure of cost is the arithmetic of that, counted, not timed: it is the same on any machine.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import scipy.sparse as sp
from numpy.typing import NDArray

from fingerdesign.bench.machine import machine
from fingerdesign.design.io import parse_design, with_values
from fingerdesign.design.layout import plate_frames
from fingerdesign.design.meshing import SectionMesh
from fingerdesign.design.schema import Design
from fingerdesign.fem.elements import quadrature, tabulate
from fingerdesign.fem.factor import Condensation
from fingerdesign.fem.hexahedra import (
    HexMesh,
    extruded_hexahedra,
    gauss,
    hex_system,
    hex_trace,
    shapes,
)
from fingerdesign.fem.system import System, assemble_system
from fingerdesign.fem.trace import contact_trace
from fingerdesign.geometry.surface import surface_of
from fingerdesign.mesh.extrude import extrude, layer_heights
from fingerdesign.mesh.section import mesh_section
from fingerdesign.mesh.types import Mesh

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]
Tell = Callable[[str], None]

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
STRIP = 1.2  # mm, half-width of the loaded strip
ZONE = 1.6  # mm, of the contact candidates
LINES = ("P2 tetrahedra", "mixed tetrahedra", "triquadratic hexahedra", "mixed hexahedra")
# Sizes relative to those below; a hexahedron's section is 2.2 times as coarse before its triangles
# are cut, which leaves edges a tenth longer.
TETRAHEDRA = (2.0, 1.5, 1.15, 0.85, 0.65, 0.5)
HEXAHEDRA = (4.0, 3.0, 2.2, 1.7, 1.3)
QUICK = 3  # sizes of each
_COARSER = 2.2
_CONTACT, _PLATE, _END, _FAR = 0.3, 0.3, 0.1, 1.5
_LAYERS, _HEX_LAYERS = 6.0, 9.0


@dataclass(frozen=True)
class HexPoint:
    """One mesh and element: its size, its cost, and what it answers.

    gigaflop: of the factorisation with its border; NaN without PARDISO. normal, tangential: mm per
    N over the strip; gages (2 loads x plates x 2): strain per N.
    """

    line: str
    size: float
    dofs: int
    contact_nodes: int
    gigaflop: float
    assemble_s: float
    condense_s: float
    normal: float
    tangential: float
    gages: tuple[float, ...]


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
        """Relative errors of both displacements, and of the gages by their largest."""
        truth = self.reference(point.line)
        gages, true = np.array(point.gages), np.array(truth.gages)
        return (
            abs(point.normal / truth.normal - 1.0),
            abs(point.tangential / truth.tangential - 1.0),
            float(np.abs(gages - true).max() / np.abs(true).max()),
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


def measure_hexahedra(tell: Tell = lambda message: None, quick: bool = False) -> Hexahedra:
    """Every line at every size; about three minutes on two quiet cores, half a minute quick."""
    found = Hexahedra([], machine())
    design = parse_design(FINGER)
    for sizes, kind in ((TETRAHEDRA, "tetrahedra"), (HEXAHEDRA, "hexahedra")):
        for size in sizes[:QUICK] if quick else sizes:
            for mixed in (False, True):
                tell(f"{kind}, size {size:g}{', mixed' if mixed else ''}")
                made = _tetrahedra if kind == "tetrahedra" else _hexahedra
                found.points.append(made(design, size, mixed))
    return found


def _tetrahedra(design: Design, size: float, mixed: bool) -> HexPoint:
    layered = with_values(design, {"mesh.layers": max(2, round(_LAYERS / size))})
    mesh = extrude(layered, ZONE, True, _sizes(size))
    start = time.perf_counter()
    young, poisson = _materials(design, mesh)
    system = assemble_system(
        mesh,
        young,
        poisson,
        _fixed(mesh.points),
        element="mixed" if mixed else "P2",
        pressure_cells=mesh.regions == 0,
    )
    facets = mesh.facets["contact"]
    inside = np.abs(mesh.points[facets[:, :3], 0]).max(axis=1) <= ZONE
    trace = contact_trace(mesh.points, facets[inside])
    where, weights = quadrature(2, 6)
    table = tabulate(2, where)
    load = _load(mesh.points, facets, table.value, table.gradient, weights)
    spent = time.perf_counter() - start
    return _solve(design, LINES[mixed], size, mesh.points, (trace.operator, load), system, spent)


def _hexahedra(design: Design, size: float, mixed: bool) -> HexPoint:
    section = mesh_section(design, ZONE, _sizes(_COARSER * size))
    heights = layer_heights(0.5 * design.body.depth_mm, max(2, round(_HEX_LAYERS / size)))
    mesh = extruded_hexahedra(section, heights, surface_of(design.body).project)
    start = time.perf_counter()
    young, poisson = _materials(design, mesh)
    system = hex_system(
        mesh, young, poisson, _fixed(mesh.points), mesh.regions == 0 if mixed else None
    )
    inside = np.abs(mesh.points[mesh.contact[:, [0, 2, 6, 8]], 0]).max(axis=1) <= ZONE
    operator = hex_trace(mesh, mesh.contact[inside])[2]
    places, weights = gauss(2, 5)
    load = _load(mesh.points, mesh.contact, *shapes(places, 2), weights)
    spent = time.perf_counter() - start
    return _solve(design, LINES[2 + mixed], size, mesh.points, (operator, load), system, spent)


def _load(points: Array, facets: IntArray, value: Array, slope: Array, weights: Array) -> Array:
    """Nodal loads (n,) of a smooth traction over the strip, 1 N in all, on one component.

    Of facets (f, k) with shape functions ``value`` (k, q) and their ``slope`` (k, 2, q): the
    traction is integrated where it acts, so that no mesh sees another.
    """
    where = np.einsum("kq,fka->fqa", value, points[facets], optimize=True)
    tangents = np.einsum("fka,kbq->fqab", points[facets], slope, optimize=True)
    measure = np.linalg.norm(np.cross(tangents[..., 0], tangents[..., 1]), axis=2) * weights
    traction = np.maximum(1.0 - (where[..., 0] / STRIP) ** 2, 0.0) ** 2 * measure
    spread = np.einsum("fq,kq->fk", traction, value, optimize=True)
    load = np.bincount(facets.ravel(), spread.ravel(), minlength=len(points))
    return np.asarray(load / load.sum())


def _solve(
    design: Design,
    line: str,
    size: float,
    points: Array,
    contact: tuple[sp.csr_matrix, Array],
    system: System,
    assemble_s: float,
) -> HexPoint:
    """Condense onto the contact nodes and the gages, load the strip, read off."""
    start = time.perf_counter()
    operator, load = contact
    pushes = sp.kron(sp.csr_matrix(load), np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0]]))
    rows = sp.vstack([pushes, _gages(design, points), operator], format="csr") @ system.lift
    rows = sp.csr_matrix(rows)
    rows.sort_indices()
    moving = np.diff(rows.indptr) > 0  # not z on the mirror plane
    condensed = Condensation(system.stiffness, rows[moving].tocsr(), system.pressures)
    spent = time.perf_counter() - start
    matrix = condensed.matrix
    gages = matrix[2 : 2 + 2 * len(plate_frames(design)), :2]
    return HexPoint(
        line=line,
        size=size,
        dofs=system.dofs,
        contact_nodes=operator.shape[0] // 3,
        gigaflop=1e-9 * condensed.operations,
        assemble_s=assemble_s,
        condense_s=spent,
        normal=float(matrix[0, 0]),
        tangential=float(matrix[1, 1]),
        gages=tuple(float(value) for value in gages.T.ravel()),
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
    from fingerdesign.bench.hexahedra_chart import draw_hexahedra

    record = {
        "machine": found.machine,
        "references_differ_by": found.band(),
        "points": [{**asdict(point), "errors": found.errors(point)} for point in found.points],
    }
    paths = [folder / "hexahedra.json", folder / "hexahedra.png"]
    paths[0].write_text(json.dumps(record, indent=1), encoding="utf-8")
    draw_hexahedra(found, paths[1])
    return paths
