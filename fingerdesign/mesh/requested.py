"""Target edge lengths of a design's mesh, and the edges found against them."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array, BoolArray, IntArray
from fingerdesign.design.schema import Design
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.surface import surface_of
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.cells import facet_kind
from fingerdesign.mesh.measures import edge_lengths
from fingerdesign.mesh.section.plates import (
    extruded_sizes,
    inner_of,
    section_frames,
    section_outline,
    section_sizes,
)
from fingerdesign.mesh.section.size_field import SectionSize
from fingerdesign.mesh.sizing import FACETS_ACROSS, MeshSizes, SizeField
from fingerdesign.mesh.types import Mesh

_END_WORDS = ("in and near plates finer at the plates' ends, where stress is singular",)


@dataclass(frozen=True)
class TargetSizes:
    """Target edge length (mm) by place, and the way to compare a cell's own with it.

    at       points (n, 2 or 3) -> (n,)
    reasons  why they differ from the keys of [mesh], a sentence each
    stretch  cells are to be this many times longer along z; infinite: only what they measure in
             the section counts (layers set the length along z)
    """

    at: Callable[[Array], Array]
    stretch: float = 1.0
    reasons: tuple[str, ...] = ()

    def ratios(self, points: Array, cells: IntArray) -> Array:
        """Mean edge of each cell (its corners) over the target at its centroid, (c,)."""
        shrunk = points.copy()
        if points.shape[1] == 3:
            shrunk[:, 2] /= self.stretch
        edges = edge_lengths(shrunk, cells)
        known = edges > 1e-9
        mean = edges.sum(axis=1) / np.maximum(known.sum(axis=1), 1)
        return np.asarray(mean / self.at(points[cells].mean(axis=1)))


def requested_sizes(design: Design, mesh: Mesh, zone: Zone) -> TargetSizes:
    """Target sizes by the ``[mesh]`` table of a mesh that is fine in a zone of contact."""
    frames = plate_frames(design) if design.plates.model != "none" else ()
    ends = _END_WORDS if frames else ()
    plane = mesh.dimension == 2
    if plane or mesh.mesher == "sweep":
        flat = (section_sizes if plane else extruded_sizes)(design, zone.half_width)
        size = (design.mesh.section if plane else design.mesh).contact_size_mm
        inner = None if plane else inner_of(design, zone)
        shown = section_frames(design) if plane else frames
        field = SectionSize(section_outline(design, zone.half_width, flat, shown, inner))
        table = "mesh.section" if plane else "mesh"
        words = _finer_words(table, size, flat.contact_size_mm, zone.half_width)
        if inner is not None:
            reach = f"over |x| <= {inner[0]:.3g} mm, which the scene's path reaches"
            words.append(f"{reach}, {inner[1]:.3g} mm")
        return TargetSizes(field, 1.0 if plane else np.inf, (*words, *ends))
    sizes = MeshSizes.of(design, zone)
    target = SizeField(surface_of(design.body), frames, sizes, zone)
    half = min(zone.half_width, zone.half_depth or np.inf)
    words = _finer_words("mesh", design.mesh.contact_size_mm, sizes.contact, half)
    if sizes.stretch > 1.0:
        words.append(
            f"elements are to be {sizes.stretch:g} times longer along z than in the section, so "
            f"at the contact {sizes.contact / np.sqrt(sizes.stretch):.3g} mm across"
        )
    return TargetSizes(target, sizes.stretch, (*words, *ends))


def _finer_words(table: str, key: float, size: float, half_width: float) -> list[str]:
    """Sentence on a size at the contact that is not ``table``.contact_size_mm; none if it is."""
    if size >= key:
        return []
    return [
        f"at the contact {size:.3g} mm, not {table}.contact_size_mm = {key:g}: "
        f"{FACETS_ACROSS:g} facets over the half-width of the scene's contact zone "
        f"({half_width:.3g} mm), but no finer than a third of the key"
    ]


def size_zones(mesh: Mesh, requested: TargetSizes) -> dict[str, BoolArray]:
    """Masks (c,) of the cells at the contact zone, in plates, in the core, and of the rest.

    The contact zone: cells that touch contact facets where the target size is nearly the least
    of all such facets.
    """
    parts = mesh.parts
    contact = mesh.facets.get("contact", np.zeros((0, 3), dtype=np.int64))
    at_contact = np.zeros(len(mesh.cells), dtype=bool)
    if len(contact):
        nodes = np.unique(contact[:, : facet_kind(contact).corners])
        target = requested.at(mesh.points[nodes])
        fine = nodes[target <= 1.2 * target.min()]
        at_contact = np.isin(mesh.corners, fine).any(axis=1) & parts["elastomer"]
    rest = parts["elastomer"] & ~at_contact
    return {"contact": at_contact, "plates": parts["plates"], "core": parts["core"], "rest": rest}


def size_ratios(mesh: Mesh, requested: TargetSizes) -> dict[str, dict[str, float]]:
    """By zone: elements, mean size, target and found (mm), and their ratio: 5 %, mean, 95 %."""
    ratios = requested.ratios(mesh.points, mesh.corners)
    edges = edge_lengths(mesh.points, mesh.corners).mean(axis=1)
    target = requested.at(mesh.points[mesh.corners].mean(axis=1))
    return {
        zone: {
            "elements": int(rows.sum()),
            "target_mm": float(target[rows].mean()),
            "edge_mm": float(edges[rows].mean()),
            "p5": float(np.percentile(ratios[rows], 5)),
            "mean": float(ratios[rows].mean()),
            "p95": float(np.percentile(ratios[rows], 95)),
        }
        for zone, rows in size_zones(mesh, requested).items()
        if rows.any()
    }
