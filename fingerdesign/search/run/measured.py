"""Parts of an outcome from an analysis: metrics, thinned traces, grips."""

import math
import statistics
from collections.abc import Iterable, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.shortfall import area_correlation, shortfalls, total
from fingerdesign.analysis.verdicts import best_area_share, verdict_view
from fingerdesign.design.schema import Design
from fingerdesign.errors import SolverError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import core_volume, outline_volume, plate_volume
from fingerdesign.records.arrays import OPEN, SLIP, ContactHistory
from fingerdesign.records.outcome import GripOutcome, Numbers, Traces, Validity, bounded
from fingerdesign.records.result import GripResult, IncrementResult, Result
from fingerdesign.report.style import evenly_spaced
from fingerdesign.runtime.threads import one_thread
from fingerdesign.search.study.file import Cost
from fingerdesign.sensing.train.stick_error import SensorErrors, stick_error

MOST_INCREMENTS, MOST_CONTACT, MOST_STEPS = 40, 120, 60
_PULLED = 0.01  # of the normal force: what pressing an uneven finger gives is no pull
_ROOM = 0.15  # of what is touched, shown around it
MARKS = {OPEN: ".", SLIP: "/"}  # what sticks is "#"
_FIRST_SLIP = 0.9  # of the greatest stick ratio of the pull: pressing alone slips at the rims


def metrics_of(design: Design, cost: Cost, analysis: Analysis) -> dict[str, float | None]:
    """The metrics of this analysis; "core_seconds" is the caller's."""
    rows = analysis.result.increments
    deepest = max(rows, key=lambda row: row.approach_mm)
    pressed = deepest.approach_mm > 0.0
    return {
        **verdict_metrics(analysis.result),
        "normal_force_N": rows[-1].normal_force_N,
        "tangential_force_N": rows[-1].tangential_force_N,
        "stiffness_N_per_mm": deepest.normal_force_N / deepest.approach_mm if pressed else None,
        "peak_pressure_MPa": max(row.peak_pressure_MPa for row in rows),
        "first_slip_N": _first_slip(rows),
        "gage_response": _gage_response(analysis),
        **own_metrics(design, cost),
    }


def verdict_metrics(result: Result) -> dict[str, float | None]:
    """The metrics of verdicts: of grips, gages and their area; failed_verdicts None where nothing
    was judged."""
    measured, best = result.measurability, best_area_share(result.slip_studies)
    judged = [each.status for each in verdict_view(result).verdicts if each.status != "note"]
    return {
        **grip_metrics(result.grips),
        "smallest_stick_change": None if measured is None else measured.smallest_stick_change,
        "area_correlation": area_correlation(result.slip_studies),
        "best_area_share": None if best is None else best[0],
        "shortfall": total(shortfalls(result)),
        "failed_verdicts": float(judged.count("fail")) if judged else None,
    }


def stick_error_of(case: Case, analysis: Analysis) -> tuple[float | None, tuple[str, ...]]:
    """The gage error of the stick ratio, and why there is none.

    Grips are as deep as the stage goes, or, where a scene is given, as its path: the model's
    contact candidates reach no farther. Dead gages are known to be dead, and not sampled.
    """
    problem, design = analysis.problem, case.design
    if problem is None:
        return None, ()
    grip = design.grip
    dead = grip.hardware.dead_gages
    sampled = [k for k, plate in enumerate(case.gage_array) if plate not in dead]
    if not sampled:
        return None, ()
    problem = replace(problem, model=problem.model.with_gages(sampled))
    deepest = max(row.approach_mm for row in analysis.result.increments)
    reach = deepest if case.scene is not None else grip.max_approach_mm
    try:
        with one_thread():
            listening = SensorErrors.of(design.rig.hardware, design.gage_factor)
            return stick_error(problem, design.gages.face, reach, listening, grip.seed), ()
    except SolverError as error:
        return None, (f"no gage error of the stick ratio: {error}",)


def own_metrics(design: Design, cost: Cost) -> dict[str, float | None]:
    """The metrics of the design alone: plates, rubber, cost."""
    plates = design.plates.number
    inserts = core_volume(design) + sum(plate_volume(frame) for frame in plate_frames(design))
    rubber = (outline_volume(design.body) - inserts) * 1e-3
    gages = plates * design.gages.faces
    price = cost.fixed + cost.plate * plates + cost.gage * gages + cost.silicone_per_ml * rubber
    return {"plates": float(plates), "rubber_volume_ml": rubber, "cost": price}


def mesh_validity(result: Result) -> Validity:
    """The ladder's estimate of the mesh's error, where it was climbed."""
    if result.ladder is None:
        return Validity()
    worst = max(result.ladder.error_estimates.values(), default=None)
    why = result.ladder.why_ended
    return Validity(mesh_error=worst, sentences=(why,) if why else ())


def traces_of(analysis: Analysis) -> Traces:
    """The path's numbers, gages and contact map, thinned to what a comparison shows."""
    every, contact = analysis.result.increments, analysis.contact
    chosen = evenly_spaced(len(every), MOST_INCREMENTS)
    rows = [every[k] for k in chosen]
    along = ("approach_mm", "shear_mm", "normal_force_N", "tangential_force_N", "stick_ratio")
    path = (*along, "contact_width_mm")
    places = {name: _numbers(getattr(row, name) for row in rows) for name in path}
    status: tuple[str, ...] = ()
    if contact is not None:
        shown = _shown_points(contact)
        places["contact_x_mm"] = _numbers(contact.points[shown, 0])
        if contact.dimension == 3:
            places["contact_z_mm"] = _numbers(contact.points[shown, 2])
        status = tuple("".join(MARKS.get(s, "#") for s in contact.status[k][shown]) for k in chosen)
    by_index = {frame.index: frame.x for frame in analysis.plates}
    return Traces(
        **places,
        gage_x_mm=_numbers(by_index[gage.plate] for gage in rows[0].gages),
        gages=tuple(_numbers(gage.reading for gage in row.gages) for row in rows),
        status=status,
    )


def grips_of(analysis: Analysis) -> tuple[GripOutcome, ...]:
    return tuple(
        grip_outcome(grip, _numbers(trace.normal_force), _numbers(trace.tangential_force))
        for grip, trace in zip(analysis.result.grips, analysis.grip_traces, strict=True)
    )


def grip_outcome(grip: GripResult, normal: Numbers, tangential: Numbers) -> GripOutcome:
    """A grip of an outcome, its path of forces thinned."""
    facts: dict[str, Any] = {
        each.name: getattr(grip, each.name, ()) for each in fields(GripOutcome)
    }
    chosen = evenly_spaced(len(normal), MOST_STEPS)
    normal, tangential = (tuple(path[k] for k in chosen) for path in (normal, tangential))
    return replace(GripOutcome(**facts), normal_force_N=normal, tangential_force_N=tangential)


def grip_metrics(grips: Sequence[GripResult]) -> dict[str, float | None]:
    """The metrics of grips; none without grips. Of several masses the worst counts.

    Margins and the peak's ratio are of grips that lifted the object: one that lets go at a small
    force is not gentle.
    """
    masses = sorted({grip.object_mass_g for grip in grips})
    each = [_of_one_mass([g for g in grips if g.object_mass_g == mass]) for mass in masses]
    return {name: _worst(name, [own[name] for own in each]) for name in (each or [{}])[0]}


def _worst(name: str, values: Sequence[float | None]) -> float | None:
    """The greatest of forces, the least of margins and successes; None where no mass has one."""
    known = [value for value in values if value is not None]
    return (max if name.startswith("peak") else min)(known, default=None)


def _of_one_mass(grips: Sequence[GripResult]) -> dict[str, float | None]:
    held = sum(bool(grip.lifted and not grip.gross_slip) for grip in grips)
    lifted = [grip for grip in grips if grip.lifted]
    margins = [grip.safety_margin for grip in lifted if grip.safety_margin is not None]
    ratios = [grip.peak_ratio for grip in lifted]
    return {
        "grip_success": held / len(grips),
        "safety_margin": statistics.median(margins) if margins else None,
        "least_margin": min(margins, default=None),
        "peak_force_N": max(grip.peak_normal_force_N for grip in grips),
        "peak_ratio": statistics.median(ratios) if ratios else None,
    }


def _first_slip(rows: Sequence[IncrementResult]) -> float | None:
    """F_t of the first row that sticks on less than ``_FIRST_SLIP`` of what the pull began with."""
    most = 0.0
    for row in rows:
        if row.stick_ratio is None or row.tangential_force_N <= _PULLED * row.normal_force_N:
            continue
        most = max(most, row.stick_ratio)
        if row.stick_ratio < _FIRST_SLIP * most:
            return row.tangential_force_N
    return None


def _gage_response(analysis: Analysis) -> float | None:
    """Greatest change of a reading per tangential force while all that touches sticks or slips."""
    rows = analysis.result.increments
    if not rows[0].gages:
        return None
    readings = np.array([[gage.reading for gage in row.gages] for row in rows])
    force = np.array([row.tangential_force_N for row in rows])
    pulled = np.flatnonzero(np.abs(np.diff(force)) > 1e-6)
    # Steps that press too would mix in what F_n does.
    still = (k for k in pulled if math.isclose(rows[k].approach_mm, rows[k + 1].approach_mm))
    if (first := next(still, None)) is None:
        return None
    change = np.abs(readings[first + 1] - readings[first]) / abs(force[first + 1] - force[first])
    return float(change.max())


def _shown_points(contact: ContactHistory) -> list[int]:
    """Numbers of the candidates that the map shows: evenly along x; in 3-D over x and z, about
    what is ever touched."""
    if contact.dimension == 2:
        line = contact.mid_line()
        return [int(line[k]) for k in evenly_spaced(len(line), MOST_CONTACT)]
    places = contact.points[:, [0, 2]]
    touched = places[(contact.status != OPEN).any(axis=0)]
    if not len(touched):
        return evenly_spaced(len(places), MOST_CONTACT)
    low, high = touched.min(axis=0), touched.max(axis=0)
    room = np.maximum(_ROOM * (high - low), 1e-9)
    low, high = low - room, high + room
    near = np.flatnonzero(((places >= low) & (places <= high)).all(axis=1))
    # Cells alike in shape and fewer than points may be shown; of each the point next to its middle.
    side = float(np.sqrt(np.prod(high - low) / MOST_CONTACT))
    while True:
        cell = np.floor((places[near] - low) / side)
        off = ((places[near] - low - (cell + 0.5) * side) ** 2).sum(axis=1)
        order = np.lexsort((off, cell[:, 1], cell[:, 0]))
        first = np.any(np.diff(cell[order], axis=0, prepend=np.nan) != 0.0, axis=1)
        if first.sum() <= MOST_CONTACT:
            return [int(k) for k in near[order[first]]]
        side *= 1.05


def _numbers(values: Iterable[Any]) -> Numbers:
    """Four digits are what a chart shows; None where there is no number."""
    numbers = (None if value is None else float(value) for value in values)
    return tuple(None if n is None or not bounded(n) else float(f"{n:.5g}") for n in numbers)
