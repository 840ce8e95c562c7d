"""``fingerdesign bench forecast``: what was predicted of dofs, memory and time, and what it was."""

import os
import time
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from statistics import harmonic_mean

import numpy as np

import fingerdesign.analysis
from fingerdesign.analysis.case import Case
from fingerdesign.analysis.forecast.forecast import forecast_case
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.shipped import load_scene
from fingerdesign.pipeline import analyse_into
from fingerdesign.runtime.files import scratch
from fingerdesign.runtime.machine import Machine, measure_machine, processor_seconds
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.any_finger.designs import parsed_design
from fingerdesign_bench.check import Check, Shown
from fingerdesign_bench.fidelity.pairs import pairs
from fingerdesign_bench.files import Record, apart, code_version, resumed
from fingerdesign_bench.machine import machine

HEADINGS = ("analysis", "dofs", "MB", "s", "factors", "GFLOP/s")
JOURNAL = "forecast.sqlite"
# A forecast within a factor of 2 tells minutes from hours.
TARGET = 2.0
TIME_LIMIT_S = 1800.0
QUANTITIES = {"dofs": "dofs", "memory_MB": "peak memory", "time_s": "time"}
_SWEPT: dict[str, object] = {"mesh.mesher": "sweep"}
_FINE: dict[str, object] = {
    "mesh.section.contact_size_mm": 0.025,
    "mesh.section.plate_size_mm": 0.025,
    "mesh.section.plate_end_size_mm": 0.01,
    "mesh.section.far_size_mm": 0.25,
}
_COARSE: dict[str, object] = _SWEPT | {
    "mesh.contact_size_mm": 0.6,
    "mesh.far_size_mm": 2.5,
    "mesh.layers": 4,
}
# design ("any_K": the random design K), scene ("": the fundamental case and the grips), fidelity,
# values: small and large, flat, swept and tetrahedral, with and without plates and grips.
PAIRS: tuple[tuple[str, str, str, dict[str, object]], ...] = (
    ("homogeneous", "", "plane-strain", {}),
    ("narrow", "pull", "plane-strain", {}),
    ("maeno2000", "", "plane-strain", {}),
    ("wide", "reference_plane_strain", "plane-strain", {}),
    ("boned", "", "plane-strain", _FINE),
    ("any_10", "", "plane-strain", {}),
    ("homogeneous", "ball", "3d", _SWEPT),
    ("narrow", "slope", "3d", _COARSE),
    ("maeno2000", "", "3d", _SWEPT),
    ("homogeneous", "", "3d", {}),
    ("pin", "twist", "3d", {}),
    ("any_13", "", "3d", {}),
)
QUICK = (0, 1, 6)


def measure_forecasts(folder: Path, report: Report, quick: bool = False) -> Shown:
    """Forecast and run each pair that ``folder`` has no record of yet, one after the other."""
    begun, every = machine(), {name_of(pair): pair for pair in plain_pairs(quick)}
    version = code_version(fingerdesign.analysis)
    work = apart("fingerdesign_bench.any_finger.forecast:measured", TIME_LIMIT_S)
    path = folder / JOURNAL
    found = resumed(path, version, every, work, report, lambda *each: " ".join(row(*each)))
    return Shown(
        "Forecasts",
        checks_of(list(found.values())),
        begun,
        {"records": [{"case": name} | record for name, record in found.items()]},
        tables=[("Forecast / measured", HEADINGS, [row(*each) for each in found.items()])],
    )


def checks_of(records: Sequence[Record]) -> list[Check]:
    """List the worst factor between forecast and measurement, either way, by quantity."""
    done = [each for each in records if each["status"] == "ok"]
    found = []
    for name, words in QUANTITIES.items():
        what = f"{words}: worst factor between forecast and measured, {len(done)} analyses"
        worst = max((factor(each, name) for each in done), default=float("inf"))
        found.append(Check(what, TARGET, worst))
    found.append(Check("analyses that failed", 0, len(records) - len(done)))
    slowest = max((float(each["asking_s"]) for each in done), default=0.0)
    return [*found, Check("seconds that a forecast takes", 1.0, slowest, "s")]


def factor(record: Record, name: str) -> float:
    """The factor by which the forecast is over or under the measurement, at least 1."""
    return float(np.exp(abs(np.log(record["forecast"][name] / record[name]))))


def row(name: str, record: Record) -> list[str]:
    """Cells under HEADINGS."""
    if record["status"] != "ok":
        return [name, "failed", "", "", "", ""]

    def both(name: str, digits: int) -> str:
        return f"{record['forecast'][name]:.{digits}f} / {record[name]:.{digits}f}"

    factors = " ".join(f"{factor(record, each):.2f}" for each in QUANTITIES)
    cells = [both("dofs", 0), both("memory_MB", 0), both("time_s", 1), factors]
    return [name, *cells, f"{record['machine']['one_core']:.0f}"]


def plain_pairs(quick: bool = False) -> list[Record]:
    """PAIRS as plain values, and the thirty of ``bench fidelity``: those with motion given in plane
    strain and those with forces in 3-D."""
    names = ("design", "scene", "fidelity", "values")
    chosen = [PAIRS[k] for k in QUICK] if quick else list(PAIRS)
    for pair in () if quick else pairs():
        fidelity = "plane-strain" if pair.control == "motion" else "3d"
        chosen.append((f"pair_{pair.number}", pair.control, fidelity, {}))
    return [dict(zip(names, each, strict=True)) for each in chosen]


def name_of(pair: Record) -> str:
    """A pair in words."""
    mesher = pair["values"].get("mesh.mesher")
    kind = pair["fidelity"] + (f", {mesher}" if mesher else "")
    return f"{pair['design']} ({pair['scene'] or 'fundamental'}, {kind})"


def case_of(pair: Record) -> Case:
    """The case of a pair."""
    name = str(pair["design"])
    if name.startswith("pair_"):
        drawn = pairs()[int(name.removeprefix("pair_"))]
        return Case(drawn.design, drawn.scene, pair["fidelity"], scene_name=drawn.control)
    random = name.startswith("any_")
    design = parsed_design(int(name.removeprefix("any_"))) if random else load_design(Path(name))
    scene = load_scene(Path(pair["scene"])) if pair["scene"] else None
    design = with_values(design, pair["values"])
    return Case(design, scene, pair["fidelity"], scene_name=pair["scene"])


def measured(pair: Record) -> Record:
    """The record of a pair, made in a folder that is thrown away."""
    with scratch("forecast") as folder:
        os.environ["FINGERDESIGN_CACHE"] = str(folder / "cache")
        return measure_pair(pair, folder / "out")


def measure_pair(pair: Record, folder: Path) -> Record:
    """Forecast and measure a pair; plain values.

    The forecast's time is for the machine as it was right before and right after the run: other
    work on it slows both.
    """
    case = case_of(pair)
    before = measure_machine()
    start = time.perf_counter()
    forecast_case(case, before)
    asking = time.perf_counter() - start
    start, used = time.perf_counter(), processor_seconds()
    result = analyse_into(case, folder)
    wall, used = time.perf_counter() - start, processor_seconds() - used
    after = measure_machine()
    one = harmonic_mean([before.one_core, after.one_core])  # the mean time of a product
    speed = Machine(one, harmonic_mean([before.all_cores, after.all_cores]), before.cores)
    # Predicted again, for that machine, as before the run: its mesh must not be found in the cache.
    os.environ["FINGERDESIGN_CACHE"] = str(folder / "empty")
    found = forecast_case(case, speed)
    record: Record = {
        **pair,
        "status": result.status,
        "failure": result.failure,
        "machine": asdict(speed),
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
