"""Design -> Solid: the body with its pockets, its plates and its core, in CadQuery, conformal.

All go through OpenCASCADE's general fuse without glue, so a plate and the body share the *same*
faces. (Imprinting with glue returns a wrong topology that calls itself valid where plate ends are
coplanar with the body's.) What runs here runs in this process, however long it takes: the mesher's
triangles and the CAD files of a run come from a process with a time limit (solid_process.py).
Importing this module loads the CAD kernel.
"""

from collections.abc import Set
from dataclasses import dataclass

import cadquery as cq
from OCP.BOPAlgo import BOPAlgo_Builder
from OCP.TopTools import TopTools_IndexedMapOfShape

from fingerdesign.cad.bodies import core_solid, outline_solid, plate_solid
from fingerdesign.cad.kernel import volume_of
from fingerdesign.design.schema import Design
from fingerdesign.errors import GeometryError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import check_volume, core_volume, outline_volume, plate_volume


def fused(outline: cq.Solid, inserts: dict[str, cq.Solid]) -> tuple[cq.Solid, dict[str, cq.Solid]]:
    """Bond ``inserts`` into a body's ``outline``: what they leave of it and each of them by name,
    solids that meet in shared faces.

    GeometryError where two inserts overlap or one leaves the body (they are named), where the
    inserts cut the body in pieces, or where the kernel fails.
    """
    if not inserts:
        return outline, {}
    fuse = BOPAlgo_Builder()
    for shape in (outline, *inserts.values()):
        fuse.AddArgument(shape.wrapped)
    fuse.Perform()
    if fuse.HasErrors():
        raise GeometryError("the CAD kernel could not fuse the plates into the body")
    numbers = TopTools_IndexedMapOfShape()  # pieces by what they are, in any orientation
    inside = {numbers.Add(piece.wrapped): piece for piece in _images(fuse, outline)}
    pieces = {
        name: [numbers.Add(piece.wrapped) for piece in _images(fuse, insert)]
        for name, insert in inserts.items()
    }
    _refuse_overlaps(pieces, inside.keys())
    taken = {own[0] for own in pieces.values()}
    rest = [piece for number, piece in inside.items() if number not in taken]
    if len(rest) != 1:
        raise GeometryError(f"the inserts cut the body into {len(rest)} pieces; it must be one")
    return rest[0], {name: inside[own[0]] for name, own in pieces.items()}


def spoken(name: str) -> str:
    """Name of a part in a sentence: "plate 0" for "plate_0"."""
    return name.replace("_", " ")


def _refuse_overlaps(pieces: dict[str, list[int]], inside: Set[int]) -> None:
    """GeometryError unless each insert is one piece of its own within the body."""
    for name, own in pieces.items():
        sharing = [other for other in pieces if other != name and set(pieces[other]) & set(own)]
        if sharing:
            raise GeometryError(f"{spoken(name)} and {spoken(sharing[0])} overlap")
    for name, own in pieces.items():
        if not set(own) <= inside:
            raise GeometryError(f"{spoken(name)} leaves the body")
        if len(own) != 1:
            raise GeometryError(f"{spoken(name)} is in {len(own)} pieces; it must be one")


def _images(fuse: BOPAlgo_Builder, shape: cq.Shape) -> list[cq.Shape]:
    """Images of a shape: its pieces, or itself where the fuse left it alone."""
    return [cq.Shape.cast(image) for image in fuse.Modified(shape.wrapped)] or [shape]


@dataclass(frozen=True)
class Solid:
    """A finger as boundary representation, mm.

    body     the elastomer, pockets of plates and core cut out
    plates   the plates, in the order of the frames, sharing their faces with ``body``
    core     the rigid core, sharing its faces with ``body``; None without one
    outline  body, plates and core as one solid, without the faces between them
    half     True: only z >= 0
    """

    body: cq.Solid
    plates: tuple[cq.Solid, ...]
    outline: cq.Solid
    half: bool
    core: cq.Solid | None = None

    @property
    def parts(self) -> tuple[cq.Solid, ...]:
        """The body, the plates and, where there is one, the core."""
        return (self.body, *self.plates, *([] if self.core is None else [self.core]))


def build_solid(
    design: Design, half: bool = False, frames: tuple[PlateFrame, ...] | None = None
) -> Solid:
    """Build a finger's solid (or its half z >= 0) and hold it against closed forms.

    frames: the plates to build; by default the design's own (none where ``plates.model`` is
    "none"). Plates that the finite elements see as sheets are solids here: that is how they are
    made. Raises GeometryError where plates or the core cross each other or leave the body, where a
    half is requested of a finger that does not mirror, where the kernel fails, or where a volume
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
        body, inserts = fused(outline, plates | core)
    except GeometryError:
        raise
    except Exception as error:  # the kernel throws its own kinds
        raise GeometryError(
            f"the CAD kernel failed to build {design.design.name}: {error}"
        ) from error
    _check_volumes(design, half, frames, outline, body, inserts)
    own = tuple(inserts[name] for name in plates)
    return Solid(body, own, outline, half, inserts.get("core"))


def _check_volumes(
    design: Design,
    half: bool,
    frames: tuple[PlateFrame, ...],
    outline: cq.Solid,
    body: cq.Solid,
    inserts: dict[str, cq.Solid],
) -> None:
    # A dome's ends and the drilled holes of bent plates are bounded by approximated curves.
    loose = design.body.dome_radius_mm is not None or design.body.step is not None
    drilled = {f"plate_{f.index}" for f in frames if f.bend_radius is not None and f.holes}
    whole = outline_volume(design.body, half)
    target = {f"plate_{frame.index}": plate_volume(frame, half) for frame in frames}
    if design.body.core is not None:
        target["core"] = core_volume(design, half)
    check_volume("body outline", volume_of(outline), whole, 1e-6 if loose else 1e-9)
    for name, volume in target.items():
        found = volume_of(inserts[name])
        check_volume(spoken(name), found, volume, 1e-6 if name in drilled else 1e-9)
    rest = whole - sum(target.values())
    loose = loose or bool(drilled)
    check_volume("body without its inserts", volume_of(body), rest, 1e-6 if loose else 1e-9)
