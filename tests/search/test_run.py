"""Jobs on local workers: in order, stored, not computed twice; bad ones are failures.

Outcomes on disk: what is put is got, whole; what is invalid is absent; failures and --retry.
"""

import os
from dataclasses import replace
from pathlib import Path

import psutil
import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.records.outcome import Failure, Outcome
from fingerdesign.search.run.cluster import Cluster, ClusterError
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.run.run import Store, StoreError, run_jobs
from fingerdesign.search.study.file import Cost, Limits
from tests.support.evaluators import outcome_of
from tests.support.warm import running

LIMITS = Limits(time_s=20.0, memory_MB=1000.0)


@pytest.fixture(scope="module")
def base():
    return load_design("maeno2000")


@pytest.fixture(autouse=True)
def evaluators(monkeypatch, children_find, tmp_path):
    """Children find the evaluators; what they evaluate stands in a file."""
    children_find(Path(__file__).parents[1] / "support")
    monkeypatch.setenv("EVALUATED", str(tmp_path / "evaluated"))
    return tmp_path / "evaluated"


def job(base, number, **values):
    changed = {"design.name": f"v-{number}", "body.base_height_mm": 6.0 + 0.01 * number}
    return Job(f"v-{number}", with_values(base, changed), Cost(), {"number": number, **values})


@pytest.mark.slow
def test_a_second_run_computes_nothing_and_twins_are_computed_once(base, tmp_path, evaluators):
    jobs = [job(base, n) for n in range(5)]
    jobs.append(replace(jobs[4], name="twin", values={"number": 1.0}, cost=Cost(plate=7.0)))
    store, before = Store(tmp_path / "store"), running()
    with Cluster(2, evaluator="evaluators:quick") as cluster:
        batch = run_jobs(jobs[:2], store, cluster, LIMITS)
        first = run_jobs(jobs, store, cluster, LIMITS)  # it serves one batch after another
    assert [each.name for each in first] == [each.name for each in jobs]
    assert sorted(evaluators.read_text().split()) == [each.name for each in jobs[:5]]
    assert batch == first[:2]
    assert first[4].metrics["cost"] != first[5].metrics["cost"]
    assert first[5].values == {"number": 1.0}
    seen = []
    with Cluster(2, evaluator="evaluators:quick") as cluster:
        assert not run_jobs([], store, cluster, LIMITS)
        assert run_jobs(jobs, store, cluster, LIMITS, seen.append) == first
        assert cluster.threads == 0  # not even started
    assert len(evaluators.read_text().split()) == 5
    assert (seen[-1].number, seen[-1].of, seen[-1].stored) == (6, 6, 6)
    assert running() <= before


@pytest.mark.slow
def test_bad_jobs_are_failures_and_the_rest_is_done(base, tmp_path, evaluators):
    kinds = {
        "crash": ("crashed", "SIGABRT"),
        "exit": ("crashed", "code 3"),
        "hang": ("timeout", "not done after 4 s"),
        "eat": ("memory", "more than 400 MB"),
        "raise": ("crashed", "ZeroDivisionError: of the test"),
        "babble": ("crashed", "its process answered with"),
    }
    jobs = [job(base, n, act=act) for n, act in enumerate([*kinds, "killed", "", "", ""])]
    for good in jobs[len(kinds) :]:
        answer = outcome_of(good.to_data()).to_json()
        Path(f"{evaluators}.{good.name}").write_text(answer, "utf-8")
    with Cluster(2, evaluator="evaluators:bad") as cluster:
        found = run_jobs(jobs, Store(tmp_path), cluster, Limits(time_s=4.0, memory_MB=400.0))
    for each, (kind, words) in zip(found, kinds.values(), strict=False):
        assert each.failure.kind == kind
        assert words in each.failure.sentence
    assert [each.status for each in found[6:]] == ["ok"] * 4  # one that somebody killed is tried


def test_local_workers_listen_on_this_machine_alone():
    def listening():
        found = psutil.Process().net_connections()
        return {each.laddr for each in found if each.status == psutil.CONN_LISTEN}

    with Cluster(1, evaluator="evaluators:quick") as cluster:
        before = listening()
        cluster.start()
        assert {each.ip for each in listening() - before} <= {"127.0.0.1", "::1"}


@pytest.mark.slow
def test_an_outcome_of_another_version_is_refused(base, tmp_path):
    with (
        Cluster(1, evaluator="evaluators:elsewhere") as cluster,
        pytest.raises(ClusterError, match=r"a worker has fingerdesign 0\.0\.1; install the same"),
    ):
        run_jobs([job(base, 1)], Store(tmp_path), cluster, LIMITS)
    assert list(tmp_path.rglob("*.txt")) == []


DIGEST = "ab" + "0" * 62


def outcome(**changes):
    reported = {
        "digest": DIGEST,
        "name": "a\nname\u2028 of 'any' sort",
        "values": {"plates.count": 9},
        "design": {"design": {"name": "x"}},
        "scene": "fundamental",
        "fidelity": "plane-strain",
        "status": "ok",
        "metrics": {"cost": 1.5, "stick_error": None},
    }
    return Outcome(**(reported | changes))


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store")


def test_what_is_put_is_got_and_what_a_killed_driver_left_is_cleared_away(store):
    assert store.get(DIGEST) is None
    store.put(outcome())
    assert store.get(DIGEST) == outcome()
    (half := store.folder / "ab" / ".0123456789ab").write_text("half")
    os.utime(half, (0, 0))
    store = Store(store.folder)
    store.put(outcome(name="later"))
    assert store.get(DIGEST).name == "later"
    assert [path.name for path in store.folder.rglob("*.*")] == [f"{DIGEST}.txt"]


def test_an_outcome_under_another_digest_or_of_an_older_format_is_none(store):
    store.put(outcome())
    (path,) = store.folder.rglob("*.txt")
    other = "ab" + "1" * 62
    path.rename(path.with_name(f"{other}.txt"))
    assert store.get(other) is None
    store.put(replace(outcome(), schema_version=0))
    assert store.get(DIGEST) is None
    path.unlink()  # a folder in its place is moved away
    (path / "inside").mkdir(parents=True)
    assert store.get(DIGEST) is None
    store.put(outcome())
    assert store.get(DIGEST) == outcome()
    assert len(list(store.folder.rglob("inside"))) == 1


@pytest.mark.parametrize("kind", ["crashed", "timeout", "memory", "failed", "refused"])
def test_what_may_fare_better_is_tried_again_and_a_refusal_stays(store, kind):
    store.put(first := outcome(status="failed", failure=Failure(kind, "why")))
    assert store.get(DIGEST) == first
    assert store.get(DIGEST, retry=True) == (first if kind == "refused" else None)


def test_no_room_is_an_error_and_leaves_nothing(store, full_disk):
    with pytest.raises(StoreError, match=r"cannot be stored in .*No space left on device"):
        store.put(outcome())
    assert [path for path in store.folder.rglob("*") if path.is_file()] == []


@pytest.mark.parametrize("digest", ["", "../../etc/passwd", "AB" * 32, "ab" * 31, f"{DIGEST}/x"])
def test_only_digests_name_files(store, digest):
    with pytest.raises(ValueError, match="is no digest"):
        store.get(digest)
    with pytest.raises(ValueError, match="is no digest"):
        store.put(outcome(digest=digest))
    assert not store.folder.exists()
