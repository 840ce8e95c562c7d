"""The elastomer at finite strain: a compressible neo-Hookean law (numpy only).

    W = mu/2 (tr F^T F - 3 - 2 ln J) + lame/2 (ln J)^2,        J = det F
    P = dW/dF = mu F - (mu + p) F^-T,                          p = -lame ln J

F is the deformation gradient, P the first Piola-Kirchhoff stress (MPa), p a pressure (compression
positive). Small strains give Hooke's law with the same lame and mu. In plane strain F_33 = 1.
Source: Bonet and Wood, Nonlinear Continuum Mechanics for Finite Element Analysis, 2nd ed. (2008),
6.4.3. In a nearly incompressible material p is an unknown of its own (cells.py).
"""

from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import SolverError


class Inverted(SolverError):
    """A deformation turns part of an element inside out: the step was too long."""


@dataclass(frozen=True)
class Deformation:
    """gradient F (..., d, d), its inverse, and log_volume ln J (...)."""

    gradient: Array
    inverse: Array
    log_volume: Array


def deformation(displacement_gradient: Array) -> Deformation:
    """Compute F, its inverse and ln J from du/dX (..., d, d), d 2 (plane strain) or 3. Raises
    Inverted where J is not positive."""
    gradient = displacement_gradient + np.eye(displacement_gradient.shape[-1])
    volume = np.asarray(np.linalg.det(gradient), dtype=float)
    inverted = ~(volume > 0.0)
    if inverted.any():
        raise Inverted(f"{int(inverted.sum())} points of the elements are turned inside out")
    return Deformation(gradient, np.asarray(np.linalg.inv(gradient), dtype=float), np.log(volume))


def second_piola(at: Deformation, first: Array, shear: Array) -> Array:
    """S = F^-1 P (..., d, d), MPa, with p = -lame ln J; first and shear (...) MPa."""
    both = shear - first * at.log_volume
    eye = np.eye(at.gradient.shape[-1])
    return np.asarray(shear[..., None, None] * eye - both[..., None, None] * _metric(at))


def second_piola_change(at: Deformation, change: Array, first: Array, shear: Array) -> Array:
    """First-order change of S (..., d, d) by ``change`` (..., d, d) of du/dX."""
    half = np.swapaxes(at.gradient, -1, -2) @ change
    metric = _metric(at)
    mixed = metric @ (half + np.swapaxes(half, -1, -2))
    both = shear - first * at.log_volume
    volume = 0.5 * first * np.einsum("...kk->...", mixed)
    return np.asarray(volume[..., None, None] * metric + both[..., None, None] * (mixed @ metric))


def _metric(at: Deformation) -> Array:
    """C^-1 = F^-1 F^-T."""
    return np.asarray(at.inverse @ np.swapaxes(at.inverse, -1, -2))
