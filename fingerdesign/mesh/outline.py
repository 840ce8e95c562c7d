"""The section's outline as a 2-D mesher wants it: points, curves, domains and sizes (no mesher)."""

from __future__ import annotations

from dataclasses import asdict, dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.design.layout import PlateFrame, crest_height, surface_height
from fingerdesign.mesh.sheets import line_beyond, room_around

if TYPE_CHECKING:
    from fingerdesign.design.meshing import SectionMesh
    from fingerdesign.design.schema import Body

BODY = 1  # domain numbers: the body, then plate k as BODY + 1 + k; 0 is outside


@dataclass
class Outline:
    """points (x, y, size or None); curves (points of a line or of a rational quadratic spline, left
    domain, right domain, size); domains (number, size). Lengths in mm."""

    far_size: float
    gradation: float
    points: list[tuple[float, float, float | None]] = field(default_factory=list)
    curves: list[tuple[list[int], int, int, float]] = field(default_factory=list)
    domains: list[tuple[int, float]] = field(default_factory=list)

    def point(self, x: float, y: float, size: float | None = None) -> int:
        """Add a point and return its number."""
        self.points.append((float(x), float(y), size))
        return len(self.points) - 1

    def curve(self, points: list[int], left: int, right: int, size: float) -> None:
        """Add a line (two points) or a spline (end, control, end)."""
        self.curves.append((points, left, right, size))

    def as_dict(self) -> dict[str, Any]:
        """Plain lists and numbers."""
        return asdict(self)


def section_outline(
    body: Body,
    frames: tuple[PlateFrame, ...],
    zone: float,
    gage_length: float,
    sizes: SectionMesh,
    sheets: bool = False,
) -> Outline:
    """Body and plates, fine over |x| <= ``zone`` on the arc and at the plates' ends.

    Plates are boxes, or with ``sheets`` their mid-lines inside the body.
    """
    outline = Outline(sizes.far_size_mm, sizes.gradation)
    _add_body(outline, body, zone, sizes)
    for frame in frames:
        if sheets:
            room = room_around(frame, frames, body)
            _add_sheet(outline, frame, gage_length, sizes, room)
        else:
            _add_plate(outline, frame, gage_length, sizes)
    return outline


def _add_body(outline: Outline, body: Body, zone: float, sizes: SectionMesh) -> None:
    half, height = 0.5 * body.width_mm, body.base_height_mm
    radius, centre = body.arc_radius_mm, crest_height(body) - body.arc_radius_mm
    corners = [
        outline.point(x, y) for x, y in ((-half, 0), (half, 0), (half, height), (-half, height))
    ]
    for a, b in ((0, 1), (1, 2), (3, 0)):
        outline.curve([corners[a], corners[b]], BODY, 0, sizes.far_size_mm)

    # The arc from right to left, cut where the zone ends; the control point of each piece is where
    # its end tangents meet, which makes the rational spline an exact circle.
    stations = [half, zone, 0.0, -zone, -half] if zone < 0.999 * half else [half, 0.0, -half]
    ends = [corners[2]]
    ends += [outline.point(x, float(surface_height(body, x))) for x in stations[1:-1]]
    ends.append(corners[3])
    for k in range(len(stations) - 1):
        pair = np.array([[x, float(surface_height(body, x)) - centre] for x in stations[k : k + 2]])
        meet = np.linalg.solve(pair, [radius**2, radius**2])
        control = outline.point(float(meet[0]), float(meet[1] + centre))
        inside = max(abs(stations[k]), abs(stations[k + 1])) <= zone + 1e-12
        size = sizes.contact_size_mm if inside else sizes.far_size_mm
        outline.curve([ends[k], control, ends[k + 1]], BODY, 0, size)


def _add_plate(outline: Outline, frame: PlateFrame, gage_length: float, sizes: SectionMesh) -> None:
    domain = BODY + 1 + frame.index
    along = _stations(frame, gage_length)
    last = len(along) - 1
    rows = []
    for side in (-0.5, 0.5):
        row = []
        for k, s in enumerate(along):
            x, y = (
                np.array([frame.x, frame.y])
                + s * frame.axis
                + (side * frame.thickness * frame.normal)
            )
            row.append(outline.point(x, y, sizes.plate_end_size_mm if k in (0, last) else None))
        rows.append(row)
    lower, upper = rows
    for k in range(last):
        outline.curve([lower[k], lower[k + 1]], domain, BODY, sizes.plate_size_mm)
        outline.curve([upper[k + 1], upper[k]], domain, BODY, sizes.plate_size_mm)
    outline.curve([lower[-1], upper[-1]], domain, BODY, sizes.plate_end_size_mm)
    outline.curve([upper[0], lower[0]], domain, BODY, sizes.plate_end_size_mm)
    outline.domains.append((domain, sizes.plate_size_mm))


def _add_sheet(
    outline: Outline, frame: PlateFrame, gage_length: float, sizes: SectionMesh, room: float
) -> None:
    """The mid-line, and beyond its ends a short line within which the square ends will open."""
    beyond = line_beyond(frame, room, sizes.plate_end_size_mm)
    along = _stations(frame, gage_length)
    along = [along[0] - beyond, *along, along[-1] + beyond]
    last = len(along) - 1
    line = []
    for k, s in enumerate(along):
        x, y = np.array([frame.x, frame.y]) + s * frame.axis
        line.append(outline.point(x, y, beyond if k in (1, last - 1) else None))
    for k, (a, b) in enumerate(pairwise(line)):
        size = beyond if k in (0, last - 1) else sizes.plate_size_mm
        outline.curve([a, b], BODY, BODY, size)


def _stations(frame: PlateFrame, gage_length: float) -> list[float]:
    """Vertices along a plate: its ends, and the gage's, so that its strain is a difference of
    nodal displacements."""
    along = [-0.5 * frame.length, 0.5 * frame.length]
    if gage_length < 0.98 * frame.length:
        along[1:1] = [-0.5 * gage_length, 0.5 * gage_length]
    return along
