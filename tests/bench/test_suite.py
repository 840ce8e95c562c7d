"""All of ``fingerdesign bench`` into one folder: parts, failures, the record."""

import json

from fingerdesign_bench.check import Check
from fingerdesign_bench.suite import PARTS, run_suite

from fingerdesign.errors import SolverError


def test_one_part_that_fails_does_not_stop_the_others(tmp_path):
    sampled = []

    def good(folder, report, quick):
        report("at work")
        path = folder / "good.csv"
        path.write_text("a\n", encoding="utf-8")
        return [path], [Check("a number", 1.0, 2.0, "s")]

    def bad(folder, report, quick):
        raise SolverError("it has no answer")

    found = run_suite(tmp_path / "new", sampled.append, True, {"bad": bad, "good": good})
    assert sampled == ["good: at work"]
    assert found.failures == {"bad": "it has no answer"}
    record = json.loads((tmp_path / "new" / "bench.json").read_text("utf-8"))
    assert record["files"] == ["good.csv"]
    assert record["failures"] == found.failures
    assert record["checks"][0]["holds"] is False
    assert record["quick"] is True
    assert set(record["machine"]["versions"]) >= {"numpy", "scipy", "mkl", "pypardiso", "pytetwild"}


def test_the_parts_are_those_that_the_help_names():
    assert list(PARTS) == ["precision", "speed", "stability"]
