"""Differences from finger to finger: parameters, by how much, and who would tighten them.

Tolerances are to either side, and any value within them is as likely: a standard deviation of the
tolerance over the root of three. Plates go by what holds them in the mold, body and surface by its
process, the rubber by its batches, sheets by their makers, gages by their factors.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.row_keys import plate_rows
from fingerdesign.layout.rows import plate_frames
from fingerdesign.mold.placement import row_tolerances, tolerances
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.sensitivity.variant import PLACES

RUBBER, GAINS = 0.15, 0.03  # Of a batch of silicone, and of gage factors (perturb/faults.py)
# Rolled bronze and polyimide film come to within 6 to 10 % of their thickness (data sheets). Moduli
# of films differ by 20 %, of metals by 3 % between suppliers. A rubber's Poisson's ratio lies below
# 0.5, to within 0.005 where it is known at all. Both are assumed.
SHEET, FILM, METAL, POISSON = 0.08, 0.2, 0.03, 0.005
_METAL_MPa = 20_000.0  # No film is as stiff, no metal as soft.
_YOUNG = "youngs_modulus_MPa"
UNIFORM = float(1.0 / np.sqrt(3.0))


@dataclass(frozen=True)
class Source:
    """A cause of scatter: its words, and the parameters that it moves, each by itself.

    tolerances (P,): to either side, in ``unit``; known: a bench measures it, so that a calibrated
    finger does without.
    """

    words: str
    parameters: tuple[str, ...]
    tolerances: tuple[float, ...]
    unit: str
    known: bool = False


def all_tolerances(sources: Sequence[Source]) -> Array:
    """Tolerances (P,) of all parameters, source by source."""
    return np.concatenate([source.tolerances for source in sources])


def by_source(values: Array, sources: Sequence[Source]) -> list[Array]:
    """The part of values (..., P) of each source."""
    ends = np.cumsum([len(source.parameters) for source in sources])
    return np.split(values, ends[:-1], axis=-1)


def unknown_places(design: Design) -> list[Fault]:
    """A fault for each row of plates whose places scatter by what is not known."""
    bound, remedy = "'x': how places of plates along z scatter is not known", "leave the row out"
    rows = [row for row in plate_rows(design) if row.table.along == "z"]
    return [Fault(row.key("along"), "z", bound, remedy) for row in rows]


def sources_of(design: Design, plan: MoldPlan, space: bool = False) -> list[Source]:
    """The sources of scatter of fingers that are cast in a mold; gains of gages are not among them,
    for they are no parameters of the model. space: in 3-D, where leads keep plates' sizes."""
    found = []
    frames, body = plate_frames(design), design.body
    if frames:
        sizes, angles = zip(*(tolerances(plan, frame.index) for frame in frames), strict=True)
        words = ("plates along x", "plates in height", "plates' angles")
        units = zip((sizes, sizes, angles), ("mm", "mm", "degrees"), strict=True)
        for key, cause, unit in zip(PLACES, words, units, strict=True):
            names = tuple(f"placement[{k}].{key}" for k in range(len(frames)))
            found.append(Source(cause, names, *unit))
        x, y = row_tolerances(plan)
        found.append(Source("row along x", ("placement.x_mm",), (x,), "mm"))
        found.append(Source("row in height", ("placement.y_mm",), (y,), "mm"))
    found += _sizes(design, plan, space)
    name, own = f"materials.{body.material}", design.material_of("body")
    size = RUBBER * own.youngs_modulus_MPa
    found.append(Source("rubber's modulus", (f"{name}.{_YOUNG}",), (size,), "MPa", known=True))
    if frames and design.plates.material != body.material:
        plate = f"materials.{design.plates.material}.{_YOUNG}"
        young = design.material_of("plates").youngs_modulus_MPa
        size = (METAL if young > _METAL_MPa else FILM) * young
        found.append(Source("plates' modulus", (plate,), (size,), "MPa", known=True))
    room = min(POISSON, 0.9 * (0.5 - own.poissons_ratio))
    poisson = (f"{name}.poissons_ratio",)
    found.append(Source("rubber's Poisson's ratio", poisson, (room,), "of one", known=True))
    return found


def _body_sizes(design: Design, plan: MoldPlan) -> list[Source]:
    """Height and radius of a body of straight sides."""
    body, limits = design.body, plan.limits
    found = [Source("body's height", ("body.base_height_mm",), (limits.tolerance_mm,), "mm")]
    if body.shape == "arc" and body.edge_radius_mm is None:
        # The rise w^2 / 8 R of the arc is off by the form of the insert's face.
        size = limits.form_mm * 8.0 * (body.arc_radius_mm / body.width_mm) ** 2
        found.append(Source("surface's radius", ("body.arc_radius_mm",), (size,), "mm"))
    return found


def _sizes(design: Design, plan: MoldPlan, space: bool) -> list[Source]:
    """Sizes of body and plates, where their derivatives are known (sensitivity/velocity.py)."""
    frames, body, found = plate_frames(design), design.body, list[Source]()
    flat = all(f.along == "x" and f.bend_radius is None and not f.holes for f in frames)
    if not flat or body.core is not None:
        return []
    if body.kind.straight and not space:
        found += _body_sizes(design, plan)
    barred = space and (design.gages.leads is not None or design.gages.kind is not None)
    if frames and not barred:
        thick = SHEET * design.plates.thickness_mm
        found.append(Source("plates' thickness", ("plates.thickness_mm",), (thick,), "mm"))
    return found
