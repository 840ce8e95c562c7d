"""Speed over commits: what is written reads back, what got slower alarms, a busy machine waits."""

import json
from dataclasses import replace

import pytest
from fingerdesign_bench.speed import history
from fingerdesign_bench.speed.history import Entry, alarms, measured, read_history, write_history

ONE = Entry("2026-11-25", "a" * 40, "a model", 2.0, 50.0)


def line(seconds, rates=None):
    rates = rates or [50.0] * len(seconds)
    return [
        replace(ONE, commit=f"{k:040x}", seconds=s, rate=rate)
        for k, (s, rate) in enumerate(zip(seconds, rates, strict=True))
    ]


def test_what_is_written_reads_back(tmp_path):
    entries = [*line([2.0, 2.1]), replace(ONE, quantity='with, a "comma"')]
    write_history(tmp_path / "speed.csv", entries)
    assert read_history(tmp_path / "speed.csv") == entries
    assert read_history(tmp_path / "none.csv") == []


@pytest.mark.parametrize(
    ("seconds", "rates", "alarm"),
    [
        ([2.0], None, False),
        ([2.0, 2.19], None, False),
        ([2.0, 2.21], None, True),
        ([2.0, 2.0, 9.0, 2.0, 2.0, 2.1], None, False),  # one that was disturbed is no measure
        ([2.0, 4.0], [50.0, 25.0], False),  # half as fast a machine
        ([2.0, 2.0], [50.0, 60.0], True),
    ],
)
def test_a_tenth_slower_than_usual_alarms(seconds, rates, alarm):
    found = alarms([*line(seconds, rates), replace(ONE, quantity="another")])
    assert len(found) == alarm
    assert all(each.startswith("a model: ") for each in found)


def test_seconds_of_records_are_added_under_the_commit(tmp_path, monkeypatch, capsys):
    checks = [
        {"name": "a model", "measured": 2.0, "unit": "s"},
        {"name": "an increment", "measured": 30.0, "unit": "ms"},
        {"name": "memory", "measured": 400.0, "unit": "MB"},
    ]
    assert measured([{"checks": checks[:1]}, checks[1:]]) == {"a model": 2.0, "an increment": 0.03}
    file, record = tmp_path / "speed.csv", tmp_path / "record.json"
    record.write_text(json.dumps(checks), "utf-8")
    monkeypatch.setattr(history, "machine_rate", lambda: 50.0)
    write_history(file, line([1.0]))
    for _ in range(2):  # a commit that is measured again has its last values
        assert history.main(file, [record], {"load_average": 0.5, "cores": 2}) == 1
    assert "a model: 100 % slower" in capsys.readouterr().out
    assert [each.seconds for each in read_history(file)] == [1.0, 2.0, 0.03]
    assert file.with_suffix(".png").stat().st_size > 1000
    assert history.main(file, [record], {"load_average": 2.5, "cores": 2}) == 2
    assert len(read_history(file)) == 3
