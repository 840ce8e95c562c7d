"""How many fingers `fingerdesign optimise` makes pass: the shipped ones and random ones.

    python -m fingerdesign_bench.any_finger.passing [--write] [NAME or SEED ...]

Each is searched as a user does it, by the command, from nothing that was stored before, for at most
15 minutes. Without names: every shipped finger that failed when the count was asked for, and the
random ones 0 to 19; this takes hours. --write: their rows of the record docs/reference/passing.csv
are replaced.
"""

import csv
import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
from datetime import UTC, datetime
from pathlib import Path

import tomlkit

from fingerdesign.checks.load import load_design
from fingerdesign.records.base import csv_text
from fingerdesign.runtime.files import write_whole
from fingerdesign_bench.any_finger.designs import random_design
from fingerdesign_bench.known.table import FILE

LIMIT_S = 900.0
_END_S = 60.0  # What an interrupted search may take to write what it has found.
SHIPPED = (
    *("maeno2000", "tees", "fine_tees", "sensitive", "narrow", "wide"),
    *("homogeneous", "block", "boned", "domed", "both_ways", "pin"),
)
ALL = (*SHIPPED, *map(str, range(20)))
HEADINGS = ("finger", "body", "outcome", "gives up", "seconds", "core seconds", "reason", "date")
Row = tuple[str, ...]


def searched(finger: str, folder: Path, limit_s: float = LIMIT_S) -> Row:
    """The row of one finger: a shipped design's name, or the seed of a random one.

    limit_s: the search is interrupted then.
    """
    design = finger
    if finger.isdigit():
        design = str(folder / f"random_{finger}.toml")
        Path(design).write_text(tomlkit.dumps(random_design(int(finger))), encoding="utf-8")
    body = load_design(design).body.shape  # An unknown name is refused before the search.
    command = [sys.executable, "-m", "fingerdesign_cli.main", "optimise", design]
    begun, before = time.monotonic(), _core_seconds()
    process = subprocess.Popen(
        [*command, "--out", str(folder), "--json"],
        env=os.environ | {"FINGERDESIGN_CACHE": str(folder / "cache")},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    )
    ended = True
    try:
        printed, _ = process.communicate(timeout=limit_s)
    except subprocess.TimeoutExpired:
        ended = False
        printed = _interrupted(process)
    outcome = {0: "passes", 1: "fails"}.get(process.returncode, "ends with an error")
    given_up, reason = _facts(printed)
    return (
        finger,
        body,
        outcome if ended else "not ended",
        given_up,
        f"{time.monotonic() - begun:.0f}",
        f"{_core_seconds() - before:.0f}",
        reason,
        datetime.now(UTC).date().isoformat(),
    )


def _interrupted(process: subprocess.Popen[str]) -> str:
    """What a search printed that is interrupted, and killed where it does not end by that."""
    process.terminate()  # As Ctrl-C; what a shell starts in the background ignores SIGINT.
    try:
        return process.communicate(timeout=_END_S)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)
        return process.communicate()[0]


def _facts(printed: str) -> tuple[str, str]:
    """Keys that the search gave up, and why none passes, in its own words; else its last line."""
    lines = [line.strip() for line in printed.replace("\r", "\n").splitlines() if line.strip()]
    facts = [line for line in lines if line.startswith("{")]
    if not facts:
        return "", lines[-1] if lines else ""
    found = json.loads(facts[-1])
    return " ".join(found["given_up"]), str(found["conflict"])


def _core_seconds() -> float:
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def main(fingers: list[str], write: bool) -> None:
    """Search each finger and print its row; add it to the record."""
    record = FILE.with_name("passing.csv")
    for finger in fingers or ALL:
        with tempfile.TemporaryDirectory() as folder:
            row = searched(finger, Path(folder))
        print(", ".join(row), flush=True)
        if write:
            _record(record, row)


def _record(record: Path, row: Row) -> None:
    """Put a row into the record, in place of an older one of the same finger."""
    with record.open(encoding="utf-8", newline="") as stream:
        rows = {each[0]: each for each in list(csv.reader(stream))[1:]}
    rows[row[0]] = list(row)
    known = [tuple(rows[name]) for name in ALL if name in rows]
    write_whole(record, csv_text(HEADINGS, known))


if __name__ == "__main__":
    main([each for each in sys.argv[1:] if each != "--write"], "--write" in sys.argv[1:])
