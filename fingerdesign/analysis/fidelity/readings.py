"""Readings of a finger in a scene, row by row, and how far two models' answers are apart.

numpy only. Errors are quoted as in every table of ours: F_n relative to its row's, F_t and contact
width relative to the path's largest (F_t to a hundredth of F_n's where nothing pulls), stick ratios
absolute, gage strains relative to the largest reading of their row.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.path import Step
from fingerdesign.control.signals import gage_readings

MICRO = 1e6
QUANTITIES = ("normal_force", "tangential_force", "contact_width", "stick_ratio", "gage")
NOT_PULLED = 0.01  # of the largest F_n: where F_t stays below it, it is the mesh's own
_NOTHING = 1e-12  # N: no force to be relative to


@dataclass(frozen=True)
class Readings:
    """A path of k rows, whole finger.

    normal_force, tangential_force (k,) N; contact_width (k,) mm; stick_ratio (k,), 0 without
    contact; gages (k, plates, 2): upper and lower face, microstrain; face: which of them is read.
    """

    normal_force: Array
    tangential_force: Array
    contact_width: Array
    stick_ratio: Array
    gages: Array
    face: str = "both"

    @property
    def rows(self) -> int:
        """Number of increments."""
        return len(self.normal_force)

    @property
    def reading(self) -> Array:
        """Reading of each gage (k, plates), microstrain: of its face, or the mean of both."""
        shape = self.gages.shape[:2]
        flat = gage_readings(self.gages.reshape(-1, 2) / MICRO, self.face)
        return np.asarray(flat).reshape(shape)

    def times(self, factor: float) -> Self:
        """Forces and strains so many times as large, on the same contact."""
        names = ("normal_force", "tangential_force", "gages")
        return replace(self, **{name: factor * getattr(self, name) for name in names})

    def part(self, rows: slice | list[int]) -> Self:
        """Some of the rows."""
        every = {name: value[rows] for name, value in vars(self).items() if name != "face"}
        return replace(self, **every)


def readings_of(steps: Sequence[Step], face: str = "both") -> Readings:
    """The readings of solved increments, at small strain or at finite."""
    found = [step.measures for step in steps]
    return Readings(
        np.array([each.normal_force for each in found]),
        np.array([each.tangential_force for each in found]),
        np.array([each.contact_width for each in found]),
        np.array([each.stick_ratio or 0.0 for each in found]),
        MICRO * np.array([each.gages.reshape(-1, 2) for each in found]).reshape(len(found), -1, 2),
        face,
    )


def errors(found: Readings, truth: Readings) -> dict[str, Array]:
    """Distance of ``found`` from ``truth``, row by row, see the module: unsigned, of each quantity
    (k,), of the gages (k, plates). ValueError where the paths differ."""
    if found.rows != truth.rows or found.gages.shape != truth.gages.shape:
        raise ValueError(f"paths of {found.rows} and {truth.rows} rows cannot be compared")
    right = truth.reading
    most = np.abs(right).max(axis=1, keepdims=True, initial=0.0)
    normal, pull = np.abs(truth.normal_force), np.abs(truth.tangential_force)
    most_pull = max(pull.max(initial=0.0), NOT_PULLED * normal.max(initial=0.0))
    widest = truth.contact_width.max(initial=0.0)
    return {
        "normal_force": _share(found.normal_force - truth.normal_force, normal),
        "tangential_force": _share(found.tangential_force - truth.tangential_force, most_pull),
        "contact_width": _share(found.contact_width - truth.contact_width, widest),
        "stick_ratio": np.abs(found.stick_ratio - truth.stick_ratio),
        "gage": _share(found.reading - right, most),
    }


def _share(difference: Array, scale: Array | float) -> Array:
    """|difference| / scale, 0 where both vanish."""
    scale = np.broadcast_to(scale, difference.shape)
    size = np.abs(difference)
    return np.where(scale > _NOTHING, size / np.maximum(scale, _NOTHING), np.minimum(size, 1.0))
