"""An outcome's own text is read back; what only looks like one is refused."""

import csv
import io
import json
from dataclasses import fields, replace

import pytest

from fingerdesign.errors import MOST_TEXT, all_shown, shown
from fingerdesign.records.outcome import (
    Failure,
    GripOutcome,
    Outcome,
    OutcomeError,
    Traces,
    Validity,
    designs_csv,
    grips_csv,
    increments_csv,
)
from fingerdesign.records.verdict import Fix, Verdict, VerdictView
from tests.support.any_outcomes import HOSTILE, any_outcomes

GOOD = next(each for each in any_outcomes(6, failed=0.0) if each.status == "ok")


def changed(**changes):
    return json.dumps(json.loads(GOOD.to_json()) | changes)


def test_its_own_text():
    for each in any_outcomes(20):
        assert Outcome.from_json(each.to_json()) == each


def nested(depth):
    return changed(values={"k": "DEEP"}).replace('"DEEP"', "[" * depth + "]" * depth)


@pytest.mark.parametrize(
    "text",
    [
        changed(status="failed"),
        changed(failure={"kind": "crashed", "sentence": "it did"}),
        changed(metrics={"cost": 1e31}),
        changed(metrics={"cost": 10**400}),
        changed(values={"plates.count": 10**400}),
        changed(values={"plates.count": [[-(10**40)]]}),
        changed(design={"body": {"width_mm": 1e300}}),
        changed(traces={"gages": [[1.0, 1e200]]}),
        changed(seconds=1e31),
        changed(traces={"gages": [[1.0, 2.0], [1.0]]}),
        changed(traces={"gages": [[1.0], []]}),
        changed(traces={"gages": [[1.0]], "gage_x_mm": [0.0, 1.0]}),
        changed(traces={"gages": [[1.0]], "stick_ratio": [0.5, 0.6]}),
        changed(traces={"contact_x_mm": [0.0, 1.0], "status": ["#"]}),
        changed(traces={"contact_z_mm": [0.0, 1.0], "status": ["#"]}),
        changed(traces={"stick_ratio": [0.5, 0.6], "status": ["#"]}),
        changed(metrics={"cost": -1e31}),
        changed(schema_version=0),
        changed(grips=[json.loads(GOOD.to_json())["grips"][0] | {"normal_force_N": [1.0]}]),
        changed(values={"k": 1}).replace('"k": 1', '"k": ' + "9" * 5000),
        nested(40),
        nested(150),
        nested(100_000),
        "[" * 100_000,
    ],
    ids=range(24),
)
def test_what_no_page_could_bear_is_refused(text):
    with pytest.raises(OutcomeError):
        Outcome.from_json(text)


def rows(text):
    return list(csv.DictReader(io.StringIO(text)))


def test_designs_are_read_back_exactly():
    made = any_outcomes(30)
    found = rows(designs_csv(made))
    assert len(found) == 30
    for outcome, row in zip(made, found, strict=True):
        assert row["digest"] == outcome.digest
        assert float(row["body.arc_radius_mm"]) == outcome.values["body.arc_radius_mm"]
        for name, value in outcome.metrics.items():
            assert row[name] == ("" if value is None else str(value))
        assert row["failure_kind"] == (outcome.failure.kind if outcome.failure else "")


def test_a_line_is_a_row_whatever_the_names():
    made = any_outcomes(12, hostile=True)
    text = designs_csv(made)
    assert len(text.splitlines()) == 13
    cells = [cell for row in csv.reader(io.StringIO(text)) for cell in row]
    assert not [cell for cell in cells if cell.startswith(("=", "@"))]
    assert "'=1+1" in cells


def test_increments_and_grips():
    made = any_outcomes(6, failed=0.0)
    path = rows(increments_csv(made))
    assert len(path) == sum(len(o.traces.normal_force_N) for o in made)
    first = made[0].traces
    assert [float(row["gage_0_microstrain"]) for row in path[:24]] == [g[0] for g in first.gages]
    grips = rows(grips_csv(made))
    assert float(grips[59]["normal_force_N"]) == made[0].grips[0].normal_force_N[-1]


def test_shown_text_is_harmless_and_ends():
    for text in HOSTILE:
        assert not set(shown(text)) & {chr(0), chr(7), "\u2028", "\u202e", "\n"}
    assert len(shown("x" * 10_000_000)) == MOST_TEXT + 1
    assert all_shown({"a\n": [1, None, True, "\x1b[2J"]}) == {"a�": [1, None, True, "�[2J"]}


def test_notes_are_no_verdicts():
    for statuses, words in (
        (("fail", "pass", "warning", "note"), "1 of 3 fail"),
        (("pass", "warning", "warning", "note"), "1 pass, 2 warnings"),
        (("pass", "note"), "passes"),
        (("note", "note"), "numbers only"),
        (("pass", "pass", "note"), "all 2 pass"),
    ):
        verdicts = tuple(Verdict(status, "a", "1") for status in statuses)
        assert VerdictView("a", "3-D", 1.0, verdicts).summary == words
        assert VerdictView("a", "3-D", 1.0, verdicts, failure="No.").summary == "failed"
    assert Fix("a", "b", "c").effect == "b (c)"
    assert Fix("a", "b").effect == "b"


FACTS = {"digest": "d", "name": "n", "scene": "s", "fidelity": "3d", "status": "failed"}
WORK = {"seconds": 1.5, "core_seconds": 2.5, "peak_memory_MB": 3.5}


def test_each_value_stands_under_its_own_heading():
    path = {k.name: (10.0 + n, 20.0 + n) for n, k in enumerate(fields(Traces)[:6])}
    traces = Traces(**path, gage_x_mm=(0.0,), gages=((7.0,), (8.0,)))
    forces = {"normal_force_N": (1.0, 2.0), "tangential_force_N": (3.0, 4.0)}
    own = {"lifted": True, "gross_slip": False, "safety_margin": 1.25}
    own |= {"controller": "c", "friction_coefficient": 0.5, "object_mass_g": 200.0}
    held = GripOutcome(**own, peak_normal_force_N=9.0, minimum_stick_ratio=0.75, **forces)
    failure, checks = Failure("timeout", "late"), Validity(0.125, 0.25)
    made = Outcome(values={}, design={}, failure=failure, validity=checks, **FACTS, **WORK)
    made = replace(made, traces=traces, grips=(held, held), metrics={"core_seconds": 99.0})
    fuller = replace(made, traces=replace(traces, gage_x_mm=(0.0, 1.0), gages=((1.0, 2.0),) * 2))
    assert designs_csv([made]).splitlines()[0].count("core_seconds") == 1
    row = rows(designs_csv([made]))[0]
    checked = {"plane_strain_error": 0.125, "mesh_error": 0.25}
    failed = {"failure_kind": "timeout", "failure": "late"}
    assert row == {key: str(each) for key, each in (FACTS | failed | checked | WORK).items()}
    first, second, *_ = rows(increments_csv([made, fuller]))
    name = {"name": "n", "digest": "d"}
    for k, found in enumerate((first, second)):
        numbers = {key: str(each[k]) for key, each in path.items()}
        gages = {"gage_0_microstrain": str(7.0 + k), "gage_1_microstrain": ""}
        assert found == name | {"increment": str(k + 1)} | numbers | gages
    found = rows(grips_csv([made]))
    assert len(found) == 4
    for number, each in enumerate(found):
        step = {key: str(force[number % 2]) for key, force in forces.items()}
        about = {"grip": str(number // 2), "step": str(number % 2)}
        assert each == name | about | {key: str(value) for key, value in own.items()} | step
