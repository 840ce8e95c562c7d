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
from fingerdesign.report.style import PAPER, SERIES, canvas, house_style
from fingerdesign.runtime.isolate import ProcessError, call
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.check import Check
from fingerdesign_bench.fidelity.pairs import pairs
from fingerdesign_bench.files import write_json
from fingerdesign_bench.lines import Record, code_version, resumed
from fingerdesign_bench.machine import caption, machine
from fingerdesign_bench.speed.growth import tick

# Forecasts drawn: what was predicted over what was measured, one panel a quantity.

_PANELS = (("dofs", "dofs"), ("memory_MB", "peak memory, MB"), ("time_s", "time, s"))
_FOOT = (
    "One process an analysis, from the design to the report, mesh cache empty. Time: for the "
    "machine's speed as measured before and after each. Lines: equal, and a factor of 2."
)


def draw_forecasts(records: Sequence[dict[str, Any]], machine: dict[str, Any], path: Path) -> None:
    """Three panels, logarithmic, with the line of equality and the band of a factor of two."""
    done = [each for each in records if each["status"] == "ok"]
    kinds = list(dict.fromkeys(kind(each) for each in done))
    with house_style():
        figure = canvas(12.5, 4.9)
        parts: Any = figure.subfigures(2, 1, height_ratios=[4.0, 0.9])
        top, bottom = parts
        for axes, (name, words) in zip(top.subplots(1, 3), _PANELS, strict=True):
            every = [each[name] for each in done] + [each["forecast"][name] for each in done]
            ends = [0.7 * min(every), 1.4 * max(every)]
            for factor, dashes in ((0.5, ":"), (1.0, "-"), (2.0, ":")):
                axes.plot(ends, [factor * end for end in ends], dashes, color="#888888", lw=1.0)
            for number, each_kind in enumerate(kinds):
                colour, _, marker = SERIES[number % len(SERIES)]
                mine = [each for each in done if kind(each) == each_kind]
                axes.plot(
                    [each[name] for each in mine],
                    [each["forecast"][name] for each in mine],
                    color=colour,
                    marker=marker,
                    linestyle="none",
                    label=f"{each_kind} ({len(mine)})",
                )
            axes.set(xscale="log", yscale="log", xlim=ends, ylim=ends)
            axes.set_title(f"{words}: predicted over measured")
            axes.set_xlabel("measured")
            tick(axes.xaxis)
            tick(axes.yaxis)
        top.axes[0].legend(loc="upper left", fontsize=8)
        text = f"{_FOOT}\n{caption(machine)}"
        bottom.text(0.008, 0.98, text, va="top", fontsize=7.5, linespacing=1.3)
        figure.savefig(path, dpi=110, facecolor=PAPER)


def kind(record: dict[str, Any]) -> str:
    """How a record's finger was meshed."""
    mesher = {"netgen": "plane strain", "extrude": "3-D, extruded"}
    return mesher.get(record["forecast"]["mesher"], "3-D, fTetWild")


LINES = "forecast.jsonl"
# A forecast within a factor of 2 tells minutes from hours.
TARGET = 2.0
TIME_LIMIT_S = 1800.0
QUANTITIES = ("dofs", "memory_MB", "time_s")
_SWEPT: dict[str, object] = {"mesh.mesher": "extrude"}
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
    """How many times the forecast is over or under what was measured, 1 or more."""
    return float(np.exp(abs(np.log(record["forecast"][name] / record[name]))))


def plain_pairs(quick: bool = False) -> list[Record]:
    """The pairs as the worker reads them: PAIRS, and the thirty of ``bench fidelity``, those with
    motion given in plane strain and those with forces in 3-D."""
    names = ("design", "scene", "fidelity", "values")
    if quick:
        return [dict(zip(names, PAIRS[k], strict=True)) for k in QUICK]
    own = [dict(zip(names, each, strict=True)) for each in PAIRS]
    for pair in pairs():
        fidelity = "plane-strain" if pair.control == "motion" else "3d"
        own.append(
            dict(zip(names, (f"pair_{pair.number}", pair.control, fidelity, {}), strict=True))
        )
    return own


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
    found = resumed(
        folder / LINES,
        "case",
        list(pairs_of),
        lambda case: {"case": case} | _run(pairs_of[case]),
        version,
        1,
        report,
        lambda record: " ".join(rows([record])[0]),
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
    """A row a pair: what was predicted and what it was."""
    found = []
    for each in records:
        reported = each["forecast"]
        if each["status"] != "ok":
            found.append([name_of(each), "failed", "", "", "", ""])
            continue
        found.append(
            [
                name_of(each),
                f"{reported['dofs']:.0f} / {each['dofs']:.0f}",
                f"{reported['memory_MB']:.0f} / {each['memory_MB']:.0f}",
                f"{reported['time_s']:.1f} / {each['time_s']:.1f}",
                " ".join(f"{factor(each, name):.2f}" for name in QUANTITIES),
                f"{each['machine']['one_core']:.0f}",
            ]
        )
    return found


def write_forecasts(found: Forecasts, folder: Path) -> list[Path]:
    """forecast.json: the records, the checks and the machine; forecast.png."""
    content = {
        "machine": found.machine,
        "checks": [check.as_dict() for check in found.checks()],
        "records": found.records,
    }
    path, chart = write_json(folder / "forecast.json", content), folder / "forecast.png"
    draw_forecasts(found.records, found.machine, chart)
    return [path, chart]
