"""Forecast of the mean contact pressure, and where finite strain finds no answer under it.

At finite strain each iteration solves the deformed body for given contact forces. Under a pressure
that does not turn with the face the body gives way: a half-plane's face at 2 shear moduli on any
mesh (tests/fem/test_finite_system.py), a column like Euler's strut with a free top.
"""

import math

from fingerdesign.design.scene import Scene, SceneObject
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.zone import approach_for, contact_reach, curvatures, flat_half_extents

_FACE = 2.0  # A free face under dead pressure, in shear moduli.
# A strut with a flat top failed at 0.98 and 0.99 of Euler's load, and the forecast is up to 7 %
# over the pressure of slender blocks: beyond this part of the load none has an answer.
_STRUT = 1.2
# In shear moduli: a block with edges of 0.1 mm failed at 0.49, where its edges roll onto the plane,
# and nothing failed earlier but slender bodies (tests/analysis/test_dead_pressure.py).
_EDGES = 0.45
_SHEAR_SHARE = 5.0 / 6.0  # Of a rectangle's area that carries shear.


def mean_pressure(design: Design, rigid: SceneObject, approach: float) -> float:
    """Forecast of the contact's mean pressure over the body's shear modulus.

    The greater of Hertz's half-space and of a layer that is bonded below and held by friction
    above: the mean strain e of the columns under the contact, as e / (1 - e), times

        E_a / G = 2 / (1 - nu) + 1 / (1 / (4 S^2) + 1 / (M / G - 2 / (1 - nu))),

    S the contact's area over the free area around it and M the confined modulus (after A. N. Gent,
    P. B. Lindley, Proc. Inst. Mech. Eng. 173 (1959) 111). Against the finite-strain model it is
    within a quarter. Plates, cores and rows of shear are left out.
    """
    if approach <= 0.0:
        return 0.0
    nu, height = design.material_of("body").poissons_ratio, float(crest_height(design.body))
    half = _half_extents(design, rigid, approach)
    curved = curvatures(design, rigid)
    free = 2.0 / (1.0 - nu)
    if min(curved) > 0.0:
        root = math.sqrt(half[0] * half[1])
        hertz = free * 2.0 * (curved[0] + curved[1]) * root / (3.0 * math.pi)
    else:
        hertz = free * math.pi * max(c * a for c, a in zip(curved, half, strict=True)) / 8.0
    gap = sum(c * a * a / 6.0 for c, a in zip(curved, half, strict=True))
    flat = design.body.kind.curvatures(design.body) == (0.0, 0.0)
    depth = 0.5 * approach if flat and rigid.flat and rigid.tilt_deg else approach - gap
    strain = min(max(depth, 0.0) / height, 0.9)
    shape = half[0] * half[1] / ((half[0] + half[1]) * height)
    confined = free * (1.0 - nu) ** 2 / max(1.0 - 2.0 * nu, 1e-9)
    # A body without Poisson's effect, or hardly pressed, gains nothing from its bonded base.
    least = min(4.0 * shape**2, confined - free)
    bonded = 1.0 / (1.0 / (4.0 * shape**2) + 1.0 / (confined - free)) if least > 1e-12 else 0.0
    return max(hertz, (free + bonded) * strain / (1.0 - strain))


def greatest_pressure(design: Design, scene: Scene) -> float:
    """The same of a scene's row with the greatest approach, or normal force."""
    most = max(row[0] for row in scene.path.rows)
    if scene.path.control != "force":
        return mean_pressure(design, scene.object, most)
    material = design.material_of("body")
    shear = 0.5 * material.youngs_modulus_MPa / (1.0 + material.poissons_ratio)
    wide, deep = _half_extents(design, scene.object, approach_for(design, scene.object, most))
    return most / (4.0 * wide * deep * shear)


def greatest_approach_at(design: Design, rigid: SceneObject, pressure: float) -> float:
    """The approach, mm, at which mean_pressure is ``pressure``; at most half of the height."""
    low, high = 0.0, 0.5 * float(crest_height(design.body))
    for _ in range(40):
        middle = 0.5 * (low + high)
        below = mean_pressure(design, rigid, middle) < pressure
        low, high = (middle, high) if below else (low, middle)
    return low


def sound_pressure(design: Design) -> float:
    """Mean pressure over the shear modulus up to which finite strain has an answer. Of a slender
    body Euler's load with the share of shear (Engesser)."""
    return min(_EDGES, 1.0 / (1.0 / _euler(design) + 1.0 / _SHEAR_SHARE))


def greatest_possible(design: Design) -> float:
    """Mean pressure over the shear modulus beyond which finite strain has no answer."""
    if design.body.kind.flat:
        return min(_FACE, _STRUT * _euler(design))
    return _FACE


def _euler(design: Design) -> float:
    """Euler's load of a strut with a free top, pi^2 E* w^2 / (48 h^2), over the shear modulus."""
    nu, height = design.material_of("body").poissons_ratio, float(crest_height(design.body))
    thin = min(design.body.width_mm, design.body.depth_mm)
    return math.pi**2 / 24.0 / (1.0 - nu) * (thin / height) ** 2


def _half_extents(design: Design, rigid: SceneObject, approach: float) -> tuple[float, float]:
    """Half-extents of the contact, mm: as forecast, but no wider than where both overlap."""
    reach, most = contact_reach(design, rigid, approach), flat_half_extents(design.body)
    overlap = [math.sqrt(2.0 * approach / c) if c else math.inf for c in curvatures(design, rigid)]
    return min(reach[0], most[0], overlap[0]), min(reach[1], most[1], overlap[1])
