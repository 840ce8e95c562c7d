"""``new`` and ``check`` through ``main``, exit codes, and how light ``--help`` is."""

import json
import os
import subprocess
import sys
import tempfile
from pathlib import Path

import click
import pytest
from fingerdesign_bench.any_finger.step_samples import sample_step
from fingerdesign_cli import main as cli_main
from fingerdesign_cli.terminal import progress

from fingerdesign.errors import FingerDesignError
from tests.support.steps import read_here

ROOT = Path(__file__).parents[2]


@pytest.fixture(autouse=True)
def _in_an_empty_folder(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)


@pytest.mark.parametrize("name", [None, "homogeneous", "narrow", "domed", "pin", "boned"])
def test_new_then_check(name, said):
    said("new", "sub/mine.toml", *(["--from", name] if name else []), "-q")
    assert "mine" in said("check", "sub/mine.toml").out
    assert Path("sub/design.schema.json").is_file()


def test_new_scene_then_check(said):
    said("new", "mine.toml", "--scene")
    said("check", "narrow", "--scene", "mine.toml")
    schema = json.loads(Path("scene.schema.json").read_text())
    text = Path("mine.toml").read_text()
    assert text.startswith("#:schema ./scene.schema.json\n")
    for table in schema["properties"].values():
        name = table.get("$ref", "").rsplit("/", 1)[-1] or table["allOf"][0]["$ref"][8:]
        for key in schema["$defs"][name]["properties"]:
            assert f"{key} = " in text
    assert not Path("design.schema.json").exists()


@pytest.mark.parametrize("name", ["ball", "pull", "twist"])
def test_new_scene_from_a_shipped_one(name, said):
    said("new", "mine.toml", "--scene", "--from", name, "-q")
    said("check", "homogeneous", "--scene", "mine.toml", "-q")
    assert "ball" in said("new", "other.toml", "--scene", "--from", "x", code=2).err


def test_new_overwrites_nothing_without_force(said):
    Path("mine.toml").write_text("precious")
    Path("design.schema.json").write_text("mine too")
    assert "--force" in said("new", "mine.toml", code=2).err
    assert Path("mine.toml").read_text() == "precious"
    said("new", "other.toml")
    assert Path("design.schema.json").read_text() == "mine too"
    os.mkfifo("pipe.toml")
    said("new", "pipe.toml", "--force", code=2)
    said("new", "mine.toml", "--force")
    said("check", "mine.toml")


def test_new_makes_a_safe_name_of_the_files(said):
    said("new", "my finger é.v2.toml")
    (report,) = json.loads(said("check", "my finger é.v2.toml", "--json").out)
    assert report["name"] == "my-finger-v2"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["x.txt"], "try x.toml"), ([], "FILE"), (["m.toml", "--from", "x"], "maeno2000")],
)
def test_wrong_input_of_new(arguments, words, said):
    assert words in said("new", *arguments, code=2).err
    assert not list(Path().iterdir())


def test_check_reports_every_fault_of_every_file(said):
    Path("bad.toml").write_text('design.name = "a"\nplates.pitch_mm = 0.1\ngages.length_mm = 9')
    Path("worse.toml").write_text("x =")
    said("new", "good.toml", "-q")
    captured = said("check", "bad.toml", "good.toml", "worse.toml", "absent.toml", code=2)
    lines = captured.err.splitlines()
    assert [line.split(":")[0] for line in lines[:3]] == ["bad.toml", "bad.toml", "worse.toml"]
    assert len(lines) == 4
    assert "absent.toml" in lines[3]
    assert "good" in captured.out


@pytest.mark.parametrize(
    ("rows", "keys"),
    [
        ("[]", ["scene.toml: path.increments_mm", "bad.toml: gages.length_mm"]),
        ("[[0.1, 0]]", ["bad.toml: gages.length_mm", "bad.toml (scene): readout.points_mm[1]"]),
    ],
)
def test_check_judges_the_scene_beside_faults_of_its_own_and_of_the_design(rows, keys, said):
    Path("bad.toml").write_text('design.name = "a"\ngages.length_mm = 9')
    points = "readout.points_mm = [[0, 30, 0], [0, 31, 0]]"
    Path("scene.toml").write_text(f"path.increments_mm = {rows}\n{points}")
    err = said("check", "bad.toml", "--scene", "scene.toml", code=2).err
    assert [line.split(" = ")[0] for line in err.splitlines()] == keys


def test_check_finds_shipped_names(said):
    assert "Of the fundamental path" in said("check", "narrow", "wide").out
    assert "did you mean narrow" in said("check", "narow", code=2).err


def test_a_designs_name_is_never_cut(monkeypatch, said):
    name = "a_finger_with_a_rather_long_name_of_mine"
    Path("long.toml").write_text(f'design.name = "{name}"')
    assert name in said("check", "long.toml").out
    monkeypatch.setattr("sys.stdout.isatty", lambda: True, raising=False)
    monkeypatch.setenv("COLUMNS", "80")
    shown = said("check", "long.toml").out
    lines = [line for line in shown.splitlines() if line.startswith("│")]
    cells = "".join(line[1:].split("│")[0].strip() for line in lines)
    assert name in cells
    assert max(len(line) for line in lines) <= 80


def test_check_as_json(said):
    Path("bad.toml").write_text('design.name = "a"\nplates.count = 501')
    said("new", "good.toml", "-q")
    good, bad = json.loads(said("check", "good.toml", "bad.toml", "--json", code=2).out)
    assert (good["sound"], good["plates"]) == (True, 15)
    assert 0 < good["least_surface_mm"] < 2
    assert 0 < good["contact_half_width_mm"] < 10
    assert bad["faults"][0]["key"] == "plates.count"
    assert set(bad["faults"][0]) == {"key", "value", "bound", "remedy"}


@pytest.mark.parametrize("rows", ["[[9.0, 0.0]]", "[[0.1, 0.0, 0.0, 0.0, 0.0]]", "[]"])
def test_a_faulty_scene_leaves_no_forecast_of_another(rows, said):
    Path("wrong.toml").write_text(f"path.increments_mm = {rows}")
    shown = said("check", "narrow", "--scene", "wrong.toml", code=2)
    assert "path.increments_mm" in shown.err
    assert "half-width" not in shown.out
    assert "half-width" in said("check", "narrow", "--scene", "fundamental").out
    shown = said("check", "narrow", "--scene", "wrong.toml", "--json", code=2).out
    assert json.loads(shown)[-1]["sound"] is (rows != "[[9.0, 0.0]]")


def test_check_says_what_plane_strain_will_refuse(said):
    text = 'design.name = "s"\nplates.along = "z"\nplates.span_mm = 4\nplates.count = 5'
    Path("across.toml").write_text(text)
    assert "note: across.toml: sound in three dimensions only" in said("check", "across.toml").out
    assert "three dimensions only" not in said("check", "narrow").out
    assert "straight along z: of a revolved body" in said("check", "pin").out


def test_check_says_what_was_understood_of_a_step_file(said, monkeypatch, tmp_path):
    read_here(monkeypatch, tmp_path / "cache")
    file = sample_step("filleted", 16.0, 12.0, 10.0, 1.5)
    text = f'design.name = "s"\nplates.count = 0\nbody.shape = "step"\nbody.step.file = "{file}"'
    Path("step.toml").write_text(text)
    out = said("check", "step.toml").out
    assert "step: 16 x 10 x 12 mm (x, y, z as turned), base 192 mm2, contact 5 of 10" in out
    assert "mirrors_in_z = true halves" in out
    Path("step.toml").write_text(text + "\nbody.step.mirrors_in_z = true")
    assert "halves" not in said("check", "step.toml").out


@pytest.mark.parametrize(
    ("arguments", "code"),
    [
        (["check"], 2),
        (["nonsense"], 2),
        (["check", "--nonsense"], 2),
        (["--nope"], 2),
        (["--version"], 0),
        (["new", "-h"], 0),
    ],
)
def test_usage_errors_are_2_and_help_is_0(arguments, code, said):
    shown = said(*arguments, code=code)
    assert shown.out if code == 0 else "Usage" in shown.err


def fail_with(monkeypatch, error):
    """Have ``check`` end with an error."""

    def fail(**_):
        raise error

    failing = click.Command("check", callback=fail)
    monkeypatch.setitem(cli_main.cli.commands, "check", failing)


@pytest.mark.parametrize(
    ("error", "code", "words"),
    [
        (FingerDesignError("no mesh passed"), 1, "failed: no mesh passed"),
        (KeyboardInterrupt(), 130, "interrupted"),
        (OSError(28, "No space left on device"), 1, "No space left on device; free space"),
        (ZeroDivisionError("oh"), 1, "unexpected ZeroDivisionError: oh"),
        (ImportError("no such library"), 1, "unexpected ImportError"),
        (click.ClickException("clicked"), 1, "clicked"),
    ],
)
def test_failures_become_exit_codes(error, code, words, monkeypatch, said):
    fail_with(monkeypatch, error)
    err = said("check", code=code).err
    assert words in err
    assert "Traceback" not in err


def test_debug_keeps_the_traceback_in_a_file(monkeypatch, said, tmp_path):
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    fail_with(monkeypatch, ZeroDivisionError("oh"))
    err = said("--debug", "check", code=1).err
    (kept,) = tmp_path.glob("fingerdesign-*.txt")
    assert str(kept) in err
    assert "ZeroDivisionError: oh" in kept.read_text()


def test_every_listed_command_has_the_help_line_it_is_listed_with(said):
    context = click.Context(cli_main.cli)
    for name in cli_main.cli.list_commands(context):
        assert "Usage: fingerdesign " + name in said(name, "--help").out


def test_progress_is_plain_lines_off_a_terminal_and_nothing_when_quiet(capsys):
    with progress("work") as show:
        show("meshing", 0.1)
        show("meshing", 0.2)
        show("solving")
    assert capsys.readouterr().err.splitlines() == ["work: meshing", "work: solving"]
    with progress("work", quiet=True) as show:
        show("meshing")
    assert capsys.readouterr().err == ""


LIGHT = """
import sys
sys.path[:0] = {paths!r}
{code}
heavy = {{"numpy", "scipy", "cadquery", "pyvista", "netgen", "matplotlib", "pydantic", "skfem"}}
heavy |= {{"distributed"}}
print(sorted(heavy & set(sys.modules)))
"""


def test_help_loads_no_numerics_and_no_cad():
    """Nor does the package alone; the list of commands takes the definitions of all."""
    code = "import fingerdesign\nfrom fingerdesign_cli.main import main\n"
    code += "for name in ([], ['check'], ['bench']):\n    assert main([*name, '--help']) == 0"
    paths = [str(ROOT / each) for each in (".", "cli", "benchmarks")]
    script = LIGHT.format(paths=paths, code=code)
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True, timeout=60
    )
    assert done.stdout.splitlines()[-1] == "[]"


def test_public_names_are_lazy_and_complete():
    import fingerdesign

    assert fingerdesign.load_design(ROOT / "designs/maeno2000.toml").design.name == "maeno2000"
    assert "analyse" in dir(fingerdesign)
    with pytest.raises(AttributeError, match="nonsense"):
        _ = fingerdesign.nonsense
