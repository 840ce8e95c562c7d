"""Areas and volumes of the body in closed form (numpy only)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.step import step_facts
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import Hole, PlateFrame
from fingerdesign.layout.profile import profile_of

if TYPE_CHECKING:
    from fingerdesign.design.body import Body
    from fingerdesign.design.schema import Design


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


# What must be true of a finger's solids: volumes and areas in closed form (numpy only).
#
# Whether plates lie inside the body and clear of each other is checks/design.py's to say, before
# anything is built; here stands what the solids are held against.


def plate_volume(frame: PlateFrame, half: bool = False) -> float:
    """Volume of one plate, mm^3; ``half``: of the part z >= 0 of one that mirrors in z = 0.

    A bent plate's is that of the flat one, because its mid-surface is in the middle; its holes are
    straight round ones along the normal, a little less than pi r^2 t.
    """
    whole = frame.length * frame.thickness * frame.span
    whole -= sum(_hole_volume(frame, hole) for hole in frame.holes)
    return float(0.5 * whole if half else whole)


def _hole_volume(frame: PlateFrame, hole: Hole) -> float:
    """Volume that a straight round hole takes out of a plate, mm^3.

    Bent: the integral over |u| <= r of 2 sqrt(r^2 - u^2) (sqrt(Ro^2 - u^2) - sqrt(Ri^2 - u^2)), u
    along the plate, by Gauss-Chebyshev points of the second kind.
    """
    if frame.bend_radius is None:
        return float(np.pi * hole.radius**2 * frame.thickness)
    count = 40
    angle = np.pi * np.arange(1, count + 1) / (count + 1)
    u, weight = hole.radius * np.cos(angle), np.pi / (count + 1) * np.sin(angle) ** 2
    inner, outer = (frame.bend_radius + side * frame.thickness for side in (-0.5, 0.5))
    thickness = np.sqrt(outer**2 - u**2) - np.sqrt(inner**2 - u**2)
    return float(2.0 * hole.radius**2 * np.sum(weight * thickness))


def core_volume(design: Design, half: bool = False) -> float:
    """Volume of the core, mm^3 (of its half z >= 0 if ``half``); 0 without one."""
    core = design.body.core
    if core is None:
        return 0.0
    depth = core.depth_mm if core.depth_mm is not None else design.body.depth_mm
    return float(core.width_mm * core.height_mm * depth * (0.5 if half else 1.0))


def check_volume(what: str, found: float, wanted: float, tolerance: float) -> None:
    """GeometryError unless two volumes agree to a relative ``tolerance``."""
    error = abs(found - wanted) / wanted
    if not error <= tolerance:
        raise GeometryError(
            f"{what}: the CAD volume {found:.9g} mm^3 differs from {wanted:.9g} mm^3 in closed "
            f"form by {error:.1e}, more than {tolerance:.0e}"
        )


def face_areas(body: Body, half: bool = False) -> dict[str, float]:
    """Areas of the finger's outer faces by name, mm^2, ends of plates and core in them included.

    By the Gauss points of ``outline_points``, exact along z. ``half``: of z >= 0, with the face
    "symmetry". A revolved body has no "end"; the edges belong to "contact". Of a STEP body what
    its solid says, without "symmetry".
    """
    if body.step is not None:
        share = 0.5 if half else 1.0
        return {name: share * float(area) for name, area in step_facts(body.step).area.items()}
    if body.shape == "revolved":
        whole = _revolved_areas(body)
    elif body.shape == "dome":
        whole = _dome_areas(body)
    else:
        whole = _straight_areas(body)
    if not half:
        return whole
    halves = {name: 0.5 * area for name, area in whole.items()}
    return halves | {"symmetry": section_area(body)}


def _straight_areas(body: Body) -> dict[str, float]:
    profile, depth = profile_of(body), body.depth_mm
    return {
        "base": body.width_mm * depth,
        "contact": 2.0 * depth * sum(piece.length for piece in profile.pieces),
        "side": 2.0 * depth * profile.side_height,
        "end": 2.0 * profile.area,
    }


def _revolved_areas(body: Body) -> dict[str, float]:
    profile, radius = profile_of(body), 0.5 * body.width_mm
    x, _, weights = outline_points(body)
    return {
        "base": float(np.pi * radius**2),
        "contact": float(np.sum(weights[:, 1] * 2.0 * np.pi * x)),
        "side": float(2.0 * np.pi * radius * profile.side_height),
    }


def _dome_areas(body: Body) -> dict[str, float]:
    profile, z_end = profile_of(body), 0.5 * body.depth_mm
    axis = profile.crest - float(body.dome_radius_mm or 0.0)
    _, y, weights = outline_points(body)
    reach = y - axis  # radius of revolution of each point of the outline
    around = 2.0 * reach * np.arcsin(z_end / reach)
    end = weights[:, 0] * (axis + np.sqrt(reach**2 - z_end**2))
    edge = profile.side_height - axis
    under = z_end * np.sqrt(edge**2 - z_end**2) + edge**2 * np.arcsin(z_end / edge)
    return {
        "base": body.width_mm * body.depth_mm,
        "contact": float(2.0 * np.sum(weights[:, 1] * around)),
        "side": float(2.0 * (under + 2.0 * z_end * axis)),
        "end": float(4.0 * np.sum(end)),
    }
