"""Built -> MoldMeshes and files: triangles of each solid, STL and STEP of each, one assembly; mm.

Vertices are rounded to the single precision of STL: what is checked is what is written. Importing
this module loads the CAD kernel.
"""

from dataclasses import replace
from pathlib import Path

import cadquery as cq
import numpy as np
from OCP.BRepGProp import BRepGProp
from OCP.GProp import GProp_GProps

from fingerdesign.cad.export import Rgba, check_whole_step, write_assembly, write_triangles
from fingerdesign.cad.kernel import volume_of
from fingerdesign.cad.triangles import merge_vertices, triangulate_measured
from fingerdesign.mold.cad.build import Built, BuiltPart, build_mold
from fingerdesign.mold.cad.coupon import build_coupon
from fingerdesign.mold.cad.mount import build_mount
from fingerdesign.mold.part import FINGER, RUBBER, MoldMeshes, PartMesh, colour_of
from fingerdesign.mold.plan.patterns import flat_patterns
from fingerdesign.mold.plan.plan import MoldPlan

ASSEMBLY = "assembly.step"
ROUNDING_MM = 1e-5  # more than single precision takes from places within 100 mm
ADAPTIVE = (1e-3, 1e-6, 1e-9)  # tolerances that the kernel's adaptive rule is given
AGREED = 1e-6  # of the volume: the most by which its three answers may differ
ANGLE_RAD = 0.17  # of a chord of a round hole: a wall full of holes keeps its volume to 1e-3


def meshed(part: BuiltPart, chord_mm: float) -> PartMesh:
    """A part's triangles within ``chord_mm`` of its solid; vertices are distinct as STL has them.

    GeometryError where the kernel yields none or does not keep the chord.
    """
    vertices, triangles, chord = triangulate_measured([part.solid], chord_mm, ANGLE_RAD)
    single = merge_vertices(vertices.astype(np.float32).astype(np.float64), triangles)
    volume = blank = part_volume(part.solid)
    if part.blank is not None and part.blank is not part.solid:
        blank = part_volume(part.blank)
    return PartMesh(part.name, *single, part.draw, part.order, part.made, volume, chord, blank)


def part_volume(solid: cq.Shape) -> float:
    """Volume of a part, mm^3, good to 1e-6 of it.

    On extruded faces that curves trim, Gauss-Kronrod's rule takes seconds. There the adaptive rule
    is used thrice, ever finer: below splines with breaks it is 1e-4 off, and its answers differ.
    """
    if any(face.geomType() == "EXTRUSION" for face in solid.Faces()):
        found = []
        for share in ADAPTIVE:
            whole = GProp_GProps()
            BRepGProp.VolumeProperties_s(solid.wrapped, whole, share, False, True)
            found.append(float(whole.Mass()))
        if max(found) - min(found) <= AGREED * abs(found[-1]):
            return found[-1]
    return volume_of(solid)


def write_files(plan: MoldPlan, built: Built, meshes: MoldMeshes, folder: Path) -> None:
    """Write NAME.stl and NAME.step of each part, of each different plate ("plate_A", ... as of
    ``flat_patterns``) and of the finger's rubber, and assembly.step.

    GeometryError where triangles are not watertight or enclose another volume than their solid.
    """
    solids = {p.name: p.solid for p in (*built.parts, *built.coupon, *built.plates, built.rubber)}
    laid = (*meshes.parts, *meshes.coupon, *meshes.plates, meshes.rubber)
    sources = {part.name: part.name for part in (*built.parts, *built.coupon)}
    sources[FINGER] = RUBBER
    for pattern in flat_patterns(plan):
        sources[pattern.name] = f"plate_{pattern.plates[0]}"
    for name, source in sources.items():
        solid, mesh = solids[source], next(each for each in laid if each.name == source)
        slack = (mesh.chord + ROUNDING_MM) * float(solid.Area())
        write_triangles(mesh.vertices, mesh.triangles, folder / f"{name}.stl", mesh.volume, slack)
        solid.exportStep(str(folder / f"{name}.step"))
        check_whole_step(folder / f"{name}.step")
    every = (*built.parts, *built.plates, built.rubber)
    named = ((part.name, part.solid, _rgba(part.name)) for part in every)
    write_assembly("mold", named, folder / ASSEMBLY)


def _rgba(name: str) -> Rgba:
    """A part's colour as the kernel has it; the rubber is translucent."""
    colour = colour_of(name)
    red, green, blue = (int(colour[k : k + 2], 16) / 255.0 for k in (1, 3, 5))
    return red, green, blue, 0.45 if name == RUBBER else 1.0


def build_and_write(plan: MoldPlan, folder: Path) -> MoldMeshes:
    """Build a planned mold, write its files into ``folder``; its triangles."""
    built = replace(build_mold(plan), coupon=(*build_coupon(plan), *build_mount(plan)))
    meshes = built.each(lambda part: meshed(part, plan.design.mold.chord_mm))
    write_files(plan, built, meshes, folder)
    return meshes
