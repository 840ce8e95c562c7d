"""Run a study: what the store holds is not computed again, what is computed is stored at once.

    with Cluster(workers) as cluster:
        outcomes = run_jobs(jobs, Store(), cluster, study.limits)

The driver alone writes the store. Killed, interrupted or out of disk, it loses what was running and
no more: run again, it goes on.
"""

from __future__ import annotations

import hashlib
import json
import re
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from fingerdesign.checks.starter import find_scene
from fingerdesign.errors import FingerDesignError
from fingerdesign.records.outcome import Failure, Outcome, OutcomeError
from fingerdesign.runtime.cache import Cache
from fingerdesign.search.run.evaluate import Job, relabelled
from fingerdesign.version import versions

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.search.run.cluster import Cluster
    from fingerdesign.search.study.file import Limits, Study
    from fingerdesign.search.study.variants import Variant


# Outcomes on disk by digest: whole or absent, shared by all studies of a user.
#
# One file an outcome, in a folder by the digest's first two digits. It holds the checksum of its
# content, so that one that a crash or a full disk has spoilt is taken for absent. Nothing but the
# driver of a study writes here.

_DIGEST = re.compile(r"[0-9a-f]{64}")
# Another machine, or another day, may fare better; "failed": as where a mesher ran out of time.
TRANSIENT = ("crashed", "timeout", "memory", "failed")


class StoreError(FingerDesignError):
    """An outcome cannot be kept: no room, no right; nothing half is left."""


class Store:
    """Outcomes in ``folder``; by default the user's own store."""

    def __init__(self, folder: Path | None = None) -> None:
        self._kept = Cache("outcomes", folder=folder)
        self.folder = self._kept.folder

    def get(self, digest: str, retry: bool = False) -> Outcome | None:
        """The outcome kept under a digest; None where there is none, or only a invalid one.

        retry: neither one that failed but was not refused.
        """
        name = _name(digest)
        try:
            line = self._kept.text(name)
        except OSError as error:
            raise StoreError(f"{self._kept.path(name)} cannot be read: {error}") from error
        if line is None:
            return None
        try:
            found = Outcome.from_json(line)
        except OutcomeError:  # of another version of this format
            return None
        if found.digest != digest:
            return None
        transient = found.failure is not None and found.failure.kind in TRANSIENT
        return None if retry and transient else found

    def put(self, outcome: Outcome) -> None:
        """Keep an outcome, in the place of an older one. StoreError where that fails."""
        try:
            self._kept.put_text(_name(outcome.digest), outcome.to_json(), durable=True)
        except OSError as error:
            raise StoreError(f"an outcome cannot be kept in {self.folder}: {error}") from error

    def clear(self) -> None:
        """Remove what drivers that were killed have left half-written; nobody would read it."""
        self._kept.clear()


def _name(digest: str) -> str:
    if not _DIGEST.fullmatch(digest):
        raise ValueError(f"{digest!r} is no digest")
    return f"{digest[:2]}/{digest}.txt"


# From a study to its jobs: one a variant and scene; a variant that is no finger as an outcome.

Planned = Job | Outcome  # an outcome: of a variant that is no finger
FUNDAMENTAL = "fundamental"


def study_scenes(study: Study, folder: Path | None = None) -> dict[str, Scene | None]:
    """The study's scenes by name; None: the fundamental case and the design's grips.

    A file lies in ``folder`` (None: the working directory). DesignError with a scene's faults.
    """
    if not study.study.scenes:
        return {FUNDAMENTAL: None}
    found: dict[str, Scene | None] = {}
    for name in study.study.scenes:
        beside = (folder or Path.cwd()) / name
        found[Path(name).stem] = find_scene(beside if beside.is_file() else name)
    return found


def planned(
    study: Study, variants: Iterator[Variant], scenes: Mapping[str, Scene | None]
) -> Iterator[Planned]:
    """The jobs of each variant, a scene each, in order; an outcome where it is invalid."""
    for variant in variants:
        yield from planned_variant(study, variant, scenes)


def planned_variant(
    study: Study, variant: Variant, scenes: Mapping[str, Scene | None]
) -> list[Planned]:
    """The jobs of one variant, a scene each; one outcome where it is invalid."""
    if variant.design is None:
        return [_invalid(study, variant)]
    table = study.study
    return [
        Job(
            name=variant.name,
            design=variant.design,
            cost=study.cost,
            values=variant.values,
            scene=scene,
            scene_name=name,
            fidelity=table.fidelity,
            tolerance=table.tolerance,
            said=(*study.fixed, *variant.values),
        )
        for name, scene in scenes.items()
    ]


def _invalid(study: Study, variant: Variant) -> Outcome:
    """The outcome of a variant that is no finger; its digest is of the values and their base."""
    reported = json.dumps([study.study.base, study.fixed, variant.values], default=str)
    return Outcome(
        digest=hashlib.sha256(f"invalid\n{reported}".encode()).hexdigest(),
        name=variant.name,
        values=dict(variant.values),
        design={},
        scene="",
        fidelity=study.study.fidelity,
        status="failed",
        failure=Failure("invalid", "\n".join(str(fault) for fault in variant.faults)),
        versions=versions(),
    )


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
