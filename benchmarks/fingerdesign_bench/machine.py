"""The machine, its load, versions and thread settings: measured times depend on them."""

import os
import platform
from importlib import metadata
from pathlib import Path
from typing import Any

import psutil
from threadpoolctl import threadpool_info

from fingerdesign.version import versions

_MORE = ("mkl", "threadpoolctl", "matplotlib")
_THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS")


def machine() -> dict[str, Any]:
    """Processor, cores, memory, load, versions and threads, as JSON holds them."""
    found = dict(versions())
    for name in _MORE:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = "absent"
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else None
    return {
        "processor": _processor(),
        "architecture": platform.machine(),
        "system": platform.system(),
        "cores": os.cpu_count(),
        "memory_GB": round(psutil.virtual_memory().total / 2**30, 1),
        "load_average": None if load is None else round(load, 2),
        "versions": found,
        "threads": {
            "environment": {name: os.environ.get(name) for name in _THREADS},
            "libraries": {str(e.get("prefix")): e.get("num_threads") for e in threadpool_info()},
            "increments": "one BLAS thread",
        },
    }


def caption(found: dict[str, Any]) -> str:
    """The machine and the versions in two lines, for the foot of a chart; first, if it was busy."""
    names = ("fingerdesign", "numpy", "scipy", "mkl", "pypardiso", "scikit-fem", "pytetwild")
    listed = ", ".join(f"{name} {found['versions'][name]}" for name in names)
    load, warning = found["load_average"], busy(found)
    loaded = "" if load is None else f", load average {load:g} at the start"
    warned = f"{warning.upper()}\n" if warning else ""
    return (
        f"{warned}{found['processor']}, {found['cores']} cores, {found['memory_GB']:g} GB{loaded}; "
        f"Python {found['versions']['python']}\n{listed}"
    )


def busy(found: dict[str, Any]) -> str:
    """A warning where more was running at the start than there are cores, or nothing."""
    load, cores = found.get("load_average"), found.get("cores")
    if load is None or cores is None or load <= cores:
        return ""
    return f"busy machine (load {load:g} on {cores} cores): times are not comparable"


def _processor() -> str:
    cpuinfo = Path("/proc/cpuinfo")
    lines = cpuinfo.read_text("utf-8").splitlines() if cpuinfo.is_file() else []
    named = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return named[0] if named else platform.processor() or "unknown processor"
