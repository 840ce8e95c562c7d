"""Records and tables of a bench in its folder, and the records that long runs resume from."""

import csv
import json
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.runtime.cache import code_digest
from fingerdesign.runtime.progress import Report
from fingerdesign.version import versions

Record = dict[str, Any]


def write_json(path: Path, record: Mapping[str, Any]) -> Path:
    """Write a record as JSON, into a folder that is made where there is none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    return path


def write_csv(path: Path, rows: Sequence[Mapping[str, Any]]) -> Path:
    """Write rows with the same keys as CSV, into a folder that is made where there is none."""
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(rows[0]), lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows)
    return path


def read_lines(path: Path) -> list[Record]:
    """The records of a file that may not be there; a line cut short by an interruption is none."""
    found = []
    for line in path.read_text("utf-8").splitlines() if path.exists() else ():
        try:
            found.append(json.loads(line))
        except ValueError:
            continue
    return found


def append_lines(path: Path, records: Sequence[Record]) -> None:
    """Add records, on lines of their own also after one that was cut short."""
    path.parent.mkdir(parents=True, exist_ok=True)
    cut = path.exists() and path.read_bytes()[-1:] not in (b"", b"\n")
    text = "".join(json.dumps(each, allow_nan=False) + "\n" for each in records)
    with path.open("a", encoding="utf-8") as file:
        file.write("\n" * cut + text)


def code_version(folder: Path) -> str:
    """The package's version and a digest of the code in a folder of it."""
    return f"{versions()['fingerdesign']}, {code_digest(folder)[:12]}"


@dataclass(frozen=True)
class Lines:
    """A file of records, a line of JSON each: what an interrupted run has done is not done again.

    key: under which a record names its case; version: of the code that makes the records; words: a
    record in a line.
    """

    path: Path
    key: str
    version: str
    words: Callable[[Record], str]

    def resumed(
        self, cases: Sequence[str], run: Callable[[str], Record], workers: int, report: Report
    ) -> list[Record]:
        """A record of each case, ``workers`` at once: the file's, or ``run(case)``, added to it.

        Records that crashed or are of another version are made again.
        """
        whole = [each for each in read_lines(self.path) if each.get("version") == self.version]
        done = {each[self.key]: each for each in whole if each.get("status") != "crashed"}
        missing = [case for case in dict.fromkeys(cases) if case not in done]
        if len(missing) < len(cases):
            report(f"{len(cases) - len(missing)} of {len(cases)} were done before")
        with ThreadPoolExecutor(workers) as pool:
            jobs = [pool.submit(run, case) for case in missing]
            try:
                for job in as_completed(jobs):
                    record = job.result() | {"version": self.version}
                    done[record[self.key]] = record
                    append_lines(self.path, [record])
                    report(f"{len(done.keys() & cases)} of {len(cases)}: {self.words(record)}")
            except BaseException:
                pool.shutdown(wait=False, cancel_futures=True)
                raise
        return [done[case] for case in cases]
