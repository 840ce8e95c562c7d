"""Areas and volumes of the body in closed form (numpy only)."""

import numpy as np

from fingerdesign.arrays import Array, IntArray
from fingerdesign.design.body import Body
from fingerdesign.design.schema import Design
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import Hole, PlateFrame
from fingerdesign.layout.profile import profile_of


def enclosed_volume(vertices: Array, triangles: IntArray) -> float:
    """Volume within closed triangles (divergence theorem), mm^3; positive if wound outward."""
    a, b, c = (vertices[triangles[:, k]] - vertices.mean(axis=0) for k in range(3))
    return float(np.einsum("ij,ij->", a, np.cross(b, c)) / 6.0)


def outline_volume(body: Body, half: bool = False) -> float:
    """Volume of body, plates and core together, mm^3 (of the half z >= 0 if ``half``)."""
    share = 0.5 if half else 1.0
    return share * body.kind.volume(body)


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
    core, depth = design.body.core, design.body.core_depth_mm
    if core is None:
        return 0.0
    return float(core.width_mm * core.height_mm * depth * (0.5 if half else 1.0))


def check_volume(what: str, found: float, target: float, tolerance: float) -> None:
    """GeometryError unless two volumes agree to a relative ``tolerance``."""
    error = abs(found - target) / target
    if not error <= tolerance:
        raise GeometryError(
            f"{what}: the CAD volume {found:.9g} mm^3 differs from {target:.9g} mm^3 in closed "
            f"form by {error:.1e}, more than {tolerance:.0e}"
        )


def face_areas(body: Body, half: bool = False) -> dict[str, float]:
    """Areas of the finger's outer faces by name, mm^2, ends of plates and core in them included.

    By the outline's Gauss points, exact along z. ``half``: of z >= 0, with the face "symmetry". A
    revolved body has no "end"; the edges belong to "contact". Of a STEP body: of its solid,
    without "symmetry".
    """
    whole = body.kind.areas(body)
    if not half:
        return whole
    halves = {name: 0.5 * area for name, area in whole.items()}
    return halves | ({"symmetry": profile_of(body).area} if body.kind.closed_form else {})
