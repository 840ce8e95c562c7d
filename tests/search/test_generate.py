"""Generated variants: whole folders, unchanged when run again; invalid ones with reasons."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import pytest

from fingerdesign import load_design
from fingerdesign.cad.export import check_whole_step
from fingerdesign.errors import Fault, GeometryError
from fingerdesign.records.base import ResultError
from fingerdesign.search.study import generate as generating
from fingerdesign.search.study.file import parse_study
from fingerdesign.search.study.generate import generate, reasons
from fingerdesign.search.study.variants import Variant, base_design, variants

TEXT = (
    '[study]\nname = "few"\nbase = "maeno2000"\nsampling = "grid"\n'
    '[parameters]\n"plates.count" = [9, 11, 45]\n'
    '"materials.silicone.source" = ["=1+1", "<b>x</b>"]\n'
)
FAKE = """
import os, time
from fingerdesign.errors import GeometryError

def written(design, folder, chord_tolerance_mm):
    (folder / "finger.step").write_text("STEP")
    count = design.plates.count
    if count == 9 and os.environ.get("FAKE_CAD") == "crashes":
        os.abort()
    if count == 9 and os.environ.get("FAKE_CAD") == "hangs":
        time.sleep(60)
    if count == 9 and os.environ.get("FAKE_CAD") == "fails":
        raise GeometryError("plates 0 and 1 share nothing")
    (folder / "body.stl").write_text("STL")
"""
KILLED = """
import sys
from pathlib import Path
from fingerdesign.search.study import generate as generating
from fingerdesign.search.study.file import read_study
from fingerdesign.search.study.variants import base_design, variants

generating.BUILD = "fake_cad_worker:written"
study = read_study(sys.argv[1])
found = variants(study, base_design(study))
generating.generate(study, found, Path(sys.argv[2]), workers=3)
"""


@pytest.fixture
def fake_cad(tmp_path, children_find, monkeypatch):
    (tmp_path / "fake_cad_worker.py").write_text(FAKE, "utf-8")
    children_find(tmp_path)
    monkeypatch.setattr(generating, "BUILD", "fake_cad_worker:written")
    return monkeypatch


def made(target, text=TEXT, **options):
    study = parse_study(text)
    return generate(study, variants(study, base_design(study)), target, **options)


def rows(path):
    return list(csv.DictReader(path.read_text("utf-8").splitlines()))


def test_designs_and_lists(tmp_path):
    target = tmp_path / "few"
    found = made(target, cad=False)
    assert [each.variant.number for each in found] == [1, 2, 3, 4, 5, 6]
    names = ["few-0001", "few-0002", "few-0003", "few-0004"]
    lists = ["generate.json", "invalid.csv", "variants.csv"]
    assert sorted(os.listdir(target)) == [*names, *lists]
    listed = rows(target / "variants.csv")
    assert [row["name"] for row in listed] == names
    for row in listed:
        design = load_design(target / row["name"] / f"{row['name']}.toml")
        assert design.digest() == row["design_digest"]
        assert design.design.name == row["name"]
        assert str(design.plates.count) == row["plates.count"]
    invalid = rows(target / "invalid.csv")
    assert {row["number"] for row in invalid} == {"5", "6"}
    assert all(row["plates.count"] == "45" and row["key"] and row["must_be"] for row in invalid)
    record = json.loads((target / "generate.json").read_text("utf-8"))
    assert (record["variants"], record["invalid"], record["cad_failed"]) == (4, 2, 0)
    (key, count, fault, name), *_ = reasons([each.variant for each in found[4:]])
    assert (count, name, fault.key) == (2, "few-0005", key)
    # A stranger's text is no formula.
    assert {row["materials.silicone.source"] for row in listed} == {"'=1+1", "<b>x</b>"}


def test_run_again_it_makes_what_is_missing_or_changed(tmp_path):
    target = tmp_path / "few"
    made(target, cad=False)
    first, second = (target / name / f"{name}.toml" for name in ("few-0001", "few-0002"))
    stamp, whole = first.stat().st_mtime_ns, second.read_text("utf-8")
    second.write_text(whole[:100], "utf-8")
    found = made(target, cad=False)
    assert [each.existed for each in found] == [True, False, True, True, False, False]
    assert first.stat().st_mtime_ns == stamp
    assert second.read_text("utf-8") == whole
    # A shorter study leaves no older variants.
    shorter = TEXT.replace("[9, 11, 45]", "[9]")
    study = parse_study(shorter)
    some = [each for each in variants(study, base_design(study)) if each.number == 1]
    generate(study, iter(some), target, cad=False, whole=False)
    assert (target / "few-0004").is_dir()  # one was requested, the others are left alone
    made(target, shorter, cad=False)
    assert sorted(p.name for p in target.iterdir() if p.is_dir()) == ["few-0001", "few-0002"]


@pytest.mark.parametrize(
    "place", ["notes.txt", "fewer-0001/x.toml", "few-0001/notes.txt", "few-01x"]
)
def test_what_is_foreign_is_refused_and_left(tmp_path, place):
    foreign = tmp_path / "few" / place
    foreign.parent.mkdir(parents=True)
    foreign.write_text("mine", "utf-8")
    with pytest.raises(ResultError):
        made(tmp_path / "few", cad=False)
    assert foreign.read_text("utf-8") == "mine"
    assert not (tmp_path / "few" / "variants.csv").exists()


@pytest.mark.parametrize("link", ["few", "few/few-0001"])
def test_a_link_is_followed_nowhere(tmp_path, link):
    (elsewhere := tmp_path / "elsewhere").mkdir()
    (tmp_path / link).parent.mkdir(exist_ok=True)
    (tmp_path / link).symlink_to(elsewhere)
    with pytest.raises(ResultError, match="in the way"):
        made(tmp_path / "few", cad=False)
    assert not list(elsewhere.iterdir())


def test_a_second_writer_is_refused(tmp_path):
    def second(each, done):
        with pytest.raises(ResultError, match="by another process"):
            made(tmp_path / "few", cad=False)

    (tmp_path / "few").mkdir()
    (tmp_path / "few" / ".few-0004.lock").touch()  # as while a worker writes, or was killed
    assert len(made(tmp_path / "few", cad=False, report=second)) == 6
    assert not list((tmp_path / "few").glob(".*.lock"))


@pytest.mark.slow
def test_killed_and_run_again_it_ends_as_if_undisturbed(tmp_path, fake_cad):
    study = tmp_path / "few.toml"
    study.write_text(TEXT, "utf-8")
    (tmp_path / "tests_generate_killed.py").write_text(KILLED, "utf-8")
    fake_cad.setenv("FAKE_CAD", "hangs")  # at the two variants of 9 plates
    few = tmp_path / "few"
    process = subprocess.Popen([sys.executable, "-m", "tests_generate_killed", study, few])
    end = time.monotonic() + 20.0
    while not (few / "few-0003").exists() and time.monotonic() < end:
        time.sleep(0.05)
    process.send_signal(signal.SIGKILL)
    process.wait()
    assert (few / "few-0003" / "finger.step").exists()
    assert list(few.glob(".*.partial-*"))
    fake_cad.delenv("FAKE_CAD")
    found = made(few)
    assert [each.existed for each in found][:4] != [False] * 4
    made(tmp_path / "whole" / "few")
    again, whole = (
        {path.relative_to(home): path.read_bytes() for path in home.rglob("*") if path.is_file()}
        for home in (few, tmp_path / "whole" / "few")
    )
    assert again == whole


def test_a_full_disk_leaves_no_step_file_cut_short(tmp_path):
    step = tmp_path / "finger.step"
    step.write_text("ISO-10303-21;\n#1 = CARTESIAN_POI", "utf-8")
    with pytest.raises(GeometryError, match="disk full"):
        check_whole_step(step)
    step.write_text("ISO-10303-21;\nENDSEC;\nEND-ISO-10303-21;\n", "utf-8")
    check_whole_step(step)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("fate", "reported", "time_s"),
    [
        ("crashes", "SIGABRT", 60),
        ("hangs", "not done after 8 s", 8),
        ("fails", "nothing", 60),
    ],
)
def test_cad_that_fails_is_a_reason_and_the_rest_goes_on(
    tmp_path, fake_cad, fate, reported, time_s
):
    """Where one hangs the others have seconds: a busy machine takes four to start a process."""
    fake_cad.setenv("FAKE_CAD", fate)
    target = tmp_path / "few"
    text = TEXT.replace(', "<b>x</b>"', "") + f"[limits]\ntime_s = {time_s}\n"
    found = made(target, text, workers=2)
    assert [each.failed for each in found] == [True, False, False]
    first, second = rows(target / "variants.csv")
    assert reported in first["cad"]
    assert second["cad"] == "written"
    assert os.listdir(target / "few-0001") == ["few-0001.toml"]
    fake_cad.delenv("FAKE_CAD")
    again = made(target, text, workers=2)
    assert [each.existed for each in again] == [False, True, False]
    assert not any(each.failed for each in again)
    assert (target / "few-0001" / "finger.step").exists()


def test_cad_requested_later_is_added_and_stays(tmp_path, fake_cad):
    made(tmp_path / "few", cad=False)
    for cad in (True, False):
        found = [each.cad for each in made(tmp_path / "few", cad=cad)]
        assert found == ["written"] * 4 + [""] * 2


def test_the_most_frequent_reason_is_first_and_counts_each_variant_once():
    faults = {key: Fault(key, 1, "at most 0", "lower it") for key in "abc"}
    found = [
        Variant(k, f"v{k}", {}, None, tuple(faults[key] for key in keys))
        for k, keys in enumerate(("a", "bb", "bc", "c"))
    ]
    counts = [(key, count, name) for key, count, _, name in reasons(found)]
    assert counts == [("b", 2, "v1"), ("c", 2, "v2"), ("a", 1, "v0")]
