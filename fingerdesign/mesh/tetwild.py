"""Tetrahedra for any finger, plates as solids: CAD surface -> fTetWild -> snapped quadratic mesh.

fTetWild takes triangles and keeps them within an envelope of ``epsilon``. It is not deterministic,
so its answer must pass the gate (``Gate``) or is made again, and what passed is kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.errors import MeshError
from fingerdesign.geometry.surface import surface_of
from fingerdesign.mesh.cache import keep_mesh, load_mesh, mesh_key
from fingerdesign.mesh.finish import finish
from fingerdesign.mesh.inside import check_closed
from fingerdesign.mesh.quality import QualityReport, assess
from fingerdesign.mesh.sizing import MeshSizes, SizeField, expected_elements
from fingerdesign.mesh.tetwild_process import Attempt, run_tetwild
from fingerdesign.mesh.types import Mesh

if TYPE_CHECKING:
    import cadquery as cq

    from fingerdesign.design.schema import Body, Design
    from fingerdesign.geometry.solid import Solid

# Edges come out longer than asked where the field is steep: at the contact 1.33 times (0.28 mm for
# 0.21, 0.39 for 0.30), at plates 1.0 to 1.08 times.
CONTACT_OVERSHOOT = 1.33
# fTetWild made 0.87 to 0.97 times the expected tetrahedra, 2 times where plates were very thin;
# where its optimisation went astray (a stop energy of 20) 3 to 8 times.
MOST_ELEMENTS_RATIO = 2.5
MOST_ELEMENTS = 600_000  # about 2.5 million dofs: no machine this is for factors more


@dataclass(frozen=True)
class Gate:
    """What a tetrahedral mesh must fulfil (NUMERICS 7; measured on accepted meshes in brackets)."""

    body_volume_error: float = 1e-3  # [2e-5]
    plate_volume_error: float = 1e-2  # [1e-12]
    face_area_error: float = 1e-3  # [1e-5]
    min_dihedral_deg: float = 5.0  # [7 to 10, after improve]
    contact_residual_mm: float = 1e-6  # [1e-13]
    least_jacobian_ratio: float = 0.05  # [0.9]

    def faults(self, report: QualityReport) -> list[str]:
        """What a mesh fails, in words; empty when it passes."""
        found = []
        for name, bound in vars(self).items():
            value = {
                "body_volume_error": report.body_volume_error,
                "plate_volume_error": report.worst_plate_volume_error,
                "face_area_error": report.worst_face_area_error,
                "min_dihedral_deg": report.min_dihedral_deg,
                "contact_residual_mm": report.contact_residual_mm,
                "least_jacobian_ratio": report.least_jacobian_ratio,
            }[name]
            least = name in ("min_dihedral_deg", "least_jacobian_ratio")
            if not (value >= bound if least else value <= bound):
                found.append(f"{name} = {value:.3g} ({'below' if least else 'above'} {bound:g})")
        return found


def tetrahedralise(
    design: Design,
    zone_half_width_mm: float,
    symmetric: bool = True,
    sizes: MeshSizes | None = None,
    use_cache: bool = True,
    zone_half_depth_mm: float | None = None,
) -> Mesh:
    """Mesh a finger (or its half z >= 0) with quadratic tetrahedra, fine at |x| <= zone half width
    and, where given, |z| <= zone half depth.

    sizes: by default the design's ``[mesh]`` table. Meshes that passed the gate are kept by content
    and returned again unless ``use_cache`` is False. MeshError when no attempt passes.
    """
    from fingerdesign.geometry.solid import build_solid
    from fingerdesign.geometry.tessellation import triangulate

    zone = (zone_half_width_mm, zone_half_depth_mm)
    sizes = sizes or MeshSizes.of(design, *zone)
    frames = meshed_frames(design)
    key = mesh_key(design, frames, sizes, zone, symmetric)
    kept = load_mesh(key) if use_cache else None
    if kept is not None and not Gate().faults(assess(kept, design)):
        return kept
    solid = build_solid(design, half=symmetric, frames=frames)
    epsilon, chord = envelope_mm(design, frames), chord_mm(design.body)
    vertices, triangles = triangulate(_parts(solid), chord)
    outside = triangulate([solid.outline], chord)
    check_closed(*outside)
    expected = _expected(design, size_field(design, frames, sizes, *zone), symmetric)
    attempts = _attempts(epsilon, int(design.mesh.attempts))
    complaints = []
    for number, attempt in enumerate(attempts, start=1):
        field = size_field(design, frames, sizes.scaled(attempt.size_factor), *zone)
        try:
            points, tets = run_tetwild(
                vertices, triangles, field, attempt, float(design.mesh.time_limit_s)
            )
            wanted = replace(field, sizes=sizes.scaled(attempt.size_factor))
            most = int(MOST_ELEMENTS_RATIO * expected / attempt.size_factor**3)
            mesh = finish(design, frames, points, tets, outside, symmetric, wanted, most)
        except MeshError as error:
            complaints.append(f"attempt {number}: {error}")
            continue
        mesh.notes["attempts"] = number
        faults = Gate().faults(assess(mesh, design))
        if len(mesh.cells) > most:
            faults.append(f"{len(mesh.cells)} tetrahedra where about {expected:.0f} were asked for")
        if not faults:
            if use_cache:
                keep_mesh(key, mesh)
            return mesh
        complaints.append(f"attempt {number}: {', '.join(faults)}")
    raise MeshError(
        f"no tetrahedral mesh of {design.design.name} passed the gate in {len(attempts)} attempts; "
        + "; ".join(complaints)
    )


def meshed_frames(design: Design) -> tuple[PlateFrame, ...]:
    """The boxes that are meshed for a design's plates: themselves, carriers of sheets, or none."""
    if design.plates.model == "none" or not design.plates.number:
        return ()
    if design.plates.model == "solid":
        return plate_frames(design)
    from fingerdesign.mesh.slots import carrier_frames

    return carrier_frames(plate_frames(design), design)


def _parts(solid: Solid) -> tuple[cq.Shape, ...]:
    return (solid.body, *solid.plates, *([solid.core] if solid.core is not None else []))


def envelope_mm(design: Design, frames: tuple[PlateFrame, ...]) -> float:
    """fTetWild's envelope: a tenth of the thinnest part, at most the chord tolerance.

    At a quarter of the thickness plates still survive; at 1.2 times they vanish without a word.
    """
    thin = [frame.thickness for frame in frames]
    if design.body.core is not None:
        thin.append(design.body.core.height_mm)
    return min([chord_mm(design.body), *(0.1 * each for each in thin)])


def chord_mm(body: Body) -> float:
    """Chord tolerance of the triangles to mesh, mm: 0.01 for a finger of 25 mm.

    Snapping takes the chords out again. At 0.002 fTetWild ran for minutes on a finger of 25 mm, at
    0.01 for a minute on one of 65 mm.
    """
    size = float(np.hypot(np.hypot(body.width_mm, body.base_height_mm), body.depth_mm))
    return 4e-4 * size


def size_field(
    design: Design,
    frames: tuple[PlateFrame, ...],
    sizes: MeshSizes,
    zone_half_width: float,
    zone_half_depth: float | None = None,
) -> SizeField:
    """The size field to ask fTetWild for, so that edges at the contact come out as ``sizes``."""
    asked = replace(sizes, contact=sizes.contact / CONTACT_OVERSHOOT)
    return SizeField(surface_of(design.body), frames, asked, zone_half_width, zone_half_depth)


def _expected(design: Design, field: SizeField, symmetric: bool) -> float:
    """How many tetrahedra the sizes ask for; MeshError where that is beyond MOST_ELEMENTS."""
    half = 0.5 * np.array([design.body.width_mm, 0.0, design.body.depth_mm])
    low = np.array([-half[0], 0.0, 0.0 if symmetric else -half[2]])
    high = np.array([half[0], field.surface.crest, half[2]])
    expected = expected_elements(field, low, high)
    if expected > MOST_ELEMENTS:
        raise MeshError(
            f"the [mesh] sizes of {design.design.name} ask for about {expected:.2g} tetrahedra, "
            f"more than {MOST_ELEMENTS}; raise mesh.contact_size_mm, plate_size_mm or far_size_mm"
        )
    return expected


def _attempts(epsilon: float, count: int) -> list[Attempt]:
    """Settings to try in turn; fTetWild is not deterministic: the same again may pass.

    A fifth of the thickness is faster where plates are very thin (0.02 mm: 60 s, not over 120), but
    where they are not, snapping may invert tetrahedra. A stop energy above 10 is no remedy: it
    yields many times the elements.
    """
    settings = (
        Attempt(epsilon),
        Attempt(2.0 * epsilon),
        Attempt(epsilon),
        Attempt(0.6 * epsilon, iterations=120, stop_energy=8.0),
        Attempt(0.6 * epsilon, size_factor=0.85),
    )
    return [settings[i % len(settings)] for i in range(max(1, count))]
