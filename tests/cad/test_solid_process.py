"""The CAD kernel in a process: the same answers, and its failures named."""

import subprocess
import sys
from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from fingerdesign.cad import solid_process
from fingerdesign.cad.export import enclosed_volume
from fingerdesign.cad.solid import build_solid
from fingerdesign.cad.solid_process import finger_triangles, write_finger_cad
from fingerdesign.cad.triangles import triangulate
from fingerdesign.checks.load import with_values
from fingerdesign.design import step as facts_module
from fingerdesign.design.body import StepFile
from fingerdesign.design.step import step_facts
from fingerdesign.errors import DesignError, GeometryError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.layout.volume import outline_volume
from fingerdesign.runtime.isolate import call
from tests.support.calls import vtk_modules
from tests.support.steps import write


def test_triangles_are_those_of_this_process(design_of):
    design = design_of("arc", "perforated", "a bone")
    frames = plate_frames(design)[1:2]
    parts, outside = finger_triangles(design, 0.02, False, frames)
    solid = build_solid(design, frames=frames)
    for found, wanted in zip(parts, triangulate(solid.parts, 0.02), strict=True):
        np.testing.assert_array_equal(found, wanted)
    assert enclosed_volume(*outside) == pytest.approx(outline_volume(design.body), rel=3e-3)


def test_files_are_written_from_a_process(design_of, tmp_path):
    files = write_finger_cad(design_of("block", "along z", "a backing"), tmp_path / "cad")
    assert set(files) == {"finger.step", "finger.stl", "body.stl", "plates.stl", "core.stl"}
    assert all(path.stat().st_size > 500 for path in files.values())


@pytest.mark.slow
def test_most_of_vtk_is_loaded_where_a_name_of_it_is_used():
    few, all_of_them = call(vtk_modules, time_s=60.0)
    assert few < 0.3 * all_of_them


def test_files_are_built_again_for_another_shape_only(design_of, own_cache, tmp_path, calls_of):
    design, builds = design_of("arc", "full span"), calls_of(solid_process, "concurrently")
    first = write_finger_cad(design, tmp_path / "first")
    same = {"design.name": "other", "grip.friction_coefficients": [0.4], "mesh.far_size_mm": 1.5}
    again = write_finger_cad(with_values(design, same), tmp_path / "again")
    assert len(builds) == 1
    for key, value in (("body.depth_mm", 11.0), ("plates.cover_mm", 1.7)):
        write_finger_cad(with_values(design, {key: value}), tmp_path / key)
    assert len(builds) == 3
    assert {name: path.read_bytes() for name, path in again.items()} == {
        name: path.read_bytes() for name, path in first.items()
    }
    for path in (tmp_path / "cad").iterdir():
        path.write_bytes(b"garbled")
    built = write_finger_cad(design, tmp_path / "built")
    assert built["finger.stl"].read_bytes() == first["finger.stl"].read_bytes()


@pytest.mark.slow
def test_what_cannot_be_built_or_does_not_come_back_is_reported(design_of, monkeypatch):
    design = design_of("arc", "full span")
    frames = tuple(replace(frame, place=0.1 * frame.index) for frame in plate_frames(design))
    with pytest.raises(GeometryError, match="plate 0 and plate 1 overlap"):
        finger_triangles(design, 0.02, False, frames)
    monkeypatch.setattr(solid_process, "TIME_LIMIT_S", 0.001)
    with pytest.raises(GeometryError, match=r"did not finish in 0\.001 s"):
        finger_triangles(design, 0.02, False, ())
    words = "import sys, fingerdesign.cad.solid_process as p; sys.exit('OCP' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", words], check=False).returncode == 0


@pytest.fixture
def brick(tmp_path, own_cache):
    """A STEP file of 20 x 12 x 10 mm that has not been read."""
    work = cq.Workplane("XY").box(20, 12, 10).translate((0, 6, 0))
    return StepFile(file=str(write(work, tmp_path / "b.step")))


@pytest.mark.parametrize(
    ("name", "value", "error", "words"),
    [
        ("TIME_LIMIT_S", 0.001, DesignError, r"body\.step\.file.*did not finish in 0.001 s"),
        *(
            ("READ", f"tests.support.calls:{reader}", GeometryError, r"b\.step .*now: .*try again")
            for reader in ("read_killed", "read_on_a_full_disk")
        ),
    ],
)
def test_a_failure_of_the_machine_is_not_reported_as_the_files(
    name, value, error, words, brick, monkeypatch
):
    """A reader that takes too long is the file's fault; what it read later counts."""
    with monkeypatch.context() as patch:
        patch.setattr(facts_module, "call", call)  # a fresh process, for it is ended
        patch.setattr(facts_module, name, value)
        with pytest.raises(error, match=words):
            step_facts(brick)
    if error is DesignError:
        facts_module._outcome.cache_clear()
    assert step_facts(brick).volume == pytest.approx(2400)
