"""How good a mesh is: angles, sizes, volumes and areas against the CAD, residual to its surface."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import plate_frames
from fingerdesign.design.volume import outline_volume, section_area
from fingerdesign.geometry.checks import (
    face_areas,
    plate_volume,
)
from fingerdesign.geometry.surface import ContactSurface
from fingerdesign.mesh.carriers import smooth_sides
from fingerdesign.mesh.snap import least_jacobian_ratio, tet_volumes
from fingerdesign.mesh.types import Mesh

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

Array = NDArray[np.float64]
IntArray = NDArray[np.int64]


@dataclass(frozen=True)
class QualityReport:
    """A mesh's quality; lengths in mm, angles in degrees, errors relative unless a unit is said.

    Angles and volumes are of the straight-sided cells; in 2-D "dihedral" means the angles of the
    triangles and "volume" the area. ``body_volume_error`` compares elastomer and plates together
    with the closed form; ``worst_face_area_error`` the curved facets with the CAD faces.
    """

    mesher: str
    dimension: int
    elements: int
    nodes: int
    dofs: int
    min_dihedral_deg: float
    dihedral_percentiles_deg: dict[str, float]
    max_aspect: float
    least_jacobian_ratio: float
    body_volume_error: float
    worst_plate_volume_error: float
    worst_face_area_error: float
    contact_residual_mm: float
    contact_edge_mm: dict[str, float]
    regions: dict[str, dict[str, float]]

    def to_dict(self) -> dict[str, Any]:
        """As plain values, for JSON."""
        return asdict(self)

    def text(self) -> str:
        """As readable lines."""
        percentiles = ", ".join(f"{k} % {v:.1f}" for k, v in self.dihedral_percentiles_deg.items())
        edge = self.contact_edge_mm
        lines = [
            f"mesher                   {self.mesher} ({self.dimension}-D, quadratic)",
            f"elements, nodes, dofs    {self.elements}, {self.nodes}, {self.dofs}",
            f"least dihedral angle     {self.min_dihedral_deg:.2f} deg (percentiles {percentiles})",
            f"greatest aspect          {self.max_aspect:.1f} (1 = regular)",
            f"least Jacobian ratio     {self.least_jacobian_ratio:.3f}",
            f"body volume error        {self.body_volume_error:.1e}",
            f"worst plate volume error {self.worst_plate_volume_error:.1e}",
            f"worst face area error    {self.worst_face_area_error:.1e}",
            f"contact residual         {self.contact_residual_mm:.1e} mm",
            f"edges at the contact     mean {edge['mean']:.3f}, greatest {edge['max']:.3f} mm",
        ]
        for name, values in self.regions.items():
            lines.append(
                f"{name + ':':<24} {values['elements']:.0f} elements, edges "
                f"{values['edge_min_mm']:.3f} to {values['edge_max_mm']:.3f} mm, least angle "
                f"{values['min_dihedral_deg']:.1f} deg"
            )
        return "\n".join(lines)


def assess(mesh: Mesh, design: Design) -> QualityReport:
    """Measure a mesh of a design against closed forms."""
    cells = mesh.corners
    angles = cell_angles(mesh.points, cells)
    volumes = cell_volumes(mesh.points, cells)
    edges = edge_lengths(mesh.points, cells)
    surface = ContactSurface.of(design.body)
    contact = mesh.facets.get("contact", np.zeros((0, 3), dtype=np.int64))
    on_contact = np.unique(contact)
    residual = surface.distance(mesh.points[on_contact]) if len(on_contact) else np.zeros(1)
    corners = contact[:, : mesh.dimension]
    lengths = edge_lengths(mesh.points, corners) if len(corners) else np.zeros(1)
    least = angles.min(axis=1)
    ratio = least_jacobian_ratio(mesh.points, mesh.cells) if mesh.dimension == 3 else np.ones(1)
    body_error, plate_error = _volume_errors(mesh, design, volumes)
    return QualityReport(
        mesher=mesh.mesher,
        dimension=mesh.dimension,
        elements=len(cells),
        nodes=len(mesh.points),
        dofs=int(mesh.points.size),
        min_dihedral_deg=float(angles.min()),
        dihedral_percentiles_deg={str(p): float(np.percentile(least, p)) for p in (1, 5, 50)},
        max_aspect=float(aspects(mesh.points, cells).max()),
        least_jacobian_ratio=float(ratio.min()),
        body_volume_error=body_error,
        worst_plate_volume_error=plate_error,
        worst_face_area_error=_worst_area_error(mesh, design),
        contact_residual_mm=float(np.abs(residual).max()),
        contact_edge_mm={"mean": float(lengths.mean()), "max": float(lengths.max())},
        regions={
            name: {
                "elements": float(rows.sum()),
                "edge_min_mm": float(edges[rows].min()),
                "edge_max_mm": float(edges[rows].max()),
                "min_dihedral_deg": float(angles[rows].min()),
                "volume": float(volumes[rows].sum()),
            }
            for name, rows in (("elastomer", mesh.regions == 0), ("plates", mesh.regions > 0))
            if rows.any()
        },
    )


def cell_volumes(points: Array, cells: IntArray) -> Array:
    """Signed areas of triangles or volumes of tetrahedra, (c,), by their corners."""
    if cells.shape[1] == 4:
        return tet_volumes(points, cells)
    a, b, c = (points[cells[:, i]] for i in range(3))
    u, v = b - a, c - a
    return np.asarray(0.5 * (u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]))


def cell_angles(points: Array, cells: IntArray) -> Array:
    """Angles of triangles (c, 3), or dihedral angles of tetrahedra (c, 6), degrees."""
    if cells.shape[1] == 3:
        corners = points[cells]
        found = []
        for i in range(3):
            u = corners[:, (i + 1) % 3] - corners[:, i]
            v = corners[:, (i + 2) % 3] - corners[:, i]
            cross = u[:, 0] * v[:, 1] - u[:, 1] * v[:, 0]
            found.append(np.arctan2(np.abs(cross), np.einsum("ij,ij->i", u, v)))
        return np.asarray(np.degrees(np.stack(found, axis=1)))
    corners = points[cells]
    found = []
    for i, j, k, m in (
        (0, 1, 2, 3),
        (0, 2, 1, 3),
        (0, 3, 1, 2),
        (1, 2, 0, 3),
        (1, 3, 0, 2),
        (2, 3, 0, 1),
    ):
        edge = corners[:, j] - corners[:, i]
        first = np.cross(edge, corners[:, k] - corners[:, i])
        second = np.cross(edge, corners[:, m] - corners[:, i])
        sine = np.linalg.norm(np.cross(first, second), axis=1)
        found.append(np.arctan2(sine, np.einsum("ij,ij->i", first, second)))
    return np.asarray(np.degrees(np.stack(found, axis=1)))


def edge_lengths(points: Array, cells: IntArray) -> Array:
    """Lengths (c, edges) of all corner-to-corner edges of simplices, mm."""
    count = cells.shape[1]
    pairs = [(i, j) for i in range(count) for j in range(i + 1, count)]
    return np.stack(
        [np.linalg.norm(points[cells[:, j]] - points[cells[:, i]], axis=1) for i, j in pairs],
        axis=1,
    )


def aspects(points: Array, cells: IntArray) -> Array:
    """Longest edge over inscribed radius, scaled so that a regular simplex has 1, (c,)."""
    longest = edge_lengths(points, cells).max(axis=1)
    volume = np.maximum(np.abs(cell_volumes(points, cells)), 1e-300)
    if cells.shape[1] == 3:
        around = edge_lengths(points, cells).sum(axis=1)
        return np.asarray(longest * around / volume / (4.0 * np.sqrt(3.0)))
    surface = np.zeros(len(cells))
    for i, j, k in ((0, 1, 2), (0, 1, 3), (0, 2, 3), (1, 2, 3)):
        a, b, c = points[cells[:, i]], points[cells[:, j]], points[cells[:, k]]
        surface += 0.5 * np.linalg.norm(np.cross(b - a, c - a), axis=1)
    return np.asarray(longest * surface / (3.0 * volume) / (2.0 * np.sqrt(6.0)))


def _volume_errors(mesh: Mesh, design: Design, volumes: Array) -> tuple[float, float]:
    if mesh.dimension == 2:
        whole = section_area(design.body)
        plates = [frame.length * frame.thickness for frame in plate_frames(design)]
    else:
        whole = outline_volume(design.body, mesh.symmetric)
        plates = [plate_volume(frame, mesh.symmetric) for frame in plate_frames(design)]
    if design.plates.model == "sheet":
        whole -= sum(plates)  # slots, filled by structural elements
    body = abs(float(volumes.sum()) / whole - 1.0)
    if design.plates.model != "solid" or not plates:
        return body, 0.0
    if mesh.regions.max(initial=0) > len(plates):
        return body, float("inf")
    found = np.bincount(mesh.regions, weights=volumes, minlength=len(plates) + 1)[1:]
    return body, float(np.abs(found / np.array(plates) - 1.0).max())


def _worst_area_error(mesh: Mesh, design: Design) -> float:
    if mesh.dimension == 2:
        return 0.0
    wanted = face_areas(design.body, mesh.symmetric)
    if design.plates.model == "sheet":  # their slots run through both z faces
        slots = sum(frame.length * frame.thickness for frame in plate_frames(design))
        for name in {"end", "symmetry"} & set(wanted):
            wanted[name] -= slots if mesh.symmetric else 2.0 * slots
    found = {
        name: float(curved_areas(mesh.points, mesh.facets[name]).sum())
        if name in mesh.facets
        else 0.0
        for name in wanted
    }
    if smooth_sides(design.body):  # no edge tells where one ends and the other begins
        for areas in (wanted, found):
            areas["contact"] += areas.pop("side")
    return max(abs(found[name] / area - 1.0) for name, area in wanted.items())


def curved_areas(points: Array, facets: IntArray) -> Array:
    """Areas (f,) of quadratic triangles (f, 6) in space, by a six-point rule (degree 4)."""
    nodes = points[facets]
    total = np.zeros(len(facets))
    for weight, inner in (
        (0.223381589678011, 0.108103018168070),
        (0.109951743655322, 0.816847572980459),
    ):
        outer = 0.5 * (1.0 - inner)
        for spot in range(3):
            b = np.full(3, outer)
            b[spot] = inner
            du = np.array([1 - 4 * b[0], 4 * b[1] - 1, 0, 4 * (b[0] - b[1]), 4 * b[2], -4 * b[2]])
            dv = np.array([1 - 4 * b[0], 0, 4 * b[2] - 1, -4 * b[1], 4 * b[1], 4 * (b[0] - b[2])])
            normal = np.cross(np.einsum("fni,n->fi", nodes, du), np.einsum("fni,n->fi", nodes, dv))
            total += 0.5 * weight * np.linalg.norm(normal, axis=1)
    return total
