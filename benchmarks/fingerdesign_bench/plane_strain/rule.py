"""Rules of thumb fitted to the plane-strain map, and how far they are off (numpy only).

    error = K poisson(nu) (a / H)^p / (1 + c D / H)

H height of the crest, D depth, a the contact's half-width. poisson(nu) = (nu^2 / (1 - nu^2))^q, the
part by which plane strain is stiffer than plane stress to a power. For D << H the finger is a thin
plate (plane stress), for D >> H the error is that of the two free ends: it falls as H / D.
"""

from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.validate.plane_strain import PlaneStrainMap

_DEPTH = np.geomspace(0.02, 20.0, 400)  # of c: the other constants are linear in logarithms


@dataclass(frozen=True)
class Rule:
    """One fitted rule; ``span`` None: of all spans. ``off``: its worst distance to the grid's
    errors, absolute; ``typical`` the root of their mean square."""

    quantity: str
    span: float | None
    factor: float
    poisson: float
    width: float
    depth: float
    off: float = 0.0
    typical: float = 0.0

    def error(self, poisson: Array | float, depth: Array | float, width: Array | float) -> Array:
        """The error for Poisson's ratio, D/H and a/H."""
        nu = np.asarray(poisson, dtype=float)
        stiffer = (nu**2 / (1.0 - nu**2)) ** self.poisson
        along = 1.0 + self.depth * np.asarray(depth, dtype=float)
        return np.asarray(self.factor * stiffer * np.asarray(width) ** self.width / along)

    def row(self) -> list[str]:
        """Cells of a table."""
        words = f"{self.factor:.3g} x^{self.poisson:.2f} (a/H)^{self.width:.2f} "
        words += f"/ (1 + {self.depth:.2g} D/H)"
        name = self.quantity.replace("_", " ")
        return [name, f"{self.span:g}", words, f"{self.typical:.1%}", f"{self.off:.1%}"]

    def as_dict(self) -> dict[str, Any]:
        """Plain values, to four digits."""
        return {
            name: float(f"{value:.4g}") if isinstance(value, float) else value
            for name, value in asdict(self).items()
        }


def fitted(chart: PlaneStrainMap, quantity: str, span: float) -> Rule:
    """The rule that fits a quantity's errors on the grid best, at one span share."""
    at = int(np.argmin(np.abs(chart.span - span)))
    error = np.abs(chart.errors[quantity][:, at])
    nu = np.broadcast_to(chart.poisson[:, None, None], error.shape)
    depth = np.broadcast_to(chart.depth[None, :, None], error.shape)
    width = chart.width[:, at]
    known = np.isfinite(error) & (error > 0.0)
    nu, depth, width, error = nu[known], depth[known], width[known], error[known]
    columns = np.column_stack([np.ones(len(nu)), np.log(nu**2 / (1.0 - nu**2)), width])
    trials = []
    for c in _DEPTH:
        target = np.log(error * (1.0 + c * depth))
        # Weighted by the error: what counts is how far it is off, not by what factor.
        solution = np.linalg.lstsq(columns * error[:, None], target * error, rcond=None)[0]
        constants = (np.exp(solution[0]), solution[1], solution[2], c)
        trial = Rule(quantity, float(chart.span[at]), *(float(each) for each in constants))
        away = trial.error(nu, depth, np.exp(width)) - error
        typical = float(np.sqrt(np.mean(away**2)))
        trials.append(replace(trial, off=float(np.abs(away).max()), typical=typical))
    return min(trials, key=lambda each: each.typical)
