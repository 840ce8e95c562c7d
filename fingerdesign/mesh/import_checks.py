"""What is asked of a mesh made elsewhere: sound cells, known names, the design's own shape."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import IntArray
from fingerdesign.design.layout import crest_height, plate_frames
from fingerdesign.errors import MeshError
from fingerdesign.mesh.area_fit import outer_areas
from fingerdesign.mesh.carriers import carriers_of, in_core
from fingerdesign.mesh.fit import face_distances, region_name, volumes_by_region
from fingerdesign.mesh.measures import (
    cell_volumes,
    curved_areas,
    edge_lengths,
    least_jacobian_ratios,
)
from fingerdesign.mesh.named import NamedMesh
from fingerdesign.mesh.types import Mesh

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


VOLUME_ERROR = 1e-2  # of body, plates, core: chords of a coarse mesh miss less
AREA_ERROR = 2e-2  # of base and contact
PLACED = 0.95  # of a part's volume that must lie where the design has that part


def used_nodes(found: NamedMesh) -> NamedMesh:
    """Without nodes that no cell has: their dofs would be free."""
    used, cells = np.unique(found.cells, return_inverse=True)
    number = np.full(len(found.points), -1)
    number[used] = np.arange(len(used))
    facets = {name: number[rows] for name, rows in found.facets.items()}
    for name, rows in facets.items():
        if len(rows) and rows.min() < 0:
            raise MeshError(f"facets of {name!r} have nodes that no cell has")
    return NamedMesh(found.points[used], cells.reshape(found.cells.shape), found.region, facets)


def oriented(found: NamedMesh, path: Path) -> NamedMesh:
    """Every cell positively oriented: those that are not are turned."""
    if found.dimension != 3:
        raise MeshError(f"{path.name} holds triangles in the plane, no tetrahedra")
    if not np.isfinite(found.points).all():
        raise MeshError(f"{path.name} has nodes that are not finite")
    volumes = cell_volumes(found.points, found.cells[:, :4])
    apart = len(np.unique(np.round(found.points, 7), axis=0))
    if apart < len(found.points):
        raise MeshError(
            f"{path.name} has {len(found.points) - apart} nodes where another one lies: its parts "
            "are not joined (in Gmsh: fragment the volumes before meshing)"
        )
    flat = np.abs(volumes) <= 1e-12 * np.abs(volumes).max()
    if flat.any():
        raise MeshError(f"{path.name} has {int(flat.sum())} tetrahedra without a volume")
    turned = [0, 2, 1, 3, *([6, 5, 4, 7, 9, 8] if found.quadratic else [])]
    cells = np.where((volumes < 0.0)[:, None], found.cells[:, turned], found.cells)
    return replace(found, cells=cells)


def regions_of(found: NamedMesh, design: Design, path: Path) -> IntArray:
    """The number of each cell's region. MeshError where names are missing or unknown."""
    wanted = {"elastomer": 0}
    if design.plates.model == "solid":
        wanted |= {f"plate_{k}": k + 1 for k in range(design.plates.number)}
    if design.body.core is not None:
        wanted["core"] = design.core_region
    lower = np.char.lower(found.region)
    names = set(np.unique(lower).tolist())
    said = ", ".join(sorted(names - {""})) or "none"
    if "" in names:
        raise MeshError(
            f"{path.name} has {int((lower == '').sum())} cells in no named region (named: {said}); "
            f"name regions {_listed(wanted)} (in Gmsh: physical volumes)"
        )
    if names != set(wanted):
        lack, strange = sorted(set(wanted) - names), sorted(names - set(wanted))
        parts = [f"lacks {_listed(lack)}"] if lack else []
        parts += [f"has {_listed(strange)}, which the design has not"] if strange else []
        raise MeshError(
            f"of the regions that {design.design.name} needs, {path.name} {' and '.join(parts)} "
            f"(found: {said})"
        )
    order, inverse = np.unique(lower, return_inverse=True)
    return np.array([wanted[str(name)] for name in order])[inverse.reshape(-1)].astype(np.int64)


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    return ", ".join(every if len(every) < 8 else [*every[:3], "...", every[-1]])


def check_places(mesh: Mesh, design: Design, path: Path) -> None:
    """MeshError unless volumes are the design's, and plates and core lie where it has them."""
    fit = volumes_by_region(mesh, design)
    whole = sum(row["volume"] for row in fit.regions.values())
    wanted = sum(row["wanted"] for row in fit.regions.values())
    wrong = [
        f"{name} {row['volume']:.6g} of {row['wanted']:.6g} mm^3"
        for name, row in fit.regions.items()
        if not row["error"] <= VOLUME_ERROR
    ]
    if wrong or not fit.body_error <= VOLUME_ERROR:
        parts = wrong or [f"the body {whole:.6g} of {wanted:.6g} mm^3"]
        raise MeshError(
            f"{path.name} is not {design.design.name} (more than {VOLUME_ERROR:.0%} off): "
            + "; ".join(parts[:4])
            + "; is it in mm, and of this design?"
        )
    volumes = cell_volumes(mesh.points, mesh.corners)
    centroids = mesh.points[mesh.corners].mean(axis=1)
    for region in np.unique(mesh.regions[mesh.regions > 0]).tolist():
        own = mesh.regions == region
        if region == design.core_region and design.body.core is not None:
            inside = in_core(design.body, centroids[own])
        else:
            inside = plate_frames(design)[region - 1].holds(centroids[own])
        share = float(volumes[own][inside].sum() / volumes[own].sum())
        if share < PLACED:
            raise MeshError(
                f"only {share:.0%} of {region_name(design, region)} in {path.name} lie where "
                f"{design.design.name} has it: place, angle or number is another"
            )


def check_faces(mesh: Mesh, design: Design, path: Path) -> None:
    """MeshError where base or contact is not the design's, by place and area, or a cell folds."""
    away = face_distances(mesh, design)
    most = VOLUME_ERROR * crest_height(design.body)
    for name in ("base", "contact"):
        if not away[name] <= most:
            raise MeshError(
                f"nodes of {name!r} in {path.name} lie up to {away[name]:.3g} mm off the design's "
                f"(more than {most:.2g} mm)"
            )
    _check_areas(mesh, design, path)
    folded = int((least_jacobian_ratios(mesh.points, mesh.cells) <= 0.0).sum())
    if folded:
        raise MeshError(f"{folded} quadratic tetrahedra of {path.name} fold over")


def _check_areas(mesh: Mesh, design: Design, path: Path) -> None:
    wanted = outer_areas(mesh, design)
    faces = carriers_of(design, (), mesh.symmetric, core=False).faces
    for name in ("base", "contact"):
        area = float(curved_areas(mesh.points, mesh.facets[name]).sum())
        allowed = AREA_ERROR * wanted[name]
        if any(name in (joined := face.boundaries) and len(joined) > 1 for face in faces):
            # No edge tells where it ends: a row of facets at its border may be the neighbour's.
            edge = float(edge_lengths(mesh.points, mesh.facets[name][:, :3]).max())
            allowed += edge * 2.0 * (design.body.width_mm + design.body.depth_mm)
            allowed = min(allowed, 0.5 * wanted[name])
        if not abs(area - wanted[name]) <= allowed:
            raise MeshError(
                f"{name!r} in {path.name} has {area:.6g} mm^2 where {design.design.name} has "
                f"{wanted[name]:.6g} mm^2{' (its half)' if mesh.symmetric else ''}: facets of it "
                "lack that name, or others have it"
            )
