"""Jobs on local workers: in order, stored, not computed twice; bad ones are failures."""

import os
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design
from fingerdesign.search.run.cluster import Cluster, ClusterError
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.run.run import Store, run_jobs
from fingerdesign.search.study.file import Cost, Limits

LISTEN = psutil.CONN_LISTEN
LIMITS = Limits(time_s=20.0, memory_MB=1000.0)


@pytest.fixture(scope="module")
def base():
    return find_design("maeno2000")


@pytest.fixture(autouse=True)
def evaluators(monkeypatch, tmp_path):
    """Children find the evaluators; what they evaluate stands in a file."""
    path = os.pathsep.join(
        [str(Path(__file__).parents[1] / "support"), os.environ.get("PYTHONPATH", "")]
    )
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


def test_local_workers_listen_on_this_machine_alone():
    with Cluster(1, evaluator="sweep_evaluators:quick") as cluster:
        before = {
            each.laddr for each in psutil.Process().net_connections() if each.status == LISTEN
        }
        cluster.start()
        now = {each.laddr for each in psutil.Process().net_connections() if each.status == LISTEN}
    assert {each.ip for each in now - before} <= {"127.0.0.1", "::1"}


def test_variants_of_one_finger_are_computed_once(base, tmp_path, evaluators):
    one = job(base, 1)
    twin = replace(one, name="twin", values={"number": 1.0}, cost=Cost(plate=7.0))
    with Cluster(2, evaluator="sweep_evaluators:quick") as cluster:
        found = run_jobs([one, twin], Store(tmp_path), cluster, LIMITS)
    assert evaluators.read_text().split() == ["v-1"]
    assert [each.name for each in found] == ["v-1", "twin"]
    assert found[0].metrics["cost"] != found[1].metrics["cost"]
    assert found[1].values == {"number": 1.0}


def test_an_outcome_of_another_version_is_refused(base, tmp_path):
    with (
        Cluster(1, evaluator="sweep_evaluators:elsewhere") as cluster,
        pytest.raises(ClusterError, match=r"a worker has fingerdesign 0\.0\.1; install the same"),
    ):
        run_jobs([job(base, 1)], Store(tmp_path), cluster, LIMITS)
    assert list(tmp_path.rglob("*.txt")) == []


def test_a_cluster_serves_one_batch_after_another(base, tmp_path):
    before = set(psutil.Process().children())
    with Cluster(2, evaluator="sweep_evaluators:quick") as cluster:
        for batch in ([1, 2], [2, 3], []):
            jobs = [job(base, number) for number in batch]
            found = run_jobs(jobs, Store(tmp_path), cluster, LIMITS)
            assert [each.name for each in found] == [each.name for each in jobs]
    assert set(psutil.Process().children()) <= before
