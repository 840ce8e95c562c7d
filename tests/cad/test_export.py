"""STEP and STL files: parts by name, watertight at an absolute chord tolerance, whole or not."""

import cadquery as cq
import meshio
import numpy as np
import pytest

from fingerdesign.cad.export import (
    check_watertight,
    enclosed_volume,
    write_cad,
    write_step,
    write_stl,
)
from fingerdesign.cad.kernel import volume_of
from fingerdesign.cad.triangles import triangulate
from fingerdesign.errors import GeometryError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import core_volume, outline_volume, plate_volume


def read_stl(path):
    found = meshio.read(path)
    points, inverse = np.unique(found.points.astype(float), axis=0, return_inverse=True)
    return points, inverse.reshape(-1)[found.cells_dict["triangle"]]


KINDS = [
    ("revolved", "", ""),
    ("arc, rounded", "bent, perforated", ""),
    ("arc", "full span", "standing on the base"),
]


@pytest.mark.parametrize("kinds", KINDS)
def test_files_of_body_plates_and_core(kinds, design_of, solid_of, tmp_path):
    design = design_of(*kinds)
    files = write_cad(solid_of(*kinds), tmp_path, chord_tolerance_mm=0.01)
    metal = sum(plate_volume(frame) for frame in plate_frames(design))
    core = core_volume(design)
    volumes = {"finger.stl": outline_volume(design.body)}
    volumes["body.stl"] = volumes["finger.stl"] - metal - core
    volumes |= {"plates.stl": metal} if metal else {}
    volumes |= {"core.stl": core} if core else {}
    assert set(files) == {"finger.step", *volumes}
    assert {path.name for path in tmp_path.iterdir()} == set(files)  # nothing left aside
    for name, wanted in volumes.items():
        points, triangles = read_stl(files[name])
        check_watertight(name, points, triangles)
        # Chords of plates as thin as these, bent and drilled, take a little more off.
        assert enclosed_volume(points, triangles) == pytest.approx(wanted, rel=4e-3)


def test_step_is_an_assembly_of_named_parts(solid_of, tmp_path):
    solid = solid_of(*KINDS[-1])
    path = write_step(solid, tmp_path / "finger.step")
    names = ["body", "plate_0", "plate_1", "plate_2", "core"]
    text = path.read_text()
    assert all(f"'{name}'" in text for name in names)
    solids = cq.importers.importStep(str(path)).solids().vals()
    assert len(solids) == len(names)
    for part, read in zip(solid.parts, solids, strict=True):
        assert read.isValid()
        assert volume_of(read) == pytest.approx(volume_of(part), rel=1e-7)


def test_holes_and_wrong_winding_are_found():
    points, triangles = triangulate([cq.Workplane().box(1, 1, 1).val()], 0.01)
    check_watertight("box", points, triangles)
    assert enclosed_volume(points, triangles) == pytest.approx(1.0)
    with pytest.raises(GeometryError, match="exactly two triangles"):
        check_watertight("box", points, triangles[1:])
    turned = triangles.copy()
    turned[0] = turned[0, ::-1]
    with pytest.raises(GeometryError, match="wound against"):
        check_watertight("box", points, turned)


def test_a_file_that_cannot_be_written_or_has_no_solid_is_an_error(tmp_path):
    target = tmp_path / "missing" / "finger.stl"
    with pytest.raises(GeometryError, match="could not be written"):
        write_stl([cq.Workplane().box(1, 1, 1).val()], target, 0.01)
    with pytest.raises(GeometryError, match="no solid"):
        write_stl([], tmp_path / "plates.stl", 0.01)
