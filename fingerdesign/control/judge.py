"""The verdict on a grip, from the plant's truth: lifted, slipped, and with what margin."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from fingerdesign.control.plants.plant import Truth

if TYPE_CHECKING:
    pass


GRAVITY = 9.80665  # m/s^2


def weight_per_finger(object_mass_g: float) -> float:
    """m g / 2 in N: two like fingers carry half the weight each.

    >>> round(weight_per_finger(200.0), 4)
    0.9807
    """
    return 0.5e-3 * GRAVITY * object_mass_g


def is_lifted(truth: Truth, object_mass_g: float) -> bool:
    """The object hangs, or in a plant without one the paper's end of a grip, mg < 2 F_t; and it
    does not slide through."""
    if truth.lifted is not None:
        return truth.lifted and not truth.complete_slip
    return not truth.complete_slip and truth.tangential_force > weight_per_finger(object_mass_g)


def safety_margin(truth: Truth, friction_coefficient: float) -> float | None:
    """F_n / (F_t / mu): how many times the least normal force is applied; None without F_t.

    >>> safety_margin(Truth(0.1, 0.1, 10.0, 2.0, 0.5, 0.0, False), 0.3)
    1.5
    """
    if not truth.tangential_force > 0.0:
        return None
    return friction_coefficient * truth.normal_force / truth.tangential_force


def minimum_stick_ratio(path: Sequence[Truth]) -> float | None:
    """Least stick ratio where F_t > 0; None where there is none."""
    ratios = [t.stick_ratio for t in path if t.tangential_force > 0.0 and t.stick_ratio is not None]
    return min(ratios, default=None)
