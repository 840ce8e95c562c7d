"""``fingerdesign generate``: files, counts, exit codes."""

import json
import struct

import pytest
from fingerdesign_cli.main import main

TEXT = (
    '[study]\nname = "few"\nbase = "maeno2000"\nsampling = "grid"\n'
    '[parameters]\n"plates.count" = [9, 11, 45]\n'
)


@pytest.fixture
def study(tmp_path):
    path = tmp_path / "few.toml"
    path.write_text(TEXT, "utf-8")
    return str(path)


def test_files_of_a_finger(study, tmp_path, said):
    out = tmp_path / "out"
    assert (
        "1 variants, 0 of them there already"
        in said("generate", study, "--out", out, "--count", "1", "--workers", "1").out
    )
    folder = out / "few" / "few-0001"
    names = ["body.stl", "few-0001.toml", "finger.step", "finger.stl", "plates.stl"]
    assert sorted(path.name for path in folder.iterdir()) == names
    step = (folder / "finger.step").read_text("utf-8")
    assert step.startswith("ISO-10303-21")
    assert "plate_8" in step
    for name in ("body.stl", "plates.stl", "finger.stl"):
        content = (folder / name).read_bytes()
        (triangles,) = struct.unpack("<I", content[80:84])
        assert len(content) == 84 + 50 * triangles
        assert triangles >= 12


def test_invalid_variants_are_counted_and_reported(study, tmp_path, said):
    arguments = ["generate", study, "--out", str(tmp_path), "--no-cad"]
    shown = said(*arguments).out
    assert "few-0003: plates." in shown
    assert "2 variants" in shown
    assert "1 cannot exist" in shown
    *each, reported = map(json.loads, said(*arguments, "--json").out.splitlines())
    assert (reported["valid"], reported["invalid"], reported["cad_failed"]) == (2, 1, 0)
    assert [one["done"] for one in each] == [1, 2, 3]
    by_number = {one["number"]: one for one in each}
    assert [by_number[number]["kept"] for number in (1, 2, 3)] == [True, True, False]
    assert by_number[3]["faults"]
    shown = said(*arguments, "--quiet")
    assert not shown.out
    assert shown.err.splitlines() == [
        f"1 of 3 cannot exist: faults in {tmp_path / 'few' / 'invalid.csv'}"
    ]


def test_only_some(study, tmp_path, capsys, said):
    arguments = ["generate", study, "--out", str(tmp_path / "out"), "--no-cad"]
    assert main([*arguments, "--only", "2"]) == 0
    assert not (tmp_path / "out" / "few" / "few-0001").exists()
    assert (tmp_path / "out" / "few" / "few-0002" / "few-0002.toml").exists()
    capsys.readouterr()
    assert main([*arguments, "--only", "3", "--quiet"]) == 1
    assert capsys.readouterr().err.startswith(
        "no variant can exist: all 1 have faults, reported in "
    )
    assert "at most 3" in said(*arguments, "--only", "4", code=2).err


def test_wrong_input_ends_before_any_work(study, tmp_path, said):
    out = tmp_path / "out"
    assert "did you mean fingers" in said("generate", "fngers", "--out", out, code=2).err
    (tmp_path / "bad.toml").write_text(TEXT.replace("plates.count", "plates.cuont"), "utf-8")
    assert (
        "did you mean plates.count"
        in said("generate", tmp_path / "bad.toml", "--out", out, code=2).err
    )
    assert not out.exists()
    (out / "few").mkdir(parents=True)
    (out / "few" / "mine.txt").write_text("mine", "utf-8")
    assert "mine.txt" in said("generate", study, "--out", out, code=2).err
