"""Areas and volumes of the body in closed form (numpy only)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.layout import crest_height

if TYPE_CHECKING:
    from fingerdesign.design.tables import Body


def section_area(body: Body) -> float:
    """Area of the mid-section, mm^2: the rectangle and the circular segment above it."""
    radius, half_width = body.arc_radius_mm, 0.5 * body.width_mm
    angle = np.arcsin(half_width / radius)
    segment = radius**2 * (angle - np.sin(angle) * np.cos(angle))
    return float(body.width_mm * body.base_height_mm + segment)


def outline_volume(body: Body, half: bool = False) -> float:
    """Volume of body and plates together, mm^3 (of the half z >= 0 if ``half``).

    Arc: section area times depth. Dome: the height integrated over the base, in z in closed form,
    in x by 128 Gauss points in the arc's angle, where the integrand is smooth (error near 1e-15).
    """
    share = 0.5 if half else 1.0
    if body.dome_radius_mm is None:
        return share * section_area(body) * body.depth_mm
    radius, dome, z_end = body.arc_radius_mm, body.dome_radius_mm, 0.5 * body.depth_mm
    nodes, weights = np.polynomial.legendre.leggauss(128)
    limit = np.arcsin(0.5 * body.width_mm / radius)
    angle = limit * nodes
    reach = dome + radius * (np.cos(angle) - 1.0)
    over_z = z_end * np.sqrt(reach**2 - z_end**2) + reach**2 * np.arcsin(z_end / reach)
    column = over_z + 2.0 * z_end * (crest_height(body) - dome)
    return float(share * np.sum(weights * limit * radius * np.cos(angle) * column))
