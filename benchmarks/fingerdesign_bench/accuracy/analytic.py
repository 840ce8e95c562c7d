"""Analytic solutions of contact mechanics: what numbers are held against (numpy only).

Two elastic bodies act through R (1/R = 1/R1 + 1/R2) and E* (1/E* is the sum of (1 - nu^2)/E of
each); against a rigid plane R and E / (1 - nu^2) are the body's own. Units are the caller's, if
consistent (mm, N, MPa here). Source, unless stated: K. L. Johnson, Contact Mechanics, 1985.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from fingerdesign.arrays import Array


def plane_strain_modulus(youngs_modulus: float, poissons_ratio: float) -> float:
    """E* = E / (1 - nu^2) of one elastic body against a rigid one.

    >>> plane_strain_modulus(3.0, 0.5)
    4.0
    """
    return youngs_modulus / (1.0 - poissons_ratio**2)


@dataclass(frozen=True)
class Hertz:
    """Half-width (line) or radius (point) of the contact, and greatest pressure."""

    half_width: float
    peak_pressure: float

    def pressure(self, distance: ArrayLike) -> Array:
        """p0 sqrt(1 - (x / a)^2), zero outside."""
        ratio = np.asarray(distance, dtype=float) / self.half_width
        return np.asarray(self.peak_pressure * np.sqrt(np.maximum(0.0, 1.0 - ratio**2)))


def hertz_line(force_per_length: float, radius: float, modulus: float) -> Hertz:
    """a^2 = 4 P' R / (pi E*), p0 = 2 P' / (pi a) (eqs 4.43, 4.45).

    >>> h = hertz_line(1.0, 20.0, 5.0)
    >>> round(h.half_width, 4), round(h.peak_pressure, 4)
    (2.2568, 0.2821)
    """
    half_width = float(np.sqrt(4.0 * force_per_length * radius / (np.pi * modulus)))
    return Hertz(half_width, 2.0 * force_per_length / (np.pi * half_width))


def hertz_point(force: float, radius: float, modulus: float) -> Hertz:
    """a^3 = 3 P R / (4 E*), p0 = 3 P / (2 pi a^2) (eqs 4.22, 4.24).

    >>> h = hertz_point(1.0, 10.0, 5.0)
    >>> round(h.half_width, 4), round(h.half_width**2 / 10.0, 5)  # the approach, a^2 / R
    (1.1447, 0.13104)
    """
    half_width = float(np.cbrt(0.75 * force * radius / modulus))
    return Hertz(half_width, float(1.5 * force / (np.pi * half_width**2)))


def hertz_point_force(approach: float, radius: float, modulus: float) -> float:
    """P = (4 / 3) E* sqrt(R) delta^(3/2) (eq. 4.23).

    >>> round(hertz_point_force(0.13104, 10.0, 5.0), 3)
    1.0
    """
    return float(4.0 / 3.0 * modulus * np.sqrt(radius) * approach**1.5)


def cattaneo_mindlin_line(tangential: float, normal: float, friction_coefficient: float) -> float:
    """Stick half-width over contact half-width under constant normal load (sect. 7.2).

    c / a = sqrt(1 - |Q| / (mu P)). Raises ValueError for |Q| > mu P.

    >>> cattaneo_mindlin_line(0.375, 1.0, 0.5)
    0.5
    """
    return float(_stick(tangential, normal, friction_coefficient) ** 0.5)


def cattaneo_mindlin_sphere(
    tangential: float,
    normal: float,
    friction_coefficient: float,
    reversed_from: float | None = None,
) -> float:
    """Stick radius over contact radius: (1 - |Q| / (mu P))^(1/3) (sects 7.2, 7.4).

    ``reversed_from`` = Q*: the shear was first raised to Q* and then brought back to Q, and |Q| is
    replaced by |Q* - Q| / 2; beyond -Q* (or Q*) nothing is left of the past.

    Cattaneo's and Mindlin's traction acts along the shear alone, while its slip also has a small
    component across it, so for nu > 0 this is the accepted approximation (sect. 7.2).

    >>> round(cattaneo_mindlin_sphere(0.4375, 1.0, 0.5), 12)
    0.5
    >>> round(cattaneo_mindlin_sphere(-0.4375, 1.0, 0.5, reversed_from=0.4375), 12)
    0.5
    """
    return float(_stick(tangential, normal, friction_coefficient, reversed_from) ** (1.0 / 3.0))


def cattaneo_mindlin_traction(
    x: ArrayLike, contact: Hertz, stick_ratio: float, friction_coefficient: float
) -> Array:
    """Shear traction at distance x from the middle: mu p(x) less mu p0 (c/a) sqrt(1 - (x/c)^2).

    The second part acts in |x| < c = stick_ratio a. The same for line and sphere, each with its own
    c / a (sect. 7.2).

    >>> contact = Hertz(1.0, 2.0)
    >>> float(cattaneo_mindlin_traction(0.0, contact, 0.6, 0.5))
    0.4
    """
    inner = Hertz(stick_ratio * contact.half_width, stick_ratio * contact.peak_pressure)
    sheared = contact.pressure(x)
    if stick_ratio > 0.0:
        sheared = sheared - inner.pressure(x)
    return np.asarray(friction_coefficient * sheared)


def _stick(
    tangential: float,
    normal: float,
    friction_coefficient: float,
    reversed_from: float | None = None,
) -> float:
    limit = friction_coefficient * normal
    if limit <= 0.0:
        raise ValueError("friction and normal force must be positive")
    share = abs(tangential) / limit
    if share > 1.0:
        raise ValueError(f"the tangential force {tangential:g} is over the limit {limit:g}")
    if reversed_from is not None and abs(tangential) <= abs(reversed_from):
        if abs(reversed_from) > limit:
            raise ValueError(f"the shear cannot have been {reversed_from:g}, over {limit:g}")
        share = abs(reversed_from - tangential) / (2.0 * limit)
    return 1.0 - share


def flat_punch_pressure(x: ArrayLike, force_per_length: float, half_width: float) -> Array:
    """p(x) = P' / (pi sqrt(a^2 - x^2)) under a rigid flat frictionless punch (eq. 2.64).

    >>> round(float(flat_punch_pressure(0.0, np.pi, 1.0)), 12)
    1.0
    """
    x = np.asarray(x, dtype=float)
    if (np.abs(x) >= half_width).any():
        raise ValueError("the pressure is not bounded at the punch's edge, nor defined outside")
    return np.asarray(force_per_length / (np.pi * np.sqrt(half_width**2 - x**2)))


def bonded_incompressible_layer(
    half_width: float, radius: float, modulus: float, thickness: float
) -> tuple[float, float]:
    """Force per length and peak pressure of a cylinder on a thin bonded layer, nu = 0.5.

    p(x) = E (a^2 - x^2)^2 / (24 R b^3), approach = a^2 / (6 R); thickness b << a, frictionless top
    (sect. 5.8).

    >>> bonded_incompressible_layer(2.0, 1.0, 3.0, 1.0)[1]
    2.0
    """
    peak = modulus * half_width**4 / (24.0 * radius * thickness**3)
    return 16.0 / 15.0 * half_width * peak, peak


def bonded_compressible_layer(
    half_width: float, radius: float, poissons_ratio: float, thickness: float
) -> tuple[float, float]:
    """Force per length and peak pressure of a cylinder on a thin bonded layer of E = 1.

    Each column yields by itself: p(x) = M (a^2 - x^2) / (2 R b), M = (1 - nu) E / ((1 + nu)
    (1 - 2 nu)), approach a^2 / (2 R); thickness b << a (sect. 5.8).

    >>> bonded_compressible_layer(3.0, 1.0, 0.0, 1.0)
    (18.0, 4.5)
    """
    stiffness = (1.0 - poissons_ratio) / ((1.0 + poissons_ratio) * (1.0 - 2.0 * poissons_ratio))
    peak = stiffness * half_width**2 / (2.0 * radius * thickness)
    return 4.0 / 3.0 * half_width * peak, peak


def sliding_wedge(slope: float, friction_coefficient: float) -> float:
    """Horizontal force over weight that pushes a block up a slope: (tan a + mu) / (1 - mu tan a).

    ``slope`` = tan a. NAFEMS benchmark CGS-4. Raises ValueError where no force is enough.

    >>> round(sliding_wedge(0.1, 0.3), 6)
    0.412371
    """
    if slope * friction_coefficient >= 1.0:
        raise ValueError("the block locks: mu tan a must be below 1")
    return (slope + friction_coefficient) / (1.0 - friction_coefficient * slope)
