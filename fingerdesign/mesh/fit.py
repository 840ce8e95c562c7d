"""Volumes, areas and faces of a mesh against those of its design, in closed form (numpy only)."""

import re
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import IntArray
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.profile import profile_of
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import core_volume, face_areas, outline_volume, plate_volume
from fingerdesign.mesh.cells import outer_facets
from fingerdesign.mesh.measures import cell_volumes, curved_areas, curved_volumes
from fingerdesign.mesh.tetra.carriers import core_faces, outer_faces, plane, plate_faces
from fingerdesign.mesh.types import Mesh
from fingerdesign.shapes.faces import Carrier

_TOUCHES = 1e-6  # mm: a plate that ends in a face of the body


def worst_area_error(mesh: Mesh, design: Design) -> float:
    """Greatest relative error of an outer face's area, by the curved facets; 0 in the section."""
    if mesh.dimension == 2:
        return 0.0
    target = outer_areas(mesh, design)
    none = np.zeros((0, 6), dtype=np.int64)
    found = {n: curved_areas(mesh.points, mesh.facets.get(n, none)).sum() for n in target}
    groups = _joined(target, outer_faces(design.body, mesh.symmetric))
    areas = [[sum(each[name] for name in group) for each in (found, target)] for group in groups]
    return max(abs(float(area) / given - 1.0) for area, given in areas if given > 0.0)


def _joined(names: Iterable[str], faces: Iterable[Carrier]) -> list[set[str]]:
    """Names in groups: no edge shows where one ends and the next begins on one face."""
    groups = [{name} for name in names]
    for face in faces:
        joined = [group for group in groups if group & set(face.boundaries)]
        groups = [group for group in groups if group not in joined]
        groups += [set().union(*joined)] if joined else []
    return groups


def outer_areas(mesh: Mesh, design: Design) -> dict[str, float]:
    """Areas of the outer faces by name, mm^2, less the mouths of sheets' slots."""
    target = dict(face_areas(design.body, mesh.symmetric))
    if design.plates.model != "sheet":
        return target
    for frame in plate_frames(design):
        mouth = frame.length * frame.thickness
        for name, area in _mouths(frame, design, mesh.symmetric, mouth):
            if name in target:
                target[name] -= area
    return target


def _mouths(
    frame: PlateFrame, design: Design, symmetric: bool, mouth: float
) -> list[tuple[str, float]]:
    """Outer faces that a slot opens in, and the area that it takes of each."""
    body = design.body
    if frame.along == "x":
        low, high = -0.5 * body.depth_mm, 0.5 * body.depth_mm
        found = [("end", mouth)] if frame.high > high - _TOUCHES else []
        if symmetric:
            return [*found, ("symmetry", mouth)]
        return [*found, ("end", mouth)] if frame.low < low + _TOUCHES else found
    half = 0.5 * body.width_mm
    share = 0.5 if symmetric else 1.0
    sides = (frame.high > half - _TOUCHES) + (frame.low < -half + _TOUCHES)
    found = [("side", share * mouth * sides)] if sides else []
    if symmetric:
        level = abs(frame.axis[0]) > 0.5  # along z: cut across; upright: cut along its mid-surface
        found.append(("symmetry", frame.span * (frame.thickness if level else frame.length)))
    return found


@dataclass(frozen=True)
class VolumeFit:
    """Volumes (mm^3; in the section areas, mm^2) against the closed forms; errors are relative.

    regions: by name "volume" (curved cells), "straight" (by corners), "target" and "error"
    """

    regions: dict[str, dict[str, float]]
    body_error: float
    body_error_straight: float
    worst_plate_error: float


def meshed_plates(mesh: Mesh, design: Design) -> tuple[PlateFrame, ...]:
    """The frames that the mesh has, or should have: all in space; those that z = 0 cuts in 2-D."""
    if design.plates.model == "none":
        return ()
    frames = plate_frames(design)
    if mesh.dimension == 3:
        return frames
    return tuple(f for f in frames if f.along == "x" and f.low < 0.0 < f.high)


def target_volumes(mesh: Mesh, design: Design) -> dict[int, float]:
    """Volume by region, mm^3 (section: area, mm^2), of the design's solid parts there."""
    frames = meshed_plates(mesh, design)
    if mesh.dimension == 2:
        whole = profile_of(design.body).area
        plates = {frame.index + 1: frame.length * frame.thickness for frame in frames}
        core = design.body.core
        inner = core.width_mm * core.height_mm if core is not None else 0.0
    else:
        whole = outline_volume(design.body, mesh.symmetric)
        plates = {frame.index + 1: plate_volume(frame, mesh.symmetric) for frame in frames}
        inner = core_volume(design, mesh.symmetric)
    target = {0: whole - sum(plates.values()) - inner}
    if design.plates.model == "solid":
        target |= plates
    if inner:
        target[design.core_region] = inner
    return target


def volumes_by_region(mesh: Mesh, design: Design) -> VolumeFit:
    """Compare the volume of every region with the design's; a missing region has the error 1."""
    target = target_volumes(mesh, design)
    count = max(int(mesh.regions.max(initial=0)), *target) + 1
    curved = np.bincount(mesh.regions, curved_volumes(mesh.points, mesh.cells), count)
    straight = np.bincount(mesh.regions, cell_volumes(mesh.points, mesh.corners), count)
    present = np.bincount(mesh.regions, minlength=count) > 0
    regions = {}
    for number in range(count):
        if not present[number] and number not in target:
            continue
        requested = target.get(number, 0.0)
        regions[mesh.region_name(number)] = {
            "volume": float(curved[number]),
            "straight": float(straight[number]),
            "target": float(requested),
            "error": _error(float(curved[number]), requested),
        }
    whole = sum(target.values())
    strange = [n for n in range(1, count) if present[n] and n not in target]
    plates = [row["error"] for name, row in regions.items() if name not in ("elastomer", "core")]
    return VolumeFit(
        regions,
        _error(float(curved.sum()), whole),
        _error(float(straight.sum()), whole),
        1.0 if strange else max(plates, default=0.0),
    )


def _error(found: float, target: float) -> float:
    return abs(found / target - 1.0) if target > 0.0 else 1.0


def face_distances(mesh: Mesh, design: Design) -> dict[str, float]:
    """Greatest distance (mm) of the nodes of each named face, mid-nodes too, to the CAD face. Next
    to the mesh's named facets, "plate_k" and "core": the surface of that region."""
    solids = {frame.index + 1: plate_faces(frame) for frame in meshed_plates(mesh, design)}
    if design.body.core is not None:
        solids[design.core_region] = core_faces(design.body)
    outer = outer_faces(design.body, mesh.symmetric)
    found = {}
    for name, facets in mesh.facets.items():
        slot = re.fullmatch(r"plate_(\d+)_(upper|lower|end|cap)", name)
        own = solids.get(int(slot[1]) + 1) if slot else None
        faces = own or [face for face in outer if name in face.boundaries]
        if faces:
            found[name] = _greatest(mesh, np.unique(facets), faces)
    cut: list[Carrier] = [plane("symmetry", (0.0, 0.0, -1.0), 0.0)] if mesh.symmetric else []
    for number in sorted(solids.keys() & set(mesh.regions.tolist())):
        surface = outer_facets(mesh.cells[mesh.regions == number])
        nodes = np.unique(np.concatenate([facets.ravel() for facets in surface]))
        found[mesh.region_name(number)] = _greatest(mesh, nodes, solids[number] + cut)
    return found


def _greatest(mesh: Mesh, nodes: IntArray, faces: list[Carrier]) -> float:
    points = mesh.in_space[nodes]
    away = np.min([np.abs(face.misfit(points)) for face in faces], axis=0)
    return float(away.max(initial=0.0))
