"""How far the contact of a scene will reach, before any model is built: the candidate zone.

A forecast, no result: one too narrow is refused by the solver (ZoneExhausted) and widened.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from fingerdesign.design.forecast import (
    contact_half_width,
    crest_curvatures,
    flat_half_extents,
)
from fingerdesign.design.layout import crest_height
from fingerdesign.design.scene import Scene, SceneObject
from fingerdesign.design.schema import Design

# The forecast for a plane on a straight finger is 8 to 26 % wide and knows nothing of shear, which
# drags the contact along by a few tenths of a millimetre.
_FACTOR, _MARGIN = 1.1, 0.3
# Half-width over that of the undeformed overlap: 0.71 in a round contact, to 1 in a long one.
_OVERLAP = 0.85
_WORTH = 0.8  # of the half-depth: a shorter zone than this leaves candidates out along z


@dataclass(frozen=True)
class Zone:
    """Contact candidates: |x| <= half_width and, where given, |z| <= half_depth (mm)."""

    half_width: float
    half_depth: float | None = None

    def __str__(self) -> str:
        deep = "" if self.half_depth is None else f", |z| <= {self.half_depth:.2f}"
        return f"|x| <= {self.half_width:.2f}{deep} mm"

    def widened(self, factor: float, design: Design) -> Zone:
        """The zone ``factor`` times as large, within the body."""
        return _within(design, factor * self.half_width, factor * (self.half_depth or math.inf))

    def fills(self, design: Design) -> bool:
        """Whether it holds the whole contact surface."""
        return self.half_depth is None and self.half_width >= 0.5 * design.body.width_mm


def candidate_zone(
    design: Design,
    rigid: SceneObject,
    approach: float,
    touch: tuple[float, float] = (0.0, 0.0),
) -> Zone:
    """The zone for an object pressed ``approach`` mm onto the finger that it touched at (x, z)."""
    wide, deep = (_FACTOR * reach + _MARGIN for reach in contact_reach(design, rigid, approach))
    return _within(design, abs(touch[0]) + wide, abs(touch[1]) + deep)


def contact_reach(design: Design, rigid: SceneObject, approach: float) -> tuple[float, float]:
    """Forecast half-extents of the contact along x and z, mm; infinite where z has no end to it."""
    across, along = _object_curvatures(rigid)
    own = crest_curvatures(design.body)
    tilted = rigid.shape == "plane" and bool(rigid.tilt_deg)
    if own == (0.0, 0.0) and tilted:
        return _wedge(rigid, approach), math.inf
    if own[1] + along == 0.0:
        return contact_half_width(design, approach, across), math.inf
    if rigid.shape == "plane" and not tilted:
        return (contact_half_width(design, approach),) * 2
    wide, deep = _overlap_reaches(np.diag(own) + _curvature_matrix(rigid), approach)
    return wide, math.inf if tilted else deep


def _wedge(rigid: SceneObject, approach: float) -> float:
    """How far a tilted plane reaches over a flat top from the edge that it touched first, mm."""
    turn = math.radians(rigid.turn_deg)
    slope = math.tan(math.radians(abs(rigid.tilt_deg))) * abs(math.cos(turn))
    return max(approach, 0.0) / slope if slope > 1e-9 else math.inf


def approach_for(design: Design, rigid: SceneObject, normal_force: float) -> float:
    """Approach, mm, at which the object presses about ``normal_force`` N; Hertz's formulas.

    Line contact on a layer as in contact_half_width, else a round point contact of the mean
    curvature (Johnson, Contact Mechanics, 1985, eqs 4.23, 4.45, 5.56); a flat top under a plane is
    pressed as a column. At most half of the height.
    """
    material, body = design.material_of("body"), design.body
    modulus = material.youngs_modulus_MPa / (1.0 - material.poissons_ratio**2)
    across, along = _object_curvatures(rigid)
    own = crest_curvatures(body)
    across, along = across + own[0], along + own[1]
    height = float(crest_height(body))
    wide, deep = flat_half_extents(body)
    length = 2.0 * deep
    if across == 0.0 < along:  # a cylinder along x on a flat top: a line along x
        across, along, length = along, 0.0, 2.0 * wide
    if along > 0.0:
        radius = 2.0 / (across + along)
        approach = math.pow(0.75 * normal_force / (modulus * math.sqrt(radius)), 2.0 / 3.0)
    elif across > 0.0:
        half = math.sqrt(4.0 * normal_force / (length * math.pi * modulus * across))
        nu = material.poissons_ratio
        layer = 2.0 * math.log(max(2.0 * height / half, 1.0 + 1e-9)) - nu / (1.0 - nu)
        approach = half * half * across / 4.0 * max(layer, 0.5)
    elif rigid.tilt_deg:  # a wedge: half the pressure of the flat top at the same depth
        approach = 2.0 * normal_force * height / (modulus * 4.0 * wide * deep)
    else:
        approach = normal_force * height / (modulus * 4.0 * wide * deep)
    return min(approach, 0.5 * height)


def greatest_approach(design: Design, scene: Scene) -> float:
    """How far the object of a scene comes, mm; a forecast where forces are prescribed."""
    rows = scene.path.rows
    if scene.path.control == "force":
        return approach_for(design, scene.object, max(row[0] for row in rows))
    return max(row[0] for row in rows)


def _within(design: Design, half_width: float, half_depth: float) -> Zone:
    half = 0.5 * design.body.depth_mm
    kept = half_depth if half_depth < _WORTH * half else None
    return Zone(min(half_width, 0.5 * design.body.width_mm), kept)


def _object_curvatures(rigid: SceneObject) -> tuple[float, float]:
    matrix = _curvature_matrix(rigid)
    return float(matrix[0, 0]), float(matrix[1, 1])


def _curvature_matrix(rigid: SceneObject) -> np.ndarray[tuple[int, int], np.dtype[np.float64]]:
    """Curvature of the object's lower face over (x, z), 1/mm; tilt left out."""
    if rigid.shape == "plane" or rigid.radius_mm is None:
        return np.zeros((2, 2))
    curvature = 1.0 / rigid.radius_mm
    if rigid.shape == "sphere":
        return np.eye(2) * curvature
    turn = math.radians(rigid.turn_deg)
    axis = np.array(
        [math.cos(turn), -math.sin(turn)] if rigid.axis == "x" else [math.sin(turn), math.cos(turn)]
    )
    return curvature * (np.eye(2) - np.outer(axis, axis))


def _overlap_reaches(
    matrix: np.ndarray[tuple[int, int], np.dtype[np.float64]], approach: float
) -> tuple[float, float]:
    """Half-extents along x and z of the ellipse q . K q / 2 = approach, lessened."""
    if np.linalg.det(matrix) <= 1e-12 * max(float(np.trace(matrix)), 1e-300) ** 2:
        level, turned = 2.0 * max(approach, 0.0), abs(float(matrix[0, 1])) > 1e-12
        first, second = (
            _OVERLAP * math.sqrt(level / each) if each and not turned else math.inf
            for each in (float(matrix[0, 0]), float(matrix[1, 1]))
        )
        return first, second
    inverse = np.linalg.inv(matrix)
    x, z = (_OVERLAP * math.sqrt(2.0 * max(approach, 0.0) * inverse[k, k]) for k in (0, 1))
    return x, z
