"""What native code must never see, and what becomes of a mesher that crashes or hangs."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import fingerdesign.mesh.tetra.tetwild as process
from fingerdesign import parse_design
from fingerdesign.errors import MeshError
from fingerdesign.layout.surface import ContactSurface
from fingerdesign.mesh.measures import cell_volumes
from fingerdesign.mesh.sizing import MeshSizes, SizeField
from fingerdesign.mesh.tetra.tetwild import Attempt, run_tetwild, validate_surface

Surface = tuple[NDArray[np.float64], NDArray[np.int64]]


@pytest.fixture
def cube():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    squares = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    triangles = [t for a, b, c, d in squares for t in ((a, b, c), (a, c, d))]
    return corners, np.array(triangles)


@pytest.fixture
def field():
    body = parse_design('design.name = "t"\nplates.count = 0').body
    return SizeField(ContactSurface.of(body), (), MeshSizes(1.0, 1.0, 1.0, 0.5), 3.0)


def test_unfit_surfaces_are_named(cube):
    vertices, triangles = cube
    validate_surface(vertices, triangles)
    with pytest.raises(MeshError, match="open: 3 edges"):
        validate_surface(vertices, triangles[1:])
    with pytest.raises(MeshError, match="coincident triangles"):
        validate_surface(vertices, np.vstack([triangles, triangles[:1, ::-1]]))
    flat = vertices.copy()
    flat[1] = 0.5 * (vertices[0] + vertices[3])  # on the diagonal 0-3: triangle 0-1-3 has no area
    with pytest.raises(MeshError, match="without area"):
        validate_surface(flat, triangles)


def test_a_mesher_out_of_time_is_ended_and_its_input_kept(cube, field, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    with pytest.raises(
        MeshError, match=r"did not finish in 0.05 s; its input is kept as .*in\.npz"
    ):
        run_tetwild(*cube, field, Attempt(0.01), 0.05)
    (kept,) = tmp_path.glob("*/in.npz")
    with np.load(kept) as data:
        np.testing.assert_allclose(data["vertices"], cube[0] / [1.0, 1.0, field.sizes.stretch])


@pytest.mark.parametrize(
    ("code", "message"),
    [
        ("os.kill(os.getpid(), signal.SIGSEGV)", "ended by SIGSEGV"),
        ("raise ValueError('bad mesh')", "it failed: ValueError: bad mesh"),
    ],
)
def test_a_mesher_that_dies_is_an_error(code, message, cube, field, tmp_path, monkeypatch):
    text = f"import os, signal\n\n\ndef tetrahedralize(**given):\n    {code}\n"
    (tmp_path / "dying_mesher.py").write_text(text)
    monkeypatch.setenv("PYTHONPATH", str(tmp_path))
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    monkeypatch.setattr(process, "TETRAHEDRALISE", "dying_mesher:tetrahedralize")
    with pytest.raises(MeshError, match=message):
        run_tetwild(*cube, field, Attempt(0.01), 30.0)


def test_success_leaves_nothing_behind(cube, field, tmp_path, monkeypatch):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    points, tets = run_tetwild(*cube, field, Attempt(0.05, iterations=10), 60.0)
    assert len(tets) > 0
    assert tets.max() < len(points)
    inside = points[tets].mean(axis=1)
    inside = tets[np.all((inside > 0.0) & (inside < 1.0), axis=1)]
    assert np.abs(cell_volumes(points, inside)).sum() == pytest.approx(1.0, rel=0.05)
    assert list(tmp_path.iterdir()) == []
    assert not Path("__tracked_surface.stl").exists()
