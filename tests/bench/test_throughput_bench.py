"""The bench of throughput: its numbers add up; what falls short is reported; a run of a few."""

import json
import os

import pytest
from fingerdesign_bench.speed import throughput
from fingerdesign_bench.speed.throughput import Throughput, Throughputs, measure_throughput


def run(workers, seconds, cost=1.0):
    return Throughput(workers, 12, 10, {"invalid": 2}, seconds, (cost,) * 10)


def failing(found):
    return [check.name for check in found.checks() if not check.holds]


def test_the_ratio_and_the_cost_are_held_to_what_is_requested():
    good = Throughputs((run(1, 20.0), run(2, 11.0)), {})
    assert good.runs[0].an_hour == pytest.approx(1800.0)
    assert good.ratio == pytest.approx(20.0 / 11.0)
    assert failing(good) == []
    assert failing(Throughputs((run(1, 20.0), run(2, 12.0)), {})) == [
        "12 variants: time on 2 workers over 1"
    ]
    assert len(failing(Throughputs((run(1, 20.0, 2.1), run(2, 11.0)), {}))) == 1
    assert json.loads(json.dumps(good.as_dict()))["ratio"] == pytest.approx(20.0 / 11.0)


@pytest.mark.slow
def test_two_variants_are_measured_in_caches_of_their_own(monkeypatch, tmp_path):
    monkeypatch.setattr(throughput, "QUICK_VARIANTS", 2)
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    found = measure_throughput(quick=True)
    assert [each.workers for each in found.runs] == [1, 2]
    assert all(each.analysed + sum(each.failures.values()) == 2 for each in found.runs)
    assert all(cost > 0.1 for each in found.runs for cost in each.core_seconds)
    assert os.environ["FINGERDESIGN_CACHE"] == str(tmp_path)
    assert list(tmp_path.iterdir()) == []
