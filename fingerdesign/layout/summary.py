"""Summary of a sound design, as ``fingerdesign check`` shows it."""

from dataclasses import dataclass

import numpy as np

from fingerdesign.design.scene import Scene, SceneObject
from fingerdesign.design.schema import Body, Design
from fingerdesign.layout import clearance
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.gaps import least_gap
from fingerdesign.layout.row_keys import PlateRow, plate_rows
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import outline_volume, plate_volume
from fingerdesign.layout.zone import contact_reach, greatest_approach

DEFAULT_APPROACH_MM = 0.1  # The first approach of the fundamental case.


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Facts of a sound design; clearances are None without plates.

    body, rows: "arc, round edge, core" and "7 along x, bent, finite". least_surface_mm: of the
    plates' nearest points, not their middles as plates.cover_mm.
    """

    name: str
    digest: str
    body: str
    plates: int
    rows: tuple[str, ...]
    least_surface_mm: float | None = None
    least_gap_mm: float | None = None
    least_side_mm: float | None = None
    least_base_mm: float | None = None
    approach_mm: float
    contact_half_width_mm: float
    volume_mm3: float
    plates_volume_mm3: float
    extruded: bool


def summarise(design: Design, scene: Scene | None = None) -> Summary:
    """Summarise a sound design, pressed as far as ``scene`` does (else the fundamental case)."""
    body, frames = design.body, plate_frames(design)
    approach = DEFAULT_APPROACH_MM if scene is None else greatest_approach(design, scene)
    rigid = SceneObject() if scene is None else scene.object
    words = [body.shape, *([f"{body.edge} edge"] if body.edge_radius_mm is not None else [])]
    return Summary(
        name=design.design.name,
        digest=design.digest(),
        body=", ".join([*words, *(["core"] if body.core is not None else [])]),
        plates=design.plates.number,
        rows=tuple(_row_words(row) for row in plate_rows(design)),
        approach_mm=approach,
        contact_half_width_mm=min(contact_reach(design, rigid, approach)[0], 0.5 * body.width_mm),
        volume_mm3=outline_volume(body),
        plates_volume_mm3=sum(plate_volume(frame) for frame in frames),
        extruded=design.extruded,
        **(_clearances(body, frames) if frames else {}),
    )


def _row_words(row: PlateRow) -> str:
    table, count = row.table, len(row.frames)
    words = [f"{count} placed" if row.placed else f"{count} along {table.along}"]
    for there, word in (
        (table.follow != "level", table.follow),
        (table.stagger_mm, "staggered"),
        (table.span_mm is not None, "finite"),
        (table.hole_diameter_mm is not None, "perforated"),
        (table.model == "sheet", "as sheets"),
        (table.model == "none", "not modelled"),
    ):
        words += [word] if there else []
    return ", ".join(words)


def _clearances(body: Body, frames: tuple[PlateFrame, ...]) -> dict[str, float | None]:
    points = np.vstack([clearance.plate_points(frame) for frame in frames])
    reach = points[:, 0] if not body.kind.turned else np.hypot(points[:, 0], points[:, 2])
    closest = least_gap(frames)
    return {
        "least_surface_mm": float(clearance.cover_clearances(body, frames).min()),
        "least_gap_mm": None if closest is None else closest.distance,
        "least_side_mm": float(0.5 * body.width_mm - np.abs(reach).max()),
        "least_base_mm": float(points[:, 1].min()),
    }
