"""The candidate zone: a forecast of the contact's extent, before any model is built.

The solver refuses a zone that is too narrow (ZoneExhausted); it is then widened.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.scene import Scene, SceneObject
from fingerdesign.design.schema import Body, Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.profile import profile_of

# The forecast for a plane on a straight finger is 4 to 24 % wide, over a core up to 9 % narrow; the
# factor covers that. It neglects shear, which moves the contact by a few tenths of a millimetre.
_FACTOR, _MARGIN = 1.15, 0.3
# Half-width over that of the undeformed overlap: 0.71 in a round contact, to 1 in a long one.
_OVERLAP = 0.85
# Part of the whole column's compression that is added to a layer's. By plane-strain models of seven
# fingers with a half-width of 0.06 to 1.4 heights, approaches are within 10 %.
_FREE_SIDES = 1.0 / 3.0
_WORTH = 0.8  # A zone shorter than this part of the half-depth leaves out candidates along z.


def flat_half_extents(body: Body) -> tuple[float, float]:
    """Half-extents along x and z of the top that is there to touch, mm: a block's without edges."""
    most = 0.5 * body.width_mm, 0.5 * body.depth_mm
    if body.kind.flat:
        return profile_of(body).pieces[0].end[0], most[1]
    return most


def contact_half_width(design: Design, approach_mm: float, object_curvature: float = 0.0) -> float:
    """Forecast of the contact's half-width at z = 0 under a plane pressed ``approach_mm``, mm.

    ``object_curvature`` (1/mm): of a cylinder along z instead of the plane. Straight body: Hertz's
    line contact on a layer of the crest's height d (Johnson, Contact Mechanics, 1985, eq. 5.56),
    approach = a^2 / (4 R) (2 ln(2 d / a) - nu / (1 - nu)), with ln(1 + x) in the place of ln(x): so
    it grows with the approach also where the contact is wide. A crest curved along z too (dome,
    pin): point contact on a half-space of the mean curvature, approach = a^2 / R. A flat top under
    a plane: all of it. Plates, cores, free sides and friction are left out, so it errs to the wide
    side: against the plane-strain model of four shipped fingers at a quarter to all of their grips'
    travel by 4 to 24 %; over a hard core it is 6 to 9 % narrow, on a layer of a third of the
    contact's half-width 20 to 70 % wide. A forecast, no result. Never more than half of the body's
    width.
    """
    body = design.body
    most = flat_half_extents(body)[0]
    if approach_mm <= 0:
        return 0.0
    across, along = body.kind.curvatures(body)
    across += object_curvature
    if along > 0.0:
        return min(math.sqrt(2.0 * approach_mm / (across + along)), most)
    if across == 0.0:
        return most
    height, nu = float(crest_height(body)), design.material_of("body").poissons_ratio
    deep = 2.0 * height * math.exp(-0.5 * nu / (1.0 - nu))
    low, high = 0.0, most
    for _ in range(60):
        middle = 0.5 * (low + high)
        reached = middle * middle * across / 2.0 * math.log1p(deep / middle)
        low, high = (middle, high) if reached < approach_mm else (low, middle)
    return low


@dataclass(frozen=True)
class Zone:
    """Contact candidates: |x| <= half_width and, where given, |z| <= half_depth (mm).

    inner: half-width, mm, that the scene's own path reaches, where grips reach further: facets of a
    long contact are finest there (None: the same everywhere).
    """

    half_width: float
    half_depth: float | None = None
    inner: float | None = None

    def __str__(self) -> str:
        deep = "" if self.half_depth is None else f", |z| <= {self.half_depth:.2f}"
        return f"|x| <= {self.half_width:.2f}{deep} mm"

    def widened(self, factor: float, design: Design) -> Zone:
        """The zone ``factor`` times as large, within the body."""
        wider = _within(design, factor * self.half_width, factor * (self.half_depth or math.inf))
        return replace(wider, inner=self.inner)

    def fills(self, design: Design) -> bool:
        """True if it holds the whole contact surface."""
        return self.half_depth is None and self.half_width >= 0.5 * design.body.width_mm


def candidate_zone(
    design: Design, rigid: SceneObject, approach: float, touch: tuple[float, float] = (0.0, 0.0)
) -> Zone:
    """The zone for an object pressed ``approach`` mm onto the finger that it touched at (x, z)."""
    wide, deep = (_FACTOR * reach + _MARGIN for reach in contact_reach(design, rigid, approach))
    return _within(design, abs(touch[0]) + wide, abs(touch[1]) + deep)


def contact_reach(design: Design, rigid: SceneObject, approach: float) -> tuple[float, float]:
    """Forecast half-extents of the contact along x and z, mm; infinite where z has no end to it."""
    matrix, own = rigid.curvature(), design.body.kind.curvatures(design.body)
    tilted = rigid.flat and bool(rigid.tilt_deg)
    if own == (0.0, 0.0) and tilted:
        # As far as a tilted plane reaches over a flat top from the edge that it touched first.
        level = abs(math.cos(math.radians(rigid.turn_deg)))
        slope = math.tan(math.radians(abs(rigid.tilt_deg))) * level
        return (max(approach, 0.0) / slope if slope > 1e-9 else math.inf), math.inf
    if own[1] + matrix[1, 1] == 0.0:
        return contact_half_width(design, approach, float(matrix[0, 0])), math.inf
    if rigid.flat and not tilted:
        return (contact_half_width(design, approach),) * 2
    wide, deep = _overlap_reaches(np.diag(own) + matrix, approach)
    return wide, math.inf if tilted else deep


def approach_for(
    design: Design, rigid: SceneObject, normal_force: float, free_sides: float = _FREE_SIDES
) -> float:
    """Approach, mm, at which the object presses about ``normal_force`` N; Hertz's formulas.

    Line contact on a layer of height h, with a contact half-width a, of a body with section area A:

        approach = a^2 curvature / 4  ln(1 + (2 h / a)^2 exp(-nu / (1 - nu))) + F h / (3 E* A)

    While a is small the first term is the layer's (Johnson, Contact Mechanics, 1985, eq. 5.56);
    the second is the free sides', which lend no support, here a third (``free_sides``). Else a
    round point contact of the mean curvature (eqs 4.23, 4.45); a flat top under a plane is pressed
    as a column. At most half of the height.
    """
    material, body = design.material_of("body"), design.body
    modulus = material.youngs_modulus_MPa / (1.0 - material.poissons_ratio**2)
    across, along = curvatures(design, rigid)
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
        layer = math.log1p((2.0 * height / half) ** 2 * math.exp(-nu / (1.0 - nu)))
        column = normal_force * height / (modulus * 4.0 * wide * deep)
        approach = half * half * across / 4.0 * layer + free_sides * column
    elif rigid.tilt_deg:  # a wedge: half the pressure of the flat top at the same depth
        approach = 2.0 * normal_force * height / (modulus * 4.0 * wide * deep)
    else:
        approach = normal_force * height / (modulus * 4.0 * wide * deep)
    return min(approach, 0.5 * height)


def greatest_approach(design: Design, scene: Scene) -> float:
    """Greatest approach of a scene's object, mm; a forecast where forces are prescribed."""
    rows = scene.path.rows
    if scene.path.control == "force":
        # What the free sides give way widens no contact.
        return approach_for(design, scene.object, max(row[0] for row in rows), free_sides=0.0)
    return max(row[0] for row in rows)


def _within(design: Design, half_width: float, half_depth: float) -> Zone:
    half = 0.5 * design.body.depth_mm
    limited = half_depth if half_depth < _WORTH * half else None
    return Zone(min(half_width, 0.5 * design.body.width_mm), limited)


def curvatures(design: Design, rigid: SceneObject) -> tuple[float, float]:
    """Curvatures of body and object together, along x and along z, 1/mm."""
    own, other = design.body.kind.curvatures(design.body), rigid.curvature()
    return own[0] + float(other[0, 0]), own[1] + float(other[1, 1])


def _overlap_reaches(matrix: Array, approach: float) -> tuple[float, float]:
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
