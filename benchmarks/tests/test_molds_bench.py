"""bench molds: it goes on where it stopped, its checks can fall short, a report is read rightly."""

import json

import pytest
from fingerdesign_bench.any_finger import molds
from fingerdesign_bench.any_finger.molds import (
    LINES,
    Molds,
    measure_molds,
)
from fingerdesign_bench.any_finger.molds_worker import design_of, remedies_of, reported
from fingerdesign_bench.files import read_lines
from fingerdesign_cli.main import main

from fingerdesign.checks.load import with_values
from fingerdesign.design.shipped import shipped_names
from fingerdesign.errors import DesignError
from fingerdesign.mold.plan.planning import plan_mold


def record(case, **changed):
    numbers = {"volume_error": 1e-9, "insert_chord_mm": 0.009, "chord_mm": 0.01, "seconds": 9.0}
    made = {"status": "made", "reason": None, "failed": [], "checks": 80}
    return {"case": case, "name": case, "kinds": ["arc", "level"]} | made | numbers | changed


def failing(found):
    return [check.name for check in found.checks() if not check.holds]


def refused(case):
    reason = "mold.limits.slot_mm = 0.2: must be at least 0.3; raise it"
    then = {"remedy": "mold.limits.slot_mm = 0.3", "then": "made"}
    return record(case, status="refused", reason=reason, volume_error=None) | then


def test_an_interrupted_run_goes_on_where_it_stopped(monkeypatch, tmp_path):
    called, cases = [], [*shipped_names(), "0", "1", "2", "3"]
    monkeypatch.setattr(molds, "_run", lambda case: called.append(case) or record(case))
    measure_molds(tmp_path, seeds=4)
    assert sorted(called) == sorted(cases)
    path = tmp_path / LINES
    first, second, *rest, last = read_lines(path)
    changed = [first | {"version": "another"}, second | {"status": "crashed"}, *rest]
    unchanged = [json.dumps(each) for each in changed]
    path.write_text("\n".join([*unchanged, json.dumps(last)[:30]]), encoding="utf-8")
    called.clear()
    found = measure_molds(tmp_path, seeds=4)
    assert set(called) == {each["case"] for each in (first, second, last)}
    assert [each["case"] for each in found.records] == cases
    called.clear()
    measure_molds(tmp_path, seeds=4)
    assert called == []


@pytest.mark.parametrize(
    ("invalid", "falls"),
    [
        ({"status": "failed", "failed": ["open"]}, "molds that fail a check"),
        ({"status": "crashed", "reason": "no"}, "crashes and hangs"),
        ({"volume_error": 2e-3}, "cavity less plates against the finger's body"),
        ({"insert_chord_mm": 0.011}, "chord on the contact surface"),
        ({"chord_mm": 0.011}, "chord on any part"),
        ({"seconds": 21.0}, "slowest answer, 2 at once"),
    ],
)
def test_each_check_can_fall_short(invalid, falls):
    good = [record(str(k)) for k in range(40)]
    assert failing(Molds(good)) == []
    assert failing(Molds([record("40", **invalid), *good])) == [falls]


def test_three_of_a_hundred_may_be_refused_with_a_remedy_and_no_more():
    good, three = [record(str(k)) for k in range(97)], [refused("a"), refused("b"), refused("c")]
    assert failing(Molds([*three, *good])) == []
    assert failing(Molds([*three, refused("d"), *good])) == ["designs without a mold"]
    for then in ({"remedy": "", "then": "refused"}, {"then": "failed"}):
        found = failing(Molds([refused("a") | then, *good]))
        assert found == ["refusals whose remedies give no mold"]


def test_what_a_refusal_tells_to_set_is_tried_until_a_plan_is_found():
    design, _ = design_of("46")  # a core too thin for the pins that hold it
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
        check("chord", "base_plate", 0.0),
        check("chord", "side_wall_left", 0.009),
        check("cavity is the finger", "", 3e-7),
        check("least wall", "base_plate", None),
    ]
    found = reported({"status": "ok", "checks": checks, "timings_s": {}})
    assert (found["status"], found["failed"], found["checks"]) == ("made", [], 5)
    assert found["volume_error"] == 3e-7
    assert (found["insert_chord_mm"], found["chord_mm"]) == (0.008, 0.009)
    wrong = [*checks, check("watertight", "base_plate", 2.0, ok=False)]
    found = reported({"status": "failed", "failure": "1 check", "checks": wrong, "timings_s": {}})
    assert (found["status"], found["failed"]) == ("failed", ["watertight"])
    found = reported({"status": "failed", "failure": "no solid", "checks": [], "timings_s": {}})
    assert (found["status"], found["failed"]) == ("failed", ["no solid"])
    assert found["volume_error"] is None


def test_the_command_reports_what_was_not_made(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(molds, "_run", lambda case: refused(case) if case == "0" else record(case))
    code = main(["bench", "molds", "--out", str(tmp_path), "--seeds", "40"])
    shown = capsys.readouterr().out
    assert code == 0
    assert "0 (arc, level): refused: mold.limits.slot_mm = 0.2" in shown
    assert "designs without a mold" in shown
    written = json.loads((tmp_path / "molds.json").read_text("utf-8"))
    assert len(written["designs"]) == 40 + len(shipped_names())
    first = next(each for each in written["kinds"] if each["kind"] == "arc")
    assert (first["designs"], first["refused"]) == (len(written["designs"]), 1)
