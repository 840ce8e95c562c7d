"""Quality of a mesh: angles, sizes, volumes and areas against the CAD, distance to its faces."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.layout.surface import surface_of
from fingerdesign.mesh.cells import facet_kind
from fingerdesign.mesh.files.imported import import_words
from fingerdesign.mesh.fit import face_distances, volumes_by_region, worst_area_error
from fingerdesign.mesh.measures import (
    aspects,
    cell_angles,
    cell_volumes,
    edge_lengths,
    least_jacobian_ratios,
)
from fingerdesign.mesh.requested import TargetSizes, size_ratios
from fingerdesign.mesh.types import Mesh

ANGLE_EDGES = np.arange(0.0, 181.0, 5.0)  # of the histogram, degrees
WORST = 20  # elements that are named one by one


@dataclass(frozen=True)
class QualityReport:
    """A mesh's quality; lengths in mm, angles in degrees, errors relative unless a unit is named.

    In 2-D "dihedral" means the angles of the triangles and "volume" the area. Angles, aspects and
    edges are those of the straight-sided cells.

    body_volume_error         elastomer, plates and core together against the closed form (a STEP
                              body: against its CAD solid), by the curved (quadratic) cells;
                              ``_straight``: by the straight-sided ones
    worst_plate_volume_error  of the plates' curved cells; 0 where no plate is meshed as a solid
    worst_face_area_error     of the curved facets of the body's outer faces
    least_jacobian_ratio      least Jacobian of a curved cell over its straight one's; <= 0: folded
    inverted_elements         cells of no positive volume, or that fold
    contact_residual_mm       greatest distance of a contact node to the true contact surface
    surface_distance_mm       greatest distance of nodes, mid-nodes included, to their CAD face, by
                              the face's name; of "plate_k" and "core" all of their own surface
    volumes                   by region: "volume" and "straight" (of curved and of straight cells),
                              "target" (closed form) and "error"
    size_ratio                by zone: mean edge over the target size there (5 %, mean, 95 %)
    worst                     the cells of least angle: place, angle, region
    modelled                  "section", "half z >= 0" or "whole": what of the finger the cells,
                              and hence the volumes, are
    size_reasons              why target sizes differ from the keys of [mesh]
    attempts                  of the mesher until this mesh passed; None where it is not reported
    failed_attempts           why those before it failed; empty where there were none
    remarks                   on a mesh that was read from a file
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
    inverted_elements: int
    body_volume_error: float
    body_volume_error_straight: float
    worst_plate_volume_error: float
    worst_face_area_error: float
    contact_residual_mm: float
    contact_edge_mm: dict[str, float]
    surface_distance_mm: dict[str, float]
    volumes: dict[str, dict[str, float]]
    regions: dict[str, dict[str, float]]
    modelled: str
    size_ratio: dict[str, dict[str, float]] = field(default_factory=dict)
    size_reasons: list[str] = field(default_factory=list)
    attempts: int | None = None
    failed_attempts: str = ""
    dihedral_histogram: dict[str, list[float]] = field(default_factory=dict)
    aspect_percentiles: dict[str, float] = field(default_factory=dict)
    worst: list[dict[str, Any]] = field(default_factory=list)
    remarks: list[str] = field(default_factory=list)


def _part(edges: Array, angles: Array, aspect: Array, volumes: Array) -> dict[str, float]:
    """The elements of one part in a few numbers."""
    return {
        "elements": len(edges),
        "edge_min_mm": float(edges.min()),
        "edge_mean_mm": float(edges.mean()),
        "edge_max_mm": float(edges.max()),
        "min_dihedral_deg": float(angles.min()),
        "max_aspect": float(aspect.max()),
        "volume": float(volumes.sum()),
    }


def assess(mesh: Mesh, design: Design, requested: TargetSizes | None = None) -> QualityReport:
    """Measure a mesh of a design against closed forms and, where given, the target sizes."""
    cells = mesh.corners
    angles = cell_angles(mesh.points, cells)
    edges = edge_lengths(mesh.points, cells)
    aspect = aspects(mesh.points, cells)
    contact = mesh.facets.get("contact", np.zeros((0, 3), dtype=np.int64))
    on_contact = np.unique(contact)
    surface = surface_of(design.body)
    residual = surface.distance(mesh.points[on_contact]) if len(on_contact) else np.zeros(1)
    kind = facet_kind(contact)
    corners = contact[:, : kind.corners]
    lengths = edge_lengths(mesh.points, corners, kind) if len(corners) else np.zeros(1)
    least = angles.min(axis=1)
    ratio = least_jacobian_ratios(mesh.points, mesh.cells)
    straight = cell_volumes(mesh.points, cells)
    inverted = (straight <= 0.0) | (ratio <= 0.0)
    fit = volumes_by_region(mesh, design)
    in_space = "half z >= 0" if mesh.symmetric else "whole"
    modelled = "section" if mesh.dimension == 2 else in_space
    return QualityReport(
        mesher=mesh.mesher,
        dimension=mesh.dimension,
        elements=len(cells),
        nodes=len(mesh.points),
        dofs=int(mesh.points.size),
        min_dihedral_deg=float(angles.min()),
        dihedral_percentiles_deg=_percentiles(least, (1, 5, 50)),
        max_aspect=float(aspect.max()),
        least_jacobian_ratio=float(ratio.min()),
        inverted_elements=int(inverted.sum()),
        body_volume_error=fit.body_error,
        body_volume_error_straight=fit.body_error_straight,
        worst_plate_volume_error=fit.worst_plate_error,
        worst_face_area_error=worst_area_error(mesh, design),
        contact_residual_mm=float(np.abs(residual).max()),
        contact_edge_mm={"mean": float(lengths.mean()), "max": float(lengths.max())},
        surface_distance_mm=face_distances(mesh, design),
        volumes=fit.regions,
        regions={
            name: _part(edges[rows], angles[rows], aspect[rows], straight[rows])
            for name, rows in mesh.parts.items()
            if rows.any()
        },
        modelled=modelled,
        size_ratio=size_ratios(mesh, requested) if requested is not None else {},
        size_reasons=list(requested.reasons) if requested is not None else [],
        attempts=int(mesh.notes["attempts"]) if "attempts" in mesh.notes else None,
        failed_attempts=str(mesh.notes.get("failed_attempts", "")),
        dihedral_histogram={
            "edges_deg": ANGLE_EDGES.tolist(),
            "counts": np.histogram(angles, ANGLE_EDGES)[0].tolist(),
        },
        aspect_percentiles=_percentiles(aspect, (50, 95, 99)),
        worst=_worst(mesh, least),
        remarks=import_words(mesh),
    )


def _percentiles(values: Array, which: tuple[int, ...]) -> dict[str, float]:
    return {str(p): float(np.percentile(values, p)) for p in which}


def _worst(mesh: Mesh, least: Array) -> list[dict[str, Any]]:
    order = np.argsort(least, kind="stable")[:WORST]
    centroids = mesh.points[mesh.corners[order]].mean(axis=1)
    return [
        {
            "element": int(cell),
            "min_dihedral_deg": float(least[cell]),
            "place_mm": [float(value) for value in place],
            "region": mesh.region_name(int(mesh.regions[cell])),
        }
        for cell, place in zip(order, centroids, strict=True)
    ]
