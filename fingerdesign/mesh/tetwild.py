"""Tetrahedra for any finger, plates as solids: CAD surface -> fTetWild -> snapped quadratic mesh.

fTetWild takes triangles and keeps them within an envelope of ``epsilon``. It is not deterministic,
so its answer must pass the gate (``Gate``) or is made again, and what passed is kept.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.design.layout import PlateFrame
from fingerdesign.errors import MeshError
from fingerdesign.geometry.surface import ContactSurface
from fingerdesign.mesh.cache import keep_mesh, load_mesh, mesh_key
from fingerdesign.mesh.finish import finish
from fingerdesign.mesh.quality import QualityReport, assess
from fingerdesign.mesh.sizing import MeshSizes, SizeField
from fingerdesign.mesh.tetwild_process import Attempt, run_tetwild
from fingerdesign.mesh.types import Mesh

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body, Design

# Edges come out longer than asked where the field is steep: mean edges at the contact were 1.33
# times the field's value there (0.28 for 0.21, 0.39 for 0.30 mm), at plates 1.0 to 1.08 times.
CONTACT_OVERSHOOT = 1.33


@dataclass(frozen=True)
class Gate:
    """What a tetrahedral mesh must fulfil (NUMERICS 7; measured on accepted meshes in brackets)."""

    body_volume_error: float = 1e-3  # [2e-5]
    plate_volume_error: float = 1e-2  # [1e-12]
    face_area_error: float = 1e-3  # [1e-5]
    min_dihedral_deg: float = 3.0  # [5 to 9]
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
) -> Mesh:
    """Mesh a finger (or its half z >= 0) with quadratic tetrahedra, fine at |x| <= zone half width.

    sizes: by default the design's ``[mesh]`` table. Meshes that passed the gate are kept by content
    and returned again unless ``use_cache`` is False. MeshError when no attempt passes.
    """
    from fingerdesign.geometry.solid import build_solid, solid_plates
    from fingerdesign.geometry.tessellation import triangulate

    sizes = sizes or MeshSizes.of(design)
    frames = solid_plates(design)
    key = mesh_key(design.body, frames, sizes, zone_half_width_mm, symmetric)
    kept = load_mesh(key) if use_cache else None
    if kept is not None and not Gate().faults(assess(kept, design)):
        return kept
    solid = build_solid(design, half=symmetric)
    epsilon = envelope_mm(design.body, frames)
    vertices, triangles = triangulate((solid.body, *solid.plates), epsilon)
    attempts = _attempts(epsilon, int(design.mesh.attempts))
    complaints = []
    for number, attempt in enumerate(attempts, start=1):
        field = size_field(design, frames, sizes.scaled(attempt.size_factor), zone_half_width_mm)
        try:
            points, tets = run_tetwild(
                vertices, triangles, field, attempt, float(design.mesh.time_limit_s)
            )
            mesh = finish(design.body, frames, points, tets, symmetric)
        except MeshError as error:
            complaints.append(f"attempt {number}: {error}")
            continue
        faults = Gate().faults(assess(mesh, design))
        if not faults:
            if use_cache:
                keep_mesh(key, mesh)
            return mesh
        complaints.append(f"attempt {number}: {', '.join(faults)}")
    raise MeshError(
        f"no tetrahedral mesh of {design.design.name} passed the gate in {len(attempts)} attempts; "
        + "; ".join(complaints)
    )


def envelope_mm(body: Body, frames: tuple[PlateFrame, ...]) -> float:
    """fTetWild's envelope: a tenth of the thinnest plate, at most 0.01 mm and 5e-4 of the body.

    At a quarter of the thickness plates still survive; at 1.2 times they vanish without a word.
    """
    size = float(np.hypot(np.hypot(body.width_mm, body.base_height_mm), body.depth_mm))
    return min([0.01, 5e-4 * size, *(0.1 * frame.thickness for frame in frames)])


def size_field(
    design: Design, frames: tuple[PlateFrame, ...], sizes: MeshSizes, zone_half_width: float
) -> SizeField:
    """The size field to ask fTetWild for, so that edges at the contact come out as ``sizes``."""
    asked = replace(sizes, contact=sizes.contact / CONTACT_OVERSHOOT)
    return SizeField(ContactSurface.of(design.body), frames, asked, zone_half_width)


def _attempts(epsilon: float, count: int) -> list[Attempt]:
    first = Attempt(epsilon)
    others = (
        Attempt(epsilon),  # not deterministic: the same again may pass
        Attempt(0.6 * epsilon, iterations=120, stop_energy=8.0),
        Attempt(0.6 * epsilon, iterations=120, stop_energy=8.0, size_factor=0.85),
        Attempt(1.5 * epsilon, size_factor=0.9),
    )
    return [first, *others, *(others[i % 4] for i in range(count))][: max(1, count)]
