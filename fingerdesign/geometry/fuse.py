"""Body and inserts made conformal: OpenCASCADE's general fuse, and what became of each part.

Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import dataclass

import cadquery as cq
from OCP.BOPAlgo import BOPAlgo_Builder
from OCP.TopTools import TopTools_IndexedMapOfShape

from fingerdesign.errors import GeometryError


@dataclass(frozen=True)
class Fused:
    """Solids that meet in shared faces.

    body     what the inserts leave of the outline
    inserts  by name, each one solid inside the outline
    outer    each face of the outline, in its own order, as the pieces that the inserts' ends make
             of it (itself where none ends in it)
    """

    body: cq.Solid
    inserts: dict[str, cq.Solid]
    outer: tuple[tuple[cq.Face, ...], ...]


def fused(outline: cq.Solid, inserts: dict[str, cq.Solid]) -> Fused:
    """Bond ``inserts`` into a body's ``outline``.

    GeometryError where two inserts overlap or one leaves the body (they are named), where the
    inserts cut the body in pieces, or where the kernel fails.
    """
    if not inserts:
        return Fused(outline, {}, tuple((face,) for face in outline.Faces()))
    fuse = BOPAlgo_Builder()
    for shape in (outline, *inserts.values()):
        fuse.AddArgument(shape.wrapped)
    fuse.Perform()
    if fuse.HasErrors():
        raise GeometryError("the CAD kernel could not fuse the plates into the body")
    numbers = TopTools_IndexedMapOfShape()  # pieces by what they are, whatever their orientation
    inside = {numbers.Add(piece.wrapped): piece for piece in _images(fuse, outline)}
    pieces = {
        name: [numbers.Add(piece.wrapped) for piece in _images(fuse, insert)]
        for name, insert in inserts.items()
    }
    _refuse_overlaps(pieces, inside.keys())
    taken = {own[0] for own in pieces.values()}
    rest = [piece for number, piece in inside.items() if number not in taken]
    if len(rest) != 1:
        raise GeometryError(f"the inserts cut the body into {len(rest)} pieces; one is wanted")
    outer = tuple(tuple(_images(fuse, face)) for face in outline.Faces())
    found = {name: inside[own[0]] for name, own in pieces.items()}
    return Fused(rest[0], found, outer)


def said(name: str) -> str:
    """How a sentence calls a part: "plate 0" for "plate_0"."""
    return name.replace("_", " ")


def _refuse_overlaps(pieces: dict[str, list[int]], inside: Set[int]) -> None:
    """GeometryError unless each insert is one piece of its own within the body."""
    for name, own in pieces.items():
        sharing = [other for other in pieces if other != name and set(pieces[other]) & set(own)]
        if sharing:
            raise GeometryError(f"{said(name)} and {said(sharing[0])} overlap")
    for name, own in pieces.items():
        if not set(own) <= inside:
            raise GeometryError(f"{said(name)} leaves the body")
        if len(own) != 1:
            raise GeometryError(f"{said(name)} is in {len(own)} pieces; one is wanted")


def _images(fuse: BOPAlgo_Builder, shape: cq.Shape) -> list[cq.Shape]:
    """What became of a shape: its pieces, or itself where the fuse left it alone."""
    return [cq.Shape.cast(image) for image in fuse.Modified(shape.wrapped)] or [shape]
