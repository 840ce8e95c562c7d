"""docs/validate.md: its Python runs, its commands and keys exist."""

import re
from pathlib import Path

from fingerdesign_cli.commands.finger import validate as command

from fingerdesign.validate.assumptions import ASSUMPTIONS

TEXT = (Path(__file__).parents[2] / "docs/validate.md").read_text("utf-8")


def test_its_python_runs(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    exec(compile(code, "docs/validate.md", "exec"), {})
    advice, numbers = capsys.readouterr().out.splitlines()
    assert advice.endswith(").")
    assert float(numbers.split()[0]) > 0.05


def test_every_assumption_and_option_is_reported_of():
    keys = re.findall(r"^\| `(\w+)` \|", TEXT, flags=re.MULTILINE)
    assert keys == [each.key for each in ASSUMPTIONS]
    options = {name for parameter in command.params for name in parameter.opts}
    assert set(re.findall(r"`(--\w+)", TEXT)) <= options
