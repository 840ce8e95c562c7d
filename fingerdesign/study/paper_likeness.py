"""Is a plate's normal strain like the shear strain of a homogeneous finger (paper 3.1)?

The finger and its twin without plates follow the fundamental scene. At each increment the gages'
strains (g,) are held against the twin's engineering shear strain at the same places (g,), by
Pearson's correlation over the places and by the slope through zero: the strain of a plate per shear
strain of the rubber. Rubber itself, nearly incompressible and in plane strain, is strained along 45
degrees by half of its shear strain: a slope of 0.5. The same is asked of the increments' changes,
on which the paper's method rests, and of a gage on the upper face alone, which feels bending too.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.control.signals import gage_readings

if TYPE_CHECKING:
    from fingerdesign.study.paper_case import PaperCase


@dataclass(frozen=True)
class Likeness:
    """Plates and rubber over the scene's k increments at g places.

    x (g,) mm; membrane (k, g), upper (k, g): the mean of both faces, and the upper face,
    microstrain; shear (k, g): the twin's engineering shear strain, microstrain.
    correlation (k,), slope (k,): of the membrane strain with it; upper_correlation (k,); face, what
    the design's gages read, and read_correlation (k,): of that;
    change_correlation (k,): of the increments' changes. tangential_force (k, 2): finger, twin; N.
    """

    x: Array
    membrane: Array
    upper: Array
    shear: Array
    correlation: Array
    slope: Array
    upper_correlation: Array
    face: str
    read_correlation: Array
    change_correlation: Array
    tangential_force: Array
    stick_ratio: Array

    @property
    def overall_slope(self) -> float:
        """Least squares over all increments and places."""
        return float((self.membrane * self.shear).sum() / (self.shear**2).sum())

    @property
    def overall_correlation(self) -> float:
        """Over all increments and places at once."""
        return correlation(self.membrane.ravel(), self.shear.ravel())


def likeness(case: PaperCase) -> Likeness:
    """Follow the scene with both fingers and compare."""
    motions = [Motion(*row) for row in case.rows]
    count = len(case.gage_x)
    plates = [step.measures for step in follow(case.finger, motions)]
    rubber = [step.measures for step in follow(case.twin, motions)]
    membrane = np.array([gage_readings(m.gages, "both") for m in plates])
    upper = np.array([gage_readings(m.gages, "upper") for m in plates])
    read = np.array([gage_readings(m.gages, case.face) for m in plates])
    shear = np.array([1e6 * m.points[:count, 3] for m in rubber])
    changes = zip(_changes(membrane), _changes(shear), strict=True)
    return Likeness(
        x=case.gage_x,
        membrane=membrane,
        upper=upper,
        shear=shear,
        correlation=_each(membrane, shear),
        slope=np.sum(membrane * shear, axis=1) / np.sum(shear**2, axis=1),
        upper_correlation=_each(upper, shear),
        face=case.face,
        read_correlation=_each(read, shear),
        change_correlation=np.array([correlation(a, b) for a, b in changes]),
        tangential_force=np.array(
            [(a.tangential_force, b.tangential_force) for a, b in zip(plates, rubber, strict=True)]
        ),
        stick_ratio=np.array(
            [np.nan if m.stick_ratio is None else m.stick_ratio for m in plates], dtype=float
        ),
    )


def correlation(first: Array, second: Array) -> float:
    """Pearson's; NaN where one does not vary.

    >>> round(correlation(np.array([1.0, 2.0, 4.0]), np.array([-1.0, -2.0, -4.0])), 6)
    -1.0
    """
    if np.ptp(first) == 0.0 or np.ptp(second) == 0.0:
        return float("nan")
    return float(np.corrcoef(first, second)[0, 1])


def _each(first: Array, second: Array) -> Array:
    return np.array([correlation(a, b) for a, b in zip(first, second, strict=True)])


def _changes(values: Array) -> Array:
    return np.diff(values, axis=0, prepend=np.zeros((1, values.shape[1])))
