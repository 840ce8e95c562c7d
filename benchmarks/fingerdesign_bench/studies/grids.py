"""``fingerdesign bench grids``: does the gage area follow the stick area in 3-D, by which grids?

The fundamental case on half of the finger, each row cut into four, so that each rank correlation
rests on 32 points: with eight, a few large steps decide it. Beside the order of the gage area A
stands its size: at full stick, in the increment in which the last spot that sticks gives way, and
in those in which nothing sticks any more.
"""

import time
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.path import object_at_touch
from fingerdesign.analysis.slip_study import slip_studies
from fingerdesign.analysis.stages import (
    STUDY_FRICTION,
    condense,
    in_wide_zone,
    make_mesh,
    one_thread,
    zone_of,
)
from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design
from fingerdesign.contact.measures import COMPLETE_SLIP
from fingerdesign.contact.problem import contact_problem
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.zone import Zone
from fingerdesign.records.arrays import SlipStudy
from fingerdesign.runtime.progress import Report

FRICTIONS = tuple(STUDY_FRICTION)
PIECES = 4  # of each row
FLAT = "plane-strain"  # in the place of a mesher: what one section says
SHORT = {"plates.cover_mm": 0.6, "plates.length_mm": 0.7}  # plates nearer to the surface


@dataclass(frozen=True)
class GridRow:
    """One finger read by one kind of grid, at FRICTIONS: rank correlations of the gage area with
    the stick area; the gage area (mm) where most sticks, where the last spot gives way, and the
    greatest where nothing sticks any more (None: it still sticks at the end). Then the least and
    greatest area with a response at all of them, the size of the model, seconds; and what sticks at
    z = 0 and the gage area (mm) after each increment from the first response on."""

    finger: str
    grid: str
    correlations: tuple[float | None, ...]
    full_stick_mm: tuple[float, ...]
    giving_way_mm: tuple[float | None, ...]
    slipping_mm: tuple[float | None, ...]
    least_mm: float
    greatest_mm: float
    dofs: int
    contact_nodes: int
    seconds: float
    stick_length_mm: tuple[tuple[float, ...], ...]
    gage_area_mm: tuple[tuple[float, ...], ...]


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
    pieces: int = PIECES,
) -> list[GridRow]:
    """Each finger read by axial grids and tees; by pairs too where the design has them. ``pieces``
    of each row of the path; mesher FLAT: one section in plane strain, by its own sizes."""
    values: dict[str, object] = {"mesh.contact_size_mm": contact_size_mm}
    if mesher != FLAT:
        values["mesh.mesher"] = mesher
    found = []
    for name, design in designs.items():
        grids = dict.fromkeys(("axial", "tee", design.gages.grid))
        for grid in grids:
            report(f"{name}, {grid}")
            own = {"gages.bridge": None, "gages.grid": grid}
            if grid != design.gages.grid:
                own["gages.transverse_weight"] = None
            finger = with_values(design, values | own | {"mesh.layers": layers})
            found.append(_row(name, grid, finger, FLAT if mesher == FLAT else "3d", pieces))
    return found


def _row(name: str, grid: str, design: Design, fidelity: str, pieces: int) -> GridRow:
    scene, start = fundamental_scene(), time.perf_counter()
    rows = [(row[0], row[1]) for row in scene.path.rows]

    def work(zone: Zone) -> tuple[int, int, tuple[SlipStudy, ...]]:
        model = condense(design, make_mesh(design, fidelity, zone), zone, scene)
        rigid = object_at_touch(scene.object, design.body)
        problem = contact_problem(model.reduced, rigid, scene.object.friction_coefficient)
        with one_thread():
            face, share = design.gages.face, design.gages.area_share
            studies = slip_studies(problem, rows, face, FRICTIONS, pieces, share)
        return model.dofs, problem.shape[0], studies

    case = Case(design, scene, fidelity, grips=False)
    dofs, nodes, studies = in_wide_zone(design, zone_of(case, scene), work)
    reported = [_reported(study, study.gage_area_mm) for study in studies]
    areas = np.concatenate(reported)
    least = COMPLETE_SLIP[2 if fidelity == FLAT else 3]
    sizes = [sizes_of(study.stick_ratio, study.gage_area_mm, least) for study in studies]
    return GridRow(
        name,
        grid,
        tuple(study.rank_correlation for study in studies),
        tuple(float(study.gage_area_mm[np.argmax(study.stick_length_mm)]) for study in studies),
        tuple(giving_way for giving_way, _ in sizes),
        tuple(slipping for _, slipping in sizes),
        float(areas.min()),
        float(areas.max()),
        dofs,
        nodes,
        time.perf_counter() - start,
        tuple(_reported(study, study.stick_length_mm) for study in studies),
        tuple(reported),
    )


def _reported(study: SlipStudy, values: Array) -> tuple[float, ...]:
    """Values from the first increment on that has a response."""
    first = int(np.isfinite(study.response).all(axis=1).argmax())
    return tuple(round(float(value), 4) for value in values[first:])


def sizes_of(stick_ratio: Array, area: Array, least: float) -> tuple[float | None, float | None]:
    """The gage area where the last spot gives way, and the greatest after it, of values after each
    increment; None where the path does not come to that. Below the ratio ``least`` all slips.

    >>> sizes_of(np.array([0.9, 0.4, 0.0, 0.0]), np.array([5.0, 4.0, 2.0, 0.5]), 0.05)
    (2.0, 0.5)
    """
    sticks = np.flatnonzero(stick_ratio >= least)
    after = area[sticks[-1] + 1 :] if len(sticks) else area[:0]
    return (
        float(after[0]) if len(after) else None,
        float(after[1:].max()) if len(after) > 1 else None,
    )
