"""``fingerdesign bench --out``: precision, speed and stability into one folder."""

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check
from fingerdesign_bench.files import write_json
from fingerdesign_bench.machine import machine

# Measures and writes into a folder; returns the files and the checks.
Part = Callable[[Path, Report, bool], tuple[list[Path], list[Check]]]


@dataclass
class Suite:
    """Files, checks, and the parts that failed with their reasons.

    machine: as it was at the start.
    """

    paths: list[Path] = field(default_factory=list)
    checks: list[Check] = field(default_factory=list)
    failures: dict[str, str] = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    machine: dict[str, Any] = field(default_factory=dict)


def run_suite(
    folder: Path,
    report: Report = lambda message: None,
    quick: bool = False,
    parts: dict[str, Part] | None = None,
) -> Suite:
    """Run every part; one that fails does not keep the others from running. Writes bench.json."""
    folder.mkdir(parents=True, exist_ok=True)
    found = Suite(machine=machine())
    for name, part in (PARTS if parts is None else parts).items():
        start = time.perf_counter()
        try:
            paths, checks = part(folder, _named(report, name), quick)
            found.paths += paths
            found.checks += checks
        except FingerDesignError as error:
            found.failures[name] = str(error)
        found.seconds[name] = round(time.perf_counter() - start, 1)
    record: dict[str, Any] = {
        "machine": found.machine,
        "quick": quick,
        "seconds": found.seconds,
        "failures": found.failures,
        "checks": [check.as_dict() for check in found.checks],
        "files": [path.name for path in found.paths],
    }
    found.paths.append(write_json(folder / "bench.json", record))
    return found


def _named(report: Report, name: str) -> Report:
    return lambda message: report(f"{name}: {message}")


def _precision(folder: Path, report: Report, quick: bool) -> tuple[list[Path], list[Check]]:
    from fingerdesign_bench.speed.precision import measure_precision, write_precision

    return write_precision(measure_precision(report, quick), folder), []


def _speed(folder: Path, report: Report, quick: bool) -> tuple[list[Path], list[Check]]:
    from fingerdesign_bench.speed.speed import measure_speed, write_speed

    found = measure_speed(report, quick)
    return write_speed(found, folder), list(found.checks)


def _stability(folder: Path, report: Report, quick: bool) -> tuple[list[Path], list[Check]]:
    from fingerdesign_bench.stability.stability import measure_stability, write_stability

    found = measure_stability(report, quick)
    return write_stability(found, folder), found.checks()


PARTS: dict[str, Part] = {"precision": _precision, "speed": _speed, "stability": _stability}
