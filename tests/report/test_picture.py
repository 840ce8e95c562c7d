"""The finger is drawn without a display; surfaces are closed; failures are named."""

import dataclasses
import io
import os

import numpy as np
import pytest

import fingerdesign.analysis.page.picture as picture_module
from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.folder import centroid_strain, write_fields
from fingerdesign.analysis.page.gage import plate_rows, strain_figure
from fingerdesign.analysis.page.picture import cast, drawing_of, gage_quads, pictures_of, surface
from fingerdesign.analysis.page.words import finger_words
from fingerdesign.design.schema import Gages
from fingerdesign.errors import PictureError
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.records.arrays import FieldHistory
from fingerdesign.report.style import house_style

# pyvista says that a default of extract_surface will be another one.
pytestmark = pytest.mark.filterwarnings("ignore:The default value of `algorithm`")


def drawn(mesh, chosen, depth=10.0):
    """The chosen cells' surface, closed or its volume would be another."""
    flat = mesh.dimension == 2
    scene = {"points": mesh.points, "cells": mesh.corners, "half": mesh.symmetric}
    found = surface(scene | {"depth": depth if flat else 0.0}, chosen)
    assert found.is_manifold
    return found.compute_normals(consistent_normals=True, auto_orient_normals=True)


def cells_volume(mesh, chosen):
    corners = mesh.points[mesh.corners[chosen]]
    edges = corners[:, 1:] - corners[:, :1]
    return float(np.abs(np.linalg.det(edges)).sum() / (2 if mesh.dimension == 2 else 6))


def test_surfaces_of_a_section_and_of_a_half_model_are_the_whole_finger_s(plane_strain, solid):
    # 10 mm deep, in VTK's single precision; two halves
    for mesh, times, within in ((plane_strain.mesh, 10.0, 1e-5), (solid.mesh, 2.0, 1e-6)):
        every = np.ones(len(mesh.cells), dtype=bool)
        found = drawn(mesh, every)
        wanted = times * cells_volume(mesh, every)
        assert found.volume == pytest.approx(wanted, rel=within)
        assert found.points[:, 2].min() == pytest.approx(-5.0)


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_pictures_are_drawn_without_a_display(which, request, monkeypatch):
    from PIL import Image

    monkeypatch.delenv("DISPLAY", raising=False)
    with pictures_of(request.getfixturevalue(which)) as waited:
        pictures = waited()
    assert list(pictures) == ["inside", "deformed"]
    for picture in pictures.values():
        assert len(picture.png) < 300_000
        pixels = np.asarray(Image.open(io.BytesIO(picture.png)).convert("RGBA"))
        drawn = pixels[..., 3] > 0
        assert 0.2 < drawn.mean() < 0.9
        assert not drawn[:, [0, -1]].any(), "cut off at the side"
        assert not drawn[[0, -1]].any(), "cut off at the top or the bottom"
        assert len(np.unique(pixels[drawn].reshape(-1, 4), axis=0)) > 100
    assert "15 plates" in pictures["inside"].alternative
    moved = np.linalg.norm(request.getfixturevalue(which).fields.displacement[-1], axis=1)
    assert pictures["deformed"].scale_mm == pytest.approx(moved.max(), rel=0.02)


def test_a_crash_and_a_hang_are_named(plane_strain, monkeypatch):
    late = pictures_of(plane_strain, time_limit_s=0.01)
    with late as waited, pytest.raises(PictureError, match="longer than"):
        waited()
    monkeypatch.setattr(picture_module, "draw", os.abort)
    with pictures_of(plane_strain) as waited, pytest.raises(PictureError, match="TypeError"):
        waited()


def test_what_does_not_move_is_not_coloured(plane_strain):
    mesh = plane_strain.mesh
    bare = dataclasses.replace(mesh, regions=0 * mesh.regions)
    fields = FieldHistory((3,), 1e-13 * plane_strain.fields.displacement[-1:])
    still = dataclasses.replace(plane_strain, fields=fields, mesh=bare, plates=())
    _, words = drawing_of(still)
    assert list(words) == ["inside"]
    assert "in increment 4 nothing moves it" in words["inside"]
    assert "no plates inside it" in words["inside"]


def test_what_cannot_be_drawn_is_refused(plane_strain, solid, failed):
    mixed = Analysis(plane_strain.result, mesh=plane_strain.mesh, fields=solid.fields)
    for analysis, words in ((failed, "no mesh"), (mixed, "does not belong")):
        with pytest.raises(PictureError, match=words):
            drawing_of(analysis)


GAGES = Gages(width_mm=0.6, z_mm=0.2)
FLAT = PlateFrame(0, 0.5, 3.0, 30.0, 2.0, 0.1, -0.5, 2.5)
ALONG_Z = PlateFrame(1, 0.7, 3.0, 40.0, 2.0, 0.1, -1.0, 0.6, along="z")
BENT = PlateFrame(2, 0.5, 3.0, 20.0, 2.0, 0.1, -0.5, 2.5, bend_radius=3.0)


@pytest.mark.parametrize(("face", "sides"), [("upper", {1}), ("lower", {-1}), ("both", {-1, 1})])
@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, BENT])
def test_gages_are_drawn_on_the_faces_that_carry_them(frame, face, sides):
    quads = gage_quads((frame,), GAGES.model_copy(update={"face": face})).reshape(-1, 3)
    s, v = frame.local(quads).T
    across = frame.across(quads) - frame.middle
    assert np.allclose(np.abs(v), 0.07)
    assert set(np.sign(v)) == sides
    assert np.abs(s).max() == pytest.approx(0.5)
    assert (across.min(), across.max()) == pytest.approx((-0.1, 0.5))


@pytest.mark.parametrize("frame", [FLAT, ALONG_Z, BENT])
def test_plates_are_drawn_closed_and_outward(frame):
    """The plate's own volume, to VTK's single precision: no triangle is missing or turned."""
    rings = [tuple(frame.to_space(frame.outline(), end) for end in (frame.low, frame.high))]
    (drawn,) = cast({"rings": rings})
    drawn = drawn.compute_normals(consistent_normals=True, auto_orient_normals=True)
    volume = abs(drawn.volume)
    wanted = frame.length * frame.thickness * frame.span
    assert volume == pytest.approx(wanted, rel=2e-3 if frame.bend_radius else 1e-5)


def test_rows_are_distinguished():
    row = [dataclasses.replace(FLAT, index=k, place=float(k)) for k in range(3)]
    deep = [dataclasses.replace(FLAT, index=3 + k, place=float(k), y=1.0) for k in range(2)]
    across = [dataclasses.replace(ALONG_Z, index=5 + k, place=3.0 + k) for k in range(2)]
    assert plate_rows([*row, *deep, *across]) == ((0, 1, 2), (3, 4), (5, 6))
    assert plate_rows(row[::-1], placed=True) == ((0, 1, 2),)
    assert plate_rows([]) == ()


def test_a_row_along_z_is_drawn_over_z(plane_strain):
    """Two rows, two pairs of panels, each over the direction along which its plates differ."""
    plates = list(plane_strain.plates)
    for k in range(10, 15):
        plates[k] = dataclasses.replace(ALONG_Z, index=k, place=float(k - 12))
    with house_style():
        image = strain_figure(plane_strain.result, plates).image
        plain = strain_figure(plane_strain.result, plane_strain.plates).image
    for words, in_plain in (("plate centre x (mm)", True), ("plate centre z (mm)", False)):
        assert words in image
        assert (words in plain) is in_plain
    assert "Row 2." in image


def test_a_core_is_its_own_region(plane_strain):
    mesh = plane_strain.mesh
    regions = np.where(mesh.points[mesh.cells[:, 0], 1] < 2.0, 16, mesh.regions)
    cored = dataclasses.replace(mesh, regions=regions, region_names={16: "core"})
    assert np.array_equal(cored.parts["core"], regions == 16)
    assert np.array_equal(cored.parts["plates"], (regions > 0) & (regions < 16))
    assert not mesh.parts["core"].any()


@pytest.mark.parametrize(
    ("changes", "said"),
    [
        ({}, "20 mm wide, 10 mm deep, with an arc of radius 20 mm"),
        ({"body.edge_radius_mm": 2.0}, "rounded with a radius of 2 mm"),
        ({"body.edge_radius_mm": 1.5, "body.edge": "chamfer"}, "chamfered by 1.5 mm"),
        ({"body.shape": "revolved"}, "20 mm across, with a round cap of radius 20 mm"),
        ({"body.shape": "dome", "body.dome_radius_mm": 25.0}, "20 mm in x and 25 mm in z"),
        ({"body.shape": "step", "body.width_mm": 20.0}, "own STEP file, 20 mm wide and 10 mm deep"),
        ({"body.core.width_mm": 6.0, "body.core.height_mm": 3.0}, "6 mm wide, 3 mm high"),
        ({"plates.rows": [{"along": "z", "count": 4}]}, "; 4 plates in a row along z, 2 mm below"),
        ({"plates.placement": [[0.0, 1.0, 2.0]]}, "Inside: 1 plate placed one by one."),
        ({"plates.count": 0}, "It has no plates."),
        ({"plates.follow": "bent", "plates.hole_diameter_mm": 0.6}, "holes 0.6 mm across"),
    ],
)
def test_the_finger_in_words(plane_strain, changes, said):
    assert said in finger_words(plane_strain.result.parameters | changes)


def bent(mesh):
    """The mesh with its mid-edge nodes moved off the edges' middles."""
    corners = np.unique(mesh.corners)
    points = mesh.points.copy()
    free = np.ones(len(points), dtype=bool)
    free[corners] = False
    points[free] += np.random.default_rng(1).normal(scale=0.002, size=(free.sum(), points.shape[1]))
    return dataclasses.replace(mesh, points=points)


def known_strain(gradient):
    """xx, yy, zz, xy, xz, yz (engineering shear) of a constant 3 x 3 gradient, microstrain."""
    g = 1e6 * gradient
    shear = [g[0, 1] + g[1, 0], g[0, 2] + g[2, 0], g[1, 2] + g[2, 1]]
    return np.array([g[0, 0], g[1, 1], g[2, 2], *shear])


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_linear_displacement_gives_its_strain_on_curved_cells(which, request):
    mesh = bent(request.getfixturevalue(which).mesh)
    gradient = np.zeros((3, 3))
    d = mesh.dimension
    gradient[:d, :d] = np.random.default_rng(0).normal(scale=1e-3, size=(d, d))
    strain = centroid_strain(mesh, mesh.points @ gradient[:d, :d].T)
    assert np.allclose(strain, known_strain(gradient), rtol=0, atol=1e-6)


def test_quadratic_displacement_is_exact_at_the_centroid(plane_strain):
    mesh = plane_strain.mesh
    x, y = mesh.points.T
    displacement = np.stack([1e-4 * x * y, 1e-4 * x**2], axis=1)
    cx, cy = mesh.points[mesh.corners].mean(axis=1).T
    strain = centroid_strain(mesh, displacement)
    assert np.allclose(strain[:, 0], 100 * cy, atol=1e-6)
    assert np.allclose(strain[:, 3], 300 * cx, atol=1e-6)
    assert not strain[:, [2, 4, 5]].any()


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_files_open_in_pyvista_with_all_they_hold(which, request, tmp_path):
    import pyvista

    analysis = request.getfixturevalue(which)
    some = FieldHistory((0, 7), analysis.fields.displacement[[0, 7]])
    paths = write_fields(tmp_path, analysis.mesh, some)
    assert [path.name for path in paths] == ["fields_01.vtu", "fields_08.vtu"]
    grid = pyvista.read(paths[1])
    mesh = analysis.mesh
    assert set(grid.celltypes) == {22 if mesh.dimension == 2 else 24}  # VTK's quadratic cells
    assert np.array_equal(grid.cell_data["region"], mesh.regions)
    moved = grid.point_data["displacement_mm"]
    assert moved.shape == (len(mesh.points), 3)
    assert np.allclose(moved[:, : mesh.dimension], some.displacement[1], atol=1e-6)
    strain = centroid_strain(mesh, some.displacement[1])
    for column, part in enumerate(("xx", "yy", "zz", "xy", "xz", "yz")):
        values = grid.cell_data[f"strain_{part}_microstrain"]
        assert np.allclose(values, strain[:, column], rtol=1e-5, atol=1e-3)
    # Straight-edged here, so VTK's own idea of each mid-edge node must be where ours is.
    volumes = grid.compute_cell_sizes(length=False, area=True, volume=True)
    size = volumes["Area" if mesh.dimension == 2 else "Volume"]
    corners = mesh.points[mesh.corners]
    exact = np.linalg.det(corners[:, 1:] - corners[:, :1]) / (2 if mesh.dimension == 2 else 6)
    assert np.allclose(size, exact, rtol=1e-6, atol=1e-12)


def test_without_fields_the_mesh_alone_is_written(plane_strain, tmp_path):
    import meshio

    (path,) = write_fields(tmp_path, plane_strain.mesh, None)
    assert path.name == "fields_mesh.vtu"
    assert np.array_equal(meshio.read(path).cells[0].data, plane_strain.mesh.cells)


def test_fields_of_another_mesh_are_refused(plane_strain, solid, tmp_path):
    with pytest.raises(ValueError, match="not of the mesh"):
        write_fields(tmp_path, plane_strain.mesh, solid.fields)
