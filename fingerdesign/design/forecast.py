"""What can be said of a design before any model is built: volumes and the contact's width."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass

import numpy as np

from fingerdesign.design import clearance
from fingerdesign.design.gaps import least_gap
from fingerdesign.design.layout import crest_height, plate_frames, surface_height
from fingerdesign.design.plate_rows import PlateRow, plate_rows
from fingerdesign.design.profile import profile_of
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Body, Design
from fingerdesign.design.volume import outline_volume


def plates_volume(design: Design) -> float:
    """Volume of all plates together, mm^3; their holes left out."""
    frames = plate_frames(design)
    holes = sum(np.pi * hole.radius**2 * f.thickness for f in frames for hole in f.holes)
    return float(sum(f.length * f.thickness * f.span for f in frames) - holes)


def crest_curvatures(body: Body) -> tuple[float, float]:
    """Curvatures of the body's crest along x and z, 1/mm; of a STEP body fitted to its heights."""
    if body.shape == "step":
        return _fitted(body, 0.05 * body.width_mm, 0), _fitted(body, 0.05 * body.depth_mm, 1)
    first = 0.0 if body.shape == "block" else 1.0 / body.arc_radius_mm
    if body.shape == "revolved":
        return first, first
    return first, 0.0 if body.dome_radius_mm is None else 1.0 / body.dome_radius_mm


def _fitted(body: Body, reach: float, axis: int) -> float:
    """Curvature of a STEP body's top over |x| or |z| <= reach; 0 where it is flat or hollow."""
    place = np.linspace(-reach, reach, 9)
    zero = np.zeros_like(place)
    heights = surface_height(body, *((place, zero) if axis == 0 else (zero, place)))
    known = np.isfinite(heights)
    if known.sum() < 3:
        return 0.0
    bent = -2.0 * float(np.polyfit(place[known], heights[known], 2)[0])
    return bent if bent > 1e-6 else 0.0


def flat_half_extents(body: Body) -> tuple[float, float]:
    """Half-extents along x and z of the top that is there to touch, mm: a block's without edges."""
    most = 0.5 * body.width_mm, 0.5 * body.depth_mm
    if body.shape == "block":
        return profile_of(body).pieces[0].end[0], most[1]
    return most


def contact_half_width(design: Design, approach_mm: float, object_curvature: float = 0.0) -> float:
    """Forecast of the contact's half-width at z = 0 under a plane pressed ``approach_mm``, mm.

    ``object_curvature`` (1/mm): of a cylinder along z instead of the plane. Straight body: Hertz's
    line contact on a layer of the crest's height d (Johnson, Contact Mechanics, 1985, eq. 5.56):
    approach = a^2 / (4 R) (2 ln(2 d / a) - nu / (1 - nu)). A crest curved along z too (dome, pin):
    point contact on a half-space of the mean curvature, approach = a^2 / R. A flat top under a
    plane: all of it. Plates, cores, free sides and friction are left out, so it errs to the wide
    side: against the plane-strain model at approaches of 0.15 to 0.4 mm, by 8 to 16 % without
    plates and by 13 to 26 % with the shipped fingers'. A forecast, no result. Never more than half
    of the body's width.
    """
    body = design.body
    most = flat_half_extents(body)[0]
    if approach_mm <= 0:
        return 0.0
    across, along = crest_curvatures(body)
    across += object_curvature
    if along > 0.0:
        return min(math.sqrt(2.0 * approach_mm / (across + along)), most)
    if across == 0.0:
        return most
    height, nu = float(crest_height(body)), design.material_of("body").poissons_ratio

    def approach(a: float) -> float:
        layer = 2.0 * math.log(2.0 * height / a) - nu / (1.0 - nu)
        return a * a * across / 4.0 * layer

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
    body: str
    plates: int
    rows: tuple[str, ...]
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
        """Return the fields by name; ``least_cover_mm``, of the plates' nearest points, not their
        middles as plates.cover_mm, as ``least_surface_mm``."""
        return {
            "least_surface_mm" if name == "least_cover_mm" else name: value
            for name, value in asdict(self).items()
        }


def body_words(body: Body) -> str:
    """A body in a few words: "arc, round edge, core"."""
    edge = f", {body.edge} edge" if body.edge_radius_mm is not None else ""
    return f"{body.shape}{edge}{', core' if body.core is not None else ''}"


def row_words(row: PlateRow) -> str:
    """A row of plates in a few words: "7 along x, bent, finite"."""
    table = row.table
    words = [
        f"{len(row.frames)} placed" if row.placed else f"{len(row.frames)} along {table.along}"
    ]
    words += [table.follow] if table.follow != "level" else []
    words += ["staggered"] if table.stagger_mm else []
    words += ["finite"] if table.span_mm is not None else []
    words += ["perforated"] if table.hole_diameter_mm is not None else []
    models = {"sheet": ["as sheets"], "none": ["not modelled"]}
    words += models.get(table.model, [])
    return ", ".join(words)


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
        reach = points[:, 0] if body.shape != "revolved" else np.hypot(points[:, 0], points[:, 2])
        side = float(0.5 * body.width_mm - np.abs(reach).max())
        base = float(points[:, 1].min())
    return Summary(
        name=design.design.name,
        digest=design.digest(),
        body=body_words(body),
        plates=plates.number,
        rows=tuple(row_words(row) for row in plate_rows(design)),
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
