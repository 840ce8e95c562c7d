"""What can be said of a design before any model is built: volumes and the contact's width."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from fingerdesign.design import clearance
from fingerdesign.design.gaps import least_gap
from fingerdesign.design.layout import crest_height, plate_frames
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.volume import outline_volume


def plates_volume(design: Design) -> float:
    """Volume of all plates together, mm^3."""
    plates = design.plates
    span = plates.span_mm if plates.span_mm is not None else design.body.depth_mm
    return plates.number * plates.length_mm * plates.thickness_mm * span


def contact_half_width(design: Design, approach_mm: float, object_curvature: float = 0.0) -> float:
    """Forecast of the contact's half-width at z = 0 under a plane pressed ``approach_mm``, mm.

    ``object_curvature`` (1/mm): of a cylinder along z instead of the plane. Straight body: Hertz's
    line contact on a layer of the crest's height d (Johnson, Contact Mechanics, 1985, eq. 5.56):
    approach = a^2 / (4 R) (2 ln(2 d / a) - nu / (1 - nu)). Dome: point
    contact on a half-space of the mean curvature, approach = a^2 / R. Plates, free sides and
    friction are left out, so it errs to the wide side: against the plane-strain model at approaches
    of 0.15 to 0.4 mm, by 8 to 16 % without plates and by 13 to 26 % with the shipped fingers'. A
    forecast, no result. Never more than half of the body's width.
    """
    body = design.body
    most = 0.5 * body.width_mm
    if approach_mm <= 0:
        return 0.0
    if body.dome_radius_mm is not None:
        radius = 2.0 / (1.0 / body.arc_radius_mm + 1.0 / body.dome_radius_mm + object_curvature)
        return min(math.sqrt(radius * approach_mm), most)
    height, nu = crest_height(body), design.material_of("body").poissons_ratio
    radius = 1.0 / (1.0 / body.arc_radius_mm + object_curvature)

    def approach(a: float) -> float:
        layer = 2.0 * math.log(2.0 * height / a) - nu / (1.0 - nu)
        return a * a / (4.0 * radius) * layer

    # The formula grows up to ln(2 d / a) = (1 + nu / (1 - nu)) / 2; it means nothing beyond.
    high = min(most, 2.0 * height * math.exp(-0.5 / (1.0 - nu)))
    if approach(high) <= approach_mm:
        return high
    low = 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if approach(middle) < approach_mm else (low, middle)
    return low


DEFAULT_APPROACH_MM = 0.1  # of the fundamental case


@dataclass(frozen=True)
class Summary:
    """What ``fingerdesign check`` shows of a sound design; clearances are None without plates."""

    name: str
    digest: str
    plates: int
    least_cover_mm: float | None
    least_gap_mm: float | None
    least_side_mm: float | None
    least_base_mm: float | None
    approach_mm: float
    contact_half_width_mm: float
    volume_mm3: float
    plates_volume_mm3: float
    extruded: bool

    def as_dict(self) -> dict[str, object]:
        """Return the fields by name."""
        return asdict(self)


def summarise(design: Design, scene: Scene | None = None) -> Summary:
    """Summarise a sound design, pressed as far as ``scene`` does (else the fundamental case)."""
    from fingerdesign.design.contact_zone import contact_reach, greatest_approach

    approach = greatest_approach(design, scene) if scene is not None else DEFAULT_APPROACH_MM
    if scene is not None:
        half_width = contact_reach(design, scene.object, approach)[0]
    else:
        half_width = contact_half_width(design, approach)
    body, plates = design.body, design.plates
    cover = gap = side = base = None
    if plates.number:
        frames = plate_frames(design)
        points = np.vstack([clearance.plate_points(frame) for frame in frames])
        cover = float(clearance.cover_clearances(body, frames).min())
        closest = least_gap(frames)
        gap = closest.distance if closest is not None else None
        side = float(0.5 * body.width_mm - np.abs(points[:, 0]).max())
        base = float(points[:, 1].min())
    return Summary(
        name=design.design.name,
        digest=design.digest(),
        plates=plates.number,
        least_cover_mm=cover,
        least_gap_mm=gap,
        least_side_mm=side,
        least_base_mm=base,
        approach_mm=approach,
        contact_half_width_mm=min(half_width, 0.5 * body.width_mm),
        volume_mm3=outline_volume(body),
        plates_volume_mm3=plates_volume(design),
        extruded=design.extruded,
    )
