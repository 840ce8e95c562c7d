"""``fingerdesign bench molds``: molds of every shipped design and of random ones of every kind.

Each design's record is one line of molds.jsonl, written when it is done: an interrupted run goes on
where it stopped. Records of other code (any file of fingerdesign/mold) are left as they are and
made again.
"""

import statistics
import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import fingerdesign.mold
from fingerdesign.runtime.isolate import ProcessError, call
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check
from fingerdesign_bench.files import Lines, Record, code_version, write_json
from fingerdesign_bench.machine import machine

SEEDS, WORKERS = 100, 2
TIME_LIMIT_S = 300.0  # of one mold, CAD and pictures and all: fifteen times the target
LINES = "molds.jsonl"
# Targets: a share, two lengths and the seconds that a user waits for a mold.
MADE_SHARE, VOLUME_ERROR, CHORD_MM, SECONDS = 0.97, 1e-3, 0.01, 20.0
MADE, REFUSED, FAILED, CRASHED = "made", "refused", "failed", "crashed"


@dataclass(frozen=True)
class Molds:
    """A record a design, shipped ones first.

    status of a record: "made" (every check holds), "refused" (before any CAD, with the faults in
    ``reason``, a ``remedy`` of theirs that gives a plan, and what ``then`` becomes of it), "failed"
    (made, but the checks in ``failed`` do not hold) or "crashed". ``workers`` were at work at once.
    """

    records: list[Record]
    workers: int = WORKERS
    machine: dict[str, Any] = field(default_factory=dict)

    def with_status(self, status: str) -> list[Record]:
        """The records of a status."""
        return [each for each in self.records if each["status"] == status]

    def unmended(self) -> list[Record]:
        """Refused designs of which no change that the refusal names makes a mold."""
        return [each for each in self.with_status(REFUSED) if each.get("then") != MADE]

    def checks(self) -> list[Check]:
        """List the targets and what was measured."""
        made, number = self.with_status(MADE), max(1, len(self.records))
        built = made + self.with_status(FAILED)
        slowest = max(
            (float(each["seconds"]) for each in self.records if "seconds" in each), default=0.0
        )
        worst = [
            max((float(each[name]) for each in built if each[name] is not None), default=0.0)
            for name in ("volume_error", "insert_chord_mm", "chord_mm")
        ]
        return [
            Check("designs without a mold", 1.0 - MADE_SHARE, 1.0 - len(made) / number),
            Check("refusals whose remedies give no mold", 0, len(self.unmended())),
            Check("molds that fail a check", 0, len(self.with_status(FAILED))),
            Check("crashes and hangs", 0, len(self.with_status(CRASHED))),
            Check("cavity less plates against the finger's body", VOLUME_ERROR, worst[0]),
            Check("chord on the contact surface", CHORD_MM, worst[1], "mm"),
            Check("chord on any part", CHORD_MM, worst[2], "mm"),
            Check(f"slowest answer, {self.workers} at once", SECONDS, slowest, "s"),
        ]


def measure_molds(
    folder: Path,
    report: Report = lambda message: None,
    seeds: int = SEEDS,
    workers: int = WORKERS,
) -> Molds:
    """Make molds that ``folder`` has no record of yet: of shipped designs and ``seeds`` others."""
    from fingerdesign.design.shipped import shipped_names

    found_machine = machine()
    cases = [*shipped_names(), *(str(seed) for seed in range(seeds))]
    version = code_version(Path(str(fingerdesign.mold.__file__)).parent)
    records = Lines(folder / LINES, "case", version, words).resumed(cases, _run, workers, report)
    return Molds(records, workers, found_machine)


def _run(case: str) -> Record:
    start = time.perf_counter()
    try:
        record: Record = call(
            "fingerdesign_bench.any_finger.molds_worker:mold_one", case, time_s=TIME_LIMIT_S
        )
    except ProcessError as error:
        record = {"case": case, "name": case, "kinds": [], "status": CRASHED}
        record["reason"] = str(error)
    return record | {"whole_s": round(time.perf_counter() - start, 2)}


def words(record: Record) -> str:
    """A design's record in a line."""
    name = " ".join(
        [record["name"], *([f"({', '.join(record['kinds'])})"] if record["kinds"] else [])]
    )
    if record["status"] == MADE:
        return f"{name}: {record['checks']} checks hold, {record['seconds']:.1f} s"
    if record["status"] == FAILED:
        return f"{name}: failed: {'; '.join(record['failed'])}"
    text = f"{name}: {record['status']}: {record['reason']}"
    return f"{text}; with {record['remedy']}: {record['then']}" if record.get("remedy") else text


def by_kind(records: Sequence[Record]) -> list[tuple[str, int, int, int, float, float]]:
    """Designs, made, refused, median seconds and greatest volume error of each kind."""
    groups: dict[str, list[Record]] = {}
    for each in records:
        for kind in each["kinds"]:
            groups.setdefault(kind, []).append(each)
    rows = []
    for kind, mine in sorted(groups.items()):
        made = [each for each in mine if each["status"] == MADE]
        refused = sum(each["status"] == REFUSED for each in mine)
        seconds = statistics.median(each["seconds"] for each in made) if made else 0.0
        worst = max((each["volume_error"] or 0.0 for each in made), default=0.0)
        rows.append((kind, len(mine), len(made), refused, seconds, worst))
    return rows


def write_molds(found: Molds, folder: Path) -> list[Path]:
    """Write molds.json: machine, checks, kinds and every design's record."""
    names = ("kind", "designs", "made", "refused", "median_s", "volume_error")
    record = {
        "machine": found.machine,
        "workers": found.workers,
        "checks": [check.as_dict() for check in found.checks()],
        "kinds": [dict(zip(names, row, strict=True)) for row in by_kind(found.records)],
        "designs": found.records,
    }
    return [write_json(folder / "molds.json", record)]
