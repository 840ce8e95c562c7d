"""Points of the work-precision diagrams, and how they are measured."""

from dataclasses import dataclass
from typing import Any

from fingerdesign_bench.speed.precision_lines import Chart, Line, Reference
from fingerdesign_bench.speed.precision_run import QUANTITIES, STAGES, Errors, Run

_ERRORS = ["F_n", "F_t", "stick", "gages", "faces"]
HEADINGS = ["chart", "method", "facets mm", "dofs", "Gflop", "s", *_ERRORS]
NORM = (
    "Error: the worst of five increments; forces relative, stick ratio absolute, gages relative to "
    "the largest reading of the increment"
)
TIMED = (
    "Time: design to last increment in a process that has made one run before (imports and the "
    "mesher's own start are left out), no cache; the least of 2 to 3 runs where they are short"
)
OFF_THE_CHART = 5.0  # An error of this size or more is no answer, so the chart has no place for it.


@dataclass(frozen=True)
class Point:
    """One run in one line of a chart, and its errors: none where the run failed."""

    chart: str
    group: str
    line: Line
    run: Run
    errors: Errors

    def record(self) -> dict[str, Any]:
        """Return the row of the data file; an error that is not there is None."""
        run, parts = self.run, ("size_mm", "element", "dofs", "contact_nodes")
        return {
            "chart": self.chart,
            "group": self.group,
            "line": self.line.label,
            "reference": self.line.reference.name,
            **{name: getattr(run, name) for name in parts},
            "seconds": run.total,
            "cpu_s": run.cpu_s,
            "gflop": run.gflop,
            **{f"{stage}_s": run.seconds.get(stage, 0.0) for stage in STAGES},
            "runs": run.runs,
            **{name: self.errors.get(name) for name in QUANTITIES},
            "failure": run.failure,
        }

    def row(self) -> list[str]:
        """Return the cells of a table with HEADINGS."""
        run, found = self.run, [self.errors.get(name) for name in QUANTITIES]
        return [
            self.chart,
            f"{self.line.label} ({self.group})",
            f"{run.size_mm:g}",
            str(run.dofs),
            f"{run.gflop:.3g}",
            f"{run.total:.2f}",
            *("failed" if error is None else f"{error:.1e}" for error in found),
        ]


@dataclass(frozen=True)
class Precision:
    """Points of all charts.

    differences: between the two references of each (chart, group).
    remarks: failures and lines that do not converge, by chart.
    """

    points: tuple[Point, ...]
    differences: dict[tuple[str, str], Errors]
    remarks: dict[str, list[str]]
    references: dict[Reference, Run]
    charts: tuple[Chart, ...]
