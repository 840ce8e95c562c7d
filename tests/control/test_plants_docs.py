"""docs/plants.md: its Python runs, its table is a sound design, its trace is replayed."""

import re
from pathlib import Path

import pytest
from fingerdesign_cli.main import main

from fingerdesign import parse_design

TEXT = (Path(__file__).parents[2] / "docs/plants.md").read_text("utf-8")


def blocks(kind):
    return re.findall(rf"```{kind}\n(.*?)```", TEXT, flags=re.DOTALL)


def test_its_design_is_sound_and_says_every_key_of_the_hardware():
    design = parse_design(blocks("toml")[0])
    assert design.grip.plant == "lift"
    given = design.grip.hardware.model_fields_set
    assert set(type(design.grip.hardware).model_fields) - given == {"specimen"}


def test_a_lift_is_recorded_and_replayed(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    exec(compile(blocks("python")[0], "plants.md", "exec"), {})
    lifted, carried, rise = capsys.readouterr().out.split()
    assert lifted == "True"
    assert float(carried) == pytest.approx(0.2 * 9.80665, abs=1e-3)
    assert float(rise) > 0.01
    (command,) = blocks("sh")[0].splitlines()
    assert main(command.split()[1:]) == 0
    assert (tmp_path / "replayed/sensitive/replay.csv").is_file()


def test_a_hand_of_ones_own_grips(capsys):
    exec(compile(blocks("python")[1], "plants.md", "exec"), {"__name__": "own"})
    lifted, margin, *reason = capsys.readouterr().out.split()
    assert (lifted, float(margin)) == ("True", pytest.approx(2.4, abs=0.3))
    assert "hangs" in " ".join(reason)
