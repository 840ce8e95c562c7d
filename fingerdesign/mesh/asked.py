"""The sizes that a design asks its mesher for, to hold a mesh against (numpy only)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array, IntArray
from fingerdesign.layout.frames import plate_frames
from fingerdesign.layout.surface import surface_of
from fingerdesign.mesh.measures import edge_lengths
from fingerdesign.mesh.section.section import extruded_sizes, section_sizes
from fingerdesign.mesh.sizing import FACETS_ACROSS, MeshSizes, SizeField, distances_to_plate
from fingerdesign.mesh.types import Mesh

if TYPE_CHECKING:
    from fingerdesign.design.mesh import SectionMesh
    from fingerdesign.design.schema import Design


_END_WORDS = ("in plates and beside them finer at the plates' ends, where stress is singular",)


@dataclass(frozen=True)
class AskedSizes:
    """Wanted edge length (mm) by place, and how a cell's own is measured against it.

    at       points (n, 2 or 3) -> (n,)
    reasons  why they differ from the keys of [mesh], a sentence each
    stretch  cells are to be this many times longer along z; infinite: only what they measure in
             the section counts (layers say how long they are along z)
    """

    at: Callable[[Array], Array]
    stretch: float = 1.0
    reasons: tuple[str, ...] = ()

    def ratios(self, points: Array, cells: IntArray) -> Array:
        """Mean edge of each cell (its corners) over the wanted one at its centroid, (c,)."""
        shrunk = points.copy()
        if points.shape[1] == 3:
            shrunk[:, 2] /= self.stretch
        edges = edge_lengths(shrunk, cells)
        known = edges > 1e-9
        mean = edges.sum(axis=1) / np.maximum(known.sum(axis=1), 1)
        return np.asarray(mean / self.at(points[cells].mean(axis=1)))


def asked_sizes(
    design: Design, mesh: Mesh, zone_half_width: float, zone_half_depth: float | None = None
) -> AskedSizes:
    """What the design's ``[mesh]`` table asks of a mesh that is fine in a zone of contact.

    ``zone_half_width``, ``zone_half_depth``: the zone's, mm (None: the full depth).
    """
    frames = plate_frames(design) if design.plates.model != "none" else ()
    has_plates = bool(frames)
    if mesh.dimension == 2:
        flat, said = section_sizes(design, zone_half_width), design.mesh.section.contact_size_mm
        field = _section_field(design, flat, zone_half_width)
        words = _finer_words("mesh.section", said, flat.contact_size_mm, zone_half_width)
        return AskedSizes(field, reasons=(*words, *_END_WORDS[:has_plates]))
    if mesh.mesher == "extrude":
        flat, said = extruded_sizes(design, zone_half_width), design.mesh.contact_size_mm
        field = _section_field(design, flat, zone_half_width)
        words = _finer_words("mesh", said, flat.contact_size_mm, zone_half_width)
        return AskedSizes(field, np.inf, (*words, *_END_WORDS[:has_plates]))
    sizes = MeshSizes.of(design, zone_half_width, zone_half_depth)
    field = SizeField(surface_of(design.body), frames, sizes, zone_half_width, zone_half_depth)
    reasons = (*_contact_words(design, sizes, zone_half_width, zone_half_depth), *_END_WORDS)
    return AskedSizes(field, sizes.stretch, reasons[: len(reasons) - (not has_plates)])


def _contact_words(
    design: Design, sizes: MeshSizes, half_width: float, half_depth: float | None
) -> list[str]:
    """Why the size at the contact is not mesh.contact_size_mm, where it is not."""
    said, half = design.mesh.contact_size_mm, min(half_width, half_depth or np.inf)
    found = _finer_words("mesh", said, sizes.contact, half)
    if sizes.stretch > 1.0:
        found.append(
            f"elements are to be {sizes.stretch:g} times longer along z than in the section, so "
            f"at the contact {sizes.contact / np.sqrt(sizes.stretch):.3g} mm across"
        )
    return found


def _finer_words(table: str, said: float, size: float, half_width: float) -> list[str]:
    """Why the size at the contact is not ``table``.contact_size_mm, where it is not."""
    if size >= said:
        return []
    return [
        f"at the contact {size:.3g} mm, not {table}.contact_size_mm = {said:g}: "
        f"{FACETS_ACROSS:g} facets over the half-width of the scene's contact zone "
        f"({half_width:.3g} mm), but no finer than a third of the key"
    ]


def _section_field(design: Design, sizes: SectionMesh, zone: float) -> Callable[[Array], Array]:
    """As netgen is asked: sizes set at the contact zone, at plates and their ends, then growing."""
    surface = surface_of(design.body)
    frames = plate_frames(design) if design.plates.model != "none" else ()

    def wanted(points: Array) -> Array:
        flat = points[:, :2]
        sideways = np.maximum(np.abs(flat[:, 0]) - zone, 0.0)
        away = np.hypot(sideways, np.abs(surface.distance(flat)))
        found = np.minimum(sizes.far_size_mm, sizes.contact_size_mm + sizes.gradation * away)
        for frame in frames:
            if frame.along != "x":
                continue
            plate, ends = distances_to_plate(frame, flat)
            found = np.minimum(found, sizes.plate_size_mm + sizes.gradation * plate)
            found = np.minimum(found, sizes.plate_end_size_mm + sizes.gradation * ends)
        return np.asarray(found)

    return wanted


def parts_of(mesh: Mesh, design: Design) -> dict[str, NDArray[np.bool_]]:
    """Which cells (c,) belong to the elastomer, to plates, to the core."""
    core = mesh.regions == design.core_region
    return {
        "elastomer": mesh.regions == 0,
        "plates": (mesh.regions > 0) & ~core,
        "core": core,
    }


def size_zones(mesh: Mesh, design: Design, asked: AskedSizes) -> dict[str, NDArray[np.bool_]]:
    """Which cells (c,) lie at the contact zone, in plates, in the core, elsewhere in the elastomer.

    The contact zone: cells that touch contact facets where the size asked for is nearly the least
    of all such facets.
    """
    parts = parts_of(mesh, design)
    contact = mesh.facets.get("contact", np.zeros((0, 3), dtype=np.int64))
    at_contact = np.zeros(len(mesh.cells), dtype=bool)
    if len(contact):
        nodes = np.unique(contact[:, : mesh.dimension])
        wanted = asked.at(mesh.points[nodes])
        fine = nodes[wanted <= 1.2 * wanted.min()]
        at_contact = np.isin(mesh.corners, fine).any(axis=1) & parts["elastomer"]
    rest = parts["elastomer"] & ~at_contact
    return {"contact": at_contact, "plates": parts["plates"], "core": parts["core"], "rest": rest}


def size_ratios(mesh: Mesh, design: Design, asked: AskedSizes) -> dict[str, dict[str, float]]:
    """By zone: elements, mean size asked and found (mm), and their ratio: 5 %, mean, 95 %."""
    ratios = asked.ratios(mesh.points, mesh.corners)
    edges = edge_lengths(mesh.points, mesh.corners).mean(axis=1)
    wanted = asked.at(mesh.points[mesh.corners].mean(axis=1))
    return {
        zone: {
            "elements": int(rows.sum()),
            "asked_mm": float(wanted[rows].mean()),
            "edge_mm": float(edges[rows].mean()),
            "p5": float(np.percentile(ratios[rows], 5)),
            "mean": float(ratios[rows].mean()),
            "p95": float(np.percentile(ratios[rows], 95)),
        }
        for zone, rows in size_zones(mesh, design, asked).items()
        if rows.any()
    }
