"""Reading of a bench folder: its table first, then every trace that it names; all faults of a
stage at once.

    phases.csv: trace, phase, friction_coefficient [, tilt_deg, samples]
"""

import csv
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from fingerdesign.control.bench_curves import KINDS, Kind, Phase, bench_curves, points_of, pressed
from fingerdesign.control.calibration import LEAST_SHEARS
from fingerdesign.control.trace import Trace, csv_text_of, read_trace
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.records.base import csv_text

TABLE = "phases.csv"
COLUMNS = ("trace", "phase", "friction_coefficient", "tilt_deg", "samples")
_REQUIRED = COLUMNS[:3]
LEAST_POINTS = 8  # A curve of a press needs so many points.
_MOST_TILT, _MOST_FRICTION, _MOST_SAMPLES = 10.0, 5.0, 1e6
# A small shear sticks while F_t / F_n is at most this fraction of the friction coefficient.
_STUCK = 0.5
# At the end of a slide F_t / F_n lies within these multiples of the stated friction coefficient.
_SLID = (0.75, 1.3)


def read_bench(source: Path, gages: int) -> tuple[Phase, ...]:
    """The phases of a folder that holds ``phases.csv``, or of such a table anywhere.

    Raises DesignError with every fault: of the table, then of all traces by row and column.
    """
    table = source / TABLE if source.is_dir() else source
    rows = _table_of(table)
    errors: list[DesignError] = []
    traces: list[Trace] = []
    for row in rows:
        try:
            traces.append(read_trace(table.parent / row["trace"], gages))
        except DesignError as error:
            errors.append(DesignError(error.faults, error.source or row["trace"]))
    if errors:
        raise DesignError.together(errors)
    phases = tuple(map(_phase, rows, traces))
    errors = [
        DesignError(faults, str(table.parent / each.name))
        for each in phases
        if (faults := _phase_faults(each))
    ]
    if errors:
        raise DesignError.together(errors)
    try:
        delay = bench_curves(phases, np.arange(float(gages))).calibration.delay
    except SolverError as error:
        bound = "such that each shear gives a force, and the quick press is measured"
        raise DesignError([Fault("traces", str(table), bound, str(error))]) from error
    return tuple(
        replace(each, points=points_of(trace, each.samples, delay))
        for each, trace in zip(phases, traces, strict=True)
    )


def _phase(row: dict[str, str], trace: Trace) -> Phase:
    samples = float(row.get("samples") or 1.0)
    return Phase(
        row["trace"],
        next(kind for kind in KINDS if kind == row["phase"]),
        float(row["friction_coefficient"]),
        float(row.get("tilt_deg") or 0.0),
        points_of(trace, samples),
        samples,
        trace,
    )


def _table_of(path: Path) -> list[dict[str, str]]:
    bound = f"a folder with {TABLE}, or such a table"
    text = csv_text_of(path, "--measured", bound)
    try:
        lines = list(csv.reader(text.splitlines(), strict=True))
    except csv.Error as error:
        raise DesignError([Fault("--measured", str(path), bound, str(error))]) from None
    header, *body = [[cell.strip() for cell in line] for line in lines] or [[]]
    if faults := _header_faults(header):
        raise DesignError(faults, str(path))
    rows = []
    for number, cells in enumerate(body, 2):
        if any(cells):
            row = dict(zip(header, cells, strict=False))
            faults += _row_faults(number, row, len(cells) == len(header))
            rows.append(row)
    if faults := faults or list(_count_faults([row["phase"] for row in rows])):
        raise DesignError(faults, str(path))
    return rows


def _header_faults(header: Sequence[str]) -> list[Fault]:
    remedy = f"columns are {', '.join(COLUMNS)}"
    absent = [name for name in _REQUIRED if name not in header]
    found = [Fault(f"row 1, column {name}", "absent", "there", remedy) for name in absent]
    return found + [
        Fault("row 1", f"'{name}'", "a known column, once", remedy)
        for k, name in enumerate(header)
        if name not in COLUMNS or name in header[:k]
    ]


def _row_faults(number: int, row: dict[str, str], whole: bool) -> list[Fault]:
    if not whole:
        bound = "as many cells as the header has names"
        return [Fault(f"row {number}", f"{len(row)} cells or more", bound, "mend the row")]
    found = []

    def wrong(name: str, bound: str, remedy: str) -> None:
        value = row.get(name) or "empty"
        found.append(Fault(f"row {number}, column {name}", value, bound, remedy))

    if not _is_here(row["trace"]):
        wrong("trace", "a CSV file in the folder of this table", "name the recorded trace")
    if row["phase"] not in KINDS:
        wrong("phase", f"one of {', '.join(KINDS)}", "say what was done")
    bound = f"over 0 and at most {_MOST_FRICTION:g}"
    if not _within(row["friction_coefficient"], 1e-6, _MOST_FRICTION):
        wrong("friction_coefficient", bound, "measure the bench's surface against the rubber")
    leant = row.get("tilt_deg") or "0"
    if not _within(leant, -_MOST_TILT, _MOST_TILT):
        wrong("tilt_deg", f"{-_MOST_TILT:g} to {_MOST_TILT:g} degrees", "write degrees")
    elif (float(leant) != 0.0) != (row["phase"] == "tilt"):
        wrong("tilt_deg", "other than 0 for phase tilt, and 0 or empty else", "say how it leant")
    if not _within(row.get("samples") or "1", 1.0, _MOST_SAMPLES):
        bound = f"1 to {_MOST_SAMPLES:g}"
        wrong("samples", bound, "say of how many samples a row is the mean")
    return found


def _is_here(name: str) -> bool:
    """True for the name of a file in the table's folder or under it."""
    path = Path(name)
    return bool(name) and "\0" not in name and not path.is_absolute() and ".." not in path.parts


def _within(cell: str, least: float, most: float) -> bool:
    try:
        return least <= float(cell.replace("_", "?")) <= most
    except ValueError:
        return False


def _count_faults(kinds: Sequence[str]) -> Iterator[Fault]:
    counts = {kind: sum(each == kind for each in kinds) for kind in KINDS}
    required: tuple[tuple[Kind, bool, str], ...] = (
        ("press", counts["press"] == 1, "exactly one row"),
        ("shear", counts["shear"] >= LEAST_SHEARS, f"at least {LEAST_SHEARS} rows"),
        ("slide", counts["slide"] <= 2, "at most two rows, one to either side"),
        ("quick", counts["quick"] <= 1, "at most one row"),
    )
    for kind, right, bound in required:
        if not right:
            remedy = "docs/how_to/identify.md lists what to record"
            yield Fault(f"phase {kind}", f"{counts[kind]} rows", bound, remedy)


def _press_faults(phase: Phase) -> Iterator[Fault]:
    at = phase.points
    if (at.shear != 0.0).any():
        yield Fault("dx_mm", "moves along x", "0 in every row", "press without shear")
    rising = len(pressed(at)[0].normal_force) - 1
    if rising < LEAST_POINTS:
        bound = f"at least {LEAST_POINTS} points, each deeper and with more force than all before"
        remedy = "press on, in smaller steps, closing positive (dy_mm)"
        yield Fault("normal_force_N", f"{rising} points", bound, remedy)


def _shear_faults(phase: Phase) -> Iterator[Fault]:
    at = phase.points
    if not at.shear[-1] > 0.0:
        yield Fault("dx_mm", f"{at.shear[-1]:g} mm in all", "toward +x", "mind the sign")
        return
    ratio = float(at.tangential_force[-1] / at.normal_force[-1])
    most = _STUCK * phase.friction_coefficient
    if not 0.0 < ratio <= most:
        bound = f"such that F_t / F_n ends over 0 and at most at {most:.3g}, half of the friction"
        yield Fault("tangential_force_N", f"F_t / F_n = {ratio:.3g}", bound, "shear by less")


def _slide_faults(phase: Phase) -> Iterator[Fault]:
    at = phase.points
    ratio = float(np.sign(at.shear[-1]) * at.tangential_force[-1] / at.normal_force[-1])
    least, most = (share * phase.friction_coefficient for share in _SLID)
    if not least <= ratio <= most:
        bound = f"such that F_t / F_n ends at about the friction, {least:.3g} to {most:.3g}"
        remedy = "shear until F_t rises no more, or correct friction_coefficient"
        yield Fault("tangential_force_N", f"F_t / F_n = {ratio:.3g}", bound, remedy)


def _pull_faults(phase: Phase) -> Iterator[Fault]:
    at = phase.points
    closed, pulled = np.flatnonzero(at.shear == 0.0), np.flatnonzero(at.shear != 0.0)
    if not len(closed) or not len(pulled) or pulled[0] < closed[-1]:
        bound = "0 while it closes, then moves along x to the end"
        yield Fault("dx_mm", f"{len(pulled)} of {len(at.shear)} points", bound, "record both")
    elif at.shear[-1] == 0.0:
        yield Fault("dx_mm", "0 mm in all", "off to one side", "record the way there alone")
    elif not at.normal_force[-1] > 0.0:
        value = f"{at.normal_force[-1]:g} at the end"
        yield Fault("normal_force_N", value, "above 0", "close first")


def _quick_faults(phase: Phase) -> Iterator[Fault]:
    trace = phase.trace
    assert trace is not None
    moves = int((trace.dy != 0.0).sum())
    if moves != 1 or (trace.dx != 0.0).any() or not trace.dy.sum() > 0.0:
        yield Fault("dy_mm", f"{moves} moves", "one move that closes, then none", "press at once")


def _phase_faults(phase: Phase) -> list[Fault]:
    """Faults of a trace that is not what its phase says: of the first check that finds any."""
    checks: dict[Kind, Sequence[Callable[[Phase], Iterator[Fault]]]] = {
        "press": (_press_faults,),
        "shear": (_pull_faults, _shear_faults),
        "slide": (_pull_faults, _slide_faults),
        "tilt": (_press_faults,),
        "quick": (_quick_faults,),
    }
    return next(filter(None, (list(check(phase)) for check in checks[phase.kind])), [])


def table_text(phases: Sequence[Phase]) -> str:
    """``phases.csv`` of phases whose traces are in the same folder."""
    rows = [
        (p.name, p.kind, f"{p.friction_coefficient:g}", f"{p.tilt_deg:g}", f"{p.samples:g}")
        for p in phases
    ]
    return csv_text(COLUMNS, rows)
