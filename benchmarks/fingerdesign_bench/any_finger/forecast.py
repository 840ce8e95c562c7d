"""``fingerdesign bench forecast``: what was predicted of dofs, memory and time, and what it was.

Each analysis's record is one line of forecast.jsonl, written when it is done: an interrupted run
goes on where it stopped. Records of other code (any file of fingerdesign/analysis) are made again.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import fingerdesign.analysis
from fingerdesign.analysis.case import Case
from fingerdesign.errors import SolverError
from fingerdesign.report.style import house_style
from fingerdesign.runtime.isolate import ProcessError, call
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.chart import dots, footed, save, tick
from fingerdesign_bench.check import Check
from fingerdesign_bench.fidelity.pairs import pairs
from fingerdesign_bench.files import Lines, Record, code_version, write_json
from fingerdesign_bench.machine import caption, machine

HEADINGS = ("analysis", "dofs", "MB", "s", "factors", "GFLOP/s")
_PANELS = (("dofs", "dofs"), ("memory_MB", "peak memory, MB"), ("time_s", "time, s"))
_FOOT = (
    "One process an analysis, from the design to the report, mesh cache empty. Time: for the "
    "machine's speed as measured before and after each. Lines: equal, and a factor of 2."
)
_MESHED = {"netgen": "plane strain", "sweep": "3-D, extruded"}  # by the mesher
LINES = "forecast.jsonl"
# A forecast within a factor of 2 tells minutes from hours.
TARGET = 2.0
TIME_LIMIT_S = 1800.0
QUANTITIES = ("dofs", "memory_MB", "time_s")
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


@dataclass
class Forecasts:
    """One record a pair, as forecast_worker writes them, and the machine."""

    records: list[Record]
    machine: dict[str, Any] = field(default_factory=dict)

    def checks(self) -> list[Check]:
        """List the worst factor between forecast and measurement, either way, by quantity."""
        done = [each for each in self.records if each["status"] == "ok"]
        found = []
        for name, words in zip(QUANTITIES, ("dofs", "peak memory", "time"), strict=True):
            what = f"{words}: worst factor between forecast and measured, {len(done)} analyses"
            worst = max((factor(each, name) for each in done), default=float("inf"))
            found.append(Check(what, TARGET, worst))
        found.append(Check("analyses that failed", 0, len(self.records) - len(done)))
        slowest = max((float(each["asking_s"]) for each in done), default=0.0)
        found.append(Check("seconds that a forecast takes", 1.0, slowest, "s"))
        return found


def factor(record: Record, name: str) -> float:
    """The factor by which the forecast is over or under the measurement, at least 1."""
    return float(np.exp(abs(np.log(record["forecast"][name] / record[name]))))


def plain_pairs(quick: bool = False) -> list[Record]:
    """The pairs as the worker reads them: PAIRS, and the thirty of ``bench fidelity``, those with
    motion given in plane strain and those with forces in 3-D."""
    names = ("design", "scene", "fidelity", "values")
    chosen = [PAIRS[k] for k in QUICK] if quick else list(PAIRS)
    for pair in () if quick else pairs():
        fidelity = "plane-strain" if pair.control == "motion" else "3d"
        chosen.append((f"pair_{pair.number}", pair.control, fidelity, {}))
    return [dict(zip(names, each, strict=True)) for each in chosen]


def case_of(pair: Record) -> Case:
    """The case of a pair."""
    from fingerdesign.checks.load import load_design, parse_design, with_values
    from fingerdesign.design.shipped import load_scene

    name = str(pair["design"])
    if name.startswith("pair_"):
        drawn = pairs()[int(name.removeprefix("pair_"))]
        return Case(drawn.design, drawn.scene, pair["fidelity"], scene_name=drawn.control)
    if name.startswith("any_"):
        import tomlkit

        from fingerdesign_bench.any_finger.designs import random_design

        design = parse_design(tomlkit.dumps(random_design(int(name.removeprefix("any_")))))
    else:
        design = load_design(Path(name))
    if pair["values"]:
        design = with_values(design, pair["values"])
    scene = load_scene(Path(pair["scene"])) if pair["scene"] else None
    return Case(design, scene, pair["fidelity"], scene_name=pair["scene"])


def measure_forecasts(
    folder: Path,
    report: Report = lambda message: None,
    quick: bool = False,
) -> Forecasts:
    """Forecast and run each pair that ``folder`` has no record of yet, in a process of its own, one
    after the other."""
    pairs_of = {name_of(pair): pair for pair in plain_pairs(quick)}
    version = code_version(Path(str(fingerdesign.analysis.__file__)).parent)
    lines = Lines(folder / LINES, "case", version, lambda record: " ".join(_row(record)))
    found = lines.resumed(
        list(pairs_of), lambda case: {"case": case} | _run(pairs_of[case]), 1, report
    )
    return Forecasts(found, machine())


def name_of(pair: Record) -> str:
    """A pair in words."""
    mesher = pair["values"].get("mesh.mesher")
    kind = pair["fidelity"] + (f", {mesher}" if mesher else "")
    return f"{pair['design']} ({pair['scene'] or 'fundamental'}, {kind})"


def _run(pair: Record) -> Record:
    try:
        record: Record = call(
            "fingerdesign_bench.any_finger.forecast_worker:measured", pair, time_s=TIME_LIMIT_S
        )
    except ProcessError as error:
        raise SolverError(f"{name_of(pair)}: {error}") from error
    return record


def rows(records: Sequence[Record]) -> list[list[str]]:
    """Cells under HEADINGS, a row a pair."""
    return [_row(each) for each in records]


def _row(record: Record) -> list[str]:
    if record["status"] != "ok":
        return [name_of(record), "failed", "", "", "", ""]

    def both(name: str, digits: int) -> str:
        return f"{record['forecast'][name]:.{digits}f} / {record[name]:.{digits}f}"

    factors = " ".join(f"{factor(record, name):.2f}" for name in QUANTITIES)
    cells = [both("dofs", 0), both("memory_MB", 0), both("time_s", 1), factors]
    return [name_of(record), *cells, f"{record['machine']['one_core']:.0f}"]


def write_forecasts(found: Forecasts, folder: Path) -> list[Path]:
    """forecast.json: the records, the checks and the machine; forecast.png."""
    content = {
        "machine": found.machine,
        "checks": [check.as_dict() for check in found.checks()],
        "records": found.records,
    }
    path = write_json(folder / "forecast.json", content)
    return [path, draw_forecasts(found.records, found.machine, folder / "forecast.png")]


def draw_forecasts(records: Sequence[Record], machine: dict[str, Any], path: Path) -> Path:
    """Three panels, logarithmic, with the line of equality and the band of a factor of two."""
    done = [each for each in records if each["status"] == "ok"]
    kinds: dict[str, list[Record]] = {}
    for each in done:
        kinds.setdefault(_MESHED.get(each["forecast"]["mesher"], "3-D, fTetWild"), []).append(each)
    with house_style():
        figure, top = footed(4.0, [_FOOT, caption(machine)])
        for axes, (name, words) in zip(top.subplots(1, 3), _PANELS, strict=True):
            every = [number for each in done for number in (each[name], each["forecast"][name])]
            ends = [0.7 * min(every), 1.4 * max(every)]
            for factor, dashes in ((0.5, ":"), (1.0, "-"), (2.0, ":")):
                axes.plot(ends, [factor * end for end in ends], dashes, color="#888888", lw=1.0)
            for number, (kind, mine) in enumerate(kinds.items()):
                x, y = [each[name] for each in mine], [each["forecast"][name] for each in mine]
                dots(axes, number, x, y, f"{kind} ({len(mine)})")
            axes.set(xscale="log", yscale="log", xlim=ends, ylim=ends, xlabel="measured")
            axes.set_title(f"{words}: predicted over measured")
            tick(axes.xaxis)
            tick(axes.yaxis)
        top.axes[0].legend(loc="upper left", fontsize=8)
        return save(figure, path)
