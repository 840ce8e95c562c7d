"""The whole of ``analyse`` on the reference finger, in a process of its own, from a cold cache."""

import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.machine import machine

LIMITS = {"3d": 90.0, "plane-strain": 10.0}  # s on 2 cores
MEMORY_MB = 6 * 1024.0
MOST_DOFS = 250_000


def measure_whole(_folder: Path, report: Report, fidelity: str | None) -> Shown:
    """Run one fidelity, or both."""
    begun, checks = machine(), list[Check]()
    for each in (fidelity,) if fidelity else ("plane-strain", "3d"):
        report(each)
        found, stages = whole_checks(each)
        checks += found
        report(f"{each}: " + ", ".join(f"{name} {s:.1f} s" for name, s in stages.items() if s))
    return Shown("A whole analysis, in a process of its own", checks, begun)


def whole_checks(fidelity: str) -> tuple[list[Check], dict[str, float]]:
    """Seconds, memory and dofs of one run with its grips and its report, and seconds by stage."""
    with tempfile.TemporaryDirectory(prefix="fingerdesign-bench-") as folder:
        arguments = ["analyse", "maeno2000", "--out", folder, "--quiet"]
        environment = os.environ | {"FINGERDESIGN_CACHE": str(Path(folder, "cache"))}
        start = time.perf_counter()
        done = subprocess.run(
            [sys.executable, "-m", "fingerdesign_cli.main", *arguments, "--fidelity", fidelity],
            env=environment,
            capture_output=True,
            text=True,
            check=False,
        )
        seconds = time.perf_counter() - start
        if done.returncode != 0:
            raise RuntimeError(f"analyse failed: {done.stderr.strip()[-500:]}")
        result = json.loads(Path(folder, "maeno2000", "result.json").read_text("utf-8"))
    children = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024.0
    label = f"analyse maeno2000, {fidelity}, cold"
    checks = [
        Check(f"{label}: wall time", LIMITS[fidelity], seconds, "s"),
        Check(f"{label}: memory", MEMORY_MB, max(children, result["peak_memory_MB"]), "MB"),
        Check(f"{label}: dofs", MOST_DOFS, result["model"]["dofs"]),
    ]
    return checks, result["timings_s"]
