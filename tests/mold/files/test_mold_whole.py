"""The command on a shipped design, nothing hand-made: every check passes, every file is there."""

import json

import jsonschema
import pytest
from fingerdesign_cli.main import main

from fingerdesign.records.base import json_schema
from tests.support.molds import read_3mf

pytestmark = pytest.mark.slow


def test_a_shipped_finger_can_be_cast(tmp_path):
    assert main(["mold", "boned", "--out", str(tmp_path), "--quiet"]) == 0
    folder = tmp_path / "boned"
    data = json.loads((folder / "mold_report.json").read_text("utf-8"))
    jsonschema.validate(data, json_schema("mold"))
    assert data["status"] == "ok"
    assert all(check["ok"] for check in data["checks"])
    assert sorted(path.name for path in folder.iterdir()) == data["files"]
    named = {name for part in (*data["parts"], *data["plates"]) for name in part["files"]}
    assert named <= set(data["files"])
    printed = {part["name"]: part for part in data["parts"] if part["print"]}
    held = read_3mf(folder / "mold.3mf")
    assert set(held) == set(printed)
    for name, part in printed.items():
        _, triangles, volume = held[name]
        assert triangles == part["triangles"]
        assert volume == pytest.approx(part["volume_mm3"], rel=3e-3)  # chords
        assert part["chord_mm"] <= data["process"]["chord_mm"]


@pytest.mark.parametrize("fixture", ["jig", "slots"])
def test_other_fixtures_pass_every_check(tmp_path, fixture):
    command = ["mold", "wide", "--fixture", fixture, "--out", str(tmp_path), "--quiet"]
    assert main(command) == 0
