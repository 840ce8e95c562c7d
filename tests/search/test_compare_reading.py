"""Outcomes read from studies, lists and analyses; what is none of these is refused by name."""

import json
from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.errors import DesignError
from fingerdesign.records.arrays import ContactHistory, write_packed
from fingerdesign.records.outcome import Failure
from fingerdesign.records.result import (
    GripResult,
    IncrementResult,
    MeshSummary,
    ModelSummary,
    Result,
)
from fingerdesign.search.compare.read import read_comparison
from fingerdesign.search.compare.recommend import Bound, Objective, recommend
from fingerdesign.search.compare.words import summary
from tests.support.any_outcomes import any_outcomes
from tests.support.result_folders import write_result_folder

MADE = any_outcomes(12)


def read_outcomes(paths):
    return read_comparison(paths).outcomes


def write_study(folder, outcomes, **record):
    folder.mkdir(parents=True)
    text = "".join(f"{outcome.to_json()}\n" for outcome in outcomes)
    (folder / "outcomes.jsonl").write_text(text, encoding="utf-8")
    (folder / "study.json").write_text(json.dumps(record), encoding="utf-8")
    return folder


def test_study_folder(tmp_path):
    record = {
        "name": "mine",
        "objectives": [{"metric": "cost", "goal": "min"}],
        "constraints": {"peak_ratio": {"at_most": 3}},
        **{"seed": 7, "fixed": {}, "parameters": {"plates.count": [9, 11]}},
    }
    found = read_comparison([write_study(tmp_path / "s", MADE, **record)])
    assert found.outcomes == MADE
    assert found.facts.name == "mine"
    assert found.facts.objectives == (Objective("cost", "min"),)
    assert found.facts.constraints == (Bound("peak_ratio", None, 3),)
    assert found.facts.record == {"seed": "7", "parameters: plates.count": "[9, 11]"}
    assert not found.facts.assumed_objectives


def test_outcomes_that_are_missing_are_warned_of(tmp_path):
    whole, part = (write_study(tmp_path / f"{n}", MADE[:n], name="mine") for n in (len(MADE), 8))
    for folder in (whole, part):
        record = {"name": "mine", "outcomes": {"all": len(MADE)}}
        (folder / "study.json").write_text(json.dumps(record), encoding="utf-8")
    for path in (part, part / "outcomes.jsonl"):
        found = read_comparison([path])
        best = recommend(found.outcomes, found.facts.objectives, found.facts.constraints)
        for each in (best, replace(best, chosen=None)):
            words = summary(found.outcomes, found.facts, each).warnings[0]
            assert words.startswith(f"{path} holds 8 of the {len(MADE)} outcomes")
    assert not read_comparison([whole, whole / "outcomes.jsonl"]).facts.missing


def test_shards_are_compared_in_one_order_whatever_theirs_is(tmp_path):
    first, second = (
        write_study(tmp_path / f"s.{k + 1}-of-2", MADE[k::2], name="s", digest="d") for k in (0, 1)
    )
    found = read_comparison([second, first])
    assert found == read_comparison([first, second]) == read_comparison([tmp_path])
    assert found == read_comparison([first, tmp_path, first / "../s.1-of-2"])  # each place once
    assert found.outcomes == (*MADE[::2], *MADE[1::2])


def test_shards_of_another_study_are_refused(tmp_path):
    shards = [
        write_study(tmp_path / f"s.{k}-of-3", MADE[k::3], name="s", digest=digest)
        for k, digest in ((1, "d"), (2, "d"), (3, "other"))
    ]
    with pytest.raises(DesignError) as refusal:
        read_comparison(shards)
    (other,) = map(str, refusal.value.faults)
    assert "s.3-of-3" in other
    assert "must be of the study of s.1-of-3" in other


def test_one_digest_stands_once_and_designs_of_one_name_are_distinguished(tmp_path):
    write_study(tmp_path / "a", MADE[:8])
    write_study(tmp_path / "b", MADE[4:])
    assert read_outcomes([tmp_path]) == MADE
    assert read_outcomes([tmp_path / "b", tmp_path / "a" / "outcomes.jsonl"])[0] == MADE[4]
    same = [replace(each, name="twin") for each in any_outcomes(4, failed=0.0)]
    for folder, some in (("first", same[:1]), ("second", same[1:2]), ("third", same[2:])):
        write_study(tmp_path / folder, some)
    both = read_outcomes([tmp_path / "first", tmp_path / "second"])
    assert [each.name for each in both] == ["twin (first)", "twin (second)"]
    for parent, some in (("x", same[:1]), ("y", same[1:2])):
        (tmp_path / parent).mkdir()
        write_study(tmp_path / parent / "own", some)
    places = [tmp_path / parent / "own" for parent in "xy"]
    assert [each.name for each in read_outcomes(places)] == [f"twin ({each})" for each in places]
    one = read_outcomes([tmp_path / "third"])
    assert [each.name for each in one] == [f"twin ({each.digest[:8]})" for each in same[2:]]


def test_every_wrong_path_is_named(tmp_path):
    folder = write_study(tmp_path / "s", MADE)
    (folder / "outcomes.jsonl").write_text(MADE[0].to_json()[:-9] + "\n", encoding="utf-8")
    with pytest.raises(DesignError, match="nowhere") as caught:
        read_comparison([tmp_path / "nowhere", folder])
    assert "outcomes.jsonl, line 1" in str(caught.value)


def result(**changes):
    """One that failed, but for ``changes``."""
    grips = tuple(
        GripResult("paper", mu, 500.0, True, mu == 0.8, 10.0, 2.4, margin, 0.3, 12.0, 0.0, 40)
        for mu, margin in ((0.2, 1.2), (0.8, 1.6))
    )
    keys = {"design.name": "mine", "body.width_mm": 22.0, "scene.object.shape": "plane"}
    facts = {"parameters": keys, "grips": grips, "status": "failed", "failure": "No mesh."}
    facts |= {"fidelity": "3d", "versions": {"numpy": "2"}}
    return Result("mine", "fundamental", "d" * 64, **(facts | changes))


def test_analysis_becomes_an_outcome(tmp_path, plain_result):
    found = read_outcomes([write_result_folder(tmp_path / "mine", plain_result)])[0]
    assert (found.name, found.status, found.fidelity) == ("mine", "ok", "plane-strain")
    assert found.design == {"design": {"name": "mine"}, "body": {"width_mm": 22.0}}
    assert found.metrics["grip_success"] == 0.5
    assert found.metrics["safety_margin"] == pytest.approx(1.4)
    least = 0.5 * 0.5 * 9.80665 / 0.2
    assert found.metrics["peak_ratio"] == pytest.approx(12.0 / least * (1 + 4) / 2)


def test_an_analysis_has_every_verdict_counted(tmp_path, plane_strain):
    grips = plane_strain.result.grips
    slips = (*grips[1:], replace(grips[0], gross_slip=True))
    for count, own in enumerate((grips, slips)):
        made = replace(plane_strain.result, grips=own)
        found = read_outcomes([write_result_folder(tmp_path / f"{count}", made)])[0]
        assert found.metrics["failed_verdicts"] == count
        assert found.metrics["area_correlation"] is not None


def test_analyses_next_to_a_study_have_the_values_of_what_is_varied(tmp_path, plain_result):
    narrower = replace(plain_result, parameters={"body.width_mm": 21.0})
    write_result_folder(tmp_path / "mine", narrower)
    write_study(tmp_path / "s", MADE)
    found = read_outcomes([tmp_path / "s", tmp_path / "mine"])
    mine = found[-1]
    assert set(MADE[0].values) <= set(mine.values)
    assert mine.values["plates.angle_deg"] is None  # its record does not say
    assert mine.values["body.width_mm"] == 21.0
    first = next(each for each in found if each.design)
    assert first.values["body.width_mm"] == first.design["body"]["width_mm"]
    assert MADE[0].values.items() <= found[0].values.items()


def test_of_analyses_alone_the_keys_in_which_they_differ_are_varied(tmp_path, plain_result):
    other = {"body.width_mm": 20.0, "grip.seed": 3, "design.name": "other"}
    for name, more in (("a", {}), ("b", other), ("c", {"grip.seed": 3})):
        changed = replace(
            plain_result, design=name, digest=name * 64, parameters=plain_result.parameters | more
        )
        write_result_folder(tmp_path / name, changed)
    a, b, c = (tmp_path / name for name in "abc")
    assert [o.values for o in read_outcomes([a, b])] == [
        {"body.width_mm": 22.0},
        {"body.width_mm": 20.0},
    ]
    # Of one finger: the rest.
    assert [o.values for o in read_outcomes([a, c])] == [{"grip.seed": None}, {"grip.seed": 3}]


def test_contact_is_that_of_the_arrays(tmp_path, plain_result):
    row = IncrementResult(0.1, 0.0, 1.0, 0.0, 1.0, 1.0, 1, 1, 0, 0.1, 1, 0.0)
    keys = {"design.name": "mine", "body.width_mm": 20.0, "plates.count": 0}
    known = replace(plain_result, increments=(row,), parameters=keys, grips=())
    folder = write_result_folder(tmp_path / "mine", known)
    assert read_outcomes([folder])[0].traces.status == ()
    nothing = np.zeros((1, 2, 1))
    history = ContactHistory(
        np.array([[-1.0, 12.0], [1.0, 12.0]]),
        np.ones(2),
        np.array([[0, 1]]),
        np.array([[0, 1]]),
        np.zeros((1, 2)),
        nothing,
        nothing,
    )
    write_packed(folder / "arrays.npz", {"contact": history})
    traces = read_outcomes([folder])[0].traces
    assert traces.status == (".#",)
    assert traces.contact_x_mm == (-1.0, 1.0)
    (folder / "arrays.npz").write_bytes(b"no arrays")
    assert read_outcomes([folder])[0].traces.status == ()


@pytest.fixture
def plain_result():
    model, mesh = ModelSummary(2, "t", 10, 5, False), MeshSummary("m", 3, 30.0, 0.0, None)
    facts = {"status": "ok", "failure": None, "fidelity": "plane-strain"}
    return replace(result(), **facts, model=model, mesh=mesh)


GOOD = any_outcomes(3, failed=0.0)
COST = f'"cost":{GOOD[0].metrics["cost"]}'


def refused(path, *names):
    with pytest.raises(DesignError) as caught:
        read_comparison([path])
    reported = str(caught.value)
    assert "run" in reported  # again
    assert len(reported) < 2000
    assert all(name in reported for name in names)


@pytest.mark.parametrize(
    ("record", "named"),
    [
        ('{"objectives": "cost"}', "objectives"),
        ('{"objectives": [{"metric": "cost", "goal": "least"}]}', "objectives"),
        ('{"objectives": [{"metric": 3, "goal": "min"}]}', "objectives"),
        ('{"constraints": {"cost": {"most": 3}}}', "constraints"),
        ('{"constraints": {"cost": {"at_most": "</script>"}}}', "constraints"),
        ("[" * 100_000, ""),
        ('{"constraints": {"cost": {"at_most": 1' + "0" * 400 + "}}}", ""),
        ('{"constraints": {"cost": {"at_most": 1e999}}}', ""),
        ('{"constraints": {"cost": {"at_least": NaN}}}', ""),
        ('{"seed": ' + "9" * 5000 + "}", ""),
        ('{"parameters": ' + "[" * 200 + "]" * 200 + "}", ""),
        ("\xff", ""),
    ],
    ids=range(12),
)
def test_wrong_records_of_studies_are_refused(tmp_path, record, named):
    folder = write_study(tmp_path / "s", GOOD)
    (folder / "study.json").write_text(record, encoding="latin-1")
    refused(folder, "study.json", named)


@pytest.mark.parametrize(
    "line",
    [
        "[" * 100_000,
        '{"digest": ' + "9" * 5000 + "}",
        *(GOOD[0].to_json().replace(COST, f'"cost":{no}') for no in ("NaN", "Infinity", "1e999")),
    ],
    ids=range(5),
)
def test_wrong_lines_of_outcomes_are_refused(tmp_path, line):
    assert COST in GOOD[0].to_json()
    (tmp_path / "outcomes.jsonl").write_text(f"{GOOD[1].to_json()}\n{line}\n", encoding="utf-8")
    refused(tmp_path, "outcomes.jsonl, line 2")


@pytest.fixture
def analysed(tmp_path, plain_result):
    grips = (replace(plain_result.grips[0], friction_coefficient=0.5),)
    return write_result_folder(tmp_path / "mine", replace(plain_result, grips=grips))


@pytest.mark.parametrize("row", ["1.0", "nan,1.0", "1.0,inf", "1e300,1.0", "a,b", "1.0,\0"])
def test_rows_of_grips(analysed, row):
    name = "grip_paper_mu0.5_500g.csv"
    path = analysed / name
    path.write_text(f"normal_force_N,tangential_force_N\n1.0,0.5\n{row}\n", encoding="utf-8")
    refused(analysed, name)
    path.write_text("normal_force_N\n1.0\n", encoding="utf-8")
    refused(analysed, name)
    path.write_text("normal_force_N,tangential_force_N\n1.0,0.5\n", encoding="utf-8")
    (found,) = read_comparison([analysed]).outcomes
    assert found.grips[0].normal_force_N == (1.0,)


def test_grips_that_agree_to_the_digits_shown_have_a_file_each(tmp_path, plain_result):
    grips = [replace(plain_result.grips[0], friction_coefficient=0.5 + k * 1e-7) for k in (0, 1)]
    folder = write_result_folder(tmp_path / "mine", replace(plain_result, grips=tuple(grips)))
    for end, force in (("", 1.0), ("_2", 2.0)):
        text = f"normal_force_N,tangential_force_N\n{force},0.5\n"
        (folder / f"grip_paper_mu0.5_500g{end}.csv").write_text(text, encoding="utf-8")
    (found,) = read_comparison([folder]).outcomes
    assert [grip.normal_force_N for grip in found.grips] == [(1.0,), (2.0,)]


def test_what_an_analysis_lacks_is_worked_on_request(tmp_path, plain_result):
    study = write_study(tmp_path / "s", GOOD, cost={"plate": 3.0})
    mine = write_result_folder(tmp_path / "mine", plain_result)
    requested = []

    def work(jobs):
        requested.extend(jobs)
        made = {"stick_error": 0.15, "cost": 7.0, "grip_success": 0.0}
        return [replace(GOOD[0], metrics=made) for _ in jobs]

    found = read_comparison([study, mine], work=work).outcomes[-1]
    (job,) = requested
    assert (job.design.body.width_mm, job.cost.plate, job.scene) == (22.0, 3.0, None)
    assert (found.metrics["stick_error"], found.metrics["cost"]) == (0.15, 7.0)
    assert found.metrics["grip_success"] == 0.5  # its own stays
    assert "cost, stick_error were computed" in found.warnings[-1]

    def failing(jobs):
        return [replace(GOOD[0], status="failed", failure=Failure("failed", "No mesh."))]

    found = read_comparison([study, mine], work=failing).outcomes[-1]
    assert "stick_error" not in found.metrics
    assert "No mesh." in found.warnings[-1]


def test_every_damaged_result_of_a_folder_is_named(tmp_path):
    for name, text in (("a", "{"), ("b", "[]")):
        (tmp_path / name).mkdir()
        (tmp_path / name / "result.json").write_text(text)
    with pytest.raises(DesignError) as caught:
        read_comparison([tmp_path])
    assert [each.key for each in caught.value.faults] == ["JSON", "JSON"]
    assert "a/result.json" in str(caught.value)
    assert "b/result.json" in str(caught.value)
