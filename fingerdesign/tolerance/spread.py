"""Spread of fingers as made, by one analysis and its derivatives.

    variance = sum over parameters of (derivative x standard deviation)^2

Readings also scatter by their gages' factors. Once calibrated on a bench, a finger's rubber and
gages are known, and what is left is the plates' places.
"""

import time
from collections.abc import Callable, Iterator

import numpy as np

from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.forecast.forecast import impossible
from fingerdesign.arrays import Array
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.fem.model import element_of
from fingerdesign.mold.plan.planning import plan_mold
from fingerdesign.sensitivity.derive import Sensitivity, sensitivity
from fingerdesign.sensitivity.variant import differentiable
from fingerdesign.tolerance.area import gage_areas, sure_response
from fingerdesign.tolerance.cast import Draws, cast_fingers, refuse_draws, yield_by_motion
from fingerdesign.tolerance.record import RowData, SourceData, ToleranceData
from fingerdesign.tolerance.sources import (
    GAINS,
    UNIFORM,
    Source,
    all_tolerances,
    by_source,
    sources_of,
    unknown_places,
)
from fingerdesign.version import versions

_OUTPUTS = ("normal_force", "tangential_force", "stick_ratio", "reading")


def tolerance(
    design: Design,
    scene: Scene | None = None,
    fidelity: str = "plane-strain",
    report: Callable[[str], None] = lambda message: None,
    scene_name: str = "",
    draws: Draws | None = None,
) -> ToleranceData:
    """Analyse a finger and the spread of those that are cast after it. ``scene`` None: the
    fundamental case; draws: also lift real models of such fingers. Raises DesignError for a wrong
    input (MoldRefused where no mold is found), SolverError where a row has no answer."""
    start = time.perf_counter()
    given, design = design, differentiable(design)
    case = Case(design, None, fidelity, fields=False, for_page=False, studied=False)
    own = fundamental_scene(design) if scene is None else scene
    if faults := impossible(case, own) or unknown_places(design):
        raise DesignError(faults)
    sources = sources_of(design, plan_mold(design), space=fidelity == "3d")
    if draws is not None:
        refuse_draws(case, sources, draws)
    report("analysing")
    names = [name for source in sources for name in source.parameters]
    found = sensitivity(design, own, names, fidelity)
    parts = variances(found, sources)
    readings = np.sqrt(np.sum(parts["reading"], axis=0).mean(axis=0))  # of gages, RMS over rows
    areas, parts["gage_area"] = gage_areas(design, own, found, sources)
    cast = cast_fingers(case, own, found, sources, draws, report) if draws else None
    return ToleranceData(
        schema_version=1,
        design=design.design.name,
        scene=scene_name or ("fundamental" if scene is None else "scene"),
        fidelity=fidelity,
        rows=tuple(_row(found, sources, parts, areas, k) for k in range(found.readings.rows)),
        sources=tuple(_sources(found, sources, parts)),
        gage_std_microstrain=tuple(readings.tolist()),
        yield_by_motion=yield_by_motion(found, sources),
        cast=cast,
        seconds=round(time.perf_counter() - start, 2),
        versions=versions(),
        gage_response=sure_response(own, found, sources),
        other_model=tuple(left_out(given)),
    )


def left_out(design: Design) -> Iterator[str]:
    """The keys whose value :func:`differentiable` replaces by another model."""
    if design.plates.number and design.plates.model != "solid":
        yield f"plates.model = '{design.plates.model}'"
    if element_of(design) != element_of(differentiable(design)):
        yield f"mesh.element = '{design.mesh.element}'"


def variances(found: Sensitivity, sources: list[Source]) -> dict[str, list[Array]]:
    """Variance (k,), of readings (k, plates), by each source, and last by the gages' gains."""
    stds, parts = UNIFORM * all_tolerances(sources), dict[str, list[Array]]()
    for name in _OUTPUTS:
        squares = (np.nan_to_num(getattr(found, name)) * stds) ** 2
        own = [part.sum(axis=-1) for part in by_source(squares, sources)]
        parts[name] = [*own, np.zeros(squares.shape[:-1])]
    parts["reading"][-1] = (GAINS * UNIFORM * found.readings.reading) ** 2
    return parts


def _row(
    found: Sensitivity,
    sources: list[Source],
    parts: dict[str, list[Array]],
    areas: list[float | None],
    k: int,
) -> RowData:
    readings = found.readings
    left = [place for place, source in enumerate(sources) if not source.known]

    def pair(name: str) -> tuple[float, float]:
        every = np.array([part[k] for part in parts[name]]).reshape(len(sources) + 1, -1)
        if not every.size:
            return 0.0, 0.0
        made, calibrated = (np.sqrt(own.sum(axis=0).mean()) for own in (every, every[left]))
        return float(made), float(calibrated)

    return RowData(
        normal_force_N=float(readings.normal_force[k]),
        tangential_force_N=float(readings.tangential_force[k]),
        stick_ratio=float(readings.stick_ratio[k]),
        largest_reading_microstrain=float(np.abs(readings.reading[k]).max(initial=0.0)),
        normal_force_std_N=pair("normal_force"),
        tangential_force_std_N=pair("tangential_force"),
        stick_ratio_std=pair("stick_ratio"),
        reading_std_microstrain=pair("reading"),
        gage_area_mm=areas[k],
        gage_area_std_mm=pair("gage_area"),
        on_kink=float(found.on_kink[k]),
    )


def _sources(
    found: Sensitivity, sources: list[Source], parts: dict[str, list[Array]]
) -> list[SourceData]:
    """The causes, the one that adds most to the readings (relative to their row's) first."""
    most = np.abs(found.readings.reading).max(axis=1, initial=0.0)
    weight = np.divide(1.0, most**2, out=np.zeros_like(most), where=most > 0.0)
    sizes = np.array([(part * weight[:, None]).sum() for part in parts["reading"]])
    if not sizes.any():  # no gages: the forces decide
        sizes = np.array([part.sum() for part in parts["normal_force"]])
    shares = sizes / max(float(sizes.sum()), 1e-300)
    rates = found.reading if found.reading.size else found.normal_force
    effects = np.abs(rates.reshape(-1, len(found.names))).max(axis=0)
    effects *= UNIFORM * all_tolerances(sources)
    rows = []
    for source, own, share in zip(sources, by_source(effects, sources), shares, strict=False):
        tolerance, worst = max(source.tolerances), source.parameters[own.argmax()]
        about = source.words, tolerance, source.unit
        rows.append(SourceData(*about, float(share), worst, source.known))
    if found.reading.size:
        rows.append(SourceData("gages' factors", GAINS, "of one", float(shares[-1]), "", True))
    return sorted(rows, key=lambda row: -row.share)
