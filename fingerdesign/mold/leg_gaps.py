"""How far legs lie from other plates, from other legs and from the core; numbers only, mm."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.gaps import Prisms, core_gaps, prism_distances
from fingerdesign.design.layout import PlateFrame
from fingerdesign.mold.frames import core_in_mold, leg_bar
from fingerdesign.mold.plan import Leg

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design

LEAST_GAP_MM = 0.1
_NEAR = 2.0  # mm: farther pairs are told apart by their boxes alone


def least_gap_mm(design: Design) -> float:
    """Least distance of a leg from metal that is not its own, mm.

    That which plates themselves keep where it is less: a leg is in its own plate's plane.
    """
    return min(LEAST_GAP_MM, 0.5 * design.plates.thickness_mm)


def leg_gaps(
    design: Design,
    scale: float,
    legs: tuple[Leg, ...],
    bars: tuple[PlateFrame, ...],
    frames: tuple[PlateFrame, ...],
) -> Array:
    """Least distance (legs,) of each leg's ``bar`` to other plates and to the core."""
    found = np.full(len(legs), np.inf)
    if not legs:
        return found
    core = design.body.core
    if core is not None:
        depth = core.depth_mm if core.depth_mm is not None else design.body.depth_mm
        # A core of full depth ends where the legs do.
        distances = core_gaps(core_in_mold(core, scale), depth, bars)
        found = np.where(np.isnan(distances), np.inf, distances)
    owners = np.array([leg.plate for leg in legs])
    plates = np.array([frame.index for frame in frames])
    first, second, distance = _pairs(bars, frames)
    other = owners[first] != plates[second]
    np.minimum.at(found, first[other], distance[other])
    return found


def crossing_legs(
    design: Design, legs: tuple[Leg, ...], frames: tuple[PlateFrame, ...]
) -> list[tuple[Leg, Leg, float]]:
    """Legs of plates along x and of plates along z that come too near: both, and how near."""
    along = {frame.index: frame for frame in frames}
    one = [leg for leg in legs if leg.side.endswith("z")]
    two = [leg for leg in legs if leg.side.endswith("x")]
    if not one or not two:
        return []
    first = tuple(leg_bar(along[leg.plate], leg, leg.exit) for leg in one)
    second = tuple(leg_bar(along[leg.plate], leg, leg.exit) for leg in two)
    i, j, distance = _pairs(first, second)
    least = least_gap_mm(design) - 1e-6
    return [(one[i[k]], two[j[k]], float(distance[k])) for k in np.flatnonzero(distance < least)]


def _pairs(
    first: tuple[PlateFrame, ...], second: tuple[PlateFrame, ...]
) -> tuple[IntArray, IntArray, Array]:
    """Every near pair of a first and a second frame, by position, and its distance."""
    a, b = Prisms.of(_spanned(first)), Prisms.of(_spanned(second))
    low_a, high_a = a.boxes()
    low_b, high_b = b.boxes()
    apart = np.maximum(low_b[None] - high_a[:, None], low_a[:, None] - high_b[None])
    bound = np.linalg.norm(np.maximum(apart, 0.0), axis=2)
    i, j = np.nonzero(bound < _NEAR)
    return a.owner[i], b.owner[j], prism_distances(a.rows(i), b.rows(j))


def _spanned(frames: tuple[PlateFrame, ...]) -> tuple[PlateFrame, ...]:
    """Frames with some span each: a leg that ends where it starts has none."""
    return tuple(replace(f, high=max(f.high, f.low + 1e-6)) for f in frames)
