"""The whole folder of a mold: record, report, drawings; checks that fail; CAD that fails.

Stages are hand-made but for the last two tests, which make shipped fingers' molds.
"""

import json
import re
from contextlib import nullcontext
from dataclasses import replace
from functools import partial
from types import SimpleNamespace
from xml.etree import ElementTree

import jsonschema
import pytest
from fingerdesign_cli.main import main

from fingerdesign.checks.load import with_values
from fingerdesign.design.mold import Mold
from fingerdesign.errors import DesignError, Fault, GeometryError
from fingerdesign.mold import make
from fingerdesign.mold.part import Check
from fingerdesign.mold.picture import Badge, Picture, Pictures, pictures_job
from fingerdesign.mold.plan.limits import limits_of
from fingerdesign.mold.record import mold_digest
from fingerdesign.records.base import ResultError, json_schema
from tests.support.molds import read_3mf

PASSED = Check("watertight", "core", True, 0.0, 0.0, "edges", "no edge is open")
FAILED = Check("wall", "base_plate", False, 0.5, 1.0, "mm", "its least wall is 0.5 mm")
FILES = [
    *("assembly.step", "base_plate.step", "base_plate.stl", "bill_of_materials.csv"),
    *("comb_back.dxf", "comb_front.dxf", "exploded.png", "mold.3mf", "mold_report.json"),
    *("plates.dxf", "profile.toml", "report.html", "coupon.3mf"),
    *("mount.dxf", "nested_combs_0.3mm.dxf", "nested_phosphor_bronze_0.1mm.dxf"),
]
CHANGE = {"rms": 0.01, "worst": 0.03, "worst_plate": 1}
EFFECT = {
    "reason": None,
    "sentences": ["A plate 0.04 mm off changes its reading by up to 3 % of the largest."],
    "changes": [{"name": "along_x", "largest": 0.04, "unit": "mm", **CHANGE}],
    "together": CHANGE,
}

LEADS = {"reason": None, "words": "4 wires", "reading_error": 0.01, "sentences": ["They are thin."]}


def names_in(folder):
    return sorted(path.name for path in folder.iterdir())


def record_in(folder):
    data = json.loads((folder / "mold_report.json").read_text("utf-8"))
    jsonschema.validate(data, json_schema("mold"))
    return data


def raising(error):
    """A stage that fails."""

    def fail(*given, **named):
        raise error

    return fail


PICTURE = Picture(b"PNG", (Badge(1, "contact_insert", 0.5, 0.2),), "The mold opened.")
UNDRAWN = {
    "pictures_job": lambda *given: nullcontext(),
    "pictures_of": lambda *given: Pictures(PICTURE, {}),
}


@pytest.fixture
def replaced(monkeypatch):
    """``replaced(STAGE=...)``: the mold is made with these stages."""

    def replace_stages(**changed):
        for name, stage in changed.items():
            monkeypatch.setattr(make, name, stage)

    return replace_stages


@pytest.fixture
def stages(hand_made, replaced):
    """``stages(checks=..., cad_error=..., STAGE=...)``: the design, its stages hand-made."""

    def install(checks=(PASSED,), cad_error=None, drawn=False, effect=EFFECT, **changed):
        design, plan, meshes = hand_made()

        def mold_meshes(planned, folder):
            for name in ("assembly.step", "base_plate.step", "base_plate.stl"):
                (folder / name).write_text("x")
            if cad_error is not None:
                raise cad_error
            return meshes

        stand_ins = {
            "plan_mold": lambda given: replace(plan, design=given),
            "mold_meshes": mold_meshes,
            "run_checks": lambda *given: tuple(checks),
            "concurrently": lambda *given, **limits: nullcontext(),
            "_effect_of": lambda job, of: dict(LEADS if "leads" in of else effect),
        }
        replaced(**(stand_ins | ({} if drawn else UNDRAWN) | changed))
        return design

    return install


def test_the_folder_holds_everything_its_record_fits_its_schema_and_its_page_shows_it(
    stages, tmp_path, golden
):
    report = make.write_mold(stages(), tmp_path / "block")
    golden("mold_folder", *(tmp_path / "block" / each for each in FILES if "base" not in each))
    assert report["status"] == "ok"
    assert names_in(tmp_path / "block") == sorted(FILES)
    data = record_in(tmp_path / "block")
    assert data["files"] == sorted(FILES)
    assert data["silicone"]["mass_g"] > 0.0
    assert [part["number"] for part in data["parts"]] == list(range(1, 10))
    assert data["plates"][0]["count"] == 3
    assert {"plan", "cad", "checks", "files", "picture"} <= set(data["timings_s"])
    page = (tmp_path / "block" / "report.html").read_text("utf-8")
    assert "http" not in page.replace("http-equiv", "")
    assert "<script" not in page
    for words in ("All 1 checks passed", "gate: pour in here", "2 bolts (M3 x 35"):
        assert words in page
    assert page.count('type="checkbox"') > 20
    assert "data:image/png;base64," in page
    assert page.count('class="badge"') == 1
    # The plan of the base plate: x to the right.
    holes = data["base"]["holes"]
    kinds = [hole["kind"] for hole in holes]
    assert kinds == [*["vent"] * 4, "wires", "gate", "riser", *["lock"] * 6]
    drawn = ElementTree.fromstring(page[page.index("<svg") : page.index("</svg>") + len("</svg>")])
    circles = [float(each.get("cx")) for each in drawn.iter("circle")]
    assert [circle > 320 for circle in circles] == [hole["x_mm"] > 0 for hole in holes]
    gate = next(hole for hole in holes if hole["kind"] == "gate")
    assert f"G gate at x {gate['x_mm']:.1f}, z {gate['z_mm']:.1f} mm" in page


FILM = {"mold.gage": "sputtered_film", "mold.leads": "leg"}


@pytest.mark.parametrize(
    ("keys", "worst", "reasons"),
    [
        ({}, 0.03, ["no gage that is sold fits"]),
        (FILM, 0.03, []),
        ({"mold.gage": "sputtered_film"}, 0.03, ["wires cannot be soldered to it"]),
        (FILM, 0.21, ["up to 21 % of the largest"]),
        ({}, 0.7, ["up to 70 % of the largest", "no gage that is sold fits"]),
    ],
)
def test_ready_to_cast_is_stated_of_a_sensor(stages, tmp_path, keys, worst, reasons):
    effect = {**EFFECT, "together": {**CHANGE, "worst": worst}}
    design = with_values(stages(effect=effect), keys)
    assert make.make_mold(design, tmp_path)["status"] == "ok"
    page = (tmp_path / "report.html").read_text("utf-8").replace("\xa0", " ")
    sensor = record_in(tmp_path)["sensor"]
    assert sensor["reading_error"] == pytest.approx(worst)
    assert sensor["to_measure"] == ("mold.gage" in keys)
    assert sensor["to_measure"] == ("sputtered_film, made to measure" in page)
    assert len(sensor["reasons"]) == len(reasons)
    assert sensor["ready"] == (not reasons) == ("ready to cast" in page)
    for reason, words in zip(sensor["reasons"], reasons, strict=True):
        assert words in reason
        assert words in page


FULL = OSError(28, "No space left on device")
UNDERCUT = "side_wall_right: face 7 is an undercut"


@pytest.mark.parametrize(
    ("given", "failure", "names"),
    [
        ({"checks": (PASSED, FAILED)}, "1 of 2 checks failed: wall (base_plate)", sorted(FILES)),
        ({"cad_error": GeometryError(UNDERCUT)}, UNDERCUT, ["mold_report.json", "report.html"]),
    ],
)
def test_a_mold_that_fails_leaves_a_record_that_says_so(stages, tmp_path, given, failure, names):
    make.write_mold(stages(**given), tmp_path / "block")
    assert names_in(tmp_path / "block") == names
    data = record_in(tmp_path / "block")
    assert (data["status"], data["failure"]) == ("failed", failure)
    page = re.sub(
        r"</?(?:a|button)\b[^>]*>", "", (tmp_path / "block" / "report.html").read_text("utf-8")
    )
    assert (UNDERCUT if "cad_error" in given else "its least wall is 0.5\xa0mm") in page


def test_a_file_that_cannot_be_written_keeps_the_checks(stages, tmp_path):
    fail = raising(GeometryError("comb_front: the border of its flat face meets itself"))
    design = stages(checks=(PASSED, FAILED), write_drawings=fail)
    report = make.make_mold(design, tmp_path)
    assert report["failure"].startswith("comb_front: the border")
    assert report["failure"].endswith("1 of 2 checks failed: wall (base_plate)")
    assert [check["ok"] for check in report["checks"]] == [True, False]
    assert names_in(tmp_path) == ["mold_report.json", "report.html"]
    assert report["parts"] == report["plates"] == report["bill"] == []


def test_a_picture_that_fails_is_named_in_its_place(stages, tmp_path):
    design = stages(drawn=True, pictures_job=partial(pictures_job, time_limit_s=0.01))
    report = make.make_mold(design, tmp_path)
    assert report["status"] == "ok"
    assert "The mold could not be drawn" in (tmp_path / "report.html").read_text("utf-8")
    assert "exploded.png" not in report["files"]


def test_digests_tell_molds_apart_and_fingers_not_and_take_designs_alone(hand_made, tmp_path):
    one, other = hand_made()[0], hand_made(draft_deg=3.0)[0]
    assert one.digest() == other.digest()
    assert mold_digest(one) != mold_digest(other)
    with pytest.raises(TypeError, match="takes a Design, not str"):
        make.make_mold("maeno2000", tmp_path)


@pytest.fixture
def command(tmp_path, terminal):
    """``command(*options, code=0)``: what `mold` says that works into tmp_path / "out"."""
    path = tmp_path / "block_by_hand.toml"
    # Which gage fits is asked of ready.py by its own tests: a plan for each takes seconds.
    film = 'mold.gage = "sputtered_film"\nmold.leads = "leg"\n'
    path.write_text(f'design.name = "block_by_hand"\nplates.count = 3\n{film}', encoding="utf-8")
    return partial(terminal, "mold", path, "--out", tmp_path / "out")


def test_the_command_exits_1_where_a_check_fails(stages, command, tmp_path):
    stages(checks=(FAILED,))
    shown = command("--process", "fdm", "--fixture", "slots", "--json", code=1)
    data = json.loads(shown.out)
    assert data["status"] == "failed"
    assert "wall (base_plate): its least wall is 0.5 mm" in shown.err
    assert (tmp_path / "out" / "block_by_hand" / "mold_report.json").is_file()
    process = data["process"]  # the command's go before the table's
    assert (process["name"], process["plate_fixture"]) == ("fdm", "slots")
    assert process["limits"]["slot_mm"] == limits_of(Mold(process="fdm")).slot_mm
    profile = tmp_path / "mine.toml"
    profile.write_text('process = "sla"\n[limits]\nslot_mm = 0.41\n', encoding="utf-8")
    shown = command("--profile", profile, "--process", "fdm", "--json", code=1)
    data = json.loads(shown.out)
    assert f"--process fdm with the limits of {profile}" in shown.err
    assert (data["process"]["name"], data["process"]["limits"]["slot_mm"]) == ("fdm", 0.41)


def test_the_command_exits_2_for_a_mold_that_cannot_be(stages, command, tmp_path):
    fault = Fault("mold.draft_deg", 30.0, "at most 12.5", "lower it")
    stages(plan_mold=raising(DesignError([fault, replace(fault, key="mold.wall_mm")])))
    lines = command("--quiet", code=2).err.splitlines()
    keys = [line.split(" = ")[0].split(": ")[-1] for line in lines]
    assert keys == ["mold.draft_deg", "mold.wall_mm"]
    assert not (tmp_path / "out" / "block_by_hand").exists()


@pytest.mark.parametrize(
    ("held", "words"),
    [
        ("mine.step", "mine.step"),
        ("core.stl", "no mold_report.json"),
        ("report.html", "no mold_report.json"),
        ("core.step/mine", "core.step"),
    ],
)
def test_what_is_no_mold_is_not_replaced(stages, command, tmp_path, held, words):
    stages()
    foreign = tmp_path / "out" / "block_by_hand" / held
    foreign.parent.mkdir(parents=True)
    foreign.write_text("x")
    assert words in command("--quiet", code=2).err
    assert foreign.read_text("utf-8") == "x"


@pytest.mark.parametrize("stage", ["write_drawings", "write_3mf"])
def test_a_full_disk_leaves_the_older_mold(stages, tmp_path, stage):
    error = GeometryError("plates.dxf could not be written")
    error.__cause__ = FULL
    design = stages()
    target = tmp_path / "block"
    make.write_mold(design, target)
    before = (target / "mold_report.json").read_bytes()
    stages(**{stage: raising(error)})
    with pytest.raises(ResultError) as reported:
        make.write_mold(design, target)
    assert str(target) in str(reported.value)
    assert "No space left on device; the older mold is as it was; free space" in str(reported.value)
    assert (target / "mold_report.json").read_bytes() == before
    assert names_in(tmp_path) == ["block"]


def test_a_disk_that_takes_no_more_is_no_finding_about_the_mold(stages, tmp_path):
    error = GeometryError("base_plate.step: the CAD kernel wrote nothing")
    folders = SimpleNamespace(TemporaryFile=raising(FULL), gettempdir=lambda: str(tmp_path))
    design = stages(cad_error=error, tempfile=folders)
    with pytest.raises(ResultError, match="No space left on device; free space"):
        make.write_mold(design, tmp_path / "block")
    assert list(tmp_path.iterdir()) == []


def test_the_command_prints_parts_and_verdict_and_what_replaces_a_good_mold_says_so(
    stages, command
):
    stages()
    out = command().out
    # The insert is 47.4 x 6 x 29.3 mm.
    for words in ("contact insert", " 8.33 ", "mold ✓ castable, 1 of 1 checks", "sensor"):
        assert words in out
    stages(checks=(FAILED,))
    for replaced in (True, False):
        err = command("--quiet", code=1).err
        assert ("replaces an older mold that had passed" in err) is replaced


def test_an_interruption_writes_nothing_and_says_so(stages, command, tmp_path):
    stages(cad_error=KeyboardInterrupt())
    out, err = command("--quiet", code=130)
    assert (out, err.strip()) == ("", "interrupted; nothing of the mold is stored")
    assert not (tmp_path / "out").exists()  # it was made for the mold


@pytest.mark.slow
def test_a_shipped_finger_can_be_cast(replaced, tmp_path, golden):
    """A closed mold with a core and slots; the README's is open, has combs and is drawn."""
    replaced(**UNDRAWN)
    assert main(["mold", "boned", "--fixture", "slots", "--out", str(tmp_path), "--quiet"]) == 0
    folder = tmp_path / "boned"
    golden("mold_boned", folder)
    data = record_in(folder)
    assert data["status"] == "ok"
    assert all(check["ok"] for check in data["checks"])
    assert names_in(folder) == data["files"]
    named = {name for part in (*data["parts"], *data["plates"]) for name in part["files"]}
    assert named <= set(data["files"])
    printed = {part["name"]: part for part in data["parts"] if part["made"] == "process"}
    held = read_3mf(folder / "mold.3mf")
    assert set(held) == {*printed, "mount"}  # which is printed too, but is no part of the mold
    for name, part in printed.items():
        _, triangles, volume = held[name]
        assert triangles == part["triangles"]
        assert volume == pytest.approx(part["volume_mm3"], rel=3e-3)  # chords
        assert part["chord_mm"] <= data["process"]["chord_mm"]
