"""Records that long runs resume from: each is stored when it is made, and not made again."""

from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from types import ModuleType
from typing import Any

from fingerdesign.runtime.cache import code_digest
from fingerdesign.runtime.isolate import ProcessError, call
from fingerdesign.runtime.journal import Journal
from fingerdesign.runtime.progress import Report
from fingerdesign.version import versions

Record = dict[str, Any]
CRASHED = "crashed"


def code_version(package: ModuleType) -> str:
    """The version of fingerdesign and a digest of the code of one of its packages."""
    folder = Path(str(package.__file__)).parent
    return f"{versions()['fingerdesign']}, {code_digest(folder)[:12]}"


def apart(function: str, time_s: float | None = None) -> Callable[[Any], Record]:
    """Return work that calls a function in a process of its own; a crash is a record, too."""

    def work(case: Any) -> Record:
        try:
            found: Record = call(function, case, time_s=time_s)
        except ProcessError as error:
            return {"status": CRASHED, "reason": str(error)}
        return found

    return work


def resumed(
    path: Path,
    version: str,
    cases: Mapping[str, Any],
    work: Callable[[Any], Record],
    report: Report,
    words: Callable[[str, Record], str] = lambda name, record: name,
    workers: int = 1,
) -> dict[str, Record]:
    """Return a record of each case by name: the journal's, or ``work(case)``, which is added.

    Records that crashed are made again. A journal of another version is refused (DesignError).
    words: a name and its record in a line. workers: how many are made at once.
    """
    with Journal(path, "bench", version) as journal, ThreadPoolExecutor(workers) as pool:
        whole = {name for name, record in journal if record.get("status") != CRASHED}
        missing = [name for name in cases if name not in whole]
        if len(missing) < len(cases):
            report(f"{len(cases) - len(missing)} of {len(cases)} were done before")
        jobs = {pool.submit(work, cases[name]): name for name in missing}
        try:
            for done, job in enumerate(as_completed(jobs), len(cases) - len(missing) + 1):
                journal.add({jobs[job]: job.result()})
                line = words(jobs[job], journal.get(jobs[job]))
                report(f"{done} of {len(cases)}: {line}")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
        return {name: journal.get(name) for name in cases}
