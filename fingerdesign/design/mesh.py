"""The ``[mesh]`` table: the mesher, element sizes and limits, or a mesh made elsewhere."""

import hashlib
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field
from pydantic_core import PydanticCustomError

from fingerdesign.design.base import Named, Table, bounded, key, refuse_key, table_fields
from fingerdesign.errors import Fault
from fingerdesign.runtime.registry import MESHERS

_LOOK_BYTES = 4096  # of a mesh file: without anything in them it is empty
MOST_BYTES = 1_000_000_000  # of a mesh that a user brings: ten million tetrahedra


class SectionMesh(Table):
    """``[mesh.section]``: element edges of the plane-strain mesh, mm."""

    contact_size_mm: float = bounded(0.05, 1e-3, 50, "at the crest")
    plate_size_mm: float = bounded(0.05, 1e-3, 50, "along the plates")
    plate_end_size_mm: float = bounded(0.03, 1e-3, 50, "at the plates' square, singular ends")
    far_size_mm: float = bounded(0.5, 1e-2, 100, "largest anywhere")
    gradation: float = bounded(0.3, 0.02, 2, "growth of the size per distance, at most")


class MeshOptions(Table):
    """Mesh of the 3-D finger; ``section`` is for plane strain."""

    mesher: Annotated[str, Named(MESHERS)] = key(
        "tetwild",
        "tetwild (any finger) | sweep (a section swept through layers) | file (made "
        "elsewhere) | auto (sweep where it can be, else tetwild)",
    )
    file: str | None = key(
        None,
        "mesher = 'file' only: tetrahedra with named regions (elastomer, plate_0, ..., "
        "core) and boundaries (base, contact); relative to the design file or absolute",
        min_length=1,
        max_length=4096,
        examples=["finger.msh"],
    )
    contact_size_mm: float = bounded(0.4, 1e-2, 50, "at the crest")
    plate_size_mm: float = bounded(0.4, 1e-2, 50, "along the plates")
    far_size_mm: float = bounded(2.0, 1e-2, 100, "largest anywhere")
    gradation: float = bounded(0.7, 0.02, 2, "growth of the size per distance")
    element: Literal["auto", "P1", "P2", "mixed"] = key(
        "auto", "auto (by the body's Poisson's ratio) | P2 | mixed (with a pressure) | P1"
    )
    layers: int | None = bounded(
        None,
        1,
        200,
        "swept layers in half the depth; absent: as the finger's height asks",
        example=4,
    )
    layer_growth: float = bounded(
        1.15, 0.5, 2, "a layer's height over the next one's toward the end; < 1: thinnest at z = 0"
    )
    time_limit_s: float = bounded(120.0, 1, 36_000, "for one attempt of the mesher")
    attempts: int = bounded(4, 1, 20, "before the mesher gives up")
    section: SectionMesh = Field(default_factory=SectionMesh)

    def _misfits(self) -> Iterator[PydanticCustomError]:
        if self.mesher == "file" and self.file is None:
            bound = "given where mesh.mesher = 'file'"
            yield refuse_key(self, "mesh.file", bound, "add it: the mesh's file")
        if self.mesher != "file" and self.file is not None:
            bound = f"absent where mesh.mesher = '{self.mesher}'"
            yield refuse_key(self, "mesh.file", bound, "remove it or set mesh.mesher = 'file'")


table_fields(MeshOptions, MESHERS, before="section")


def mesh_file_faults(options: MeshOptions) -> list[Fault]:
    """The fault of a ``mesh.file`` that cannot be read, before anything is made of it."""
    if options.file is None:
        return []
    path = Path(options.file)
    try:
        if path.is_file():
            if (size := path.stat().st_size) > MOST_BYTES:
                read, bound = f"{size / 1e9:.1f} GB", f"at most {MOST_BYTES / 1e9:g} GB"
                return [Fault("mesh.file", read, bound, "write a coarser mesh, or a binary file")]
            with path.open("rb") as file:
                if file.read(_LOOK_BYTES).strip():
                    return []
            remedy = "write it again: it is empty"
            return [Fault("mesh.file", options.file, "a mesh file with nodes and cells", remedy)]
        why = "it is no ordinary file" if path.exists() else "there is none"
    except (OSError, ValueError) as error:
        why = error.strerror or "it cannot be read" if isinstance(error, OSError) else "not a path"
    return [Fault("mesh.file", options.file, "a readable mesh file", f"correct the path: {why}")]


def mesh_file_digest(name: str) -> str:
    """SHA-256 of a mesh file's content, in hexadecimal; "absent" where it cannot be read."""
    try:
        with Path(name).open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except (OSError, ValueError):
        return "absent"
