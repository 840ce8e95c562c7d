"""The count of fingers that `optimise` makes pass."""

import csv

import pytest
from fingerdesign_bench.any_finger import passing
from fingerdesign_bench.known.table import FILE


@pytest.mark.slow
def test_a_search_that_does_not_end_is_interrupted_and_says_so(tmp_path):
    finger, body, outcome, _, seconds, *_ = passing.searched("3", tmp_path, limit_s=0.5)
    assert (finger, body, outcome) == ("3", "block", "not ended")
    assert 0.5 <= float(seconds) < passing._END_S


def test_rows_replace_those_of_the_same_finger_and_stand_in_order(tmp_path):
    record = tmp_path / "passing.csv"
    record.write_text("finger\n", encoding="utf-8")
    for finger, outcome in (("7", "fails"), ("tees", "passes"), ("7", "passes")):
        passing._record(record, (finger, "arc", outcome, "", "1", "2", "", "2026-11-27"))
    with record.open(encoding="utf-8", newline="") as stream:
        headings, *rows = csv.reader(stream)
    assert headings == list(passing.HEADINGS)
    assert [row[:3] for row in rows] == [["tees", "arc", "passes"], ["7", "arc", "passes"]]


@pytest.mark.parametrize(
    ("printed", "facts"),
    [
        (
            'trial 4\rtrial 8\n{"given_up": [], "conflict": "No hand lifts."}\n',
            ("", "No hand lifts."),
        ),
        ('{"given_up": ["body.shape", "body.core"], "conflict": ""}', ("body.shape body.core", "")),
        ("no such design\n", ("", "no such design")),
        ("", ("", "")),
    ],
)
def test_facts_are_the_searchs_own(printed, facts):
    assert passing._facts(printed) == facts


def test_the_record_has_each_finger_once():
    with FILE.with_name("passing.csv").open(encoding="utf-8", newline="") as stream:
        _, *rows = csv.reader(stream)
    names = [row[0] for row in rows]
    assert names == [each for each in passing.ALL if each in names]
