"""Where things lie: the section's outline and the plates' frames, in closed form (numpy only).

Axes: x tangential, y normal (base at y = 0, crest toward +y), z along the plates, mid-plane z = 0.
Lengths in mm, angles anticlockwise from +x.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body, Design

Array = NDArray[np.float64]


@dataclass(frozen=True)
class PlateFrame:
    """One plate: a box of ``length`` along ``axis``, ``thickness`` along ``normal``, span along z.

    ``axis`` is at ``angle_deg`` anticlockwise from +x; ``normal`` is 90 degrees anticlockwise from
    the axis (the *upper* side).
    """

    index: int
    x: float
    y: float
    angle_deg: float
    length: float
    thickness: float
    z_min: float
    z_max: float

    @property
    def axis(self) -> Array:
        """Unit vector along the plate in the section, shape (2,)."""
        angle = np.radians(self.angle_deg)
        return np.array([np.cos(angle), np.sin(angle)])

    @property
    def normal(self) -> Array:
        """Unit vector toward the upper side, shape (2,)."""
        axis = self.axis
        return np.array([-axis[1], axis[0]])

    def corners(self) -> Array:
        """Section corners, anticlockwise from the lower near end, shape (4, 2)."""
        half_length = 0.5 * self.length * self.axis
        half_thickness = 0.5 * self.thickness * self.normal
        centre = np.array([self.x, self.y])
        return np.array(
            [
                centre - half_length - half_thickness,
                centre + half_length - half_thickness,
                centre + half_length + half_thickness,
                centre - half_length + half_thickness,
            ]
        )

    def local(self, points: Array) -> Array:
        """Coordinates (along axis, along normal) of section points (n, 2) from the centre."""
        offset = points[:, :2] - np.array([self.x, self.y])
        return np.stack([offset @ self.axis, offset @ self.normal], axis=1)


def crest_height(body: Body) -> float:
    """Greatest height of the body: base_height + R - sqrt(R^2 - (width/2)^2), mm."""
    radius, half_width = body.arc_radius_mm, 0.5 * body.width_mm
    return float(body.base_height_mm + radius - np.sqrt(radius**2 - half_width**2))


def surface_height(body: Body, x: Array | float, z: Array | float = 0.0) -> Array:
    """Height of the contact surface over (x, z), mm; the dome is a torus patch (see surface.py)."""
    x, z = np.asarray(x, dtype=float), np.asarray(z, dtype=float)
    radius, crest = body.arc_radius_mm, crest_height(body)
    profile = np.sqrt(radius**2 - x**2) - radius  # below the crest, <= 0
    if body.dome_radius_mm is None:
        return np.asarray(crest + profile + 0.0 * z)
    # Revolving the section about the x-parallel axis at y = crest - dome radius.
    reach = body.dome_radius_mm + profile
    return np.asarray(crest - body.dome_radius_mm + np.sqrt(reach**2 - z**2))


def plate_frames(design: Design) -> tuple[PlateFrame, ...]:
    """The plates' frames, left to right (or in the order of ``plates.placement``)."""
    plates, body = design.plates, design.body
    if plates.placement is not None:
        rows = [(float(x), float(y), float(angle)) for x, y, angle in plates.placement]
    else:
        first = -0.5 * (plates.count - 1) * plates.pitch_mm
        xs = [first + i * plates.pitch_mm for i in range(plates.count)]
        # NaN where a plate lies beyond the arc: the checks refuse it, with its key.
        with np.errstate(invalid="ignore"):
            ys = [float(surface_height(body, x)) - plates.cover_mm for x in xs]
        rows = [(x, y, plates.angle_deg) for x, y in zip(xs, ys, strict=True)]
    half_span = 0.5 * (plates.span_mm if plates.span_mm is not None else body.depth_mm)
    return tuple(
        PlateFrame(i, x, y, angle, plates.length_mm, plates.thickness_mm, -half_span, half_span)
        for i, (x, y, angle) in enumerate(rows)
    )
