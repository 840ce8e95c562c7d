"""The arrays of an analysis that ``result.json`` does not hold, and the file that holds them.

Every class checks its shapes when made: a report from mismatched arrays would mislead silently.
"""

from __future__ import annotations

import json
import zipfile
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.records.base import ResultError
from fingerdesign.runtime.cache import GARBLED, packed, unpacked

OPEN, STICK, SLIP = 0, 1, 2
_MOST_UNPACKED = 200  # times the file's size


@dataclass(frozen=True, eq=False)
class ContactHistory:
    """The contact candidates and what each of them did, increment by increment.

    points               (m, dim) mm, on the undeformed surface
    areas                (m,) mm^2 (in plane strain mm per mm of depth: lengths), > 0
    facets               (f, 2 | 3) segments or triangles of the surface, into points
    status               (k, m) OPEN, STICK or SLIP
    normal_traction      (k, m) MPa, >= 0 in compression
    tangential_traction  (k, m, 1 | 2) MPa on the finger, along x (and z)
    slip                 (k, m, 1 | 2) mm, accumulated slip along x (and z)
    symmetric            the points are the half z >= 0
    """

    points: Array
    areas: Array
    facets: IntArray
    status: IntArray
    normal_traction: Array
    tangential_traction: Array
    slip: Array
    symmetric: bool = False

    def __post_init__(self) -> None:
        m, dim = self.points.shape
        k = len(self.status)
        _require_shapes(
            self,
            areas=(m,),
            facets=(len(self.facets), dim),
            status=(k, m),
            normal_traction=(k, m),
            tangential_traction=(k, m, dim - 1),
            slip=(k, m, dim - 1),
        )
        if self.facets.size and (self.facets.min() < 0 or self.facets.max() >= m):
            raise ValueError(f"ContactHistory.facets must index the {m} points")

    @property
    def dimension(self) -> int:
        return int(self.points.shape[1])

    def stick_length(self) -> Array:
        """Length along x that sticks at each increment, (k,), mm: in 3-D on the line z = 0."""
        line = self.mid_line()
        x = self.points[line, 0]
        spans = np.diff(np.concatenate([x[:1], 0.5 * (x[1:] + x[:-1]), x[-1:]]))
        return np.asarray((self.status[:, line] == STICK) @ spans)

    def mid_line(self) -> IntArray:
        """Points on z = 0 (all of them in plane strain), by rising x."""
        if self.dimension == 2:
            return np.argsort(self.points[:, 0])
        height = np.abs(self.points[:, 2])
        # Free meshes have no row exactly on z = 0 unless it is a plane of symmetry.
        reach = 0.5 * float(np.median(np.sqrt(self.areas)))
        near = np.flatnonzero(height <= max(reach, float(height.min())))
        return near[np.argsort(self.points[near, 0])]


@dataclass(frozen=True, eq=False)
class SlipStudy:
    """The fundamental case at one friction coefficient: gage area and stick area (Fig. 8).

    stick_ratio       (k,) truth; NaN without contact
    stick_length_mm   (k,) truth, along x
    gage_area_raw_mm  (k,) length of plate positions with response_raw over the threshold
    gage_area_mm      (k,) the same, rid of what the normal force alone would cause
    gage_x_mm         (g,) plate centres, rising
    response_raw      (k, g) |change of strain / change of F_t|, microstrain/N, since the last
                      increment whose F_t differs by the floor; NaN without one, in complete slip
    response          (k, g) the same, compensated
    threshold         microstrain/N
    rank_correlation_raw, rank_correlation  Spearman's, of the area with the stick area; None where
                      it is not defined (an area that never changes)
    step_correlation  of the step index alone with the stick area, its size: what any area that
                      rises or falls steadily would reach
    tangential_force, normal_force  (k,) N
    force_floor_N     the least change of F_t that a response is made from
    rank_by_share     rank_correlation at other values of gages.area_share: (share, correlation)
    """

    friction_coefficient: float
    stick_ratio: Array
    stick_length_mm: Array
    gage_area_raw_mm: Array
    gage_area_mm: Array
    gage_x_mm: Array
    response_raw: Array
    response: Array
    threshold: float
    rank_correlation_raw: float | None
    rank_correlation: float | None
    tangential_force: Array
    normal_force: Array
    force_floor_N: float = 0.0
    step_correlation: float | None = None
    rank_by_share: tuple[tuple[float, float | None], ...] = ()

    def __post_init__(self) -> None:
        k, g = len(self.stick_ratio), len(self.gage_x_mm)
        forces = ("tangential_force", "normal_force")
        names = ("stick_length_mm", "gage_area_raw_mm", "gage_area_mm", *forces)
        _require_shapes(self, **dict.fromkeys(names, (k,)), response_raw=(k, g), response=(k, g))


@dataclass(frozen=True, eq=False)
class GripTrace:
    """One grip step by step: arrays of (steps,), forces of one finger.

    approach, shear     the object's motion, mm
    normal_force, tangential_force  N
    stick_ratio         truth, which only the judge sees; NaN without contact
    gage_area_mm        what the controller made of the readings; NaN before it has one
    dx, dy              the command that led to the step, mm
    hold                the rule had set dx to zero
    gage_readings       (steps, gages) microstrain
    lift_step           first step at which the object is lifted, None if it is not
    without_rule        the same grip with the rule switched off, if it was tried
    rise                of the object above its support, mm; None where there is no support
    unsure              the controller reported that it knows too little; None where it never does
    reported_stick_ratio, warns  report on the sample before the command that led to the step:
                        stick ratio (NaN: none), near slip; None where it never reports
    """

    controller: str
    friction_coefficient: float
    object_mass_g: float
    approach: Array
    shear: Array
    normal_force: Array
    tangential_force: Array
    stick_ratio: Array
    gage_area_mm: Array
    dx: Array
    dy: Array
    hold: BoolArray
    gage_readings: Array
    lift_step: int | None = None
    without_rule: GripTrace | None = None
    rise: Array | None = None
    unsure: BoolArray | None = None
    reported_stick_ratio: Array | None = None
    warns: BoolArray | None = None

    def __post_init__(self) -> None:
        steps = len(self.approach)
        forces = ("shear", "normal_force", "tangential_force")
        optional = ("rise", "unsure", "reported_stick_ratio", "warns")
        there = (name for name in optional if getattr(self, name) is not None)
        names = (*forces, "stick_ratio", "gage_area_mm", "dx", "dy", "hold", *there)
        gages = self.gage_readings.shape[1:]
        _require_shapes(self, **dict.fromkeys(names, (steps,)), gage_readings=(steps, *gages))

    def until(self, steps: int) -> GripTrace:
        """The first ``steps`` of it."""
        values = ((each.name, getattr(self, each.name)) for each in fields(self))
        arrays = (item for item in values if isinstance(item[1], np.ndarray))
        cut: dict[str, Any] = {name: value[:steps] for name, value in arrays}
        return replace(self, **cut)

    @property
    def limit(self) -> Array:
        """Tangential force at which the object would slip, mu F_n, (steps,), N."""
        return np.asarray(self.friction_coefficient * self.normal_force)

    @property
    def forces(self) -> Array:
        """Normal and tangential force, (2, steps), N."""
        return np.stack([self.normal_force, self.tangential_force])

    @property
    def hold_starts(self) -> IntArray:
        """The steps at which the rule begins to hold, from 0."""
        return np.flatnonzero(np.diff(self.hold.astype(int), prepend=0) == 1)

    @property
    def weight_per_finger_N(self) -> float:
        """m g / 2, N, with g = 9.80665 m/s^2."""
        return 0.5 * 9.80665e-3 * self.object_mass_g


@dataclass(frozen=True, eq=False)
class FieldHistory:
    """Displacement of all mesh nodes at some increments.

    increments: which of ``Result.increments``, (k,). displacement: (k, n, dim), mm.
    """

    increments: tuple[int, ...]
    displacement: Array

    def __post_init__(self) -> None:
        if self.displacement.ndim != 3 or len(self.displacement) != len(self.increments):
            raise ValueError(
                f"FieldHistory.displacement of shape {self.displacement.shape} must be "
                f"({len(self.increments)}, nodes, dim)"
            )


def _require_shapes(record: Any, **shapes: tuple[int, ...]) -> None:
    for name, shape in shapes.items():
        got = getattr(record, name).shape
        if got != shape:
            raise ValueError(f"{type(record).__name__}.{name} has shape {got}, must be {shape}")


def write_packed(path: Path, value: Any) -> None:
    """Write a value that can be :func:`packed` as an .npz; plain values are JSON in ``about``."""
    arrays: dict[str, Any] = {}
    about = json.dumps(packed(value, arrays))
    with path.open("xb") as file:
        np.savez(file, about=np.array(about), **arrays)


def read_packed(path: Path, *kinds: type) -> Any:
    """Read the value that :func:`write_packed` wrote; of ``kinds`` alone, so a file runs no code.
    Raises ResultError where it is not there, or is not of these."""
    try:
        _refuse_bomb(path)
        with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
        about = json.loads(str(arrays.pop("about")))
        return unpacked(about, arrays, {kind.__name__: kind for kind in kinds})
    except (*GARBLED, RecursionError, MemoryError) as error:  # a header may claim any shape
        why = f"{type(error).__name__}: {error}"[:200]
        raise ResultError(f"{path} cannot be read ({why}); run the analysis again") from error


def _refuse_bomb(path: Path) -> None:
    """ValueError where the file would unpack to far more than it is: ours are stored as they are,
    and packed by hand numbers become a tenth."""
    with zipfile.ZipFile(path) as archive:
        content = sum(each.file_size for each in archive.infolist())
    if content > _MOST_UNPACKED * path.stat().st_size:
        raise ValueError(f"it would unpack to {content / 1e6:.0f} MB")
