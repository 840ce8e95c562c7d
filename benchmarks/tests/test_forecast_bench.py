"""bench forecast: its pairs are sound, its checks can fall short, what it writes is whole."""

import json

import pytest
from fingerdesign_bench.any_finger import forecast as bench
from fingerdesign_bench.any_finger.forecast import checks_of, factor, measure_pair, plain_pairs
from fingerdesign_cli.main import main

from fingerdesign.analysis.forecast.limits import refuse


def record(pair, **changed):
    reported = {"dofs": 1000, "memory_MB": 600.0, "time_s": 10.0, "mesher": "netgen"}
    found = {"dofs": 1100, "memory_MB": 500.0, "time_s": 9.0, "asking_s": 0.1, "status": "ok"}
    speed = {"one_core": 50.0, "all_cores": 90.0, "cores": 2}
    return {**pair, "machine": speed, "forecast": reported, **found, **changed}


@pytest.mark.slow
def test_every_pair_can_be_analysed():
    pairs = plain_pairs()
    assert len({bench.name_of(pair) for pair in pairs}) == len(pairs) == len(bench.PAIRS) + 30
    for pair in pairs:
        case = bench.case_of(json.loads(json.dumps(pair)))
        refuse(case, case.path_scene)


@pytest.mark.parametrize(
    ("changed", "short"),
    [
        ({}, set()),
        ({"dofs": 2100}, {"dofs"}),
        ({"dofs": 490}, {"dofs"}),
        ({"memory_MB": 290.0}, {"peak memory"}),
        ({"time_s": 4.9}, {"time"}),
        ({"asking_s": 1.2}, {"seconds"}),
        ({"status": "failed"}, {"analyses", "dofs", "peak memory", "time"}),
    ],
)
def test_a_wrong_forecast_falls_short(changed, short):
    checks = checks_of([record(plain_pairs()[0], **changed)])
    wrong = [check.name for check in checks if not check.holds]
    assert len(wrong) == len(short)
    assert all(any(name.startswith(each) for name in wrong) for each in short)


def test_the_command_says_and_writes_it(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr(bench, "apart", lambda *given: lambda pair: record(pair, time_s=30.0))
    assert main(["bench", "forecast", "--quick", "--out", str(tmp_path)]) == 1
    out = capsys.readouterr().out
    assert "FALLS SHORT" in out
    assert "homogeneous (ball, 3d, sweep)" in out
    written = json.loads((tmp_path / "forecast.json").read_text())
    assert len(written["records"]) == len(bench.QUICK)


@pytest.mark.slow
def test_a_pair_is_predicted_and_measured(own_cache, tmp_path):
    found = measure_pair(plain_pairs(quick=True)[0], tmp_path / "out")
    assert found["status"] == "ok"
    assert factor(found, "dofs") < 1.5
    assert set(found["timings_s"]) >= set(found["forecast"]["timings_s"])
