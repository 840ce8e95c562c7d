"""docs/plugins.md: its package is installed as it stands, and its commands run."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from tests.support.plugins import installed

PAGE = (Path(__file__).parents[1] / "docs" / "plugins.md").read_text("utf-8")

COARSER = "section = { contact_size_mm = 0.2, plate_size_mm = 0.2, plate_end_size_mm = 0.1 }"


@pytest.fixture(scope="module")
def package(tmp_path_factory):
    """The page's files, and a process beside them."""
    folder = tmp_path_factory.mktemp("page")
    (folder / "extras").mkdir()
    for name, text in re.findall(r"```(?:toml|python)\n# (\S+)\n(.*?)```", PAGE, flags=re.DOTALL):
        (folder / name).write_text(text, "utf-8")
    design = folder / "hand.toml"
    design.write_text(design.read_text("utf-8").replace('"slices", ', f'"slices", {COARSER}, '))
    project = tomllib.loads((folder / "pyproject.toml").read_text("utf-8"))["project"]
    points = project["entry-points"]["fingerdesign.plugins"]
    with installed(folder, "\n".join(f"{name} = {at}" for name, at in points.items())) as worker:
        yield folder, worker


(COMMANDS,) = re.findall(r"```sh\n(.*?)```", PAGE, flags=re.DOTALL)


@pytest.mark.parametrize(
    "line",
    [
        pytest.param(line, marks=[pytest.mark.slow] * ("analyse" in line))
        for line in COMMANDS.splitlines()
    ],
)
def test_a_command_of_the_page_runs(package, line):
    folder, worker = package
    program, *words = line.split()
    assert program == "fingerdesign"
    code, written = worker.call("tests.support.calls:command", words, time_s=240.0)
    assert code == 0, written
    if words[0] == "mesh":
        quality = json.loads((folder / "mesh" / "quality.json").read_text("utf-8"))
        assert quality["mesher"] == "slices"
