"""The sizes that a section is meshed with, in plane strain and to be extruded.

Those of the design's ``[mesh]`` table, but at the contact no coarser than the scene's contact
needs: the same rule as that of tetrahedra (sizing.contact_size). A model's sizes so follow from
the greatest approach of its scene at every fidelity.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.mesh.sizing import contact_size

if TYPE_CHECKING:
    from fingerdesign.design.meshing import SectionMesh
    from fingerdesign.design.schema import Design

_END = 0.25  # of the plates' size: no smaller elements at the ends of thin plates


def section_sizes(design: Design, zone_half_width: float) -> SectionMesh:
    """Sizes of the plane-strain mesh for a contact zone of ``zone_half_width`` (mm)."""
    sizes = design.mesh.section
    return _fit(sizes, zone_half_width)


def extruded_sizes(design: Design, zone_half_width: float) -> SectionMesh:
    """Sizes of the section that is extruded: the 3-D ones of the ``[mesh]`` table."""
    mesh = design.mesh
    sizes = mesh.section.model_copy(
        update={
            "contact_size_mm": mesh.contact_size_mm,
            "plate_size_mm": mesh.plate_size_mm,
            "plate_end_size_mm": max(design.plates.thickness_mm, _END * mesh.plate_size_mm),
            "far_size_mm": mesh.far_size_mm,
        }
    )
    return _fit(sizes, zone_half_width)


def _fit(sizes: SectionMesh, zone_half_width: float) -> SectionMesh:
    size = contact_size(sizes.contact_size_mm, zone_half_width)
    return sizes.model_copy(update={"contact_size_mm": size})
