"""One analysis forecast, then run.

In a process of its own and with an empty mesh cache, so that peak memory and time are its own.
"""

import os
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
    from fingerdesign.runtime.machine import Machine, measure_machine, processor_seconds
    from fingerdesign_bench.any_finger.forecast import case_of

    case = case_of(pair)
    before = measure_machine()
    start = time.perf_counter()
    forecast_case(case, before)
    asking = time.perf_counter() - start
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    start, used = time.perf_counter(), processor_seconds()
    result = analyse_into(case, folder)
    wall, used = time.perf_counter() - start, processor_seconds() - used
    after = measure_machine()
    one, every = (  # the mean time of a product
        2.0 / (1.0 / first + 1.0 / second)
        for first, second in (
            (before.one_core, after.one_core),
            (before.all_cores, after.all_cores),
        )
    )
    machine = Machine(one, every, before.cores)
    # Predicted again, for that machine, as before the run: its mesh must not be found in the cache.
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


def measured(pair: dict[str, Any]) -> dict[str, Any]:
    """The record of a pair, made in a folder that is thrown away."""
    with tempfile.TemporaryDirectory(prefix="fingerdesign-forecast-") as folder:
        os.environ["FINGERDESIGN_CACHE"] = str(Path(folder, "cache"))
        return measure_pair(pair, Path(folder, "out"))
