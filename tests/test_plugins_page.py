"""docs/how_to/plugins.md: its package is installed as it stands, and its commands run."""

import contextlib
import json
import re
import sys
import tomllib
from pathlib import Path

import pytest
from fingerdesign_cli.main import main

from fingerdesign import DesignError, with_values
from fingerdesign.checks.load import load_design
from fingerdesign.runtime.isolate import Worker
from fingerdesign.runtime.registry import allow_code
from tests.support.plugins import installed

PAGE = (Path(__file__).parents[1] / "docs/how_to/plugins.md").read_text("utf-8")

COARSER = (
    "contact_size_mm = 1.0, plate_size_mm = 1.5, "
    "section = { contact_size_mm = 0.2, plate_size_mm = 0.2, plate_end_size_mm = 0.1 }"
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """The page's files."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "extras").mkdir()
    for name, text in re.findall(r"```(?:toml|python)\n# (\S+)\n(.*?)```", PAGE, flags=re.DOTALL):
        (folder / name).write_text(text, "utf-8")
    return folder


@pytest.fixture(scope="module")
def package(folder):
    """A process in the folder of the page's files."""
    design = folder / "hand.toml"
    design.write_text(design.read_text("utf-8").replace('"slices", ', f'"slices", {COARSER}, '))
    project = tomllib.loads((folder / "pyproject.toml").read_text("utf-8"))["project"]
    points = project["entry-points"]["fingerdesign.plugins"]
    with installed(folder, "\n".join(f"{name} = {at}" for name, at in points.items())) as worker:
        yield folder, worker


ALONE, COMMANDS = re.findall(r"```sh\n(.*?)```", PAGE, flags=re.DOTALL)


@pytest.mark.slow
@pytest.mark.parametrize("line", COMMANDS.splitlines())
def test_a_command_of_the_page_runs(package, line):
    folder, worker = package
    program, *words = line.split()
    assert program == "fingerdesign"
    words += ["--no-picture"] * (words[0] == "mesh")  # the page on analyses draws one
    code, written = worker.call("tests.support.calls:command", words, time_s=240.0)
    assert code == 0, written
    if words[0] == "mesh":
        quality = json.loads((folder / "mesh" / "quality.json").read_text("utf-8"))
        assert quality["mesher"] == "slices"


@pytest.fixture
def here(folder, nothing_allowed):
    """A user in the folder of the page's files; what is imported there is forgotten again."""
    before = set(sys.modules)
    with contextlib.chdir(folder):
        yield folder
    for name in set(sys.modules) - before:
        if Path(getattr(sys.modules[name], "__file__", None) or "/").is_relative_to(folder):
            del sys.modules[name]


@pytest.mark.slow
@pytest.mark.parametrize("line", ALONE.splitlines())
def test_a_controller_in_one_file_grips(here, line, capsys):
    assert main(line.split()[1:]) == 0, capsys.readouterr()
    written = here / line.split()[-1] / "sensitive"
    if line.split()[1] == "grip":
        (grip,) = json.loads((written / "result.json").read_text("utf-8"))["grips"]
        assert (grip["controller"], grip["lifted"]) == ("steady", True)
    else:
        (judged,) = json.loads((written / "control.json").read_text("utf-8"))["controllers"]
        assert judged["controller"] == "steady:Steady"


def test_a_class_is_found_by_worker_processes_and_its_file_counts(here):
    allow_code("steady:Steady", "steady:Stedy")
    design = with_values(load_design("sensitive"), {"grip.controller": "steady:Steady"})
    with Worker() as worker:
        there = worker.call("tests.support.calls:hand_of", design, time_s=60.0)
    assert there == ("steady", design.digest())
    before = design.digest()
    file = here / "steady.py"
    file.write_text(file.read_text("utf-8").replace("8.0", "7.0"), "utf-8")
    assert design.digest() != before
    with pytest.raises(DesignError, match=r"'steady:Stedy': .* steady:Steady\?"):
        with_values(design, {"grip.controller": "steady:Stedy"})


BROKEN = {
    "nowhere:Hand": ("", "run where its folder lies"),
    "broken.py:Hand": ("class Hand: ...", "write broken:Hand, without .py"),
    "broken:Hand": ("raise OSError('no cable')", "correct it: OSError: no cable"),
    "broken:Hands": ("class Hand: ...", "did you mean broken:Hand?"),
    "broken:Arm": ("import not_there", "No module named 'not_there'"),
    "broken:hand": ("hand = 3", "must be a class"),
    "broken:Short": ("class Short:\n    def __init__(self): ...", "Short(grip, own, held)"),
    "broken:Mute": (
        "class Mute:\n    def __init__(self, *given): ...\n    def start(self, *given): ...",
        "has no attribute 'command'",
    ),
    "broken:Some": (
        "class Some:\n    def __init__(self, *given): ...\n"
        "    start = command = lambda self, *given: None",
        'give Some a line like name = "press"',
    ),
}


@pytest.mark.parametrize("name", BROKEN)
@pytest.mark.parametrize("command", ["grip", "study"])
def test_what_is_no_controller_is_refused_before_any_work(here, name, command, capsys):
    text, remedy = BROKEN[name]
    (here / "broken.py").write_text(text, "utf-8")
    assert main([command, "sensitive", "--controller", name, "--out", "none"]) == 2
    shown = capsys.readouterr().err
    assert shown.startswith(f"--controller = {name}: must be ")
    assert remedy in shown
    assert not (here / "none").exists()
