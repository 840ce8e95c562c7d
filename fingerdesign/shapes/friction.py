"""Friction of an object's surface: the largest shear traction as a function of the pressure.

    bound(p) = min(s p, tau0 + mu p0^n p^(1 - n), cap)      MPa, of the pressure p >= 0, MPa

With tau0 = n = 0 and no cap it is Coulomb's law, without the first term. Otherwise s =
:data:`STEEPEST`: at first touch no contact carries more than s times its pressure. A bound that
jumped to tau0 at p = 0 would leave increments without any answer: a node that opens under the
shear which it carries only while closed. As it stands the bound is continuous, concave and rises,
and an increment whose motion is given has an answer for the same reason as with Coulomb's law.
"""

from dataclasses import dataclass, replace
from math import inf, isfinite
from typing import Self

import numpy as np

from fingerdesign.arrays import Array

# The range of friction coefficients that scenes may ask for ends here too. On a Hertz contact whose
# peak pressure is p0, bound(p) differs from tau0 on (tau0 / (s p0))^2 of the area: 0.1 % if
# tau0 = 0.3 p0.
STEEPEST = 10.0


@dataclass(frozen=True)
class FrictionLaw:
    """A law of friction; see the module for the equation.

    coefficient: mu, that at the pressure p0 where the exponent n is not 0; strength: tau0, MPa;
    cap, MPa; exponent: n, 0 <= n < 1; reference: p0, MPa. Raises ValueError for other numbers.
    """

    coefficient: float
    strength: float = 0.0
    cap: float = inf
    exponent: float = 0.0
    reference: float = 1.0

    def __post_init__(self) -> None:
        mu = self.coefficient
        if not (isfinite(mu) and mu >= 0.0):
            raise ValueError(f"friction coefficient {mu} must be finite and >= 0")
        if self.is_coulomb:
            return
        sound = (
            mu <= STEEPEST
            and 0.0 <= self.strength < inf
            and self.cap > 0.0
            and 0.0 <= self.exponent < 1.0
            and 0.0 < self.reference < inf
        )
        if not sound:
            raise ValueError(
                f"{self!r}: the coefficient must be at most {STEEPEST:g}, the strength finite and "
                "at least 0, the cap over 0, the exponent at least 0 and below 1, the reference "
                "pressure finite and over 0"
            )

    @property
    def is_coulomb(self) -> bool:
        """Tell whether the bound is the coefficient times the pressure, at any pressure."""
        return self.strength == 0.0 and self.cap == inf and self.exponent == 0.0

    @property
    def steepest(self) -> float:
        """The largest slope, and the largest bound over pressure."""
        return self.coefficient if self.is_coulomb else STEEPEST

    @property
    def name(self) -> str:
        """The law as a text, as records have it; "" for Coulomb's."""
        return "" if self.is_coulomb else str(self)

    @property
    def shown(self) -> float | str:
        """Coulomb's coefficient, or the law as a text."""
        return self.coefficient if self.is_coulomb else str(self)

    def scaled(self, share: float) -> Self:
        """The law with ``share`` > 0 times the bound, but for its first touch."""
        mu, strength, cap = (share * each for each in (self.coefficient, self.strength, self.cap))
        return replace(self, coefficient=mu, strength=strength, cap=cap)

    def bound(self, normal: Array, areas: Array | float = 1.0) -> Array:
        """Largest shear forces (k,) N at normal forces (k,) N on areas (k,) mm^2.

        Of pressures, areas left out, it is tractions. Below 0 the first term goes on as a line.

        >>> FrictionLaw(0.0, strength=0.2).bound(np.array([0.01, 1.0, 4.0])).tolist()
        [0.1, 0.2, 0.2]
        >>> FrictionLaw(0.3, 0.1, cap=0.5).bound(np.array([1.0, 4.0])).tolist()
        [0.4, 0.5]
        """
        if self.is_coulomb:
            return np.asarray(self.coefficient * normal)
        free = self.strength * areas + self._rising(np.maximum(normal, 0.0), areas)
        return np.asarray(np.minimum(np.minimum(STEEPEST * normal, free), self.cap * areas))

    def slope(self, normal: Array, areas: Array | float = 1.0) -> Array:
        """Derivative (k,) of :meth:`bound` by the normal force; at a corner that of either side.

        >>> FrictionLaw(0.3, 0.1, cap=0.5).slope(np.array([0.001, 1.0, 4.0])).tolist()
        [10.0, 0.3, 0.0]
        """
        if self.is_coulomb:
            return np.full(np.shape(normal), self.coefficient)
        pressed = np.maximum(normal, 0.0)
        rising = self._rising(pressed, areas)
        free = self.strength * areas + rising
        steep = STEEPEST * normal <= free
        own = (1.0 - self.exponent) * rising / np.where(pressed > 0.0, pressed, 1.0)
        slope = np.where(free < self.cap * areas, own, 0.0)
        return np.where(steep & (STEEPEST * normal <= self.cap * areas), STEEPEST, slope)

    def _rising(self, pressed: Array, areas: Array | float) -> Array:
        """mu p0^n p^(1 - n), as a force."""
        if self.exponent == 0.0:
            return np.asarray(self.coefficient * pressed)
        scale = self.coefficient * (self.reference * areas) ** self.exponent
        return np.asarray(scale * pressed ** (1.0 - self.exponent))

    def __str__(self) -> str:
        if self.is_coulomb:
            return f"{self.coefficient:g}"
        cap = "" if self.cap == inf else f", at most {self.cap:g} MPa"
        if self.coefficient == 0.0:
            return f"{self.strength:g} MPa{cap}"
        own = f"{self.coefficient:g}"
        if self.exponent:
            own += f" (p / {self.reference:g} MPa)^-{self.exponent:g}"
        return (f"{self.strength:g} MPa + {own} p" if self.strength else f"{own} p") + cap
