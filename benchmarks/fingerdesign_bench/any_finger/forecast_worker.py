"""One analysis forecast, then run: ``python -m ...any_finger.forecast_worker PAIR OUT``.

In a process of its own and with an empty mesh cache, so that peak memory and time are its own.
"""

from __future__ import annotations

import json
import os
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any


def measure_pair(pair: dict[str, Any], folder: Path) -> dict[str, Any]:
    """Forecast and measure a pair (design, scene, fidelity, values); plain values.

    The forecast's time is for the machine as it was right before and right after the run: other
    work on it slows both.
    """
    from fingerdesign.analysis.forecast.forecast import forecast_case
    from fingerdesign.pipeline import analyse_into
    from fingerdesign.runtime.machine import measure_machine, slower
    from fingerdesign_bench.any_finger.forecast import case_of

    case = case_of(pair)
    before = measure_machine()
    start = time.perf_counter()
    forecast_case(case, before)
    asking = time.perf_counter() - start
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    start, used = time.perf_counter(), _processor_seconds()
    result = analyse_into(case, folder)
    wall, used = time.perf_counter() - start, _processor_seconds() - used
    machine = slower(before, measure_machine())
    # Foretold anew, for that machine, as before the run: its mesh must not be found in the cache.
    os.environ["FINGERDESIGN_CACHE"] = str(folder / "empty")
    found = forecast_case(case, machine)
    record: dict[str, Any] = {
        **pair,
        "status": result.status,
        "failure": result.failure,
        "machine": asdict(machine),
        "load": load,
        "asking_s": asking,
        "forecast": found.as_dict() | {"time_s": found.total_s},
    }
    if result.model is None or result.mesh is None:
        return record
    return record | {
        "elements": result.mesh.elements,
        "dofs": result.model.dofs,
        "contact_nodes": result.model.contact_nodes,
        "memory_MB": result.peak_memory_MB,
        "time_s": sum(result.timings_s.values()),
        "wall_s": wall,
        "processor_s": used,
        "timings_s": result.timings_s,
    }


def _processor_seconds() -> float:
    """Of this process and of those that it started and that have ended."""
    told = os.times()
    return told.user + told.system + told.children_user + told.children_system


def main(arguments: list[str]) -> int:
    """Measure the pair given as JSON and write its record."""
    from fingerdesign.runtime.process import die_with_parent

    die_with_parent()
    with tempfile.TemporaryDirectory(prefix="fingerdesign-forecast-") as folder:
        os.environ["FINGERDESIGN_CACHE"] = str(Path(folder, "cache"))
        record = measure_pair(json.loads(arguments[0]), Path(folder, "out"))
    Path(arguments[1]).write_text(json.dumps(record, allow_nan=False), encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
