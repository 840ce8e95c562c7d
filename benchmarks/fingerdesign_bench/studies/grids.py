"""``fingerdesign bench grids``: does the gage area follow the stick area in 3-D, by which grids?

The fundamental case on half of the finger, each row cut into four, so that each rank correlation
rests on 32 points: with eight, a few large steps decide it.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.path import object_at_touch
from fingerdesign.analysis.stages import (
    STUDY_FRICTION,
    condense,
    in_wide_zone,
    make_mesh,
    one_thread,
    zone_of,
)
from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design
from fingerdesign.contact.problem import contact_problem
from fingerdesign.control.slip_study import slip_studies
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.zone import Zone
from fingerdesign.records.arrays import SlipStudy
from fingerdesign.runtime.progress import Report

FRICTIONS = tuple(STUDY_FRICTION)
PIECES = 4  # of each row
SHORT = {"plates.cover_mm": 0.6, "plates.length_mm": 0.7}  # plates nearer to the surface


@dataclass(frozen=True)
class GridRow:
    """One finger read by one kind of grid: rank correlations of the gage area with the stick area
    at FRICTIONS, least and greatest area (mm) with a response, the size of the model, seconds."""

    finger: str
    grid: str
    correlations: tuple[float | None, ...]
    least_mm: float
    greatest_mm: float
    dofs: int
    contact_nodes: int
    seconds: float


def fingers(names: Sequence[str]) -> dict[str, Design]:
    """Designs by name; without names maeno2000, and the same with shorter plates nearer to the
    surface. DesignError for those without gages, of which there is nothing to correlate."""
    if names:
        found = {name: find_design(name) for name in names}
        remedy = "add plates: their gages are what is read"
        faults = [
            Fault(f"{name}: plates.count", 0, "at least 1", remedy)
            for name, design in found.items()
            if not design.plates.number
        ]
        if faults:
            raise DesignError(faults)
        return found
    own = find_design("maeno2000")
    return {"maeno2000": own, "cover 0.6, plates 0.7 mm": with_values(own, SHORT)}


def measure_grids(
    designs: dict[str, Design],
    mesher: str,
    contact_size_mm: float,
    layers: int,
    report: Report = lambda message: None,
) -> list[GridRow]:
    """Each finger read by axial grids and tees; by pairs too where the design has them."""
    values: dict[str, object] = {"mesh.mesher": mesher, "mesh.contact_size_mm": contact_size_mm}
    found = []
    for name, design in designs.items():
        grids = dict.fromkeys(("axial", "tee", design.gages.grid))
        for grid in grids:
            report(f"{name}, {grid}")
            own = {"gages.bridge": None, "gages.grid": grid}
            if grid != design.gages.grid:
                own["gages.transverse_weight"] = None
            finger = with_values(design, values | own | {"mesh.layers": layers})
            found.append(_row(name, grid, finger))
    return found


def _row(name: str, grid: str, design: Design) -> GridRow:
    scene, start = fundamental_scene(), time.perf_counter()
    rows = [(row[0], row[1]) for row in scene.path.rows]

    def work(zone: Zone) -> tuple[int, int, tuple[SlipStudy, ...]]:
        model = condense(design, make_mesh(design, "3d", zone), zone, scene)
        rigid = object_at_touch(scene.object, design.body)
        problem = contact_problem(model.reduced, rigid, scene.object.friction_coefficient)
        with one_thread():
            studies = slip_studies(problem, rows, design.gages.face, FRICTIONS, PIECES)
        return model.dofs, problem.shape[0], studies

    case = Case(design, scene, "3d", grips=False)
    dofs, nodes, studies = in_wide_zone(design, zone_of(case, scene), work)
    areas = np.concatenate([study.gage_area_mm for study in studies])
    responding = areas[areas > 0.0]
    return GridRow(
        name,
        grid,
        tuple(study.rank_correlation for study in studies),
        float(responding.min(initial=np.inf)) if len(responding) else 0.0,
        float(areas.max()),
        dofs,
        nodes,
        time.perf_counter() - start,
    )
