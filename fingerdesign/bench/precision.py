"""Work-precision diagrams: errors of forces, stick ratio and gage strains against wall time."""

from __future__ import annotations

import csv
import json
import os
import time
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from fingerdesign.bench.machine import machine
from fingerdesign.bench.precision_plan import (
    CHARTS,
    REFERENCES,
    Chart,
    Group,
    Line,
    Reference,
)
from fingerdesign.bench.precision_run import STAGES, Method, Run, errors, measured
from fingerdesign.errors import SolverError
from fingerdesign.runtime.progress import Tell

Errors = tuple[float, float, float, float]

QUANTITIES = {
    "normal_force_error": "normal force, relative",
    "tangential_force_error": "tangential force, relative",
    "stick_ratio_error": "stick ratio, absolute",
    "gage_error": "gage strain, of the largest",
}
NORM = (
    "Error: the worst of five increments; gages: membrane strain of three plates, relative to the "
    "largest reading of the increment"
)
TIMED = (
    "Time: design to last increment in a process that has made one run before (imports and the "
    "mesher's own start are left out), no cache; the least of 2 to 3 runs where they are short"
)
OFF_THE_CHART = 5.0  # an error as large tells that there is no answer, and needs no place
_LARGE = 0.02  # of F_n: what is still this far off on its finest mesh does not converge


@dataclass(frozen=True)
class Point:
    """One run in one line of a chart. Errors are None where it failed; ``failure`` says why."""

    chart: str
    group: str
    line: str
    reference: str
    size_mm: float
    element: str
    dofs: int
    contact_nodes: int
    seconds: float
    geometry_s: float
    mesh_s: float
    assemble_s: float
    condense_s: float
    increments_s: float
    runs: int
    normal_force_error: float | None
    tangential_force_error: float | None
    stick_ratio_error: float | None
    gage_error: float | None
    failure: str = ""

    def error(self, key: str) -> float | None:
        """The error of one of QUANTITIES."""
        value: float | None = getattr(self, key)
        return value


@dataclass(frozen=True)
class Precision:
    """Everything that the diagrams show.

    doubts: how far the two references of each (chart, group) differ, in the order of QUANTITIES.
    remarks: what failed or does not converge, by chart.
    """

    points: tuple[Point, ...]
    doubts: dict[tuple[str, str], Errors]
    remarks: dict[str, tuple[str, ...]]
    references: dict[str, Run]
    machine: dict[str, Any]
    charts: tuple[Chart, ...]
    seconds: float
    cpu_seconds: float
    quick: bool


def measure_precision(
    tell: Tell = lambda message: None,
    quick: bool = False,
    charts: Sequence[Chart] = CHARTS,
    references: Sequence[Reference] = REFERENCES,
) -> Precision:
    """All points of ``charts``: six minutes on two quiet cores; ``quick``: half a minute.

    A run that fails is a point with its reason. Raises SolverError where a reference fails.
    """
    began, used = time.perf_counter(), _processor_seconds()
    found_machine = machine()
    wanted = {name for chart in charts for group in chart.groups for name in _names(group)}
    kept: dict[tuple[Method, float], Run] = {}

    def run(method: Method, size: float, repeat: bool) -> Run:
        key = (method, size)
        if key not in kept:
            tell(f"{describe(method)}, {size:g} mm")
            kept[key] = measured(method, size, repeat)
        return kept[key]

    measured(Method("plane strain"), 0.4, repeat=False)  # warms imports and the mesher's process
    solved: dict[str, Run] = {}
    for each in references:
        if each.name in wanted:
            result = run(each.method, each.quick_size_mm if quick else each.size_mm, False)
            if result.answers is None:
                raise SolverError(f"the reference {each.name} failed: {result.failure}")
            solved[each.name] = result
    points: list[Point] = []
    doubts: dict[tuple[str, str], Errors] = {}
    remarks: dict[str, tuple[str, ...]] = {}
    for chart in charts:
        said: list[str] = []
        for group in chart.groups:
            first, second = (solved[name].answers for name in group.doubt)
            assert first is not None
            assert second is not None
            doubts[chart.key, group.heading] = errors(first, second)
            for line in group.lines:
                sizes = line.sizes[: line.quick] if quick else line.sizes
                new = [
                    _point(chart, group, line, run(line.method, size, not quick), solved)
                    for size in sizes
                ]
                points += new
                said += _remarks(group, line, new)
        remarks[chart.key] = tuple(said)
    return Precision(
        tuple(points),
        doubts,
        remarks,
        solved,
        found_machine,
        tuple(charts),
        time.perf_counter() - began,
        _processor_seconds() - used,
        quick,
    )


def write_precision(found: Precision, folder: Path) -> list[Path]:
    """precision.csv, precision.json and a picture a chart, and one of the stages."""
    from fingerdesign.bench.precision_chart import draw_chart, draw_stages

    folder.mkdir(parents=True, exist_ok=True)
    table, record = folder / "precision.csv", folder / "precision.json"
    with table.open("w", encoding="utf-8", newline="") as stream:
        writer = csv.DictWriter(stream, list(asdict(found.points[0])), lineterminator="\n")
        writer.writeheader()
        writer.writerows(asdict(point) for point in found.points)
    record.write_text(json.dumps(_record(found), indent=1, allow_nan=False) + "\n", "utf-8")
    pictures = []
    for chart in found.charts:
        pictures.append(folder / f"precision-{chart.key}.png")
        draw_chart(found, chart, pictures[-1])
    pictures.append(folder / "precision-stages.png")
    draw_stages(found, pictures[-1])
    return [table, record, *pictures]


def describe(method: Method) -> str:
    """A method in words."""
    plates = "" if method.plates == "solid" else f", plates: {method.plates}"
    element = "" if method.element == "auto" else f", {method.element}"
    full = ", full at each iteration" if method.solve == "full" else ""
    return f"{method.kind}{element}, nu = {method.poissons_ratio:g}{plates}{full}"


def _names(group: Group) -> set[str]:
    return {*group.doubt, *(line.reference for line in group.lines)}


def _point(chart: Chart, group: Group, line: Line, run: Run, solved: dict[str, Run]) -> Point:
    reference = solved[line.reference].answers
    assert reference is not None
    normal, tangential, stick, gage = (
        (None,) * 4 if run.answers is None else errors(run.answers, reference)
    )
    stages = {f"{name}_s": run.seconds.get(name, 0.0) for name in STAGES}
    return Point(
        chart=chart.key,
        group=group.heading,
        line=line.label,
        reference=line.reference,
        size_mm=run.size_mm,
        element=run.element,
        dofs=run.dofs,
        contact_nodes=run.contact_nodes,
        seconds=run.total,
        runs=run.runs,
        normal_force_error=normal,
        tangential_force_error=tangential,
        stick_ratio_error=stick,
        gage_error=gage,
        failure=run.failure,
        **stages,
    )


def _remarks(group: Group, line: Line, points: Sequence[Point]) -> list[str]:
    """What failed, and what its finest mesh leaves."""
    name = f"{line.label} ({group.heading})"
    said = [f"{name}, {p.size_mm:g} mm: failed: {p.failure}" for p in points if p.failure]
    last = [point for point in points if not point.failure][-1:]
    for point in last:
        worst = point.normal_force_error
        if worst is not None and worst > _LARGE:
            left = f"F_n still {worst:.0%} off at {point.size_mm:g} mm ({point.dofs} dofs)"
            said.append(f"{name}: {line.floor}: {left}" if line.floor else f"{name}: {left}")
        if point.gage_error is not None and point.gage_error > OFF_THE_CHART:
            said.append(f"{name}: gage strain {point.gage_error:.0f} times off, off the chart")
    return said


def _record(found: Precision) -> dict[str, Any]:
    return {
        "machine": found.machine,
        "norm": NORM,
        "timed": TIMED,
        "quick": found.quick,
        "seconds": round(found.seconds, 1),
        "processor_seconds": round(found.cpu_seconds, 1),
        "references": {
            name: {
                "method": describe(run.method),
                "element": run.element,
                "size_mm": run.size_mm,
                "dofs": run.dofs,
                "seconds": round(run.total, 2),
            }
            for name, run in found.references.items()
        },
        "references_differ": [
            {"chart": chart, "group": group, **dict(zip(QUANTITIES, values, strict=True))}
            for (chart, group), values in found.doubts.items()
        ],
        "remarks": found.remarks,
    }


def _processor_seconds() -> float:
    """Of this process and of those that it started and that have ended."""
    times = os.times()
    return float(times.user + times.system + times.children_user + times.children_system)
