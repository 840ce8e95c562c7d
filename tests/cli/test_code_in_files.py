"""Code that a file names runs only where the user permits it."""

import sys
from pathlib import Path

import pytest

import fingerdesign
from fingerdesign.checks.load import judge_design, with_values
from fingerdesign.errors import DesignError
from fingerdesign.studio.document import Document

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


@pytest.mark.parametrize("key", ["body.shape", "mesh.mesher", "plates.follow"])
def test_no_other_key_leads_to_code(key, here):
    name = "hand:Hand"
    with pytest.raises(DesignError):
        fingerdesign.parse_design(f'design.name = "a"\n{key} = "{name}"', allow_code=True)
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
