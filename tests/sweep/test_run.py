"""Jobs on local workers: in order, stored, not computed twice; bad ones are failures."""

import os
from pathlib import Path

import pytest

from fingerdesign.design.io import with_values
from fingerdesign.design.starter import find_design
from fingerdesign.sweep.cluster import Cluster
from fingerdesign.sweep.evaluate import Job
from fingerdesign.sweep.run import run_jobs
from fingerdesign.sweep.store import Store
from fingerdesign.sweep.study_file import Cost, Limits

LIMITS = Limits(time_s=20.0, memory_MB=1000.0)


@pytest.fixture(scope="module")
def base():
    return find_design("maeno2000")


@pytest.fixture(autouse=True)
def evaluators(monkeypatch, tmp_path):
    """Children find the evaluators; what they evaluate stands in a file."""
    path = os.pathsep.join([str(Path(__file__).parent), os.environ.get("PYTHONPATH", "")])
    monkeypatch.setenv("PYTHONPATH", path)
    monkeypatch.setenv("EVALUATED", str(tmp_path / "evaluated"))
    return tmp_path / "evaluated"


def job(base, number, **values):
    changed = {"design.name": f"v-{number}", "body.base_height_mm": 6.0 + 0.01 * number}
    return Job(f"v-{number}", with_values(base, changed), Cost(), {"number": number, **values})


def test_a_second_run_computes_nothing(base, tmp_path, evaluators):
    jobs = [job(base, n) for n in range(5)]
    store = Store(tmp_path / "store")
    with Cluster(2, evaluator="sweep_evaluators:quick") as cluster:
        first = run_jobs(jobs, store, cluster, LIMITS)
    assert [each.name for each in first] == [each.name for each in jobs]
    assert sorted(evaluators.read_text().split()) == [each.name for each in jobs]
    seen = []
    with Cluster(2, evaluator="sweep_evaluators:quick") as cluster:
        assert run_jobs(jobs, store, cluster, LIMITS, seen.append) == first
        assert cluster.threads == 0  # not even started
    assert len(evaluators.read_text().split()) == 5
    assert (seen[-1].number, seen[-1].of, seen[-1].stored) == (5, 5, 5)


def test_bad_jobs_are_failures_and_the_rest_is_done(base, tmp_path):
    acts = ["crash", "exit", "hang", "eat", "raise", "babble", "killed", "", "", ""]
    jobs = [job(base, n, act=act) for n, act in enumerate(acts)]
    limits = Limits(time_s=2.0, memory_MB=400.0)
    store = Store(tmp_path / "store")
    with Cluster(2, evaluator="sweep_evaluators:bad") as cluster:
        found = run_jobs(jobs, store, cluster, limits)
    by_act = {each.values["act"]: each for each in found}
    kinds = {act: by_act[act].failure.kind for act in acts[:6]}
    assert kinds == {
        "crash": "crashed",
        "exit": "crashed",
        "hang": "timeout",
        "eat": "memory",
        "raise": "crashed",
        "babble": "crashed",
    }
    assert "SIGABRT" in by_act["crash"].failure.sentence
    assert "code 3" in by_act["exit"].failure.sentence
    assert "ZeroDivisionError: of the test" in by_act["raise"].failure.sentence
    assert [each.status for each in found[6:]] == ["ok"] * 4  # one that somebody killed is tried
