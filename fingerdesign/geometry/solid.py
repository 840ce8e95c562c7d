"""Design -> Solid: the body with its plate pockets and the plates, in CadQuery, conformal.

Body and plates go through OpenCASCADE's general fuse without glue, so a plate and the body share
the *same* faces. (Imprinting with glue returns a wrong topology that calls itself valid where plate
ends are coplanar with the body's.) Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cadquery as cq
import numpy as np
from OCP.BOPAlgo import BOPAlgo_Builder

from fingerdesign.design.checks import tetwild_faults
from fingerdesign.design.layout import PlateFrame, crest_height, plate_frames
from fingerdesign.design.volume import outline_volume
from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.geometry.checks import (
    check_clearances,
    check_volume,
    plate_volume,
)
from fingerdesign.geometry.surface import ContactSurface

if TYPE_CHECKING:
    from fingerdesign.design.schema import Body, Design

FACE_NAMES = ("base", "contact", "side", "end", "symmetry")


@dataclass(frozen=True)
class Solid:
    """A finger as boundary representation, mm.

    body     the elastomer, plate pockets cut out
    plates   the plates, in the order of the design, sharing their faces with ``body``
    outline  body and plates as one solid, without the plates' faces
    faces    the outside by name ("base", "contact", "side", "end", and "symmetry" of a half), plate
             ends that lie in it included; and "plate_0", ...: all faces of each plate
    half     True: only z >= 0
    """

    body: cq.Solid
    plates: tuple[cq.Solid, ...]
    outline: cq.Solid
    faces: dict[str, tuple[cq.Face, ...]]
    half: bool

    def unique_faces(self) -> tuple[cq.Face, ...]:
        """Every face of body and plates, shared ones once."""
        seen: dict[int, list[cq.Face]] = {}
        found: list[cq.Face] = []
        for face in (f for solid in (self.body, *self.plates) for f in solid.Faces()):
            bucket = seen.setdefault(face.hashCode(), [])
            if not any(face.isSame(other) for other in bucket):
                bucket.append(face)
                found.append(face)
        return tuple(found)


def solid_plates(design: Design) -> tuple[PlateFrame, ...]:
    """Frames of the plates that tetwild meshes as solids; none where ``plates.model`` is "none".

    Raises DesignError for plates as sheets.
    """
    faults = tetwild_faults(design)
    if faults:
        raise DesignError(faults, design.design.name)
    return plate_frames(design) if design.plates.model != "none" else ()


def build_solid(design: Design, half: bool = False) -> Solid:
    """Build a finger's solid (or its half z >= 0) and hold it against closed forms.

    Plates that the finite elements see as sheets are boxes here: that is how they are made. Raises
    GeometryError where plates cross each other or leave the body, where the kernel fails, or where
    a volume differs from its closed form by 1e-9 (arc, plates) or 1e-6 (dome).
    """
    frames = plate_frames(design) if design.plates.model != "none" else ()
    check_clearances(design, frames)
    try:
        outline = _outline(design.body, half)
        boxes = [_plate(frame, half) for frame in frames]
        body, plates = _fuse(outline, boxes)
    except GeometryError:
        raise
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(
            f"the CAD kernel failed to build {design.design.name}: {error}"
        ) from error
    tolerance = 1e-9 if design.body.dome_radius_mm is None else 1e-6
    whole = outline_volume(design.body, half)
    metal = [plate_volume(frame, half) for frame in frames]
    check_volume("body outline", outline.Volume(), whole, tolerance)
    check_volume("body without its plates", body.Volume(), whole - sum(metal), tolerance)
    for frame, plate, volume in zip(frames, plates, metal, strict=True):
        check_volume(f"plate {frame.index}", plate.Volume(), volume, 1e-9)
    return Solid(body, plates, outline, _name_faces(design.body, body, plates, half), half)


def _outline(body: Body, half: bool) -> cq.Solid:
    ContactSurface.of(body)  # refuses shapes without one
    width, height, depth = body.width_mm, body.base_height_mm, body.depth_mm
    crest = crest_height(body)
    low = 0.0 if half else -0.5 * depth
    length = 0.5 * depth - low
    start = cq.Workplane("XY", origin=(0, 0, low)).moveTo(-width / 2, 0).lineTo(width / 2, 0)
    if body.dome_radius_mm is None:
        section = start.lineTo(width / 2, height).threePointArc((0, crest), (-width / 2, height))
        return _one_solid(section.close().extrude(length), "body outline")
    block = start.lineTo(width / 2, crest + 1).lineTo(-width / 2, crest + 1).close().extrude(length)
    return _one_solid(block.cut(_above_dome(body)), "body outline")


def _above_dome(body: Body) -> cq.Workplane:
    """The space above the torus patch: the space above the arc, revolved about the dome's axis."""
    width, height, dome = body.width_mm, body.base_height_mm, float(body.dome_radius_mm or 0.0)
    crest = crest_height(body)
    reach = dome - (crest - height)  # the least radius of revolution, at the sides
    if reach <= 0.5 * body.depth_mm:
        raise GeometryError(
            f"body.dome_radius_mm = {dome} is too small: at the sides the dome would end inside "
            f"the depth; it must exceed {crest - height + 0.5 * body.depth_mm:.6g}"
        )
    angle = 0.5 * (np.arcsin(0.5 * body.depth_mm / reach) + 0.5 * np.pi)
    top = crest + (dome + 2.0) / np.cos(angle)
    beyond = 0.5 * width + 1.0
    section = (
        cq.Workplane("XY")
        .moveTo(-beyond, height)
        .lineTo(-width / 2, height)
        .threePointArc((0, crest), (width / 2, height))
        .lineTo(beyond, height)
        .lineTo(beyond, top)
        .lineTo(-beyond, top)
        .close()
    )
    axis = ((0.0, crest - dome, 0.0), (1.0, crest - dome, 0.0))
    sweep = float(np.degrees(2 * angle))
    return section.revolve(sweep, *axis).rotate(*axis, -0.5 * sweep)


def _plate(frame: PlateFrame, half: bool) -> cq.Solid:
    low = 0.0 if half else frame.low
    box = cq.Workplane("XY").box(
        frame.length, frame.thickness, frame.high - low, centered=(True, True, False)
    )
    turned = box.rotate((0, 0, 0), (0, 0, 1), frame.angle_deg)
    return _one_solid(turned.translate((frame.x, frame.y, low)), f"plate {frame.index}")


def _one_solid(work: cq.Workplane, what: str) -> cq.Solid:
    solids = work.solids().vals()
    if len(solids) != 1 or not solids[0].isValid():
        raise GeometryError(f"{what}: the CAD kernel made {len(solids)} solids, or an invalid one")
    return solids[0]


def _fuse(outline: cq.Solid, boxes: list[cq.Solid]) -> tuple[cq.Solid, tuple[cq.Solid, ...]]:
    if not boxes:
        return outline, ()
    fuse = BOPAlgo_Builder()
    for shape in (outline, *boxes):
        fuse.AddArgument(shape.wrapped)
    fuse.Perform()
    if fuse.HasErrors():
        raise GeometryError("the CAD kernel could not fuse the plates into the body")
    parts = {s.hashCode(): s for s in cq.Shape.cast(fuse.Shape()).Solids()}
    plates = []
    for index, box in enumerate(boxes):
        images = [cq.Shape.cast(shape) for shape in fuse.Modified(box.wrapped)] or [box]
        if len(images) != 1 or images[0].hashCode() not in parts:
            raise GeometryError(f"plate {index} crosses another plate or leaves the body")
        plates.append(parts.pop(images[0].hashCode()))
    if len(parts) != 1:
        raise GeometryError(f"the plates cut the body into {len(parts)} pieces; one is wanted")
    return next(iter(parts.values())), tuple(plates)


def _name_faces(
    body: Body, elastomer: cq.Solid, plates: tuple[cq.Solid, ...], half: bool
) -> dict[str, tuple[cq.Face, ...]]:
    named: dict[str, list[cq.Face]] = {
        name: [] for name in FACE_NAMES if half or name != "symmetry"
    }
    shared = [face for plate in plates for face in plate.Faces()]
    for index, plate in enumerate(plates):
        named[f"plate_{index}"] = list(plate.Faces())
    ends = 0.5 * body.depth_mm
    for face in [*elastomer.Faces(), *shared]:
        if face.geomType() != "PLANE":
            named["contact"].append(face)
            continue
        box = face.BoundingBox(1e-7)
        if box.ylen < 1e-5 and abs(box.ymin) < 1e-5:
            named["base"].append(face)
        elif box.xlen < 1e-5 and abs(abs(box.xmin) - 0.5 * body.width_mm) < 1e-5:
            named["side"].append(face)
        elif box.zlen < 1e-5 and half and abs(box.zmin) < 1e-5:
            named["symmetry"].append(face)
        elif box.zlen < 1e-5 and abs(abs(box.zmin) - ends) < 1e-5:
            named["end"].append(face)
    for name in ("base", "contact", "side", "end"):
        if not named[name]:
            raise GeometryError(f"no face of the body was recognised as its {name!r} face")
    return {name: tuple(faces) for name, faces in named.items()}
