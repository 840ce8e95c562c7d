"""Run a study: what the store holds is not computed again, what is computed is stored at once.

    with Cluster(workers) as cluster:
        outcomes = run_jobs(jobs, Store(), cluster, study.limits)

The driver alone writes the store. Killed, interrupted or out of disk, it loses what was running and
no more: run again, it goes on.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.records.outcome import Outcome
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.evaluate import EVALUATE, Job, relabelled
from fingerdesign.search.run.jobs import Planned, planned, study_scenes
from fingerdesign.search.run.store import Store
from fingerdesign.search.study.variants import base_design, variants

if TYPE_CHECKING:
    from fingerdesign.search.study.file import Limits, Study


@dataclass(frozen=True)
class Standing:
    """Where a study stands.

    number, of  outcomes at hand, and of how many; of them failures, stored (taken from the store)
                and computed (now; the digests are counted, two variants may have one)
    seconds     since the start; left: estimated till the end, None where nothing tells yet
    threads     of workers that evaluate, 0 before computing; waiting: for workers, there are none
    outcome     that came now; None: nothing new; from_store: it was not computed now
    """

    number: int
    of: int
    failures: int
    stored: int
    computed: int
    seconds: float
    left: float | None = None
    threads: int = 0
    waiting: bool = False
    outcome: Outcome | None = None
    from_store: bool = False


Report = Callable[[Standing], None]


def run_study(
    study: Study,
    store: Store,
    workers: int | None = None,
    scheduler: str | None = None,
    report: Report = lambda standing: None,
    *,
    folder: Path | None = None,
    retry: bool = False,
    evaluator: str = EVALUATE,
) -> tuple[Outcome, ...]:
    """The outcomes of all of a study's variants, in order, invalid ones too.

    folder: where files that the study names lie; retry: what failed and was not refused is computed
    again. Raises DesignError for a wrong study, StoreError, ClusterError.
    """
    scenes = study_scenes(study, folder)
    plan = list(planned(study, variants(study, base_design(study, folder)), scenes))
    with Cluster(workers, scheduler, evaluator) as cluster:
        return run_jobs(plan, store, cluster, study.limits, report, retry=retry)


def run_jobs(
    plan: Sequence[Planned],
    store: Store,
    cluster: Cluster,
    limits: Limits,
    report: Report = lambda standing: None,
    *,
    retry: bool = False,
) -> tuple[Outcome, ...]:
    """The outcomes of jobs, in their order; an outcome among them stands for itself.

    Jobs of one digest are computed once. Raises StoreError and ClusterError.
    """
    return _Run(plan, store, report, retry).outcomes(cluster, limits)


class _Run:
    def __init__(self, plan: Sequence[Planned], store: Store, report: Report, retry: bool) -> None:
        self._plan, self._store, self._report, self._retry = plan, store, report, retry
        self._found: dict[int, Outcome] = {}  # by place in the plan
        self._missing: dict[str, list[int]] = {}  # places by digest
        self._failures = self._stored = self._computed = 0
        self._start = time.monotonic()
        self._first: float | None = None  # when computing began

    def outcomes(self, cluster: Cluster, limits: Limits) -> tuple[Outcome, ...]:
        self._look_up()
        if self._missing:
            self._first = time.monotonic()
            look = lambda: self._report(self._standing(cluster))  # noqa: E731
            for digest, outcome in cluster.outcomes(self._jobs(), limits, look):
                self._store.put(outcome)
                self._computed += 1
                for place in self._missing.pop(digest):
                    self._add(place, outcome, cluster)
        return tuple(self._found[place] for place in range(len(self._plan)))

    def _look_up(self) -> None:
        """Take what the store holds; the rest is missing."""
        self._store.clear()
        for place, each in enumerate(self._plan):
            if isinstance(each, Outcome):
                self._add(place, each)
                continue
            digest = each.digest()
            if digest in self._missing:
                self._missing[digest].append(place)
                continue
            stored = self._store.get(digest, self._retry)
            if stored is None:
                self._missing[digest] = [place]
            else:
                self._stored += 1
                self._add(place, stored, from_store=True)

    def _jobs(self) -> Iterator[tuple[str, Job]]:
        for digest, places in list(self._missing.items()):
            job = self._plan[places[0]]
            assert isinstance(job, Job)
            yield digest, job

    def _add(
        self,
        place: int,
        outcome: Outcome,
        cluster: Cluster | None = None,
        from_store: bool = False,
    ) -> None:
        job = self._plan[place]
        own = relabelled(outcome, job) if isinstance(job, Job) else outcome
        self._found[place] = own
        self._failures += own.status == "failed"
        self._report(self._standing(cluster, own, from_store))

    def _standing(
        self, cluster: Cluster | None, outcome: Outcome | None = None, from_store: bool = False
    ) -> Standing:
        now = time.monotonic()
        left = None
        if self._computed and self._first is not None:
            left = (now - self._first) / self._computed * len(self._missing)
        return Standing(
            number=len(self._found),
            of=len(self._plan),
            failures=self._failures,
            stored=self._stored,
            computed=self._computed,
            seconds=now - self._start,
            left=left,
            threads=0 if cluster is None else cluster.threads,
            waiting=cluster is not None and cluster.threads == 0,
            outcome=outcome,
            from_store=from_store,
        )
