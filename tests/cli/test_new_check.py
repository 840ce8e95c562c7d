"""``new`` and ``check`` through ``main``, exit codes, and how light ``--help`` is."""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import click
import pytest

from fingerdesign.design.shipped import shipped_text
from fingerdesign.errors import FingerDesignError
from fingerdesign.studio.document import with_keys

ROOT = Path(__file__).parents[2]

pytestmark = pytest.mark.usefixtures("in_tmp_path")


@pytest.mark.parametrize("name", [None, "homogeneous", "narrow", "domed", "pin", "boned"])
def test_new_then_check(name, terminal):
    terminal("new", "sub/mine.toml", *(["--from", name] if name else []), "-q")
    assert "mine" in terminal("check", "sub/mine.toml").out
    assert Path("sub/design.schema.json").is_file()


def test_a_file_that_is_no_mesh_of_the_finger_is_a_fault(terminal):
    Path("none.msh").write_text("none")
    Path("own.toml").write_text('design.name = "own"\n[mesh]\nmesher = "file"\nfile = "none.msh"\n')
    stated = terminal("check", "own.toml", code=2).err
    assert "mesh.file = " in stated
    assert "must be a mesh of this finger; meshio could not read" in " ".join(stated.split())


def test_new_names_the_folder_and_the_schema_that_it_writes(terminal):
    (first, _) = terminal("new", "sub/a.toml").out.splitlines()
    assert "design.schema.json" in first
    assert "new folder sub" in first
    (second, _) = terminal("new", "sub/b.toml").out.splitlines()
    assert second == "sub/b.toml written"


def test_new_refuses_names_that_no_file_can_have(terminal):
    Path("link.toml").symlink_to("nowhere/y.toml")
    for name, why in {
        f"{300 * 'a'}.toml": "choose a shorter one",
        "link.toml": "a link to nothing",
        ".toml": "try finger.toml",
        "a.txt": "try a.toml",
    }.items():
        assert why in terminal("new", name, code=2).err
    assert "too long for the name of a file" in terminal("check", 300 * "a", code=2).err
    assert Path("link.toml").is_symlink()


@pytest.mark.parametrize("name", ["maeno2000", "fine_tees"])
def test_keys_for_a_gage_that_is_sold_can_be_pasted_and_pass(name, terminal):
    (report,) = json.loads(terminal("check", name, "--json").out)
    (note,) = [each for each in report["notes"] if "that is sold fits" in each]
    pairs = dict(re.findall(r"((?:plates|gages)\.\w+_mm) = ([\d.]*\d)", note))
    assert {"plates.length_mm", "plates.cover_mm", "gages.length_mm"} <= set(pairs)
    text = with_keys(shipped_text(name), {key: float(value) for key, value in pairs.items()})
    Path("mine.toml").write_text(text, "utf-8")
    (report,) = json.loads(terminal("check", "mine.toml", "--json").out)
    assert not [each for each in report["notes"] if "that is sold fits" in each]


def test_check_names_what_it_judges_later_and_the_file_that_was_meant(terminal):
    Path("mine.toml").write_text("[plates]\ncount = 90\n[grip]\nobject_mass_g = 0\n", "utf-8")
    printed = terminal("check", "mine.toml", code=2).err
    assert "grip.object_mass_g" in printed
    assert "distances are judged after that" in printed
    assert "did you mean mine.toml?" in terminal("check", "mine", code=2).err
    assert "name a file in it" in terminal("check", ".", code=2).err


def test_new_scene_then_check(terminal):
    terminal("new", "mine.toml", "--scene")
    terminal("check", "narrow", "--scene", "mine.toml")
    schema = json.loads(Path("scene.schema.json").read_text())
    text = Path("mine.toml").read_text()
    assert text.startswith("#:schema ./scene.schema.json\n")
    for table in schema["properties"].values():
        name = table.get("$ref", "").rsplit("/", 1)[-1] or table["allOf"][0]["$ref"][8:]
        for key in schema["$defs"][name]["properties"]:
            assert f"{key} = " in text
    assert not Path("design.schema.json").exists()


def test_new_overwrites_nothing_without_force(terminal):
    Path("mine.toml").write_text("precious")
    Path("design.schema.json").write_text("mine too")
    assert "--force" in terminal("new", "mine.toml", code=2).err
    assert Path("mine.toml").read_text() == "precious"
    terminal("new", "other.toml")
    assert Path("design.schema.json").read_text() == "mine too"
    os.mkfifo("pipe.toml")
    terminal("new", "pipe.toml", "--force", code=2)
    terminal("new", "mine.toml", "--force")
    terminal("check", "mine.toml")


def test_new_makes_a_safe_name_of_the_files(terminal):
    terminal("new", "my finger é.v2.toml")
    (report,) = json.loads(terminal("check", "my finger é.v2.toml", "--json").out)
    assert report["name"] == "my-finger-v2"


@pytest.mark.parametrize(
    ("arguments", "words"),
    [(["x.txt"], "try x.toml"), ([], "FILE"), (["m.toml", "--from", "x"], "maeno2000")],
)
def test_wrong_input_of_new(arguments, words, terminal):
    assert words in terminal("new", *arguments, code=2).err
    assert not list(Path().iterdir())


def test_check_reports_every_fault_of_every_file(terminal):
    Path("bad.toml").write_text('design.name = "a"\nplates.pitch_mm = 0.1\ngages.length_mm = 9')
    Path("worse.toml").write_text("x =")
    terminal("new", "good.toml", "-q")
    captured = terminal("check", "bad.toml", "good.toml", "worse.toml", "absent.toml", code=2)
    lines = captured.err.splitlines()
    assert [line.split(":")[0] for line in lines[:3]] == ["bad.toml", "bad.toml", "worse.toml"]
    assert len(lines) == 4
    assert "absent.toml" in lines[3]
    assert "good" in captured.out
    assert "slip sensing is not forecast" in captured.out


@pytest.mark.parametrize(
    ("rows", "keys"),
    [
        ("[]", ["scene.toml: path.increments_mm", "bad.toml: gages.length_mm"]),
        ("[[0.1, 0]]", ["bad.toml: gages.length_mm", "bad.toml (scene): readout.points_mm[1]"]),
    ],
)
def test_check_judges_the_scene_with_faults_of_its_own_and_of_the_design(rows, keys, terminal):
    Path("bad.toml").write_text('design.name = "a"\ngages.length_mm = 9')
    points = "readout.points_mm = [[0, 30, 0], [0, 31, 0]]"
    Path("scene.toml").write_text(f"path.increments_mm = {rows}\n{points}")
    err = terminal("check", "bad.toml", "--scene", "scene.toml", code=2).err
    assert [line.split(" = ")[0] for line in err.splitlines()] == keys


def test_tables_have_legends_with_units(terminal):
    shown = terminal("check", "film_tees").out
    for words in ("to the contact surface", "GB: memory", "tangential force of one finger"):
        assert words in shown
    assert max(map(len, shown.splitlines())) <= 80
    shown = terminal("list", "gages").out
    assert "Et N/mm" in shown
    for column in ("with tabs:", "factor:", "order:", "weeks:", "price of a piece:"):
        assert column in shown
    for row in json.loads(terminal("list", "gages", "--json").out)["gages"]:
        # A quarter bridge gives GF strain / 4.
        assert row["microstrain_per_uV_V"] == pytest.approx(4.0 / row["factor"], abs=6e-4)


def test_check_as_json(terminal):
    Path("bad.toml").write_text('design.name = "a"\nplates.count = 501')
    terminal("new", "good.toml", "-q")
    good, bad = json.loads(terminal("check", "good.toml", "bad.toml", "--json", code=2).out)
    assert (good["sound"], good["plates"]) == (True, 11)
    assert 0 < good["least_surface_mm"] < 2
    assert 0 < good["contact_half_width_mm"] < 10
    assert bad["faults"][0]["key"] == "plates.count"
    assert set(bad["faults"][0]) == {"key", "value", "bound", "remedy"}


@pytest.mark.parametrize("rows", ["[[9.0, 0.0]]", "[[0.1, 0.0, 0.0, 0.0, 0.0]]", "[]"])
def test_a_faulty_scene_leaves_no_forecast_of_another(rows, terminal):
    Path("wrong.toml").write_text(f"path.increments_mm = {rows}")
    shown = terminal("check", "narrow", "--scene", "wrong.toml", code=2)
    assert "path.increments_mm" in shown.err
    assert "Distances" not in shown.out
    assert "Distances" in terminal("check", "narrow", "--scene", "fundamental").out
    shown = terminal("check", "narrow", "--scene", "wrong.toml", "--json", code=2).out
    assert json.loads(shown)[-1]["sound"] is (rows != "[[9.0, 0.0]]")


def failing(error):
    """Work that ends with an error."""

    def fail():
        raise error

    return fail


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
def test_failures_become_exit_codes(error, code, words, as_check, terminal):
    as_check(failing(error))
    err = terminal("check", code=code).err
    assert words in err
    assert "Traceback" not in err


def test_debug_writes_the_traceback_to_a_file(as_check, terminal):
    as_check(failing(ZeroDivisionError("oh")))
    err = terminal("--debug", "check", code=1).err
    stored = Path(err.split("its traceback is in ")[1].strip())
    assert "ZeroDivisionError: oh" in stored.read_text()
    stored.unlink()


LIGHT = """
import sys
sys.path[:0] = {paths!r}
{code}
heavy = {{"numpy", "scipy", "cadquery", "pyvista", "netgen", "matplotlib", "pydantic", "skfem"}}
heavy |= {{"distributed", "gymnasium", "trame"}}
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


def test_variants_of_a_study_that_cannot_exist_are_counted_and_a_study_of_such_alone_is_refused(
    tmp_path, terminal
):
    study = tmp_path / "s.toml"
    text = '[study]\nname = "s"\nbase = "tees"\nsampling = "grid"\n[parameters]\n'
    study.write_text(f"{text}plates.cover_mm = [0.01, 0.6, 0.7]\n", "utf-8")
    shown = " ".join(terminal("check", study).out.split())
    assert "cannot exist: 1 of 3 variants tried (s-0001: plates.cover_mm = 0.01" in shown
    study.write_text(f"{text}plates.cover_mm = [0.6, 0.7]\n", "utf-8")
    assert "cannot exist" not in terminal("check", study).out
    study.write_text(f"{text}grip.controller = ['regulator']\n".replace("tees", "narrow"), "utf-8")
    assert "each variant" not in terminal("check", study).out
    trained = f"{text}plates.count = [5]\n[fixed]\ngrip.controller = 'regulator'\n"
    study.write_text(trained, "utf-8")
    assert "each variant: grip.controller = 'regulator' is trained" in terminal("check", study).out
    # Half of them exist, of the last key's values each second one.
    many = [20.0 + 0.1 * k for k in range(50)]
    study.write_text(f"{text}body.arc_radius_mm = {many}\nplates.cover_mm = [0.01, 0.6]\n")
    shown = " ".join(terminal("check", study).out.split())
    assert 15 < int(re.search(r"cannot exist: (\d+) of 50", shown)[1]) < 35
    study.write_text(f"{text}mesh.file = ['none.msh']\n", "utf-8")
    refused = terminal("check", study, code=2).err
    assert "variants: 1: must be such that a variant can exist; mesh.file = " in refused


def test_what_fixed_keys_make_impossible_is_named_as_theirs(tmp_path, terminal):
    study = tmp_path / "s.toml"
    text = '[study]\nname = "s"\nbase = "tees"\nsampling = "grid"\n'
    given = '[fixed]\n"mesh.section.far_size_mm" = 0.001\n"body.core.height_mm" = 90.0\n'
    study.write_text(f"{text}{given}[parameters]\nplates.count = [3, 5]\n", "utf-8")
    assert 'fixed."' in terminal("check", study, code=2).err
    given = '[fixed]\n"mesh.mesher" = "file"\n"mesh.file" = "none.msh"\n'
    study.write_text(f"{text}{given}[parameters]\nplates.count = [3, 5]\n", "utf-8")
    assert 'fixed."mesh.file" = ' in terminal("check", study, code=2).err
    assert 'fixed."mesh.file" = ' in terminal("sweep", study, code=2).err
