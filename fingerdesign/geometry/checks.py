"""What must be true of a finger: volumes, areas and clearances in closed form (numpy only)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.design.layout import PlateFrame, crest_height
from fingerdesign.design.volume import section_area
from fingerdesign.errors import GeometryError
from fingerdesign.geometry.surface import ContactSurface

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body, Design

Array = NDArray[np.float64]


def plate_volume(frame: PlateFrame, half: bool = False) -> float:
    """Volume of one plate, mm^3 (of its part z >= 0 if ``half``)."""
    low = max(0.0, frame.low) if half else frame.low
    return float(frame.length * frame.thickness * (frame.high - low))


def check_volume(what: str, found: float, wanted: float, tolerance: float) -> None:
    """GeometryError unless two volumes agree to a relative ``tolerance``."""
    error = abs(found - wanted) / wanted
    if not error <= tolerance:
        raise GeometryError(
            f"{what}: the CAD volume {found:.9g} mm^3 differs from {wanted:.9g} mm^3 in closed "
            f"form by {error:.1e}, more than {tolerance:.0e}"
        )


def check_clearances(design: Design, frames: tuple[PlateFrame, ...]) -> None:
    """GeometryError unless each plate lies inside the body and clear of every other."""
    body = design.body
    surface = ContactSurface.of(body)
    for frame in frames:
        corners = frame.corners()
        if not np.all(np.isfinite(corners)):
            raise GeometryError(f"plate {frame.index} lies beyond the arc")
        for z in {0.0, frame.high}:
            ends = np.column_stack([corners, np.full(len(corners), z)])
            margin = min(
                float(corners[:, 1].min()),
                0.5 * body.width_mm - float(np.abs(corners[:, 0]).max()),
                0.5 * body.depth_mm - frame.high + 1e-9,
                # Below its lowest point the surface, continued, bounds nothing.
                float(np.maximum(-surface.distance(ends), surface.lowest - ends[:, 1]).min()),
            )
            if margin <= 0.0:
                raise GeometryError(
                    f"plate {frame.index} at x = {frame.x:.4g} leaves the body by {-margin:.4g} mm"
                )
    for i, first in enumerate(frames):
        for second in frames[i + 1 :]:
            gap = plate_gap(first, second)
            if gap <= 0.0:
                raise GeometryError(
                    f"plates {first.index} and {second.index} overlap by {-gap:.4g} mm"
                )


def plate_gap(first: PlateFrame, second: PlateFrame) -> float:
    """Greatest separation of two plates' sections along their own axes, mm; <= 0: they overlap.

    By the separating-axis theorem it is positive exactly when two rectangles are apart; then it is
    a lower bound of their distance.
    """
    a, b = first.corners(), second.corners()
    gaps = []
    for axis in (first.axis, first.normal, second.axis, second.normal):
        p, q = a @ axis, b @ axis
        gaps.append(max(q.min() - p.max(), p.min() - q.max()))
    return float(max(gaps))


def face_areas(body: Body, half: bool = False) -> dict[str, float]:
    """Areas of the finger's outer faces by name, mm^2, plate ends in them included.

    By Gauss points in the arc's angle and along z, as in ``outline_volume``. ``half``: of z >= 0,
    with the face "symmetry".
    """
    radius, dome, z_end = body.arc_radius_mm, body.dome_radius_mm, 0.5 * body.depth_mm
    nodes, weights = np.polynomial.legendre.leggauss(128)
    limit = np.arcsin(0.5 * body.width_mm / radius)
    angle = limit * nodes
    if dome is None:
        area = section_area(body)
        contact = 2.0 * radius * limit * 2.0 * z_end
        side, end = 2.0 * z_end * body.base_height_mm, area
    else:
        reach = dome + radius * (np.cos(angle) - 1.0)
        along = 2.0 * reach * np.arcsin(z_end / reach)  # arc length in z at each angle
        contact = float(np.sum(weights * limit * radius * along))
        lift = crest_height(body) - dome
        edge = dome + radius * (np.cos(limit) - 1.0)
        under = z_end * np.sqrt(edge**2 - z_end**2) + edge**2 * np.arcsin(z_end / edge)
        side = float(under + 2.0 * z_end * lift)
        height = lift + np.sqrt(reach**2 - z_end**2)
        end = float(np.sum(weights * limit * radius * np.cos(angle) * height))
    whole = {"base": 2.0 * z_end * body.width_mm, "contact": float(contact), "side": 2.0 * side}
    if not half:
        return {**whole, "end": 2.0 * end}
    symmetry = {"end": end, "symmetry": section_area(body)}
    return {name: 0.5 * value for name, value in whole.items()} | symmetry
