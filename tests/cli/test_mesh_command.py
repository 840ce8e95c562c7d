"""``fingerdesign mesh``: what it writes, and its exit codes."""

from __future__ import annotations

import json
from pathlib import Path

import pytest
from fingerdesign_cli.main import main

from fingerdesign.mesh.io import read_mesh

DESIGN = """
design.name = "small"
body.width_mm = 12.0
body.base_height_mm = 5.0
body.depth_mm = 6.0
plates.count = 1
plates.thickness_mm = 0.3
mesh.mesher = "extrude"
mesh.layers = 2
mesh.contact_size_mm = 1.0
mesh.plate_size_mm = 1.0
"""


@pytest.fixture
def design(tmp_path: Path) -> Path:
    path = tmp_path / "small.toml"
    path.write_text(DESIGN)
    return path


@pytest.mark.parametrize(("fidelity", "dimension"), [("plane-strain", 2), ("3d", 3)])
def test_mesh_report_and_picture_are_written(
    fidelity: str, dimension: int, design: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    options = ["--fidelity", fidelity, "--format", "vtu", "--format", "msh", "--quiet", "--json"]
    assert main(["mesh", str(design), "--out", str(out), *options]) == 0
    printed = json.loads(capsys.readouterr().out)
    names = {"mesh.vtu", "mesh.msh", "quality.txt", "quality.json", "mesh.png"}
    assert {path.name for path in out.iterdir()} == names
    assert {Path(path).name for path in printed["files"]} == names
    report = json.loads((out / "quality.json").read_text())
    assert report["dimension"] == dimension
    assert report["min_dihedral_deg"] == printed["min_dihedral_deg"]
    for name in ("mesh.vtu", "mesh.msh"):
        mesh = read_mesh(out / name)
        assert len(mesh.cells) == report["elements"]
        assert mesh.dimension == dimension
    assert (out / "mesh.png").read_bytes().startswith(b"\x89PNG")
    assert f"{report['elements']}" in (out / "quality.txt").read_text()


def test_a_wrong_design_is_bad_input(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "wrong.toml"
    path.write_text('design.name = "wrong"\nmesh.contact_size = 1.0\n')
    assert main(["mesh", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "mesh.contact_size" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_an_unknown_format_fails(
    design: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["mesh", str(design), "--out", str(tmp_path / "out"), "--fidelity", "plane-strain"]
    assert main([*arguments, "--format", "nonsense", "--quiet"]) == 1
    assert "could not write" in capsys.readouterr().err
