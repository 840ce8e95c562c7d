"""How many tetrahedra fTetWild will make: the size field integrated over the body, by an octree.

The same integral as mesh.sizing.expected_elements, by cells only as fine as the field, so that it
takes a tenth of a second on any body, then times what fTetWild was found to make of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.layout.frames import PlateFrame, plate_frames
from fingerdesign.layout.layers import not_a_sheet
from fingerdesign.mesh.sizing import MeshSizes, SizeField
from fingerdesign.mesh.tetra.slots import THICK, sized_frames
from fingerdesign.mesh.tetra.tetwild import size_field

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.layout.zone import Zone


_CELL = 0.7  # largest cell of the integral over the size at its middle
_DEEPEST = 12
EQUILATERAL = np.sqrt(3.0) / 4.0
_FIRST = 6  # cells across the body's shortest extent to begin with
# Cells of one level: of more, some stand for all, so that an astronomic mesh is predicted at once.
_MOST_CELLS = 200_000


# fTetWild made 1.44 times the integral on 100 random designs (bench.any_designs), 2.0 times where
# plates have holes: their rims are finer than any size names. Scatter 22 % (a standard deviation),
# 0.63 to 1.7 times, once 2.9.
MADE, MADE_WITH_HOLES = 1.44, 2.0
# Facets of the contact zone over the like integral of its surface.
MADE_AT_CONTACT = 0.68


@dataclass(frozen=True)
class SpaceCount:
    """tetrahedra; contact_nodes: of the candidate facets."""

    tetrahedra: float
    contact_nodes: float


def count_space(design: Design, zone: Zone, symmetric: bool) -> SpaceCount:
    """Expected size of ``tetrahedralise``'s mesh of a finger, or of its half z >= 0."""
    sizes = MeshSizes.of(design, zone.half_width, zone.half_depth)
    frames = _sized(design, symmetric)
    field = size_field(design, frames, sizes, zone.half_width, zone.half_depth)
    half = 0.5 * np.array([design.body.width_mm, 0.0, design.body.depth_mm])
    low = np.array([-half[0], 0.0, 0.0 if symmetric else -half[2]])
    high = np.array([half[0], field.surface.crest, half[2]])
    holes = any(frame.holes for frame in frames)
    made = MADE_WITH_HOLES if holes else MADE
    return SpaceCount(made * integral(field, low, high), _contact_nodes(field, low, high))


def _sized(design: Design, symmetric: bool) -> tuple[PlateFrame, ...]:
    """The plates that the sizes go by, of the way that is tried first (mesh.plate_ways).

    Whether there is room to cut plates in is not asked: on CAD surfaces that takes seconds.
    """
    frames = plate_frames(design) if design.plates.model != "none" else ()
    thick = design.plates.thickness_mm > THICK * design.mesh.plate_size_mm
    if design.plates.model == "sheet" or not (
        thick or any(not_a_sheet(frame, symmetric) for frame in frames)
    ):
        return sized_frames(frames)
    return frames


def _contact_nodes(field: SizeField, low: Array, high: Array) -> float:
    """Nodes of the candidate facets."""
    first = np.array([max(low[0], -field.zone_half_width), low[2]])
    last = np.array([min(high[0], field.zone_half_width), high[2]])
    if field.zone_half_depth is not None:
        first[1] = max(low[2], -field.zone_half_depth)
        last[1] = min(high[2], field.zone_half_depth)
    share = (np.arange(24) + 0.5) / 24
    x, z = np.meshgrid(*(first[k] + (last[k] - first[k]) * share for k in range(2)))
    x, z = x.reshape(-1), z.reshape(-1)
    y = field.surface.height(x, z)
    known = np.isfinite(y)
    wanted = field(np.column_stack([x, y, z])[known])
    cell = float(np.prod(last - first)) / len(x)
    facets = cell * (1.0 / (EQUILATERAL * field.sizes.stretch * wanted**2)).sum()
    facets *= MADE_AT_CONTACT
    return float(0.5 * facets + 1.5 * np.sqrt(facets) + 1.0)


def some_of(cells: Array, most: int) -> tuple[Array, float]:
    """No more than ``most`` of the cells, by chance but always the same ones, and their share."""
    if len(cells) <= most:
        return cells, 1.0
    chosen = np.random.default_rng(0).choice(len(cells), most, replace=False)
    return cells[chosen], most / len(cells)


def integral(field: SizeField, low: Array, high: Array) -> float:
    """Regular tetrahedra of the field's size, stretched, within the body between low, high (3,)."""
    stretch = np.array([1.0, 1.0, field.sizes.stretch])
    extent = (high - low) / stretch
    count = np.maximum(np.round(_FIRST * extent / extent.min()), 1)
    step = extent / count * stretch
    axes = [low[k] + step[k] * (np.arange(int(count[k])) + 0.5) for k in range(3)]
    cells = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])
    total, stands_for = 0.0, 1.0
    for level in range(_DEEPEST + 1):
        wanted = field(cells)
        good = ((step / stretch).max() <= _CELL * wanted) | (level == _DEEPEST)
        own = cells[good]
        inside = field.surface.encloses(own) if len(own) else np.zeros(0, dtype=bool)
        tet = field.sizes.stretch * wanted[good][inside] ** 3 / (6.0 * np.sqrt(2.0))
        total += stands_for * float((step.prod() / tet).sum())
        cells, share = some_of(cells[~good], _MOST_CELLS // 8)
        stands_for /= share
        if not len(cells):
            break
        step = 0.5 * step
        cells = (cells[:, None] + 0.5 * step * corners).reshape(-1, 3)
    return total
