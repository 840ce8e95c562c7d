"""The finger is drawn without a display; surfaces are closed; failures are named."""

import dataclasses
import io
import os

import numpy as np
import pytest

import fingerdesign.analysis.page.picture as picture_module
from fingerdesign.analysis.analysis import Analysis
from fingerdesign.analysis.page.picture import PictureJob, gage_quads, surface
from fingerdesign.errors import PictureError
from fingerdesign.records.arrays import FieldHistory, GageLayout

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


def test_surface_of_a_section_closes_around_its_volume(plane_strain):
    mesh = plane_strain.mesh
    every = np.ones(len(mesh.cells), dtype=bool)
    wanted = 10.0 * cells_volume(mesh, every)
    assert drawn(mesh, every).volume == pytest.approx(wanted, rel=1e-5)  # VTK's single precision


def test_surface_of_a_half_model_is_that_of_the_whole(solid):
    mesh = solid.mesh
    every = np.ones(len(mesh.cells), dtype=bool)
    found = drawn(mesh, every)
    assert found.volume == pytest.approx(2 * cells_volume(mesh, every))
    assert found.points[:, 2].min() == pytest.approx(-5.0)


@pytest.mark.parametrize(("face", "count"), [("upper", 1), ("lower", 1), ("both", 2)])
def test_gages_lie_on_the_faces_that_carry_them(plane_strain, face, count):
    plate = plane_strain.plates[3]
    quads = gage_quads((plate,), GageLayout(1.2, 0.8, 0.5, face))
    assert quads.shape == (count, 4, 3)
    local = plate.local(quads.reshape(-1, 3))
    assert np.ptp(local[:, 0]) == pytest.approx(1.2)
    assert np.ptp(quads[..., 2]) == pytest.approx(0.8)
    assert quads[..., 2].mean() == pytest.approx(0.5)
    if face != "both":
        assert np.all(np.sign(local[:, 1]) == (1 if face == "upper" else -1))
    assert np.all(np.abs(local[:, 1]) > 0.05)


@pytest.mark.parametrize("which", ["plane_strain", "solid"])
def test_pictures_are_drawn_without_a_display(which, request, monkeypatch):
    from PIL import Image

    monkeypatch.delenv("DISPLAY", raising=False)
    with PictureJob(request.getfixturevalue(which)) as job:
        pictures = job.pictures()
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
    with (
        PictureJob(plane_strain, time_limit_s=0.01) as job,
        pytest.raises(PictureError, match="longer than"),
    ):
        job.pictures()
    monkeypatch.setattr(picture_module, "draw", os.abort)
    with (
        PictureJob(plane_strain) as job,
        pytest.raises(PictureError, match=r"the drawing process failed: it failed: TypeError"),
    ):
        job.pictures()


def test_what_does_not_move_is_not_coloured(plane_strain):
    fields = FieldHistory((3,), 1e-13 * plane_strain.fields.displacement[-1:])
    still = dataclasses.replace(
        plane_strain,
        fields=fields,
        mesh=dataclasses.replace(plane_strain.mesh, regions=0 * plane_strain.mesh.regions),
        plates=(),
    )
    job = PictureJob(still)
    assert list(job.words) == ["inside"]
    assert "in increment 4 nothing moves it" in job.words["inside"]
    assert "no plates inside it" in job.words["inside"]


def test_no_mesh_no_picture(failed):
    with pytest.raises(PictureError, match="no mesh"):
        PictureJob(failed)


def test_a_field_of_another_mesh_is_refused(plane_strain, solid):
    mixed = Analysis(plane_strain.result, mesh=plane_strain.mesh, fields=solid.fields)
    with pytest.raises(PictureError, match="does not belong"):
        PictureJob(mixed)
