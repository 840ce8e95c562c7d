"""Points of the work-precision diagrams, and how they are measured."""

from dataclasses import dataclass

from fingerdesign_bench.speed.precision_lines import Chart
from fingerdesign_bench.speed.precision_run import Run

Errors = tuple[float, float, float, float, float]

QUANTITIES = {
    "normal_force_error": "normal force, relative",
    "tangential_force_error": "tangential force, relative",
    "stick_ratio_error": "stick ratio, absolute",
    "gage_error": "gages, mean of both faces",
    "face_error": "gages, single faces",
}
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
    cpu_s: float
    gflop: float
    mesh_s: float
    assemble_s: float
    condense_s: float
    increments_s: float
    runs: int
    normal_force_error: float | None
    tangential_force_error: float | None
    stick_ratio_error: float | None
    gage_error: float | None
    face_error: float | None
    failure: str = ""

    def error(self, key: str) -> float | None:
        """Return the error of one of QUANTITIES."""
        value: float | None = getattr(self, key)
        return value

    def row(self) -> list[str]:
        """Return the cells of a table with HEADINGS."""
        found = [self.error(key) for key in QUANTITIES]
        return [
            self.chart,
            f"{self.line} ({self.group})",
            f"{self.size_mm:g}",
            str(self.dofs),
            f"{self.gflop:.3g}",
            f"{self.seconds:.2f}",
            *("failed" if error is None else f"{error:.1e}" for error in found),
        ]


@dataclass(frozen=True)
class Precision:
    """Points of all charts.

    differences: between the two references of each (chart, group), in the order of QUANTITIES.
    remarks: failures and lines that do not converge, by chart.
    """

    points: tuple[Point, ...]
    differences: dict[tuple[str, str], Errors]
    remarks: dict[str, list[str]]
    references: dict[str, Run]
    charts: tuple[Chart, ...]
