"""bench molds: it goes on where it stopped, its checks can fall short, a report is read rightly."""

import json

import pytest
from fingerdesign_bench.any_finger import molds
from fingerdesign_bench.any_finger.molds import checks_of, design_of, remedies_of, reported
from fingerdesign_bench.files import CRASHED, resumed
from fingerdesign_cli.main import main

from fingerdesign.checks.load import with_values
from fingerdesign.design.shipped import shipped_names
from fingerdesign.errors import DesignError
from fingerdesign.mold.plan.planning import plan_mold

REASON = "mold.limits.slot_mm = 0.2: must be at least 0.3; raise it"
REFUSED = {"status": "refused", "reason": REASON, "remedy": "mold.limits.slot_mm = 0.3"}
REFUSED |= {"then": "made", "volume_error": None}


def record(**changed):
    numbers = {"volume_error": 1e-9, "insert_chord_mm": 0.009, "chord_mm": 0.01, "seconds": 9.0}
    made = {"status": "made", "failed": [], "checks": 80, "kinds": ["arc", "level"]}
    return made | numbers | changed


def failing(*records):
    return [check.name for check in checks_of(records, 2) if not check.holds]


def test_an_interrupted_run_goes_on_where_it_stopped(tmp_path):
    path, called = tmp_path / "new" / "some.sqlite", []

    def work(case):
        called.append(case)
        return record(status=CRASHED if case == 2 else "made", case=case)

    def run(version, **cases):
        return resumed(path, version, cases, work, lambda message: None, workers=2)

    run("one", a=1, b=2)
    found = run("one", c=3, b=2, a=1)
    assert sorted(called) == [1, 2, 2, 3]  # what crashed is made again
    assert {name: each["case"] for name, each in found.items()} == {"c": 3, "b": 2, "a": 1}
    with pytest.raises(DesignError, match="version"):
        run("another", a=1)


@pytest.mark.parametrize(
    ("invalid", "falls"),
    [
        ({"status": "failed", "failed": ["open"]}, "molds that fail a check"),
        ({"status": "crashed", "reason": "no"}, "crashes and hangs"),
        ({"volume_error": 2e-3}, "cavity less plates against the finger's body"),
        ({"insert_chord_mm": 0.011}, "chord on the contact surface"),
        ({"chord_mm": 0.011}, "chord on any part"),
        ({"seconds": 21.0}, "slowest answer, 2 at once"),
        (REFUSED | {"remedy": "", "then": "refused"}, "refusals whose remedies give no mold"),
        (REFUSED | {"then": "failed"}, "refusals whose remedies give no mold"),
    ],
)
def test_each_check_can_fall_short(invalid, falls):
    good = [record()] * 40
    assert failing(*good) == []
    assert failing(record(**invalid), *good) == [falls]


def test_three_of_a_hundred_may_be_refused_with_a_remedy_and_no_more():
    good, refused = [record()] * 97, record(**REFUSED)
    assert failing(*[refused] * 3, *good) == []
    assert failing(*[refused] * 4, *good) == ["designs without a mold"]


@pytest.mark.slow
def test_what_a_refusal_tells_to_set_is_tried_until_a_plan_is_found():
    design, _ = design_of("69")  # a core that no pins can hold
    with pytest.raises(DesignError) as error:
        plan_mold(design)
    changes = [change for fault in error.value.faults for change in remedies_of(fault)]
    assert {"body.core.bottom_mm": 0.0} in changes
    assert plan_mold(with_values(design, {"body.core.bottom_mm": 0.0})).walls


def test_a_report_is_summarised():
    def check(name, part, measured, ok=True):
        return {"name": name, "part": part, "ok": ok, "measured": measured, "sentence": name}

    checks = [
        check("chord", "contact_insert", 0.008),
        check("chord", "side_wall_left", 0.009),
        check("cavity is the finger", "", 3e-7),
        check("least wall", "base_plate", None),
    ]
    found = reported({"status": "ok", "checks": checks, "timings_s": {}})
    assert (found["status"], found["failed"], found["checks"]) == ("made", [], 4)
    assert found["volume_error"] == 3e-7
    assert (found["insert_chord_mm"], found["chord_mm"]) == (0.008, 0.009)
    wrong = [*checks, check("watertight", "base_plate", 2.0, ok=False)]
    found = reported({"status": "failed", "failure": "1 check", "checks": wrong, "timings_s": {}})
    assert (found["status"], found["failed"]) == ("failed", ["watertight"])
    found = reported({"status": "failed", "failure": "no solid", "checks": [], "timings_s": {}})
    assert (found["status"], found["failed"]) == ("failed", ["no solid"])


def test_the_command_reports_what_was_not_made(monkeypatch, tmp_path, capsys):
    def work(case):
        return record(name=case, **(REFUSED if case == "0" else {}))

    monkeypatch.setattr(molds, "apart", lambda *given: work)
    assert main(["bench", "molds", "--out", str(tmp_path), "--seeds", "40"]) == 0
    shown = capsys.readouterr().out
    assert "0 (arc, level): refused: mold.limits.slot_mm = 0.2" in shown
    assert "designs without a mold" in shown
    written = json.loads((tmp_path / "molds.json").read_text("utf-8"))
    assert len(written["designs"]) == 40 + len(shipped_names())
    first = next(each for each in written["kinds"] if each["kind"] == "arc")
    assert (first["designs"], first["refused"]) == (len(written["designs"]), 1)
