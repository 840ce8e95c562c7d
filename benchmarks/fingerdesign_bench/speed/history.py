"""Speed over commits: a file of measured seconds, its chart, and an alarm at 10 %.

    fingerdesign bench speed --out out/speed && fingerdesign bench whole --json > whole.json
    python -m fingerdesign_bench.speed.history FILE.csv out/speed/speed.json whole.json

Takes the checks in s and ms of the records. Seconds are multiplied by the machine's rate, that of
fixed work measured now, so that machines of one kind compare. A quantity alarms where it takes more
than 10 % longer than the median of its last five entries; the exit code is then 1. On a busy
machine nothing is written (exit code 2): its times mean nothing.
"""

import csv
import json
import statistics
import subprocess
import sys
import time
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, fields
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import TypeAdapter

from fingerdesign.records.base import csv_text
from fingerdesign.runtime.files import write_whole
from fingerdesign_bench.chart import footed, save
from fingerdesign_bench.machine import busy, machine

ALARM, BEFORE = 1.1, 5
_FACTORS = {"s": 1.0, "ms": 1e-3}


@dataclass(frozen=True)
class Entry:
    """A quantity of a commit: seconds as measured; rate: fixed work done in a second then."""

    date: str
    commit: str
    quantity: str
    seconds: float
    rate: float

    @property
    def work(self) -> float:
        """Seconds times rate: what does not depend on how fast the machine is."""
        return self.seconds * self.rate


def machine_rate(runs: int = 5) -> float:
    """Fixed work, a product of matrices and a loop, in 1/s: the best of some runs."""
    matrix = np.random.default_rng(0).normal(size=(600, 600))
    best = np.inf
    for _ in range(runs):
        start = time.process_time()
        matrix @ matrix
        sum(k * k for k in range(200_000))
        best = min(best, time.process_time() - start)
    return 1.0 / best


def read_history(path: Path) -> list[Entry]:
    """The entries of a file, oldest first; none where there is no file."""
    if not path.is_file():
        return []
    with path.open(encoding="utf-8", newline="") as stream:
        return TypeAdapter(list[Entry]).validate_python(list(csv.DictReader(stream)))


def write_history(path: Path, entries: Sequence[Entry]) -> None:
    """Write all entries, a row each."""
    names = [each.name for each in fields(Entry)]
    write_whole(path, csv_text(names, [list(asdict(each).values()) for each in entries]))


def measured(records: Iterable[Any]) -> dict[str, float]:
    """Seconds of every check in s or ms, by name; a record is a list of checks, or holds one."""
    found: dict[str, float] = {}
    for record in records:
        for check in record["checks"] if isinstance(record, dict) else record:
            if check.get("unit") in _FACTORS:
                found[check["name"]] = _FACTORS[check["unit"]] * float(check["measured"])
    return found


def alarms(entries: Sequence[Entry]) -> list[str]:
    """A line for each quantity whose last entry is more than 10 % slower than those before it."""
    found = []
    for quantity in dict.fromkeys(each.quantity for each in entries):
        *before, last = [each for each in entries if each.quantity == quantity][-BEFORE - 1 :]
        if before:
            usual = statistics.median(each.work for each in before)
            if last.work > ALARM * usual:
                found.append(f"{quantity}: {100.0 * (last.work / usual - 1.0):.0f} % slower")
    return found


def draw_history(path: Path, entries: Sequence[Entry]) -> Path:
    """Draw each quantity over the commits, relative to its first entry."""
    figure, top = footed(5.0, ["Seconds times the machine's rate, over the first entry's."])
    axes = top.subplots()
    commits = list(dict.fromkeys(each.commit for each in entries))
    for quantity in dict.fromkeys(each.quantity for each in entries):
        own = [each for each in entries if each.quantity == quantity]
        places = [commits.index(each.commit) for each in own]
        axes.plot(places, [each.work / own[0].work for each in own], marker="o", label=quantity)
    axes.set_xticks(range(len(commits)), [each[:8] for each in commits], rotation=45)
    axes.set_ylabel("relative")
    axes.legend(fontsize=7)
    return save(figure, path)


def main(file: Path, records: Sequence[Path], on: dict[str, Any] | None = None) -> int:
    """Add the records' seconds under the present commit; print alarms. Returns the exit code.

    on: a record of the machine that they were measured on; None: this one, now.
    """
    if warning := busy(on or machine()):
        print(f"not written: {warning}")
        return 2
    head = ["git", "rev-parse", "HEAD"]
    commit = subprocess.run(head, capture_output=True, text=True, check=True).stdout.strip()
    date, rate = datetime.now(UTC).date().isoformat(), round(machine_rate(), 2)
    found = measured(json.loads(each.read_text("utf-8")) for each in records)
    entries = [each for each in read_history(file) if each.commit != commit]
    entries += [Entry(date, commit, name, round(s, 5), rate) for name, s in found.items()]
    write_history(file, entries)
    print(f"{file}, {draw_history(file.with_suffix('.png'), entries)}")
    found_alarms = alarms(entries)
    print("\n".join(found_alarms) or "no alarm")
    return int(bool(found_alarms))


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1]), [Path(each) for each in sys.argv[2:]]))
