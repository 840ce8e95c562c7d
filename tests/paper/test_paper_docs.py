"""docs/paper.md: its Python runs, its keys and verdicts are the program's."""

import re
from pathlib import Path

import pytest
from fingerdesign_cli.commands.hand import paper as command

from fingerdesign.paper.claims import CLAIMS
from fingerdesign.paper.remade import ORDER

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs/paper.md").read_text("utf-8")


@pytest.mark.slow
def test_its_python_runs(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    exec(compile(code, "docs/paper.md", "exec"), {})
    first, second = capsys.readouterr().out.splitlines()
    assert first == f"{len(CLAIMS)} partly"
    assert second == "True"


def test_every_figure_and_claim_is_reported_of():
    figures = re.findall(r"^\| `(\w+)` \|", TEXT, flags=re.MULTILINE)
    assert figures == list(ORDER)
    claims = re.findall(r"^\| `(\w+)`: .* \| (yes|partly|no) \|", TEXT, flags=re.MULTILINE)
    assert [key for key, _ in claims] == list(CLAIMS)
    options = {name for parameter in command.params for name in parameter.opts}
    assert set(re.findall(r"(--\w+)", TEXT)) <= options


def test_its_pictures_are_there():
    for name in re.findall(r"\]\((images/[^)]+)\)", TEXT):
        assert (ROOT / "docs" / name).is_file(), name
