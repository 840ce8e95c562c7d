"""Run a study: what the store holds is not computed again, what is computed is stored at once.

    with Cluster(workers) as cluster:
        outcomes = run_jobs(jobs, Store(), cluster, study.limits)

The driver alone writes the store. Killed, interrupted or out of disk, it loses what was running and
no more: run again, it goes on.
"""

import hashlib
import json
import re
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path

from fingerdesign.design.scene import Scene
from fingerdesign.design.shipped import load_scene
from fingerdesign.errors import FingerDesignError
from fingerdesign.records.outcome import Failure, Outcome, OutcomeError, Traces
from fingerdesign.runtime.cache import Cache
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.evaluate import Job, relabelled
from fingerdesign.search.study.file import Limits, Study
from fingerdesign.search.study.metrics import ON_REQUEST
from fingerdesign.search.study.variants import Variant
from fingerdesign.version import versions

_DIGEST = re.compile(r"[0-9a-f]{64}")
# Another machine, or another day, may fare better; "failed": as where a mesher ran out of time.
TRANSIENT = ("crashed", "timeout", "memory", "failed")
PART = 1000  # jobs of a large study that are planned at a time: 100 MB of designs
Planned = Job | Outcome  # an outcome: of a variant that is no finger
FUNDAMENTAL = "fundamental"


class StoreError(FingerDesignError):
    """An outcome cannot be stored: no room or no permission; no partial file is left."""


class Store:
    """Outcomes on disk by digest, in ``folder``; by default the user's own store.

    One file each, with a checksum: a damaged file counts as absent. All studies of a user share it.
    """

    def __init__(self, folder: Path | None = None) -> None:
        self._cache = Cache("outcomes", folder=folder)
        self.folder = self._cache.folder
        self._cache.clear()  # what drivers that were killed have left half-written

    def get(self, digest: str, retry: bool = False) -> Outcome | None:
        """The outcome stored under a digest; None where there is none, or only an invalid one.

        retry: neither one that failed but was not refused.
        """
        name = _name(digest)
        try:
            line = self._cache.text(name)
            found = None if line is None else Outcome.from_json(line)
        except OSError as error:
            raise StoreError(f"{self._cache.path(name)} cannot be read: {error}") from error
        except OutcomeError:  # of another version of this format
            return None
        if found is None or found.digest != digest:
            return None
        transient = found.failure is not None and found.failure.kind in TRANSIENT
        return None if retry and transient else found

    def put(self, outcome: Outcome) -> None:
        """Store an outcome, in place of an older one. StoreError where that fails."""
        try:
            self._cache.put_text(_name(outcome.digest), outcome.to_json(), durable=True)
        except OSError as error:
            raise StoreError(f"an outcome cannot be stored in {self.folder}: {error}") from error


def _name(digest: str) -> str:
    if not _DIGEST.fullmatch(digest):
        raise ValueError(f"{digest!r} is no digest")
    return f"{digest[:2]}/{digest}.txt"


def study_scenes(study: Study, folder: Path | None = None) -> dict[str, Scene | None]:
    """The study's scenes by name; None: the fundamental case and the design's grips.

    A file lies in ``folder`` (None: the working directory). DesignError with a scene's faults.
    """
    if not study.study.scenes:
        return {FUNDAMENTAL: None}
    found: dict[str, Scene | None] = {}
    for name in study.study.scenes:
        own = (folder or Path.cwd()) / name
        found[Path(name).stem] = load_scene(own if own.is_file() else name)
    return found


def planned(
    study: Study, variants: Iterable[Variant], scenes: Mapping[str, Scene | None]
) -> Iterator[Planned]:
    """The jobs of each variant, a scene each, in order; one outcome where it is invalid."""
    table = study.study
    named = {*study.constraints, *(each.metric for each in study.objectives)}
    for variant in variants:
        if variant.design is None:
            yield _invalid(study, variant)
            continue
        for name, scene in scenes.items():
            yield Job(
                name=variant.name,
                design=variant.design,
                cost=study.cost,
                values=variant.values,
                scene=scene,
                scene_name=name,
                fidelity=table.fidelity,
                tolerance=table.tolerance,
                study_keys=(*study.fixed, *variant.values),
                on_request=tuple(name for name in ON_REQUEST if name in named),
            )


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
    """Progress of a study.

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
    bare: bool = False,
) -> tuple[Outcome, ...]:
    """The outcomes of jobs, in their order, of one digest computed once; an outcome among them is
    returned unchanged. bare: see :func:`bared`. Raises StoreError and ClusterError."""
    found: dict[int, Outcome] = {}  # by place in the plan
    missing: dict[str, list[int]] = {}  # places by digest
    start = first = time.monotonic()
    now = Standing(0, len(plan), 0, 0, 0, 0.0)

    def tell(threads: int | None, outcome: Outcome | None = None, stored: bool = False) -> None:
        nonlocal now
        seconds = time.monotonic()
        now = replace(
            now,
            number=len(found),
            failures=now.failures + (outcome is not None and outcome.status == "failed"),
            stored=now.stored + stored,
            seconds=seconds - start,
            left=(seconds - first) / now.computed * len(missing) if now.computed else None,
            threads=threads or 0,
            waiting=threads == 0,
            outcome=outcome,
            from_store=stored,
        )
        report(now)

    def add(place: int, outcome: Outcome, threads: int | None, stored: bool = False) -> None:
        own = relabelled(outcome, job) if isinstance(job := plan[place], Job) else outcome
        found[place] = bared(own) if bare else own
        tell(threads, found[place], stored)

    jobs: list[tuple[str, Job]] = []
    for place, each in enumerate(plan):
        if isinstance(each, Outcome):
            add(place, each, None)
            continue
        digest = each.digest()
        stored = None if digest in missing else store.get(digest, retry)
        if stored is not None:
            add(place, stored, None, stored=True)
            continue
        if digest not in missing:
            jobs.append((digest, each))
        missing.setdefault(digest, []).append(place)
    first = time.monotonic()
    came = cluster.outcomes(jobs, limits, lambda: tell(cluster.threads))
    for digest, outcome in came if jobs else ():
        store.put(outcome)
        now = replace(now, computed=now.computed + 1)
        for place in missing.pop(digest):
            add(place, outcome, cluster.threads)
    return tuple(found[place] for place in range(len(plan)))


def bared(outcome: Outcome) -> Outcome:
    """The outcome without what the store alone holds of a large study."""
    return replace(outcome, design={}, traces=Traces(), grips=(), warnings=())


def run_in_parts(
    plan: Iterable[Planned],
    of: int,
    store: Store,
    cluster: Cluster,
    limits: Limits,
    report: Report = lambda standing: None,
    *,
    retry: bool = False,
) -> Iterator[Outcome]:
    """Bare outcomes of so many jobs that they are planned and held ``PART`` at a time, in order.

    of: how many there are. Raises StoreError and ClusterError.
    """
    source = iter(plan)
    last = before = Standing(0, of, 0, 0, 0, 0.0)

    def shown(now: Standing) -> None:
        nonlocal last
        sums = {
            name: getattr(before, name) + getattr(now, name)
            for name in ("number", "failures", "stored", "computed", "seconds")
        }
        number = sums["number"]
        left = sums["seconds"] / number * (of - number) if number and sums["computed"] else None
        last = replace(now, of=of, left=left, **sums)
        report(last)

    while part := list(islice(source, PART)):
        yield from run_jobs(part, store, cluster, limits, shown, retry=retry, bare=True)
        before = last
