"""A STEP file's one solid, in the CAD kernel (in a process of its own): read, turned, moved.

Importing this module loads the CAD kernel.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from OCP.Bnd import Bnd_Box
from OCP.BRep import BRep_Tool
from OCP.BRepBndLib import BRepBndLib
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepGProp import BRepGProp
from OCP.BRepLib import BRepLib
from OCP.gp import gp_Trsf
from OCP.GProp import GProp_GProps
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID, TopAbs_VERTEX
from OCP.TopExp import TopExp_Explorer
from OCP.TopoDS import TopoDS

from fingerdesign.arrays import Array
from fingerdesign.cad.step_rules import refused

MOST_FACES = 2000  # every node of a mesh asks each face near it
INTEGRALS = 1e-10  # relative error of volumes and areas

# Where the file's axes go, row by row x, y, z of ours; each a rotation.
TURNS = {
    "y": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-y": ((-1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "x": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "-x": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "z": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-z": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
}


def parts(shape: Any, kind: Any, *outside_of: Any) -> Iterator[Any]:
    """Sub-shapes of a kind (not those within another kind), with their orientation."""
    explorer = TopExp_Explorer(shape, kind, *outside_of)
    while explorer.More():
        yield explorer.Current()
        explorer.Next()


def read_solid(path: str, name: str) -> Any:
    """The one valid, closed solid that a STEP file holds, in mm. DesignError says what is wrong."""
    reader = STEPControl_Reader()
    if reader.ReadFile(path) != IFSelect_RetDone:
        raise refused(
            "file", name, "a STEP file", "the CAD kernel cannot read it; export it again as STEP"
        )
    reader.TransferRoots()
    shape = reader.OneShape()
    export = "export the finger's body alone, as one solid"
    if shape is None or shape.IsNull():
        raise refused(
            "file", name, "a STEP file with a solid", f"there is no shape in it; {export}"
        )
    solids = list(parts(shape, TopAbs_SOLID))
    sheets = sum(1 for _ in parts(shape, TopAbs_SHELL, TopAbs_SOLID))
    sheets += sum(1 for _ in parts(shape, TopAbs_FACE, TopAbs_SHELL))
    if len(solids) != 1 or sheets:
        found = f"it holds {len(solids)} solids and {sheets} open surfaces"
        raise refused("file", name, "a STEP file of one solid", f"{found}; {export}")
    solid = TopoDS.Solid_s(solids[0])
    faces = sum(1 for _ in parts(solid, TopAbs_FACE))
    if faces > MOST_FACES:
        remedy = f"it has {faces}; simplify it, or convert a faceted body into surfaces"
        raise refused("file", name, f"a body of at most {MOST_FACES} faces", remedy)
    open_shell = any(not BRep_Tool.IsClosed_s(shell) for shell in parts(solid, TopAbs_SHELL))
    if open_shell or not faces:
        raise refused(
            "file", name, "a closed solid", f"its surface has gaps; close them and {export}"
        )
    if not BRepCheck_Analyzer(solid).IsValid():
        remedy = "the CAD kernel finds faces or edges that do not fit; mend it in your CAD"
        raise refused("file", name, "a valid solid", remedy)
    if volume_of(solid) < 0.0:
        BRepLib.OrientClosedSolid_s(solid)
    if not volume_of(solid) > 0.0:
        raise refused("file", name, "a solid with a volume", f"it encloses nothing; {export}")
    return solid


def volume_of(solid: Any) -> float:
    """Volume, mm^3."""
    found = GProp_GProps()
    # Gauss-Kronrod: the kernel's plain rule is 6e-6 off below a spline, and believes itself.
    BRepGProp.VolumePropertiesGK_s(solid, found, INTEGRALS, False, True, False, False, False)
    return float(found.Mass())


def moved(solid: Any, turn: tuple[tuple[int, int, int], ...], shift: Array) -> Any:
    """The solid turned (rows of a rotation), then shifted (3,) mm; its geometry is a copy."""
    place = gp_Trsf()
    rows = [(*row, float(by)) for row, by in zip(turn, shift, strict=True)]
    place.SetValues(*(float(value) for row in rows for value in row))
    return TopoDS.Solid_s(BRepBuilderAPI_Transform(solid, place, True).Shape())


def box_of(shape: Any) -> tuple[Array, Array]:
    """Corners (3,) of a box that holds a shape, 1e-7 mm wider than it."""
    box = Bnd_Box()
    BRepBndLib.AddOptimal_s(shape, box, False, False)
    values = np.array(box.Get())
    return values[:3], values[3:]


def extent(solid: Any) -> tuple[Array, Array]:
    """Least and greatest coordinates (3,), mm: those of vertices where they are the extremes, else
    to 1e-6 mm: the kernel's box is wider by its tolerance of 1e-7."""
    low, high = (np.round(corner, 6) for corner in box_of(solid))
    corners = [BRep_Tool.Pnt_s(TopoDS.Vertex_s(v)) for v in parts(solid, TopAbs_VERTEX)]
    if corners:
        places = np.array([(p.X(), p.Y(), p.Z()) for p in corners])
        least, most = places.min(axis=0), places.max(axis=0)
        low = np.where(np.abs(low - least) < 1e-5, least, low)
        high = np.where(np.abs(high - most) < 1e-5, most, high)
    return low, high
