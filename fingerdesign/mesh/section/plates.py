"""The outline of a finger's section, plates as boxes or as lines, and the sizes of its edges."""

from itertools import pairwise

import numpy as np

from fingerdesign.design.mesh import SectionMesh
from fingerdesign.design.schema import Body, Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.zone import Zone
from fingerdesign.mesh.section.outline import BODY, ContactSizes, Outline, body_outline, core_box
from fingerdesign.mesh.sheets import line_beyond, room_around
from fingerdesign.mesh.sizing import contact_size

Inner = tuple[float, float]
_SAGITTA = 0.1  # of the thickness: what a chord of a bent face may leave, before its middle is bent
_END = 0.25  # of the plates' size: no smaller elements at the ends of sheets
# Sections that are swept. Gages under a bell of pressure, in per cent of the largest (mean of both
# faces; single faces), with three layers in half the depth, against 5 to 9 layers whose plate ends
# are half as thick as the plate or finer; contact facets of 0.4 mm, left of tees and fine_tees 0.6:
#                 ends as thick as the plate, gradation 0.3     half as thick, 0.5
#     maeno2000   23 Gflop    1.1; 3.0                          40 Gflop    0.3; 3.0
#     sensitive   37 Gflop    1.0; 2.2                          38 Gflop    0.9; 1.4
#     tees        22 Gflop    2.2; 4.5                          27 Gflop    0.4; 4.0
#     fine_tees   44 Gflop    2.4; 4.4                          41 Gflop    1.3; 3.8
# Fine ends with a gradation of 0.7 leave 2.3; 7.0 on tees and 3.3; 17 on fine_tees.
_SOLID_END = 0.1  # of the plates' size: no smaller elements at the ends of thin solid plates
_ALONG = 3.0  # elements along a plate, at least: short plates bend
_GRADATION = 0.5  # mm a mm: growth of the elements, at most
# A long contact's pressure kinks where plates lie below and where slip begins. Facets are long in z
# anyway: across, those that the scene's path reaches may be so much shorter. On the reference
# finger the pressure at z = 0 is then within 3 % of its peak of that on facets of 0.1 mm; facets as
# long as the key leave 8 %. (fTetWild's, cut finer across alone, leave as much as before: they are
# irregular.)
_INNER_SIZE = 0.3
_STEEPEST = 1.0  # Gradation: a size cannot grow faster than the way to it is long.


def section_frames(design: Design) -> tuple[PlateFrame, ...]:
    """The plates that the section z = 0 cuts across their span; none where they are left out."""
    if design.plates.model == "none":
        return ()
    return tuple(f for f in plate_frames(design) if f.along == "x" and f.low <= 0.0 <= f.high)


def _add_sheet(
    outline: Outline,
    frame: PlateFrame,
    frames: tuple[PlateFrame, ...],
    gage_length: float,
    sizes: SectionMesh,
    body: Body,
) -> None:
    """Add a plate as its mid-line inside the body. Beyond each end goes a short line within which
    the square ends will open."""
    beyond = line_beyond(frame, room_around(frame, frames, body), sizes.plate_end_size_mm)
    along = _stations(frame, gage_length)
    along = [along[0] - beyond, *along, along[-1] + beyond]
    last = len(along) - 1
    line = []
    for k, (x, y) in enumerate(frame.from_local(np.array(along), 0.0)):
        line.append(outline.point(x, y, beyond if k in (1, last - 1) else None))
    for k, (a, b) in enumerate(pairwise(line)):
        size = beyond if k in (0, last - 1) else sizes.plate_size_mm
        outline.curve([a, b], BODY, BODY, size)


def _add_plate(
    outline: Outline, frame: PlateFrame, domain: int, gage_length: float, sizes: SectionMesh
) -> None:
    """Add a solid plate as a domain, fine at its square ends."""
    along, size = np.array(_stations(frame, gage_length)), sizes.plate_end_size_mm
    last = len(along) - 1
    lower, upper = (
        [outline.point(x, y, size if k in (0, last) else None) for k, (x, y) in enumerate(where)]
        for where in (frame.from_local(along, side * frame.thickness) for side in (-0.5, 0.5))
    )
    for k in range(last):
        _add_face(outline, frame, (lower[k], lower[k + 1]), domain, sizes)
        _add_face(outline, frame, (upper[k + 1], upper[k]), domain, sizes)
    outline.curve([lower[-1], upper[-1]], domain, BODY, size)
    outline.curve([upper[0], lower[0]], domain, BODY, size)
    outline.domains.append((domain, sizes.plate_size_mm))


def _add_face(
    outline: Outline, frame: PlateFrame, ends: tuple[int, int], domain: int, sizes: SectionMesh
) -> None:
    size = sizes.plate_size_mm
    if frame.bend_radius is None:
        outline.curve(list(ends), domain, BODY, size)
        return
    centre = frame.centre - frame.bend_radius * frame.normal
    most = float(np.sqrt(8.0 * _SAGITTA * frame.thickness * frame.bend_radius))
    outline.arc(ends, centre, domain, BODY, min(size, most))


def _stations(frame: PlateFrame, gage_length: float) -> list[float]:
    """Vertices along a plate: its ends, and the gage's, so that its strain is a difference of
    nodal displacements."""
    along = [-0.5 * frame.length, 0.5 * frame.length]
    if gage_length < 0.98 * frame.length:
        along[1:1] = [-0.5 * gage_length, 0.5 * gage_length]
    return along


def section_sizes(design: Design, zone_half_width: float) -> SectionMesh:
    """Sizes of the plane-strain mesh for a contact zone of ``zone_half_width`` (mm)."""
    return _fit(design.mesh.section, zone_half_width)


def extruded_sizes(design: Design, zone_half_width: float) -> SectionMesh:
    """Sizes of the section that is extruded: the 3-D ones of the ``[mesh]`` table."""
    mesh, plates = design.mesh, design.plates
    end = max(plates.thickness_mm, _END * mesh.plate_size_mm)
    size = mesh.plate_size_mm
    if plates.model == "solid":
        end = min(size, max(0.5 * plates.thickness_mm, _SOLID_END * size))
        size = min([size, *(frame.length / _ALONG for frame in plate_frames(design))])
    sizes = mesh.section.model_copy(
        update={
            "contact_size_mm": mesh.contact_size_mm,
            "plate_size_mm": size,
            "plate_end_size_mm": end,
            "far_size_mm": mesh.far_size_mm,
            "gradation": min(mesh.gradation, _GRADATION),
        }
    )
    return _fit(sizes, zone_half_width)


def scaled(sizes: SectionMesh, factor: float) -> SectionMesh:
    """The same sizes, every length times ``factor``; coarser ones grow as much faster."""
    names = ("contact_size_mm", "plate_size_mm", "plate_end_size_mm", "far_size_mm")
    lengths = {name: factor * getattr(sizes, name) for name in names}
    steep = max(sizes.gradation, min(_STEEPEST, factor * sizes.gradation))
    return sizes.model_copy(update=lengths | {"gradation": steep})


def inner_of(design: Design, zone: Zone, coarser: float = 1.0) -> Inner | None:
    """Half-width over which an extruded section's contact edges are finest; their length, mm.

    ``coarser`` multiplies that length.
    """
    if zone.inner is None:
        return None
    finest = _INNER_SIZE * extruded_sizes(design, zone.half_width).contact_size_mm
    return zone.inner, coarser * finest


def _fit(sizes: SectionMesh, zone_half_width: float) -> SectionMesh:
    size = contact_size(sizes.contact_size_mm, zone_half_width)
    return sizes.model_copy(update={"contact_size_mm": size})


def section_outline(
    design: Design,
    zone_half_width: float,
    sizes: SectionMesh,
    frames: tuple[PlateFrame, ...],
    inner: Inner | None = None,
) -> Outline:
    """The outline to mesh: the body, its core, plates as boxes or as lines. The plates' domains
    have the numbers of their order in ``frames``."""
    body, gage_length = design.body, design.gages.length_mm
    ends = [(min(zone_half_width, 0.5 * body.width_mm), sizes.contact_size_mm)]
    if inner is not None and inner[0] < ends[0][0]:
        ends.insert(0, inner)
    elif inner is not None:
        ends = [(ends[0][0], inner[1])]
    reaches, edges = zip(*ends, strict=True)
    contact = ContactSizes(reaches, edges, sizes.far_size_mm)
    outline = body_outline(body, contact, sizes, core_box(body, design.core_region))
    for k, frame in enumerate(frames):
        if design.plates.model == "sheet":
            _add_sheet(outline, frame, frames, gage_length, sizes, body)
        else:
            _add_plate(outline, frame, BODY + 1 + k, gage_length, sizes)
    return outline
