"""Fingers as cast: drawn within their tolerances, and real models of them, each meshed by itself.

    yield = share of lifts with a margin of LOW to HIGH times the least force

By motion alone, a stage closes every finger as far as the design needs for the middle of the band,
and margins go with the normal force, to first order in the tolerances. With its own controller each
drawn finger is calibrated and lifts what ``[grip]`` says; as many are drawn as the interval needs.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.fidelity.readings import Readings, readings_of
from fingerdesign.analysis.path import follow_path, problem_at_touch
from fingerdesign.analysis.stages import (
    condense,
    in_wide_zone,
    make_mesh,
    rig_of,
    run_grips,
    zone_of,
)
from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.control.calibration import LEAST_GAGES
from fingerdesign.design.keys import leaves
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.streams import stream
from fingerdesign.runtime.threads import one_thread
from fingerdesign.sensing.perturb.finger import placement_keys, places_of
from fingerdesign.sensing.train.ready import with_estimator
from fingerdesign.sensitivity.derive import Sensitivity
from fingerdesign.sensitivity.variant import PLACE, PLACES
from fingerdesign.tolerance.record import CastData
from fingerdesign.tolerance.sources import Source, all_tolerances

LOW, HIGH = 1.1, 1.5  # People grip with 1.2 to 1.5 times the least force; 1.1 still holds.
_DRAWS = 20_000  # Of the linear model: a share of them is good to 0.4 points.
_LEAST, _MOST = 10, 2000  # Fingers that are drawn, at least and at most.
_SOUND = 100  # So many draws are checked before the work begins; most runs need fewer.
_BATCH = 4  # The same for any number of processes, so that all draw equally many fingers.


@dataclass(frozen=True)
class Draws:
    """Draw fingers, in so many processes, until the yield is known to within a share, at 95 %."""

    within: float
    workers: int = 1


@dataclass(frozen=True)
class CastFinger:
    """A drawn finger: readings along the scene, and of each lift its margin, 0 where it failed."""

    readings: Readings
    margins: tuple[float, ...]


def yield_by_motion(found: Sensitivity, sources: Sequence[Source]) -> tuple[float, float]:
    """Share of fingers as made, and once calibrated, whose normal force keeps the margin."""
    row = int(np.argmax(found.readings.normal_force))
    force = float(found.readings.normal_force[row])
    if not force > 0.0:
        return 0.0, 0.0
    chance = stream(0, "yield by motion")
    sizes = all_tolerances(sources)
    known = np.concatenate([[source.known] * len(source.parameters) for source in sources])
    ways = chance.uniform(-1.0, 1.0, (_DRAWS, len(sizes))) * sizes * found.normal_force[row] / force
    return _kept(1.0 + ways.sum(axis=1)), _kept(1.0 + (ways * ~known).sum(axis=1))


def changes_of_finger(sources: Sequence[Source], number: int) -> Array:
    """Changes (P,) of the parameters of finger ``number``, each anywhere within its tolerance."""
    sizes = all_tolerances(sources)
    return np.asarray(stream(number, "finger as cast").uniform(-1.0, 1.0, len(sizes)) * sizes)


def drawn(design: Design, sources: Sequence[Source], changes: Array) -> Design:
    """The finger with these changes (P,). DesignError where it is not sound."""
    names = [name for source in sources for name in source.parameters]
    places = np.zeros((len(plate_frames(design)), 3))
    values, known = dict[str, object](), dict(leaves(design.model_dump(mode="json")))
    for name, off in zip(names, changes.tolist(), strict=True):
        if (place := PLACE.fullmatch(name)) is None:
            values[name] = float(known[name]) + off
        else:
            rows = slice(None) if place[1] is None else int(place[1])
            places[rows, PLACES.index(place[2])] += off
    sized = with_values(design, values)
    frames = plate_frames(sized)
    return (
        with_values(sized, placement_keys(frames, places_of(frames) + places)) if frames else sized
    )


def refuse_draws(case: Case, sources: Sequence[Source], draws: Draws) -> None:
    """Raise DesignError where fingers as cast cannot be lifted, or the first ones are not sound."""
    remedy = "leave --yield-within out: yield by motion needs no real models"
    name, value = case.design.design.name, f"{100.0 * draws.within:g}"
    if not case.runs_grips:
        bound = f"given with {LEAST_GAGES} gages in a row or more, which a hand needs"
        raise DesignError([Fault("--yield-within", value, bound, remedy)], name)
    for number in range(_SOUND):
        try:
            drawn(case.design, sources, changes_of_finger(sources, number))
        except DesignError as error:
            bound = f"given where fingers as cast are sound; number {number + 1}: {error.faults[0]}"
            raise DesignError([Fault("--yield-within", value, bound, remedy)], name) from error


def cast_finger(case: Case, scene: Scene, sources: Sequence[Source], number: int) -> CastFinger:
    """Draw a finger, mesh it by itself, follow the scene and lift with the design's controller."""
    own = replace(case, design=drawn(case.design, sources, changes_of_finger(sources, number)))
    design = own.design

    def work(zone: Zone) -> CastFinger:
        mesh = make_mesh(design, own.fidelity, zone, own.symmetric)
        model = condense(design, mesh, zone, scene).reduced
        problem = problem_at_touch(model, scene.object, design.body)
        met = own.path_scene  # Grips are against the level plane, whatever the scene leans by.
        array = problem_at_touch(model.with_gages(own.gage_array), met.object, design.body)
        with one_thread():
            steps = follow_path(problem, scene, design)
            lifts = [each for each, _ in run_grips(own, rig_of(own, zone, met, array))]
        margins = tuple(float(each.success and (each.safety_margin or 0.0)) for each in lifts)
        return CastFinger(readings_of(steps, design.gages.face), margins)

    zones = [zone_of(own, each) for each in (scene, own.path_scene)]
    return in_wide_zone(design, max(zones, key=lambda each: each.half_width), work)


def cast_fingers(
    case: Case,
    scene: Scene,
    linear: Sensitivity,
    sources: Sequence[Source],
    draws: Draws,
    report: Callable[[str], None],
) -> CastData:
    """Draw fingers until the yield is known well enough. case: of the grips; scene: of the readings
    and of their derivatives."""
    case = with_estimator(case, report)
    found: list[CastFinger] = []
    with Pool(draws.workers, shared=(case, scene, tuple(sources))) as pool:
        while len(found) < _MOST:
            numbers = range(len(found), len(found) + _BATCH)
            found += pool.in_order(cast_finger, [(number,) for number in numbers])
            half = _half_width([_share(each) for each in found])
            report(f"{len(found)} fingers as cast: yield known to {100 * half:.0f} points")
            if len(found) >= _LEAST and half <= draws.within:
                break
    return cast_data(found, linear, sources)


def _share(finger: CastFinger) -> float:
    """Share of a finger's lifts within the band; NaN without lifts."""
    margins = np.array(finger.margins)
    return float(((margins >= LOW) & (margins <= HIGH)).mean()) if len(margins) else np.nan


def _half_width(shares: Sequence[float]) -> float:
    """Half the width of the mean's 95 % interval, over fingers; of equal ones by the rule of three.

    >>> round(_half_width([1.0] * 30), 2)
    0.1
    """
    spread = float(np.nan_to_num(np.std(shares, ddof=1))) if len(shares) > 1 else 1.0
    return float(max(1.96 * spread / len(shares) ** 0.5, 3.0 / len(shares)))


def cast_data(
    found: Sequence[CastFinger], linear: Sensitivity, sources: Sequence[Source]
) -> CastData:
    """The record of drawn fingers, next to what the derivatives say of the same ones."""
    shares = [_share(each) for each in found]
    lifted = [float((np.array(each.margins) > 0.0).mean()) for each in found if each.margins]
    share, half = float(np.nan_to_num(np.mean(shares))), _half_width(shares)
    design = float(linear.readings.normal_force.max())
    changes = np.array([changes_of_finger(sources, number) for number in range(len(found))])
    row = int(np.argmax(linear.readings.normal_force))
    force = np.array([each.readings.normal_force[row] for each in found])
    forecast = linear.readings.normal_force[row] + changes @ linear.normal_force[row]
    readings = np.array([each.readings.reading for each in found])
    return CastData(
        fingers=len(found),
        share=share,
        interval=(max(0.0, share - half), min(1.0, share + half)),
        lifted=float(np.mean(lifted)) if lifted else 0.0,
        by_motion=(_kept(forecast / design), _kept(force / design)),
        reading_std_microstrain=(_scatter(linear.reading @ changes.T), _scatter(readings.T)),
        normal_force_std_N=(float(forecast.std(ddof=1)), float(force.std(ddof=1))),
    )


def _kept(forces: Array) -> float:
    """Share of normal forces, relative to the design's, that keep the margin by motion alone."""
    margins = np.sqrt(LOW * HIGH) * forces
    return float(((margins >= LOW) & (margins <= HIGH)).mean())


def _scatter(values: Array) -> float:
    """Standard deviation over fingers (the last axis), RMS over all else; 0 without gages."""
    return float(np.sqrt(values.var(axis=-1, ddof=1).mean())) if values.size else 0.0
