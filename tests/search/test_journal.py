"""A search's journal: another's is refused and left as it is, as is what only looks like one."""

import pytest

from fingerdesign.errors import DesignError
from fingerdesign.search.optimise.optimise import Trials
from fingerdesign.search.study.file import parse_study
from fingerdesign.search.study.variants import base_design

STUDY = parse_study(
    """
study = { name = "s", base = "maeno2000", count = 8, seed = 5 }
objectives = [{ metric = "cost" }]
parameters = { "plates.count" = [9, 11, 13] }
"""
)
BASE = base_design(STUDY)


def test_a_refused_study_adds_nothing_to_the_journal(tmp_path):
    journal = tmp_path / "trials.jsonl"
    with Trials(STUDY, BASE, journal) as trials:
        trials.draw(3)
        trials.report(1, [2.0], {})
    whole = journal.read_bytes()
    others = STUDY.model_copy(update={"study": STUDY.study.model_copy(update={"seed": 6})})
    second = two_objectives()
    for other in (others, second):
        for content in (whole, whole + b'{"op'):
            journal.write_bytes(content)
            with pytest.raises(DesignError, match="another study"), Trials(other, BASE, journal):
                pass
            assert journal.read_bytes() == content
    with Trials(STUDY, BASE, journal) as trials:  # the half line is gone, nothing else written
        assert len(trials.drawn()) == 3
    assert journal.read_bytes() == whole


def two_objectives():
    """The study with one more objective."""
    (one,) = STUDY.objectives
    more = one.model_copy(update={"metric": "plates"})
    return STUDY.model_copy(update={"objectives": (one, more)})


@pytest.mark.parametrize(
    "line",
    [
        '{"op_code": 0}',
        '{"op_code":0,"worker_id":"a","study_name":7,"directions":[9]}',
        '{"op_code":5,"worker_id":"a","study_id":3,"datetime_start":"x"}',
        '{"op_code":4,"worker_id":"a","study_id":0}',
        '{"op_code":99}',
        '{"op_code":"x"}',
        '{"op_code":0,"worker_id":"a","study_name":"other","directions":[1]}',
        '{"op_code":' + "[" * 100_000,
    ],
)
@pytest.mark.parametrize("end", ["\n", "\n{"])
def test_what_is_like_a_journal_is_refused_and_left_alone(tmp_path, line, end):
    journal = tmp_path / "trials.jsonl"
    journal.write_text(line + end)
    with pytest.raises(DesignError, match="journal of trials"):
        Trials(STUDY, BASE, journal).__enter__()
    assert journal.read_text() == line + end
