"""``fingerdesign mesh``: what it writes, and its exit codes."""

import json
from pathlib import Path

import pytest
from fingerdesign_cli.mesh import ENDINGS

from fingerdesign.mesh.files.io import read_named
from tests.support.fingers import SMALL


@pytest.fixture
def design(tmp_path):
    path = tmp_path / "small.toml"
    path.write_text(SMALL)
    return path


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fidelity", "dimension", "pictures"),
    [("plane-strain", 2, ["mesh.png", "quality.png"]), ("3d", 3, [])],  # one drawing is enough
)
def test_mesh_and_report_are_written(fidelity, dimension, pictures, design, tmp_path, terminal):
    out = tmp_path / "out"
    options = ["--fidelity", fidelity, "--quiet", "--json"]
    options += [each for ending in ENDINGS for each in ("--format", ending)]
    options += [] if pictures else ["--no-picture"]
    printed = json.loads(terminal("mesh", design, "--out", out, *options).out)
    meshes = {f"mesh.{ending}" for ending in ENDINGS}
    names = meshes | {"quality.txt", "quality.json", *pictures}
    assert {path.name for path in out.iterdir()} == names
    assert {Path(path).name for path in printed["files"]} == names
    report = json.loads((out / "quality.json").read_text())
    assert report["dimension"] == dimension
    assert report["min_dihedral_deg"] == printed["min_dihedral_deg"]
    for name in meshes:
        mesh = read_named(out / name)
        quadratic = (1, 6) if dimension == 2 else (3, 10)  # prisms are read as tetrahedra
        assert mesh.cells.shape == (quadratic[0] * report["elements"], quadratic[1])
        assert mesh.dimension == dimension
    for name in pictures:
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    assert set(report["size_ratio"]) == {"contact", "plates", "rest"}
    assert max(report["surface_distance_mm"].values()) < 1e-9
    assert f"{report['elements']}" in (out / "quality.txt").read_text()


@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ("mesh.contact_size = 1.0", "mesh.contact_size"),
        # A section that analyse refuses is not meshed.
        ('plates.along = "z"\nplates.cover_mm = 4.0', "plates.along = z: must be 'x'"),
        ('mesh.mesher = "file"\nmesh.file = "wrong.toml"', "which reads no mesh.file"),
    ],
)
def test_a_wrong_design_is_bad_input(lines, words, tmp_path, terminal):
    path, out = tmp_path / "wrong.toml", tmp_path / "out"
    path.write_text(f'design.name = "wrong"\nplates.count = 1\n{lines}\n')
    assert words in terminal("mesh", path, "--out", out, "--fidelity", "plane-strain", code=2).err
    assert not out.exists()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--format", "foo"], "one of vtu"),
        (["--out", "small.toml"], "--out = small.toml: must be a folder"),
        (["--out", ""], "--out = '': must be a path that is not empty"),
        (["--out", "small.toml/x"], "small.toml is a file"),
        (["--out", "dangling/x"], "dangling is a link to nothing"),
        (["--out", "n" * 300], "must be a folder that can be written into"),
        pytest.param(
            ["--out", "/proc/x"],
            "must be a folder that can be written into",
            marks=pytest.mark.skipif(not Path("/proc/self").exists(), reason="no /proc here"),
        ),
        (["--scene", "fundamentel"], "did you mean fundamental"),
    ],
)
def test_wrong_options_are_refused_before_any_meshing(
    options, words, design, in_tmp_path, terminal
):
    Path("dangling").symlink_to("nothing")
    assert words in terminal("mesh", design, "--out", "out", *options, code=2).err
    assert not (design.parent / "out").exists()


def test_a_mesh_made_elsewhere_is_read_next_to_its_design(design, tmp_path, in_tmp_path, terminal):
    out = tmp_path / "out"
    options = ["--no-picture", "--quiet", "--format", "inp", "--format", "inp"]
    terminal("mesh", design, "--out", out, *options)
    assert not (out / "quality.png").exists()
    own = out / "again.toml"
    own.write_text(SMALL.replace('"sweep"', '"file"\nmesh.file = "mesh.inp"'))
    report = json.loads(
        terminal("mesh", own, "--out", tmp_path / "again", *options[:2], "--json").out
    )
    assert report["mesher"] == "file"
    assert "mesh.inp" in report["remarks"][0]
    assert report["volumes"]["plate_0"]["error"] < 1e-9
    (out / "mesh.inp").unlink()
    assert "mesh.file" in terminal("mesh", own, "--out", tmp_path / "third", code=2).err
    assert not (tmp_path / "third").exists()


def test_files_of_the_users_own_are_not_written_over(in_tmp_path, tmp_path, terminal):
    """A mesh goes into the very folder that is named, a drawing next to others."""
    (tmp_path / "mine").mkdir()
    for name, line in (
        ("quality.txt", "mesh tees --fidelity plane-strain --no-picture"),
        ("tees.svg", "view tees"),
        ("paper.html", "paper --design tees"),
    ):
        own = tmp_path / "mine" / name
        own.write_text("precious", "utf-8")
        refused = terminal(*line.split(), "--out", "mine", code=2).err
        assert f"a folder without {name}, which no command has written" in refused
        assert own.read_text("utf-8") == "precious"
        own.unlink()
    terminal("view", "tees", "--out", "mine")
    terminal("view", "tees", "--out", "mine")  # its own is drawn again


def test_a_mesh_is_not_written_over_the_one_that_its_design_names(in_tmp_path, tmp_path, terminal):
    (tmp_path / "mine").mkdir()
    (tmp_path / "mine" / "quality.json").write_text("{}", "utf-8")
    (tmp_path / "mine" / "mesh.msh").write_text("precious", "utf-8")
    text = 'design.name = "own"\n[mesh]\nmesher = "file"\nfile = "mine/mesh.msh"\n'
    (tmp_path / "own.toml").write_text(text, "utf-8")
    refused = terminal("mesh", "own.toml", "--format", "msh", "--out", "mine", code=2).err
    assert "without the design's own mesh.file" in refused
    assert (tmp_path / "mine" / "mesh.msh").read_text("utf-8") == "precious"
