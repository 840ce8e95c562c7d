"""docs/control.md: its Python runs, its commands and options exist; the schema is the code's."""

import re
from pathlib import Path

from fingerdesign_cli.options import CONTROLLER_NAMES

from fingerdesign.records.base import DATA, schema_text
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.trials.page import look_of

TEXT = (Path(__file__).parents[2] / "docs/control.md").read_text("utf-8")


def test_its_python_runs(capsys):
    (code,) = re.findall(r"```python\n(.*?)```", TEXT, flags=re.DOTALL)
    exec(compile(code, "docs/control.md", "exec"), {})
    reported = capsys.readouterr().out.split()
    assert float(reported[0]) == 1.0
    assert 1.15 < float(reported[-1]) < 1.3


def test_every_controller_is_offered_and_has_a_look():
    assert set(CONTROLLER_NAMES) == set(CONTROLLERS.names())
    assert len({look_of(name) for name in CONTROLLER_NAMES}) == len(CONTROLLER_NAMES)


def test_the_shipped_schema_is_the_one_in_the_code():
    assert (DATA / "control.schema.json").read_text("utf-8") == schema_text("control")
