"""Scatter of responses and gage area: of rows that only shear, so that no normal force is in them.

A row's responses are the changes of the readings since the row before, over that of F_t; the area
is the length of plates whose response exceeds a threshold (control/signals.py). The threshold is
the design's own, as a hand has it: ``gages.area_share`` of the largest response of the first such
row. The area is made again of readings that the derivatives change.
"""

from collections.abc import Sequence

import numpy as np

from fingerdesign.analysis.case import gage_array
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.arrays import Array, BoolArray
from fingerdesign.control.signals import length_over
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.layout.rows import plate_frames
from fingerdesign.runtime.streams import stream
from fingerdesign.sensitivity.derive import Sensitivity
from fingerdesign.tolerance.sources import GAINS, UNIFORM, Source, all_tolerances, by_source

SURE = 0.9  # Of the fingers as made reach the response that is reported.
_DRAWS = 20_000  # Of the linear model: a quantile of them is good to half a percent of the spread.
_PULL = 1e-6  # Of the normal force: a smaller change of F_t is rounding.
_STEP = 0.05  # Of a standard deviation: a difference so small is a derivative.


def gage_areas(
    design: Design, scene: Scene, found: Sensitivity, sources: Sequence[Source]
) -> tuple[list[float | None], list[Array]]:
    """Areas (k,) mm, None in a row that presses; their variances (k,) by each source, and last by
    the gages' factors."""
    readings, force = found.readings.reading, found.readings.tangential_force
    frames = plate_frames(design)
    places = {frame.index: frame.x for frame in frames if frame.along == "x"}
    plates = sorted(set(gage_array(design)) & places.keys(), key=places.__getitem__)
    shears = _shears(scene, found.readings)
    if len(plates) < 2 or readings.shape[1] < len(frames) or not shears.any():
        return [None] * len(force), [np.zeros(len(force))] * (len(sources) + 1)
    x = np.array([places[plate] for plate in plates])
    first = _responses(readings[:, plates], force)[int(np.argmax(shears))]
    threshold = design.gages.area_share * float(first.max())

    def areas(more: Array, pull: Array) -> Array:
        each = _responses((readings + more)[:, plates], force + pull)
        return shears * [length_over(x, one, threshold) for one in each]

    def variance(more: Array, pull: Array) -> Array:
        ways = [areas(sign * _STEP * more, sign * _STEP * pull) for sign in (1.0, -1.0)]
        return np.asarray(((ways[0] - ways[1]) / (2.0 * _STEP)) ** 2)

    stds = UNIFORM * all_tolerances(sources)
    rates = np.moveaxis(found.reading * stds, -1, 0), (found.tangential_force * stds).T
    every = np.column_stack([variance(*each) for each in zip(*rates, strict=True)])
    parts = [part.sum(axis=1) for part in by_source(every, sources)]
    none, gains = np.zeros_like(force), GAINS * UNIFORM * np.eye(readings.shape[1])
    parts.append(np.sum([variance(gain * readings, none) for gain in gains], axis=0))
    own = areas(np.zeros_like(readings), none)
    return [float(area) if mine else None for area, mine in zip(own, shears, strict=True)], parts


def sure_response(
    scene: Scene, found: Sensitivity, sources: Sequence[Source]
) -> tuple[float, float] | None:
    """Greatest response of the first row that only shears, microstrain/N: as designed, and what
    ``SURE`` of the fingers as made reach, by the derivatives and the gages' factors. None without
    such a row, or without gages.

    A response r = dR / dF_t of a gage changes by (d(dR)/dp - r d(dF_t)/dp) / dF_t.
    """
    readings, force = found.readings.reading, found.readings.tangential_force
    shears = _shears(scene, found.readings)
    if not (readings.size and shears.any()):
        return None
    row = int(np.argmax(shears))
    pull = float(_steps(force)[row])
    response = _steps(readings)[row] / pull
    more_pull = np.outer(response, _steps(found.tangential_force)[row])
    rates = (_steps(found.reading)[row] - more_pull) / pull
    chance, sizes = stream(0, "response"), all_tolerances(sources)
    made = response + (chance.uniform(-1.0, 1.0, (_DRAWS, len(sizes))) * sizes) @ rates.T
    made *= 1.0 + GAINS * chance.uniform(-1.0, 1.0, made.shape)
    reached = float(np.quantile(np.abs(made).max(axis=1), 1.0 - SURE))
    return float(np.abs(response).max()), reached


def _shears(scene: Scene, readings: Readings) -> BoolArray:
    """Mark the rows of a path (k,) where the object moves along x alone, and is held by it."""
    places = [(*row, *[0.0] * (4 - len(row))) for row in scene.path.rows]  # y, x, z and twist
    rows = np.diff([(0.0, 0.0, 0.0, 0.0), *places], axis=0)
    alone = (rows[:, 1] != 0.0) & ~rows[:, [0, 2, 3]].any(axis=1)
    pull = np.abs(_steps(readings.tangential_force))
    return np.asarray(alone & (pull > _PULL * np.abs(readings.normal_force)))


def _steps(values: Array) -> Array:
    """Changes of each row since the one before, of the first since nothing."""
    return np.asarray(np.diff(values, axis=0, prepend=0.0))


def _responses(readings: Array, force: Array) -> Array:
    """Responses (k, g), microstrain/N, of each row since the one before; 0 where F_t stays."""
    change = _steps(readings)
    pull = _steps(force)[:, None] * np.ones_like(change)
    return np.abs(np.divide(change, pull, out=np.zeros_like(change), where=pull != 0.0))
