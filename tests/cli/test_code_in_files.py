"""Code that a file names runs only where the user permits it."""

import contextlib
import os
import subprocess
import sys
from pathlib import Path

import pytest
import tomlkit

import fingerdesign
from fingerdesign.checks.load import judge_design, with_values
from fingerdesign.design.keys import set_value
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError
from fingerdesign.studio.document import Document
from tests.support.house import ROOT

HAND = """
from pathlib import Path
Path(__file__).with_name("ran").touch()
class Hand:
    name = "mine"
    def __init__(self, *given): ...
    def start(self, *given): ...
    def command(self, *given): ...
"""
DESIGN = 'design.name = "a"\ngrip.controller = "hand:Hand"\n'
STUDY = """
[study]
name = "s"
base = "{base}"
sampling = "grid"
[fixed]
"grip.controller" = {fixed}
[parameters]
"{key}" = {values}
"""
STUDIES = {
    "base": {"base": "a.toml", "fixed": '"paper"', "key": "plates.count", "values": "[7]"},
    "fixed": {"base": "narrow", "fixed": '"hand:Hand"', "key": "plates.count", "values": "[7]"},
    "parameter": {
        "base": "narrow",
        "fixed": '"paper"',
        "key": "grip.controller",
        "values": '["paper", "hand:Hand"]',
    },
}
REMEDY = "add --allow-code"


@pytest.fixture
def here(tmp_path, in_tmp_path, nothing_allowed):
    """A folder with a design that names a class, and that class's file, which leaves a trace."""
    Path("hand.py").write_text(HAND)
    Path("a.toml").write_text(DESIGN)
    yield tmp_path
    sys.modules.pop("hand", None)


@pytest.mark.parametrize(
    "command", ["check", "view", "studio", "analyse", "grip", "mesh", "mold", "validate", "train"]
)
def test_no_command_runs_what_a_design_names(command, here, terminal):
    shown = terminal(command, "a.toml", code=2)
    assert "grip.controller = 'hand:Hand': must be " in shown.err
    assert REMEDY in shown.err
    assert not Path("ran").exists()


@pytest.mark.parametrize("command", ["check", "generate", "sweep", "optimise"])
@pytest.mark.parametrize("place", STUDIES)
def test_no_command_runs_what_a_study_names(place, command, here, terminal):
    Path("s.toml").write_text(STUDY.format(**STUDIES[place]))
    terminal(command, "s.toml", code=2)
    assert not Path("ran").exists()


def test_the_user_can_permit_it(here, terminal):
    terminal("check", "a.toml", "--allow-code", "--quiet")
    assert Path("ran").exists()


def test_a_name_on_the_command_line_is_permitted_and_the_files_is_not(here, terminal):
    Path("hand.py").write_text("class Other:\n    name = 'o'\n")
    Path("other.py").write_text(HAND)
    Path("a.toml").write_text(DESIGN)
    shown = terminal("grip", "a.toml", "--controller", "other:Hand", code=2)
    assert Path("ran").exists()
    assert "'hand:Hand'" in shown.err
    assert "hand" not in sys.modules
    sys.modules.pop("other", None)


def keys_of(schema, table="", seen=()):
    """Dotted keys of a JSON schema, tables in arrays as [0], each nested kind once."""
    if isinstance(schema, list):
        return {key for each in schema for key in keys_of(each, table, seen)}
    found = keys_of([*schema.get("anyOf", []), *schema.get("allOf", [])], table, seen)
    name = schema.get("$ref", "").rpartition("/")[2]
    if name and name not in seen:
        found |= keys_of(SCHEMA["$defs"][name], table, (*seen, name))
    if "items" in schema:
        found |= keys_of(schema["items"], f"{table}[0]", seen)
    if isinstance(schema.get("additionalProperties"), dict):
        found |= keys_of(schema["additionalProperties"], f"{table}.silicone", seen)
    for key, inner in schema.get("properties", {}).items():
        found |= keys_of(inner, f"{table}.{key}".lstrip("."), seen)
    return found or {table}


SCHEMA = Design.model_json_schema()


@pytest.mark.parametrize("name", ["hand:Hand", "hand.py", "./hand.py:Hand", "hand"])
def test_only_a_controllers_key_leads_to_code(name, here):
    keys = keys_of(SCHEMA)
    assert len(keys) > 150
    assert {"body.shape", "body.step.file", "mesh.file", "mesh.mesher", "grip.controller"} <= keys
    for key in sorted(keys - {"grip.controller"}):
        data = {"design": {"name": "a"}, "body": {"shape": "step"} if ".step." in key else {}}
        with contextlib.suppress(DesignError):
            set_value(data, key, name)
            fingerdesign.parse_design(tomlkit.dumps(data), folder=here, allow_code=True)
        assert not Path("ran").exists(), key


def test_a_body_by_a_function_comes_from_python_alone(here):
    """A STEP body's readers take the file's geometry; a function is handed over by a script."""
    Path("hand.step").write_text(HAND)
    for file in ("hand.py", "hand.step", "hand:Hand"):
        text = f'design.name = "a"\nbody.shape = "step"\nbody.step.file = "{file}"'
        with pytest.raises(DesignError, match=r"body\.step\.file"):
            fingerdesign.parse_design(text, folder=here, allow_code=True)
    with pytest.raises(TypeError, match="callable"):
        fingerdesign.with_body(fingerdesign.load_design("narrow"), "hand:Hand")
    assert not Path("ran").exists()


@pytest.mark.parametrize("command", ["check", pytest.param("view", marks=pytest.mark.slow)])
def test_files_that_lie_next_to_a_design_do_not_run(command, here):
    """Modules with the names of libraries, a start-up file of Python's, one of matplotlib's."""
    Path("a.toml").write_text(f"{DESIGN.partition('grip')[0]}plates.count = 1\n")
    for name in ("numpy", "matplotlib", "plotly", "sitecustomize", "usercustomize", "conftest"):
        Path(f"{name}.py").write_text(HAND)
    Path("matplotlibrc").write_text("backend: module://hand\n")
    code = "from fingerdesign_cli.start import entry_point; entry_point()"  # as the installed one
    given = [sys.executable, "-P", "-c", code, command, "a.toml"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join((str(ROOT), str(ROOT / "cli")))}
    subprocess.run(given, check=True, env=environment, capture_output=True, timeout=100)
    assert not Path("ran").exists()


def test_loading_in_python_runs_it_only_where_it_is_allowed(here):
    for load in (fingerdesign.load_design, lambda file: Document.of(Path(file))):
        with pytest.raises(DesignError, match="allow_code=True"):
            load("a.toml")
    assert judge_design(DESIGN).faults
    with pytest.raises(DesignError, match="allow_code=True"):
        with_values(fingerdesign.load_design("narrow"), {"grip.controller": "hand:Hand"})
    assert not Path("ran").exists()
    design = fingerdesign.load_design("a.toml", allow_code=True)
    assert Path("ran").exists()
    assert with_values(design, {"plates.count": 7}).grip.controller == "hand:Hand"
    Path("b.toml").write_text(DESIGN.replace("hand:Hand", "other:Hand"))
    with pytest.raises(DesignError, match="allow_code=True"):  # it was for that one call
        fingerdesign.load_design("b.toml")
