"""The suite of known answers: every file is sound, references are what theory says, cases run."""

import csv
import doctest
import json
import re
from pathlib import Path

import numpy as np
import pytest
from fingerdesign_bench.accuracy import analytic
from fingerdesign_bench.known import measured, theory
from fingerdesign_bench.known.case import KINDS, Case, Outcome, load_cases
from fingerdesign_bench.known.export import judged, write_problem
from fingerdesign_bench.known.patches import sheared_brick
from fingerdesign_bench.known.run import run_cases, solution, write_suite
from fingerdesign_bench.known.sees import FAULTS, sees
from fingerdesign_bench.known.table import FILE

CASES = load_cases()
DOCS = Path(__file__).parents[2] / "docs/reference/suite.md"
# Problems of a second or less; the others are marked slow.
CHEAP = (
    *("patch_", "ssnv128", "wedge", "two_codes_plane_strain", "two_codes_plate", "order_ring"),
    *("flat_punch", "measured_disc", "measured_blocks", "line_", "order_layer"),
)
# Models of 5 to 33 s that `bench suite` runs. Tested here are one angle of each grid in space and
# all in plane strain. Gages along z are tested on known fields in tests/fem, and a twist in
# tests/contact; Hertz in space by two cylinders; a sphere by Mindlin's loop; Spence, and
# loads together, by a line.
SUITE_ALONE = {
    "off_centre",
    *("gages_0", "gages_45", "gages_90", "gages_along_z"),
    *("gages_tee_0", "gages_tee_45", "gages_tee_90", "gages_tee_along_z"),
    *("hertz_ball", "hertz_sphere", "lubkin", "measured_ring", "order_sphere", "product_pin"),
    "product_dome",
    *("together_sphere_below", "together_sphere_beyond", "spence_sphere_45_10"),
    *(f"spence_sphere_30_{each}" for each in (10, 15, 20, 30, 50)),
}
SOUND = {
    "name": "one",
    "quantity": "force",
    "title": "A case",
    "kind": "analytic",
    "function": "bodies.wedge",
    "source": "derived",
    "reference": 2.0,
    "uncertainty": 1e-3,
    "tolerance": 1e-2,
    "regression": 2.01,
    "regression_tolerance": 1e-3,
}


def named(name):
    return [case for case in CASES if case.name == name]


def test_there_are_many_and_each_names_what_it_should():
    assert len({case.name for case in CASES}) >= 40
    assert {case.kind for case in CASES} == set(KINDS)
    for case in CASES:
        assert len(case.source) > 10, case.words
        assert case.verdict(case.regression) in ("met", "known miss"), case.words
        json.dumps(Outcome(case, case.regression).as_dict(), allow_nan=False)


@pytest.mark.parametrize(
    "wrong", [{"kind": "guess"}, {"uncertainty": 0.1}, {"reference": 0.0}, {"known": 1.0}]
)
def test_a_case_that_cannot_be_is_refused(wrong):
    with pytest.raises((TypeError, ValueError)):
        Case(**{**SOUND, **wrong})


@pytest.mark.parametrize(
    ("value", "more", "verdict"),
    [
        (2.0101, {}, "met"),
        (2.0, {}, "changed"),
        (2.1, {}, "missed"),
        (2.1, {"known_miss": "another law", "regression": 2.1}, "known miss"),
        (2.1, {"known_miss": "another law"}, "changed"),
        (2.1, {"at_least": True, "regression": 2.1}, "met"),
        (float("nan"), {}, "missed"),
    ],
)
def test_verdicts(value, more, verdict):
    assert Case(**{**SOUND, **more}).verdict(value) == verdict


def test_a_quantity_that_is_no_number_fails_alone():
    answer = {"function": "case.Solution", "arguments": {"values": {"force": np.nan, "way": 2.01}}}
    cases = [Case(**{**SOUND, **answer, "quantity": each}) for each in ("force", "way")]
    lost, whole = run_cases(cases).outcomes
    assert (lost.verdict, whole.verdict) == ("missed", "met")
    assert lost.failure == "the answer is not a finite number"
    assert whole.failure == ""


def test_references_of_spence_lubkin_and_mindlin_are_what_theory_gives():
    for case in CASES:
        given = case.arguments
        if case.function == "histories.spence" and given["plane"]:
            found = theory.spence(given["poissons_ratio"], given["friction"], True)
            known = dict(zip(("stick", "centre"), found, strict=True))[case.quantity]
            assert known == pytest.approx(case.reference, abs=1e-5)
    (moment,) = (case for case in named("lubkin") if case.quantity == "moment")
    assert theory.lubkin(0.5)[1] == pytest.approx(moment.reference, rel=1e-5)
    (work,) = (case for case in named("mindlin_loop") if case.quantity == "work of a cycle")
    assert theory.mindlin_loss(0.8) == pytest.approx(work.reference, rel=1e-4)
    left, work = named("line_loop")
    assert theory.line_shift(0.0, 0.8) == pytest.approx(left.reference, rel=1e-7)
    assert theory.line_loss(0.8) == pytest.approx(work.reference, rel=1e-7)


def test_the_loss_of_a_line_contact_is_the_area_of_its_loop():
    shares = np.linspace(-0.8, 0.8, 20001)
    back = np.array([theory.line_shift(q, 0.8) for q in shares])
    assert np.trapezoid(back + back[::-1], shares) == pytest.approx(theory.line_loss(0.8), rel=1e-6)


@pytest.mark.parametrize(
    "name",
    [
        name if name.startswith(CHEAP) else pytest.param(name, marks=pytest.mark.slow)
        for name in dict.fromkeys(case.name for case in CASES)
        if name not in SUITE_ALONE
    ],
)
def test_a_case_is_met(name):
    for outcome in run_cases(named(name)).outcomes:
        assert not outcome.fails, outcome


def test_measured_references_are_what_their_sources_give():
    """Discs: points of the figure; rings and blocks: the laws."""
    for case in CASES:
        if case.function == "measured.disc":
            given = case.arguments
            points = dict(measured.FIG_27[given["shape_factor"]])
            assert points[given["percent"]] == case.reference
        elif case.function == "measured.ring":
            share = float(case.quantity.split()[1]) / 100.0
            law = measured.measured_ring(np.array(share))
            assert case.reference == pytest.approx(float(law), rel=1e-4)
        elif case.function == "measured.compression_modulus":
            given = {key: case.arguments[key] for key in ("youngs_modulus", "k", "bulk_modulus")}
            blocks = measured.measured_blocks(np.array(float(case.quantity[4:])), **given)
            assert case.reference == pytest.approx(float(blocks), rel=1e-5)


def test_what_is_written(tmp_path):
    found = run_cases([*named("wedge"), *named("patch_brick_0")])
    (path,) = write_suite(found, tmp_path)
    page = path.read_text("utf-8")
    assert all(outcome.case.words in page for outcome in found.outcomes)


def test_another_solver_is_judged_by_the_laws(tmp_path, in_tmp_path, capsys):
    """The page's example runs; forces that break a law do not pass."""
    problem, steps = sheared_brick().solved
    path = tmp_path / "suite" / "problems" / "equal_cylinders.npz"
    path.parent.mkdir(parents=True)
    write_problem(path, problem, steps)
    (block,) = re.findall(r"```python\n(.*?)```", DOCS.read_text("utf-8"), flags=re.DOTALL)
    exec(compile(block, "suite.md", "exec"), {"__name__": "page"})
    assert float(capsys.readouterr().out.strip("[] \n")) < 1e-9
    given = dict(np.load(path))
    for component, factor in ((0, 1.02), (1, 0.9), (1, -1.0)):
        forces = given["multiplier"].copy()
        forces[..., component] *= factor
        assert judged(given, forces).max() > 1e-3


def test_judging_along_a_path_that_slips_and_opens(tmp_path):
    path = tmp_path / "together.npz"
    write_problem(path, *solution(*named("together_line_beyond")[:1]).solved)
    given = np.load(path)
    assert judged(given, given["multiplier"]).max() < 1e-6


def test_closed_forms_as_their_examples_say():
    assert doctest.testmod(analytic).failed == doctest.testmod(theory).failed == 0


def test_faults_are_seen_by_the_rows_that_they_touch_and_leave_no_trace():
    wedge = named("wedge") or [case for case in CASES if case.function == "bodies.wedge"]
    rows = sees(wedge)
    assert rows["a friction 1 % off"] == [case.words for case in wedge]
    assert rows["a gage's sign"] == []
    assert not run_cases(wedge).fails


def test_the_record_of_what_sees_faults_is_of_the_rows_that_there_are():
    """Else `python -m fingerdesign_bench.known.sees --write` makes it again."""
    with FILE.with_name("sees.csv").open(encoding="utf-8", newline="") as stream:
        rows = list(csv.DictReader(stream))
    assert [row["fault"] for row in rows] == list(FAULTS)
    assert {int(row["of"]) for row in rows} == {sum(case.quick for case in CASES)}
