"""STEP and STL files: parts by name, watertight at an absolute chord tolerance, whole or not."""

from __future__ import annotations

from pathlib import Path

import cadquery as cq
import numpy as np
import pytest
from numpy.typing import NDArray

from fingerdesign import parse_design
from fingerdesign.design.layout import plate_frames
from fingerdesign.design.schema import Design
from fingerdesign.design.volume import outline_volume
from fingerdesign.errors import GeometryError
from fingerdesign.geometry.checks import (
    plate_volume,
)
from fingerdesign.geometry.export import check_watertight, enclosed_volume, write_cad, write_stl
from fingerdesign.geometry.solid import build_solid
from fingerdesign.geometry.surface import ContactSurface
from fingerdesign.geometry.tessellation import merge_vertices, triangulate

CASES = ["plates.count = 3", 'plates.count = 0\nbody.shape = "dome"\nbody.dome_radius_mm = 12.0']


def read_stl(path: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    content = path.read_bytes()
    count = int.from_bytes(content[80:84], "little")
    assert len(content) == 84 + 50 * count
    record = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
    corners = np.frombuffer(content, record, offset=84)["corners"].astype(float).reshape(-1, 3)
    points, inverse = np.unique(corners, axis=0, return_inverse=True)
    return points, inverse.reshape(-1, 3)


def design_of(keys: str) -> Design:
    return parse_design(f'design.name = "t"\n{keys}')


@pytest.mark.parametrize("keys", CASES)
def test_files_are_watertight_and_true_to_the_design(keys: str, tmp_path: Path) -> None:
    design = design_of(keys)
    files = write_cad(build_solid(design), tmp_path, chord_tolerance_mm=0.01)
    metal = sum(plate_volume(frame) for frame in plate_frames(design))
    volumes = {"finger.stl": outline_volume(design.body)}
    volumes["body.stl"] = volumes["finger.stl"] - metal
    if metal:
        volumes["plates.stl"] = metal
    assert set(files) == {"finger.step", *volumes}
    assert {path.name for path in tmp_path.iterdir()} == set(files)  # nothing left aside
    for name, wanted in volumes.items():
        points, triangles = read_stl(files[name])
        check_watertight(name, points, triangles)
        assert enclosed_volume(points, triangles) == pytest.approx(wanted, rel=1e-3)


def test_the_chord_tolerance_is_absolute(tmp_path: Path) -> None:
    design = design_of("plates.count = 0")
    surface = ContactSurface.of(design.body)
    solid = build_solid(design)
    for tolerance in (0.05, 0.01, 0.002):
        points, triangles = read_stl(write_stl([solid.outline], tmp_path / "finger.stl", tolerance))
        middles = points[triangles].mean(axis=1)
        top = np.abs(surface.distance(points[triangles].reshape(-1, 3))).reshape(-1, 3) < 1e-5
        chord = -surface.distance(middles[top.all(axis=1)])
        assert 0.0 < chord.max() <= tolerance


def test_step_is_an_assembly_of_named_parts(tmp_path: Path) -> None:
    design = design_of("plates.count = 3")
    path = write_cad(build_solid(design), tmp_path)["finger.step"]
    text = path.read_text()
    for name in ("body", "plate_0", "plate_1", "plate_2"):
        assert f"'{name}'" in text
    solids = cq.importers.importStep(str(path)).solids().vals()
    assert len(solids) == 4
    assert sum(s.Volume() for s in solids) == pytest.approx(outline_volume(design.body), rel=1e-6)


def test_a_half_is_not_exported(tmp_path: Path) -> None:
    with pytest.raises(GeometryError, match="whole finger"):
        write_cad(build_solid(design_of("plates.count = 0"), half=True), tmp_path)


def test_holes_and_wrong_winding_are_found() -> None:
    points, triangles = triangulate([cq.Workplane().box(1, 1, 1).val()], 0.01)
    check_watertight("box", points, triangles)
    assert enclosed_volume(points, triangles) == pytest.approx(1.0)
    with pytest.raises(GeometryError, match="exactly two triangles"):
        check_watertight("box", points, triangles[1:])
    turned = triangles.copy()
    turned[0] = turned[0, ::-1]
    with pytest.raises(GeometryError, match="wound against"):
        check_watertight("box", points, turned)


def test_a_failed_write_leaves_the_old_file(tmp_path: Path) -> None:
    target = tmp_path / "missing" / "finger.stl"
    with pytest.raises(GeometryError, match="could not be written"):
        write_stl([cq.Workplane().box(1, 1, 1).val()], target, 0.01)
    with pytest.raises(GeometryError, match="no solid"):
        write_stl([], tmp_path / "plates.stl", 0.01)


def test_near_vertices_become_one() -> None:
    base = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    doubled = np.vstack([base, base + 3e-9])
    points, triangles = merge_vertices(doubled, np.array([[0, 1, 2], [3, 4, 5], [0, 3, 1]]))
    assert len(points) == 3
    assert len(triangles) == 2  # the third has collapsed
