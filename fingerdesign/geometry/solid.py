"""Design -> Solid: the body with its pockets, its plates and its core, in CadQuery, conformal.

All go through OpenCASCADE's general fuse without glue, so a plate and the body share the *same*
faces. (Imprinting with glue returns a wrong topology that calls itself valid where plate ends are
coplanar with the body's.) What runs here runs in this process, however long it takes: the mesher's
triangles and the CAD files of a run come from a process with a time limit (solid_process.py).
Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import cadquery as cq

from fingerdesign.design.layout import PlateFrame, plate_frames
from fingerdesign.design.volume import outline_volume
from fingerdesign.errors import GeometryError
from fingerdesign.geometry.bodies import outline_solid
from fingerdesign.geometry.checks import check_volume, core_volume, plate_volume
from fingerdesign.geometry.faces import named_faces
from fingerdesign.geometry.fuse import Fused, fused, said
from fingerdesign.geometry.kernel import volume_of
from fingerdesign.geometry.plates import core_solid, plate_solid

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


@dataclass(frozen=True)
class Solid:
    """A finger as boundary representation, mm.

    body     the elastomer, pockets of plates and core cut out
    plates   the plates, in the order of the frames, sharing their faces with ``body``
    core     the rigid core, sharing its faces with ``body``; None without one
    outline  body, plates and core as one solid, without the faces between them
    faces    the outside by name ("base", "contact" with the edges, "side", "end" but of a revolved
             body, and "symmetry" of a half), ends of plates and core that lie in it included; and
             "plate_0", ..., "core": all faces of each
    half     True: only z >= 0
    """

    body: cq.Solid
    plates: tuple[cq.Solid, ...]
    outline: cq.Solid
    faces: dict[str, tuple[cq.Face, ...]]
    half: bool
    core: cq.Solid | None = None

    @property
    def parts(self) -> tuple[cq.Solid, ...]:
        """The body, the plates and, where there is one, the core."""
        return (self.body, *self.plates, *([] if self.core is None else [self.core]))

    def unique_faces(self) -> tuple[cq.Face, ...]:
        """Every face of body, plates and core, shared ones once."""
        seen: dict[int, list[cq.Face]] = {}
        found: list[cq.Face] = []
        for face in (f for solid in self.parts for f in solid.Faces()):
            bucket = seen.setdefault(face.hashCode(), [])
            if not any(face.isSame(other) for other in bucket):
                bucket.append(face)
                found.append(face)
        return tuple(found)


def build_solid(
    design: Design, half: bool = False, frames: tuple[PlateFrame, ...] | None = None
) -> Solid:
    """Build a finger's solid (or its half z >= 0) and hold it against closed forms.

    frames: the plates to build; by default the design's own (none where ``plates.model`` is
    "none"). Plates that the finite elements see as sheets are solids here: that is how they are
    made. Raises GeometryError where plates or the core cross each other or leave the body, where a
    half is asked of a finger that does not mirror, where the kernel fails, or where a volume
    differs from its closed form by 1e-9 (1e-6: domes, STEP files, perforated bent plates).
    """
    if frames is None:
        frames = plate_frames(design) if design.plates.model != "none" else ()
    step = design.body.step
    if half and step is not None and not step.mirrors_in_z:
        raise GeometryError("body.step.mirrors_in_z is false: build the whole finger")
    try:
        outline = outline_solid(design.body, half)
        plates = {f"plate_{frame.index}": plate_solid(frame, half) for frame in frames}
        core = {} if design.body.core is None else {"core": core_solid(design.body, half)}
        parts = fused(outline, plates | core)
        faces = named_faces(design.body, outline, parts, half)
    except GeometryError:
        raise
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(
            f"the CAD kernel failed to build {design.design.name}: {error}"
        ) from error
    _check_volumes(design, half, frames, outline, parts)
    inserts = [parts.inserts[name] for name in plates]
    return Solid(parts.body, tuple(inserts), outline, faces, half, parts.inserts.get("core"))


def _check_volumes(
    design: Design, half: bool, frames: tuple[PlateFrame, ...], outline: cq.Solid, parts: Fused
) -> None:
    # A dome's ends and the drilled holes of bent plates are bounded by approximated curves.
    loose = design.body.shape == "dome" or design.body.step is not None
    drilled = {f"plate_{f.index}" for f in frames if f.bend_radius is not None and f.holes}
    whole = outline_volume(design.body, half)
    wanted = {f"plate_{frame.index}": plate_volume(frame, half) for frame in frames}
    if design.body.core is not None:
        wanted["core"] = core_volume(design, half)
    check_volume("body outline", volume_of(outline), whole, 1e-6 if loose else 1e-9)
    for name, volume in wanted.items():
        found = volume_of(parts.inserts[name])
        check_volume(said(name), found, volume, 1e-6 if name in drilled else 1e-9)
    rest = whole - sum(wanted.values())
    loose = loose or bool(drilled)
    check_volume("body without its inserts", volume_of(parts.body), rest, 1e-6 if loose else 1e-9)
