"""The lowest rung of the ladder: a straight finger without plates, by formulas (numpy only).

Hertz's line contact on a layer of the crest's height (Johnson, Contact Mechanics, 1985, eq. 5.56)

    approach(a) = a^2 / (4 R) (2 ln(2 d / a) - nu / (1 - nu)),   P(a) = pi E* a^2 L / (4 R)

and, pulled sideways under a held force, Cattaneo's partial slip as the difference of two such
contacts (Jaeger 1998; Ciavarella 1998), of half-widths a and c:

    Q = mu (P(a) - P(c)),   shear = mu (yield(a) - yield(c)),   stick ratio c / a
    yield(a) = a^2 / (4 R) (2 ln(2 d / a) + (2 - nu) / (1 - nu))

The last is eq. 5.56 for a force along the surface: Flamant's displacement below it has its other
constant the other way round (Timoshenko and Goodier, Theory of Elasticity, 1970, art. 36).
"""

import math
from collections.abc import Callable

import numpy as np

from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height

NAME = "formulas: Hertz on a layer, Cattaneo"
_STEPS = 60


def analytic_readings(design: Design, scene: Scene) -> Readings | None:
    """The readings of the path by formulas; None where these do not hold.

    They hold for an arc without plates or core under a level plane that is pressed, never let go,
    and pulled one way only at constant approach or force.
    """
    body, rigid = design.body, scene.object
    plain = body.shape == "arc" and body.edge_radius_mm is None and body.core is None
    if not plain or design.plates.number or not rigid.flat or rigid.tilt_deg:
        return None
    rows = np.array([row[:2] for row in scene.path.rows])
    if not scene.path.mirrors_in_z or not _monotone(rows):
        return None
    law = _Layer(design)
    found = []
    friction = rigid.friction_coefficient
    for normal, pull in rows:
        if scene.path.control == "force":
            half = law.inverse(law.force, normal)
            grip = law.inverse(law.force, max(normal - pull / max(friction, 1e-12), 0.0))
        else:
            half = law.inverse(law.approach, normal)
            left = law.sideways(half) - pull / max(friction, 1e-12)
            grip = law.inverse(law.sideways, max(left, 0.0))
        tangential = friction * (law.force(half) - law.force(grip))
        found.append((law.force(half), tangential, 2.0 * half, grip / half if half > 0.0 else 0.0))
    normal_force, tangential_force, width, stick = np.array(found).T
    none = np.empty((len(found), 0, 2))
    return Readings(normal_force, tangential_force, width, stick, none, design.gages.face)


class _Layer:
    """Force and approach of a half-width on the finger's layer, both rising up to ``widest``."""

    def __init__(self, design: Design) -> None:
        body, material = design.body, design.material_of("body")
        self.nu = material.poissons_ratio
        self.radius, self.depth = body.arc_radius_mm, body.depth_mm
        self.modulus = material.youngs_modulus_MPa / (1.0 - self.nu**2)
        self.height = float(crest_height(body))
        most = 2.0 * self.height * math.exp(-0.5 / (1.0 - self.nu))
        self.widest = min(0.5 * body.width_mm, most)

    def force(self, half: float) -> float:
        """N on the whole finger."""
        return math.pi * self.modulus * half**2 * self.depth / (4.0 * self.radius)

    def approach(self, half: float) -> float:
        """mm, along the normal."""
        return self._yields(half, -self.nu / (1.0 - self.nu))

    def sideways(self, half: float) -> float:
        """mm along the surface, where all of it slips at a friction coefficient of 1."""
        return self._yields(half, (2.0 - self.nu) / (1.0 - self.nu))

    def _yields(self, half: float, constant: float) -> float:
        if half <= 0.0:
            return 0.0
        layer = 2.0 * math.log(2.0 * self.height / half) + constant
        return half**2 / (4.0 * self.radius) * layer

    def inverse(self, law: Callable[[float], float], value: float) -> float:
        """The half-width, mm, at which a rising law has a value."""
        if value <= 0.0:
            return 0.0
        low, high = 0.0, self.widest
        for _ in range(_STEPS):
            middle = 0.5 * (low + high)
            low, high = (middle, high) if law(middle) < value else (low, middle)
        return low


def _monotone(rows: np.ndarray[tuple[int, int], np.dtype[np.float64]]) -> bool:
    """Whether the first column never falls, and the second rises only while the first is held."""
    steps = np.diff(rows, axis=0)
    pulled = rows[:, 1] != 0.0
    held = (steps[:, 0] == 0.0) | (~pulled[1:])
    return bool((steps >= 0.0).all() and held.all() and rows[0, 1] == 0.0)
