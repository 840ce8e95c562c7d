"""Plane strain and 3-D on the same section, compared for each model of a study.

The 3-D model is the section swept through layers, so what is left between the two is the
assumption, not the mesh. For each approach the finger is pressed in two rows and sheared in two:
in 3-D, in plane strain by the same motions, and in plane strain by the forces of 3-D. table.py
compares them.
"""

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.analysis.fidelity.models import Model, Solved, solve
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.arrays import Array
from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.scene import Scene
from fingerdesign.errors import SolverError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.files import Record, resumed
from fingerdesign_bench.plane_strain.file import Point

JOURNAL = "plane_strain.sqlite"
FORMAT = 1  # It is raised when the meaning of the records changes.
READ = ("normal_force", "tangential_force", "contact_width", "stick_ratio", "gages")


def run_study(points: Iterable[Point], journal: Path, report: Report) -> list[Record]:
    """Return the records of all points. Those that the journal has are not made again."""
    by_key = {key_of(point): point for point in points}

    def words(key: str, _record: Record) -> str:
        point = by_key[key]
        return point.name or ", ".join(f"{name} {at:g}" for name, at in point.values.items())

    found = resumed(journal, str(FORMAT), by_key, compare, report, words)
    return [
        record | {"name": by_key[key].name, "values": by_key[key].values}
        for key, record in found.items()
    ]


def key_of(point: Point) -> str:
    """Digest of the design's content, the scene and the meshes."""
    parts = (point.design.digest(), point.scene.model_dump(), point.mesh.model_dump())
    text = json.dumps([*parts, point.layers], sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def compare(point: Point) -> Record:
    """One model's record: what it is, its cost, and for each approach the readings of "space" (the
    3-D model), "motion" (plane strain, equal motion) and "force" (equal force; None with "why"
    where plane strain cannot carry the forces)."""
    deepest = scene_of(point, max(point.scene.approach_mm))
    flat, solid = models_of(point)
    section, space = solve(point.design, deepest, flat), solve(point.design, deepest, solid)
    design = point.design
    body, plates = design.body, design.plates
    return {
        "name": point.name,
        "values": point.values,
        "radius_mm": body.arc_radius_mm,
        "depth_mm": body.depth_mm,
        "width_mm": body.width_mm,
        "height_mm": float(crest_height(body)),
        "cover_mm": plates.cover_mm,
        "poissons_ratio": design.material_of("body").poissons_ratio,
        "span_share": _span_share(point),
        "friction_coefficient": point.scene.friction_coefficient,
        "dofs": space.dofs,
        "seconds": round(space.total + section.total, 2),
        "rows": [_row(point, approach, section, space) for approach in point.scene.approach_mm],
    }


def models_of(point: Point) -> tuple[Model, Model]:
    """Plane strain and 3-D on the same section."""
    own = {name: getattr(point.mesh, name) for name in SectionMesh.model_fields}
    sizes = SectionMesh.model_construct(**own)
    return (
        Model("plane strain", sizes, element="mixed"),
        Model("3-D", sizes, layers=point.layers, mesher="sweep", element="mixed"),
    )


def scene_of(point: Point, approach: float) -> Scene:
    """Press in two rows, shear in two; one increment each, as for the shipped table."""
    shear = point.scene.shear_per_approach * approach
    rows = [[0.5 * approach, 0.0], [approach, 0.0], [approach, 0.5 * shear], [approach, shear]]
    return _scene(point, {"increments_mm": rows, "substeps": 1})


def _scene(point: Point, path: dict[str, Any]) -> Scene:
    rigid = {"friction_coefficient": point.scene.friction_coefficient}
    return Scene.model_validate({"object": rigid, "path": path})


def _row(point: Point, approach: float, section: Solved, space: Solved) -> Record:
    """One approach's readings."""
    truth = space.along(scene_of(point, approach))
    moved = section.along(scene_of(point, approach))
    found: Record = {"approach_mm": approach, "space": _plain(truth), "motion": _plain(moved)}
    rows = np.column_stack([truth.normal_force, truth.tangential_force]).tolist()
    forces = {"control": "force", "increments_N": rows, "substeps": 1}
    try:
        forced = section.along(_scene(point, forces))
        return found | {"force": _plain(forced)}
    except SolverError as error:
        return found | {"force": None, "why": str(error)}


def _plain(readings: Readings) -> Record:
    """Readings as lists of numbers, to seven digits."""

    def digits(values: Array) -> Any:
        flat = [float(f"{value:.7g}") for value in values.ravel()]
        return np.array(flat).reshape(values.shape).tolist()

    return {name: digits(getattr(readings, name)) for name in READ}


def _span_share(point: Point) -> float:
    plates = point.design.plates
    if plates.model == "none" or not plates.number:
        return 0.0
    depth = point.design.body.depth_mm
    return (plates.span_mm if plates.span_mm is not None else depth) / depth
