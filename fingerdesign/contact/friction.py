"""Friction at the nodes of a contact: bounds of forces, of a law and of the nodes' areas.

A node's bound is that of its mean pressure: area times the law's bound of force over area. The
solvers see bounds and their slopes alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.shapes.friction import FrictionLaw


class Friction(Protocol):
    """Bounds at k nodes."""

    def bound(self, normal: Array, share: float = 1.0) -> Array:
        """``share`` times the largest tangential forces (k,) N at normal forces (k,) N."""

    def slope(self, normal: Array) -> Array:
        """Derivative (k,) of the bound by the normal force."""

    def secant(self, normal: Array) -> Array | float:
        """Bound over normal force (k,): the coefficient that Coulomb's law would need."""

    def at(self, nodes: IntArray | int) -> Friction:
        """The friction at some of the nodes, in their order, or at one."""

    def scaled(self, share: float) -> Friction:
        """The same with ``share`` (0 to 1) times the bounds, but for their first touch."""


@dataclass(frozen=True, eq=False)
class Coulomb:
    """Bound mu N; ``coefficient``: one number, or one a node (k,)."""

    coefficient: float | Array

    def bound(self, normal: Array, share: float = 1.0) -> Array:
        return np.asarray((self.coefficient * share) * normal)

    def slope(self, normal: Array) -> Array:
        return np.broadcast_to(self.coefficient, np.shape(normal))

    def secant(self, normal: Array) -> Array | float:
        return self.coefficient

    def at(self, nodes: IntArray | int) -> Coulomb:
        own = self.coefficient
        return Coulomb(own[nodes]) if isinstance(own, np.ndarray) else self

    def scaled(self, share: float) -> Coulomb:
        return Coulomb(share * self.coefficient)


@dataclass(frozen=True, eq=False)
class ByPressure:
    """Bound s_i A_i bound(N_i / A_i) of a law, areas A (k,) mm^2, shares s (k,), or 1 of all."""

    law: FrictionLaw
    areas: Array
    shares: Array | float = 1.0

    def bound(self, normal: Array, share: float = 1.0) -> Array:
        whole = self.shares * self.law.bound(normal, self.areas)
        return whole if share == 1.0 else share * whole

    def slope(self, normal: Array) -> Array:
        return np.asarray(self.shares * self.law.slope(normal, self.areas))

    def secant(self, normal: Array) -> Array:
        pressed = np.maximum(normal, 0.0)
        whole = self.bound(pressed)
        safe = np.where(pressed > 0.0, pressed, 1.0)
        return np.where(pressed > 0.0, whole / safe, self.shares * self.law.steepest)

    def at(self, nodes: IntArray | int) -> ByPressure:
        own = self.shares[nodes] if isinstance(self.shares, np.ndarray) else self.shares
        return ByPressure(self.law, self.areas[nodes], own)

    def scaled(self, share: float) -> Friction:
        return replace(self, law=self.law.scaled(share)) if share else Coulomb(0.0)


def friction_at(
    law: FrictionLaw, areas: Array, shares: Array | None = None
) -> Coulomb | ByPressure:
    """Friction of a law at nodes of these areas (k,) mm^2, times ``shares`` (k,) of its bound."""
    own = 1.0 if shares is None else shares
    return Coulomb(law.coefficient * own) if law.is_coulomb else ByPressure(law, areas, own)
