"""A STEP file -> a body whose faces numpy computes with (step_faces.py); in a process of its own.

Importing this module loads the CAD kernel.
"""

import hashlib
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from OCP.BRep import BRep_Tool
from OCP.BRepBuilderAPI import BRepBuilderAPI_Transform
from OCP.BRepCheck import BRepCheck_Analyzer
from OCP.BRepLib import BRepLib
from OCP.BRepTools import BRepTools
from OCP.gp import gp_Trsf
from OCP.IFSelect import IFSelect_RetDone
from OCP.STEPControl import STEPControl_Reader
from OCP.TopAbs import TopAbs_FACE, TopAbs_SHELL, TopAbs_SOLID, TopAbs_VERTEX
from OCP.TopoDS import TopoDS

from fingerdesign.arrays import Array
from fingerdesign.cad.step_faces import box_of, describe, groups, middle, parts, triple, volume_of
from fingerdesign.cad.step_rules import check_body, check_mirror, named, on_base, picks, refused
from fingerdesign.runtime.cache import packed
from fingerdesign.runtime.files import scratch

MOST_FACES = 2000  # every node of a mesh is compared with each face near it
_EXPORT = "export the finger's body alone, as one solid"
# Where the file's axes go, row by row x, y, z of ours; each a rotation.
TURNS = {
    "y": ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
    "-y": ((-1, 0, 0), (0, -1, 0), (0, 0, 1)),
    "x": ((0, -1, 0), (1, 0, 0), (0, 0, 1)),
    "-x": ((0, 1, 0), (-1, 0, 0), (0, 0, 1)),
    "z": ((1, 0, 0), (0, 0, 1), (0, -1, 0)),
    "-z": ((1, 0, 0), (0, 0, -1), (0, 1, 0)),
}


def read_solid(path: str, name: str) -> Any:
    """The one valid, closed solid of a STEP file, in mm. DesignError names what is wrong."""
    reader = STEPControl_Reader()
    if reader.ReadFile(path) != IFSelect_RetDone:
        remedy = "the CAD kernel cannot read it; export it again as STEP"
        raise refused("file", name, "a STEP file", remedy)
    reader.TransferRoots()
    solid = _one_solid(reader.OneShape(), name)
    faces = len(list(parts(solid, TopAbs_FACE)))
    if faces > MOST_FACES:
        remedy = f"it has {faces}; simplify it, or convert a faceted body into surfaces"
        raise refused("file", name, f"a body of at most {MOST_FACES} faces", remedy)
    if not faces or not all(map(BRep_Tool.IsClosed_s, parts(solid, TopAbs_SHELL))):
        remedy = f"its surface has gaps; close them and {_EXPORT}"
        raise refused("file", name, "a closed solid", remedy)
    if not BRepCheck_Analyzer(solid).IsValid():
        remedy = "the CAD kernel finds faces or edges that do not fit; mend it in your CAD"
        raise refused("file", name, "a valid solid", remedy)
    if volume_of(solid) < 0.0:
        BRepLib.OrientClosedSolid_s(solid)
    if not volume_of(solid) > 0.0:
        raise refused("file", name, "a solid with a volume", f"it encloses nothing; {_EXPORT}")
    return solid


def _one_solid(shape: Any, name: str) -> Any:
    """The only solid of a shape that has no open surface. DesignError for another shape."""
    if shape is None or shape.IsNull():
        remedy = f"there is no shape in it; {_EXPORT}"
        raise refused("file", name, "a STEP file with a solid", remedy)
    solids = list(parts(shape, TopAbs_SOLID))
    sheets = [*parts(shape, TopAbs_SHELL, TopAbs_SOLID), *parts(shape, TopAbs_FACE, TopAbs_SHELL)]
    if len(solids) != 1 or sheets:
        found = f"it holds {len(solids)} solids and {len(sheets)} open surfaces"
        raise refused("file", name, "a STEP file of one solid", f"{found}; {_EXPORT}")
    return TopoDS.Solid_s(solids[0])


def moved(solid: Any, turn: tuple[tuple[int, int, int], ...], shift: Array) -> Any:
    """The solid turned (rows of a rotation), then shifted (3,) mm; its geometry is a copy."""
    place = gp_Trsf()
    rows = [(*row, float(by)) for row, by in zip(turn, shift, strict=True)]
    place.SetValues(*(float(value) for row in rows for value in row))
    return TopoDS.Solid_s(BRepBuilderAPI_Transform(solid, place, True).Shape())


def extent(solid: Any) -> tuple[Array, Array]:
    """Least and greatest coordinates (3,), mm: those of vertices where they are the extremes, else
    to 1e-6 mm: the kernel's box is wider by its tolerance of 1e-7."""
    low, high = (np.round(corner, 6) for corner in box_of(solid))
    corners = [BRep_Tool.Pnt_s(TopoDS.Vertex_s(v)) for v in parts(solid, TopAbs_VERTEX)]
    if corners:
        places = np.array([triple(place) for place in corners])
        least, most = places.min(axis=0), places.max(axis=0)
        low = np.where(np.abs(low - least) < 1e-5, least, low)
        high = np.where(np.abs(high - most) < 1e-5, most, high)
    return low, high


def read_body(
    file: str, name: str, rules: dict[str, Any]
) -> tuple[dict[str, Any], dict[str, NDArray[Any]], bytes]:
    """Read, turn, name, move, describe a body: its facts in plain values, its faces as numpy
    computes with them, and its solid as BREP.

    file: the path; name: what to call it; rules: ``[body.step]``. Raises DesignError for a file
    that will not do.
    """
    solid = moved(read_solid(file, name), TURNS[rules["up"]], np.zeros(3))
    low, high = extent(solid)
    found = [describe(TopoDS.Face_s(face), name) for face in parts(solid, TopAbs_FACE)]
    shift = -on_base(found, low, rules)
    if rules["centre"]:
        sideways = -0.5 * (low + high) * np.array([1.0, 0.0, 1.0])
        # The kernel's extents are good to 1e-7: a body modelled about its middle stays exact.
        shift += np.where(np.abs(sideways) > 1e-6, sideways, 0.0)
    if shift.any():
        solid = moved(solid, TURNS["y"], shift)
        low, high = low + shift, high + shift
    faces = [TopoDS.Face_s(face) for face in parts(solid, TopAbs_FACE)]
    found = [describe(face, name) for face in faces]
    middles = np.array([middle(face) for face in faces])
    where = zip(found, middles[:, None], strict=True)
    normals = np.array([face.normal(place)[0] for face, place in where])
    names = named(found, *picks(found, middles, normals, rules), low, high)
    own = zip(found, names, groups(faces, found), strict=True)
    found = [replace(face, name=word, group=group) for face, word, group in own]
    check_body(found, low, high, name)
    if rules["mirrors_in_z"]:
        check_mirror(found, name)
    arrays: dict[str, NDArray[Any]] = {}
    about = packed(tuple(found), arrays)
    with scratch("step") as folder:
        outline = folder / "outline.brep"
        if not BRepTools.Write_s(solid, str(outline)):
            raise OSError("the CAD kernel could not write outline.brep")
        brep = outline.read_bytes()
    words = {"faces": about, "volume": volume_of(solid), "low": list(low), "high": list(high)}
    words["outline"] = hashlib.sha256(brep).hexdigest()
    return words, arrays, brep
