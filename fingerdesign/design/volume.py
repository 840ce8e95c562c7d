"""Areas and volumes of the body in closed form (numpy only)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.profile import profile_of

if TYPE_CHECKING:
    from fingerdesign.design.body_table import Body


def section_area(body: Body) -> float:
    """Area of the mid-section, mm^2."""
    return profile_of(body).area


def outline_points(body: Body) -> tuple[Array, Array, Array]:
    """Gauss points x (n,), heights and weights of the integral over x of half the outline.

    Piece by piece in the arc's angle, where a dome's integrands are smooth (error near 1e-15);
    weights are dx and, as a second column, the outline's length.
    """
    nodes, weights = np.polynomial.legendre.leggauss(64)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    xs, ys, ws = [], [], []
    for piece in profile_of(body).pieces:
        (x0, y0), (x1, y1) = piece.start, piece.end
        if piece.radius:
            first, last = (
                float(np.arctan2(x - piece.x, y - piece.y)) for x, y in ((x0, y0), (x1, y1))
            )
            angle = first + (last - first) * nodes
            xs.append(piece.x + piece.radius * np.sin(angle))
            ys.append(piece.y + piece.radius * np.cos(angle))
            length = weights * (last - first) * piece.radius
            ws.append(np.column_stack([length * np.cos(angle), length]))
        else:
            xs.append(x0 + (x1 - x0) * nodes)
            ys.append(y0 + (y1 - y0) * nodes)
            ws.append(np.column_stack([weights * (x1 - x0), weights * piece.length]))
    return np.concatenate(xs), np.concatenate(ys), np.vstack(ws)


def outline_volume(body: Body, half: bool = False) -> float:
    """Volume of body, plates and core together, mm^3 (of the half z >= 0 if ``half``)."""
    share = 0.5 if half else 1.0
    if body.step is not None:
        from fingerdesign.design.step_facts import step_facts

        return share * step_facts(body.step).volume
    if body.straight:
        return share * section_area(body) * body.depth_mm
    x, y, weights = outline_points(body)
    if body.shape == "revolved":
        return float(share * np.sum(weights[:, 0] * 2.0 * np.pi * x * y))
    z_end, axis = 0.5 * body.depth_mm, profile_of(body).crest - float(body.dome_radius_mm or 0.0)
    reach = y - axis
    over_z = z_end * np.sqrt(reach**2 - z_end**2) + reach**2 * np.arcsin(z_end / reach)
    column = over_z + 2.0 * z_end * axis
    return float(share * 2.0 * np.sum(weights[:, 0] * column))
