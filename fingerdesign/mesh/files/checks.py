"""Checks of a mesh made elsewhere against its design: names, places, faces, joints."""

from collections.abc import Iterable
from pathlib import Path

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.errors import MeshError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mesh.cells import facet_keys, pieces, same_keys, tetra_facets
from fingerdesign.mesh.files.named import NamedMesh
from fingerdesign.mesh.fit import face_distances, outer_areas, volumes_by_region
from fingerdesign.mesh.measures import (
    cell_volumes,
    curved_areas,
    edge_lengths,
    least_jacobian_ratios,
)
from fingerdesign.mesh.tetra.boundary import BoundaryFacets
from fingerdesign.mesh.tetra.carriers import in_core, outer_faces
from fingerdesign.mesh.types import Mesh

VOLUME_ERROR = 1e-2  # of body, plates, core: chords of a coarse mesh miss less
AREA_ERROR = 2e-2  # of base and contact
PLACED = 0.95  # of a part's volume that must lie where the design has that part
OFF = 0.3  # of a facet's longest edge: outside facets farther off the design's faces are cracks
OFF_HEIGHT = 1e-2  # of the finger's height, added to it


def regions_of(found: NamedMesh, design: Design, path: Path) -> IntArray:
    """The number of each cell's region. MeshError where names are missing or unknown."""
    target = {"elastomer": 0}
    if design.plates.model == "solid":
        target |= {f"plate_{k}": k + 1 for k in range(design.plates.number)}
    if design.body.core is not None:
        target["core"] = design.core_region
    lower = np.char.lower(found.region)
    names = set(np.unique(lower).tolist())
    given = ", ".join(sorted(names - {""})) or "none"
    if "" in names:
        raise MeshError(
            f"{path.name} has {int((lower == '').sum())} cells in no named region (named: "
            f"{given}); name regions {_listed(target)} (in Gmsh: physical volumes)"
        )
    if names != set(target):
        lack, strange = sorted(set(target) - names), sorted(names - set(target))
        parts = [f"lacks {_listed(lack)}"] if lack else []
        parts += [f"has {_listed(strange)}, which the design has not"] if strange else []
        raise MeshError(
            f"of the regions that {design.design.name} needs, {path.name} {' and '.join(parts)} "
            f"(found: {given})"
        )
    order, inverse = np.unique(lower, return_inverse=True)
    return np.array([target[str(name)] for name in order])[inverse.reshape(-1)].astype(np.int64)


def _listed(names: Iterable[str]) -> str:
    every = list(names)
    return ", ".join(every if len(every) < 8 else [*every[:3], "...", every[-1]])


def check_places(mesh: Mesh, design: Design, path: Path) -> None:
    """MeshError unless volumes are the design's, and plates and core lie where it has them."""
    fit = volumes_by_region(mesh, design)
    whole = sum(row["volume"] for row in fit.regions.values())
    target = sum(row["target"] for row in fit.regions.values())
    wrong = [
        f"{name} {row['volume']:.6g} of {row['target']:.6g} mm^3"
        for name, row in fit.regions.items()
        if not row["error"] <= VOLUME_ERROR
    ]
    if wrong or not fit.body_error <= VOLUME_ERROR:
        parts = wrong or [f"the body {whole:.6g} of {target:.6g} mm^3"]
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
                f"only {share:.0%} of {mesh.region_name(region)} in {path.name} lie where "
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
    target = outer_areas(mesh, design)
    faces = outer_faces(design.body, mesh.symmetric)
    for name in ("base", "contact"):
        area = float(curved_areas(mesh.points, mesh.facets[name]).sum())
        allowed = AREA_ERROR * target[name]
        if any(name in (joined := face.boundaries) and len(joined) > 1 for face in faces):
            # No edge tells where it ends: a row of facets at its border may be the neighbour's.
            edge = float(edge_lengths(mesh.points, mesh.facets[name][:, :3]).max())
            allowed += edge * 2.0 * (design.body.width_mm + design.body.depth_mm)
            allowed = min(allowed, 0.5 * target[name])
        if not abs(area - target[name]) <= allowed:
            raise MeshError(
                f"{name!r} in {path.name} has {area:.6g} mm^2 where {design.design.name} has "
                f"{target[name]:.6g} mm^2{' (its half)' if mesh.symmetric else ''}: facets of it "
                "lack that name, or others have it"
            )


def check_joined(points: Array, corners: IntArray, path: Path) -> None:
    """MeshError where cells (c, 4) overlap (three at a facet), or are not all joined by facets."""
    facets, _, cells = tetra_facets(corners)
    keys = facet_keys(facets, len(points))
    first, second = same_keys(keys)
    thrice = first[np.isin(second, first)]
    if len(thrice):
        owners = np.unique(cells[thrice])
        raise MeshError(
            f"{path.name} has {len(np.unique(keys[thrice]))} facets that more than two tetrahedra "
            f"share {_where(points[corners[owners]].mean(axis=1))}: cells overlap or are double"
        )
    count, piece = pieces(cells[first], cells[second], len(corners))
    if count > 1:
        size = np.bincount(piece)
        away = piece != size.argmax()
        raise MeshError(
            f"{path.name} falls into {count} pieces that share no facet; {int(away.sum())} of "
            f"{len(piece)} tetrahedra are not joined to the rest "
            f"{_where(points[corners[away]].mean(axis=1))} (in Gmsh: fragment the volumes, so "
            "that they share their surfaces)"
        )


def check_outside(points: Array, faces: BoundaryFacets, design: Design, path: Path) -> None:
    """MeshError where the mesh's outside runs inside the body: a crack, or cells that lack."""
    corners = faces.corners[faces.outside]
    places = points[corners]
    edge = np.linalg.norm(places - np.roll(places, 1, axis=1), axis=2).max(axis=1)
    off = faces.misfit[faces.outside]
    far = off > OFF * edge + OFF_HEIGHT * crest_height(design.body)
    if far.any():
        raise MeshError(
            f"{int(far.sum())} facets on the outside of {path.name} lie up to "
            f"{off[far].max():.3g} mm off the faces of {design.design.name} "
            f"{_where(places[far].mean(axis=1))}: the mesh is torn, or cells lack"
        )
    if design.body.shape == "step":  # its solid may have voids
        return
    sides = np.sort(corners[:, [[0, 1], [1, 2], [2, 0]]], axis=2).reshape(-1, 2)
    _, edges = np.unique(sides[:, 0] * len(points) + sides[:, 1], return_inverse=True)
    owner = np.repeat(np.arange(len(corners)), 3)
    first, second = same_keys(edges.reshape(-1))
    count, piece = pieces(owner[first], owner[second], len(corners))
    if count > 1:
        inner = piece != np.bincount(piece).argmax()
        raise MeshError(
            f"the outside of {path.name} has {count} surfaces, where that of {design.design.name} "
            f"has one: {int(inner.sum())} facets bound a cavity or crack "
            f"{_where(places[inner].mean(axis=1))}"
        )


def _where(middles: Array) -> str:
    x, y, z = middles[0]
    return f"(near x = {x:.4g}, y = {y:.4g}, z = {z:.4g})"
