"""Records of long runs, a line of JSON each: what an interrupted run has done is not done again."""

import hashlib
import json
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from pathlib import Path
from typing import Any

from fingerdesign.runtime.progress import Report
from fingerdesign.version import versions

Record = dict[str, Any]


def read_lines(path: Path) -> list[Record]:
    """The records of a file that may not be there; a line cut short by an interruption is none."""
    found = []
    for line in path.read_text("utf-8").splitlines() if path.exists() else ():
        try:
            found.append(json.loads(line))
        except ValueError:
            continue
    return found


def append_line(path: Path, record: Record) -> None:
    """Add a record, on a line of its own also after one that was cut short."""
    cut = path.exists() and path.read_bytes()[-1:] not in (b"", b"\n")
    with path.open("a", encoding="utf-8") as file:
        file.write("\n" * cut + json.dumps(record, allow_nan=False) + "\n")


def code_version(folder: Path) -> str:
    """The package's version and a digest of the code in a folder of it."""
    digest = hashlib.sha256()
    for path in sorted(folder.rglob("*.py")):
        digest.update(path.read_bytes())
    return f"{versions()['fingerdesign']}, {digest.hexdigest()[:12]}"


def resumed(
    path: Path,
    key: str,
    cases: Sequence[Any],
    run: Callable[[Any], Record],
    version: str,
    workers: int,
    report: Report,
    words: Callable[[Record], str],
) -> list[Record]:
    """A record of each case, ``workers`` at once: the file's, or ``run(case)``, added to it.

    Records that crashed or are of another version are made again. key: under which a record names
    its case. words: a record in a line.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    whole = (each for each in read_lines(path) if each.get("version") == version)
    done = {each[key]: each for each in whole if each["status"] != "crashed"}
    missing = [case for case in cases if case not in done]
    if len(missing) < len(cases):
        report(f"{len(cases) - len(missing)} of {len(cases)} were done before")
    with ThreadPoolExecutor(workers) as pool:
        jobs = [pool.submit(run, case) for case in missing]
        try:
            for job in as_completed(jobs):
                record = job.result() | {"version": version}
                done[record[key]] = record
                append_line(path, record)
                count = sum(case in done for case in cases)
                report(f"{count} of {len(cases)}: {words(record)}")
        except BaseException:
            pool.shutdown(wait=False, cancel_futures=True)
            raise
    return [done[case] for case in cases]
