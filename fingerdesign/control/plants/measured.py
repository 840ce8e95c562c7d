"""A finger measured on its bench: traces of a few phases, and one table that says what each was.

    phases.csv: trace, phase, friction_coefficient [, tilt_deg, samples]

A trace (:mod:`.recorded`) begins at first touch, gages and forces zeroed. Rows without a move
repeat the point before them: the point is their mean, less those that a delay makes stale; rows
before any move are the zero that is taken off. ``samples``: whose mean a row is already.

    press  closing alone, as far as the stage goes     readings against F_n
    shear  closed to a depth, then sheared a little    response to F_t where all sticks; dF_t/dx
    slide  closed, then sheared until all slips        response to F_t at the limit of friction;
                                                       cross-talk, where there is one to either side
    tilt   a press against the surface leant by tilt_deg
    quick  one quick press, every sample a row         the delay

The surface is one plane of known friction coefficient in all phases.
"""

from __future__ import annotations

import csv
import os
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.calibration import Calibration, delay_of
from fingerdesign.control.plants.plant import Plant
from fingerdesign.control.plants.recorded import RecordedPlant, Trace, read_trace
from fingerdesign.control.signals import NormalCalibration
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.runtime.files import whole_text

Kind = Literal["press", "shear", "slide", "tilt", "quick"]
KINDS: tuple[Kind, ...] = get_args(Kind)
TABLE = "phases.csv"
COLUMNS = ("trace", "phase", "friction_coefficient", "tilt_deg", "samples")
_OWED = COLUMNS[:3]
LEAST_POINTS = 8  # of a press: fewer make no curve
LEAST_SHEARS = 2
_MOST_TILT, _MOST_FRICTION, _MOST_SAMPLES = 10.0, 5.0, 1e6
_STUCK = 0.5  # of the friction coefficient, the most that F_t / F_n of a small shear may be
_SLID = (0.75, 1.3)  # times the friction coefficient said: F_t / F_n at the end of a slide


@dataclass(frozen=True)
class Points:
    """Where a phase stood still, k points: approach and shear (k,) mm since touch, forces (k,) N,
    readings (k, g) microstrain, samples (k,): of how many each is the mean."""

    approach: Array
    shear: Array
    normal_force: Array
    tangential_force: Array
    readings: Array
    samples: Array


@dataclass(frozen=True)
class Phase:
    """One row of the table and its trace's points; samples: whose mean a row of the trace is;
    trace: as recorded, None of one that a model played."""

    name: str
    kind: Kind
    friction_coefficient: float
    tilt_deg: float
    points: Points
    samples: float = 1.0
    trace: Trace | None = None

    def played(self, plant: Plant) -> Phase:
        """The same moves on another plant, point by point."""
        at = self.points
        moves = np.diff(np.array([at.shear, at.approach]), axis=1, prepend=0.0).T
        felt = [plant.move(float(dx), float(dy)) for dx, dy in moves]
        again = replace(
            at,
            normal_force=np.array([each.normal_force for each in felt]),
            tangential_force=np.array([each.tangential_force for each in felt]),
            readings=np.array([each.readings for each in felt]),
            samples=np.full(len(felt), np.inf),
        )
        return replace(self, points=again, trace=None)


@dataclass(frozen=True)
class BenchCurves:
    """What the phases say of a finger. calibration: as a controller takes it; tilted: presses by
    their tilt, degrees; sliding (g,) microstrain/N: F_t's response where all slips, None without a
    slide; slid: F_t / F_n there."""

    calibration: Calibration
    tilted: tuple[tuple[float, NormalCalibration], ...] = ()
    sliding: Array | None = None
    slid: float | None = None


def points_of(trace: Trace, samples: float = 1.0, delay: int = 0) -> Points:
    """Where a trace stood still; see the module. ``samples``: of how many each row is the mean."""
    moved = (trace.dx != 0.0) | (trace.dy != 0.0)
    values = np.column_stack([trace.normal_force, trace.tangential_force, trace.readings])
    at_rest = np.flatnonzero(np.cumsum(moved) == 0)
    zero = values[at_rest].mean(axis=0) if len(at_rest) else np.zeros(values.shape[1])
    found, counts = [], []
    starts = np.flatnonzero(moved)
    for start, end in zip(starts, np.append(starts, len(moved))[1:], strict=True):
        rows = np.arange(start, end)
        rows = rows[delay:] if len(rows) > delay else rows[-1:]
        found.append(values[rows].mean(axis=0) - zero)
        counts.append(samples * len(rows))
    table = np.array(found).reshape(len(found), values.shape[1])
    approach, shear = np.cumsum(trace.dy)[moved], np.cumsum(trace.dx)[moved]
    return Points(approach, shear, table[:, 0], table[:, 1], table[:, 2:], np.array(counts))


def pressed(points: Points) -> tuple[NormalCalibration, Array]:
    """Readings under F_n alone, from none on, and the approaches (c,) mm of their points.

    Points whose force noise has put below an earlier one's are left out, and so are those that lie
    no deeper than an earlier one.
    """
    rising = _highest(points.normal_force) & _highest(points.approach)
    force = np.concatenate([[0.0], points.normal_force[rising]])
    readings = np.concatenate([np.zeros((1, points.readings.shape[1])), points.readings[rising]])
    return NormalCalibration(force, readings), np.concatenate([[0.0], points.approach[rising]])


def _highest(values: Array) -> NDArray[np.bool_]:
    """Which values are above 0 and above all that come before them."""
    return np.asarray(values > np.maximum.accumulate(np.concatenate([[0.0], values[:-1]])))


def bench_curves(phases: Sequence[Phase], gage_x: Array) -> BenchCurves:
    """The curves of a bench's phases. Raises SolverError where the shears give none."""
    (press,) = _of_kind(phases, "press")
    cross_talk = _cross_talk(phases)
    normal, approach = pressed(press.points)
    sheared = [(f, r, k) for f, r, k in (_sheared(p, normal) for p in _of_kind(phases, "shear"))]
    kept: list[tuple[float, Array, float]] = []
    for each in sorted(sheared, key=lambda found: found[0]):
        if each[2] > 0.0 and (not kept or each[0] > kept[-1][0]):
            kept.append(each)
    if len(kept) < LEAST_SHEARS:
        raise SolverError("sheared on the bench, the finger gives no rising tangential force")
    sticking = NormalCalibration(
        np.array([f for f, _, _ in kept]), np.array([r for _, r, _ in kept])
    )
    stiffness = np.array([k for _, _, k in kept])
    delay = 0
    for quick in _of_kind(phases, "quick"):
        if quick.trace is not None:
            depth = float(quick.trace.dy.sum())
            felt = RecordedPlant(_from_the_press(quick.trace))
            pressing = float(np.interp(depth, approach, normal.normal_force))
            try:
                delay = delay_of(felt, depth, pressing)
            except SolverError as error:
                due = f"75 % of the {pressing:.3g} N that the press has at its depth"
                raise SolverError(f"{quick.name}, the quick press, never reaches {due}") from error
    first = np.abs(sticking.readings[0])
    x = np.asarray(gage_x, dtype=float)
    measured = normal, first, float(stiffness[0]), sticking, stiffness, approach, delay
    found = Calibration(x, *measured, cross_talk)
    tilted = tuple((p.tilt_deg, pressed(p.points)[0]) for p in _of_kind(phases, "tilt"))
    for slide in (each for each in _of_kind(phases, "slide") if each.points.shear[-1] > 0.0):
        at, force = slide.points, float(slide.points.normal_force[-1])
        pull = float(at.tangential_force[-1]) - cross_talk * force
        return BenchCurves(found, tilted, (at.readings[-1] - normal.at(force)) / pull, pull / force)
    return BenchCurves(found, tilted)


def _cross_talk(phases: Sequence[Phase]) -> float:
    """What is felt as F_t of each newton of F_n: half the sum of F_t / F_n as it slides to either
    side; 0 where it was not slid to both."""
    ends = [(at.shear[-1], at.tangential_force[-1] / at.normal_force[-1]) for at in _slides(phases)]
    ratios = {way > 0.0: float(ratio) for way, ratio in ends}
    return 0.5 * sum(ratios.values()) if len(ratios) == 2 else 0.0


def _slides(phases: Sequence[Phase]) -> list[Points]:
    return [each.points for each in _of_kind(phases, "slide")]


def _of_kind(phases: Sequence[Phase], kind: Kind) -> list[Phase]:
    return [each for each in phases if each.kind == kind]


def _sheared(phase: Phase, normal: NormalCalibration) -> tuple[float, Array, float]:
    """F_n before a small shear, the gages' response per N of F_t, dF_t/dx."""
    at = phase.points
    last = int(np.flatnonzero(at.shear == 0.0)[-1])
    rise = float(at.tangential_force[-1] - at.tangential_force[last])
    alone = normal.at(float(at.normal_force[-1])) - normal.at(float(at.normal_force[last]))
    change = at.readings[-1] - at.readings[last] - alone
    return float(at.normal_force[last]), change / rise, rise / float(at.shear[-1])


def _from_the_press(trace: Trace) -> Trace:
    first = int(np.argmax(trace.dy > 0.0))
    arrays = {key: None if v is None else v[first:] for key, v in vars(trace).items()}
    return Trace(**arrays)  # type: ignore[arg-type]


# Reading: the table first, then every trace that it names; all faults of a stage at once.


@dataclass(frozen=True)
class _Row:
    """A row of the table that is sound."""

    name: str
    kind: Kind
    friction_coefficient: float
    tilt_deg: float
    samples: float


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
            _refuse_endless(table.parent / row.name)
            traces.append(read_trace(table.parent / row.name, gages))
        except DesignError as error:
            errors.append(DesignError(error.faults, error.source or row.name))
    if errors:
        raise DesignError.together(errors)
    phases = tuple(map(_phase, rows, traces))
    errors = [
        DesignError(faults, str(table.parent / each.name))
        for each in phases
        if (faults := list(_CHECKS[each.kind](each)))
    ]
    if errors:
        raise DesignError.together(errors)
    try:
        delay = bench_curves(phases, np.arange(float(gages))).calibration.delay
    except SolverError as error:
        bound = "such that each shear gives a force, and the quick press is felt"
        raise DesignError([Fault("traces", str(table), bound, str(error))]) from error
    return tuple(_phase(row, trace, delay) for row, trace in zip(rows, traces, strict=True))


def _phase(row: _Row, trace: Trace, delay: int = 0) -> Phase:
    points = points_of(trace, row.samples, delay)
    own = (row.name, row.kind, row.friction_coefficient, row.tilt_deg)
    return Phase(*own, points, row.samples, trace)


def _refuse_endless(path: Path) -> None:
    if os.path.exists(path) and not (os.path.isfile(path) or os.path.isdir(path)):
        why = "a device or pipe may never end"
        raise DesignError([Fault("trace", str(path), "an ordinary file", why)])


def _table_of(path: Path) -> list[_Row]:
    _refuse_endless(path)
    try:
        lines = list(csv.reader(whole_text(path, "utf-8-sig").splitlines(), strict=True))
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        bound = f"a folder with {TABLE}, or such a table"
        why = error.strerror if isinstance(error, OSError) else "it is not CSV text in UTF-8"
        raise DesignError([Fault("--measured", str(path), bound, f"{why}")]) from None
    lines = [[cell.strip() for cell in line] for line in lines]
    header, *body = lines or [[]]
    faults = [
        Fault(f"row 1, column {name}", "absent", "there", f"columns are {', '.join(COLUMNS)}")
        for name in _OWED
        if name not in header
    ]
    faults += [
        Fault("row 1", f"'{name}'", "a known column, once", f"columns are {', '.join(COLUMNS)}")
        for k, name in enumerate(header)
        if name not in COLUMNS or name in header[:k]
    ]
    if faults:
        raise DesignError(faults, str(path))
    rows = []
    for number, cells in enumerate(body, 2):
        if any(cells):
            row = dict(zip(header, cells, strict=False))
            faults += _row_faults(number, row, len(cells) == len(header))
            rows.append(row)
    if faults := faults or list(_count_faults([row["phase"] for row in rows])):
        raise DesignError(faults, str(path))
    return [
        _Row(
            row["trace"],
            next(kind for kind in KINDS if kind == row["phase"]),
            float(row["friction_coefficient"]),
            float(row.get("tilt_deg") or 0.0),
            float(row.get("samples") or 1.0),
        )
        for row in rows
    ]


def _row_faults(number: int, row: dict[str, str], whole: bool) -> list[Fault]:
    if not whole:
        bound = "as many cells as the header has names"
        return [Fault(f"row {number}", f"{len(row)} cells or more", bound, "mend the row")]
    found = []

    def wrong(name: str, bound: str, remedy: str) -> None:
        value = row.get(name) or "empty"
        found.append(Fault(f"row {number}, column {name}", value, bound, remedy))

    if not row["trace"] or "\0" in row["trace"]:
        wrong("trace", "a CSV file beside this table", "name the recorded trace")
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


def _within(cell: str, least: float, most: float) -> bool:
    try:
        return least <= float(cell.replace("_", "?")) <= most
    except ValueError:
        return False


def _count_faults(kinds: Sequence[str]) -> Iterator[Fault]:
    counts = {kind: sum(each == kind for each in kinds) for kind in KINDS}
    asked: tuple[tuple[Kind, bool, str], ...] = (
        ("press", counts["press"] == 1, "exactly one row"),
        ("shear", counts["shear"] >= LEAST_SHEARS, f"at least {LEAST_SHEARS} rows"),
        ("slide", counts["slide"] <= 2, "at most two rows, one to either side"),
        ("quick", counts["quick"] <= 1, "at most one row"),
    )
    for kind, right, bound in asked:
        if not right:
            remedy = "docs/how_to/calibrate.md says what to record"
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
    if found := list(_pull_faults(phase)):
        yield from found
        return
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
    if found := list(_pull_faults(phase)):
        yield from found
        return
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


_CHECKS: dict[Kind, Callable[[Phase], Iterator[Fault]]] = {
    "press": _press_faults,
    "shear": _shear_faults,
    "slide": _slide_faults,
    "tilt": _press_faults,
    "quick": _quick_faults,
}


def table_text(phases: Sequence[Phase]) -> str:
    """``phases.csv`` of phases whose traces lie beside it."""
    rows = [
        (p.name, p.kind, f"{p.friction_coefficient:g}", f"{p.tilt_deg:g}", f"{p.samples:g}")
        for p in phases
    ]
    return "\n".join(",".join(row) for row in [COLUMNS, *rows]) + "\n"
