"""Curves of a finger measured on its bench: traces of a few phases (bench_table.py reads them).

    phases.csv: trace, phase, friction_coefficient [, tilt_deg, samples]

A trace (trace.py) begins at first touch, gages and forces zeroed. Rows without a move
repeat the point before them: the point is their mean, less those that a delay makes stale; rows
before any move are the zero that is taken off. ``samples``: whose mean a row is already.

    press  closing alone, as far as the stage goes     readings against F_n
    shear  closed to a depth, then sheared a little    response to F_t where all sticks; dF_t/dx
    slide  closed, then sheared until all slips        response to F_t up to the limit of friction;
                                                       cross-talk, where there is one to either side
    tilt   a press against the surface leant by tilt_deg
    quick  one quick press, every sample a row         the delay

The surface is one plane of known friction coefficient in all phases.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from operator import itemgetter
from typing import Literal, Self, get_args

import numpy as np
from numpy.typing import NDArray

from fingerdesign.arrays import Array
from fingerdesign.control.calibration import Shear, delay_of, rising
from fingerdesign.control.plants.plant import Plant
from fingerdesign.control.signals import Calibration, NormalCalibration
from fingerdesign.control.trace import Trace
from fingerdesign.errors import SolverError

Kind = Literal["press", "shear", "slide", "tilt", "quick"]
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True)
class Points:
    """Points at which a phase was at rest, k of them: approach and shear (k,) mm since touch,
    forces (k,) N, readings (k, g) microstrain, samples (k,): of how many each is the mean."""

    approach: Array
    shear: Array
    normal_force: Array
    tangential_force: Array
    readings: Array
    samples: Array

    @property
    def moves(self) -> list[tuple[float, float]]:
        """The moves (dx, dy) mm from touch on, one to each point."""
        ways = np.diff(np.array([self.shear, self.approach]), axis=1, prepend=0.0).T
        return [(float(dx), float(dy)) for dx, dy in ways]


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

    def played(self, plant: Plant) -> Self:
        """The same moves on another plant, point by point."""
        samples = [plant.move(*each) for each in self.points.moves]
        again = replace(
            self.points,
            normal_force=np.array([each.normal_force for each in samples]),
            tangential_force=np.array([each.tangential_force for each in samples]),
            readings=np.array([each.readings for each in samples]),
            samples=np.full(len(samples), np.inf),
        )
        return replace(self, points=again, trace=None)


@dataclass(frozen=True)
class Slide:
    """A slide at one depth. shear (k,) mm; tangential_force (k,) N; responses (k, g): change of
    readings since no shear at the same F_n, over F_t at the end, microstrain/N: so the friction
    hardly matters."""

    shear: Array
    tangential_force: Array
    responses: Array

    def at(self, shear: Array) -> Array:
        """Responses (m, g) at shears (m,) mm of this slide's side, linear between its points."""
        rising = np.abs(self.shear)
        return np.column_stack([np.interp(np.abs(shear), rising, r) for r in self.responses.T])


@dataclass(frozen=True)
class BenchCurves:
    """Curves of a finger by its phases. calibration: as a controller takes it; tilted: presses by
    their tilt, degrees; slides: toward +x, then toward -x; slid: F_t / F_n at the end toward +x,
    None without such a slide."""

    calibration: Calibration
    tilted: tuple[tuple[float, NormalCalibration], ...] = ()
    slides: tuple[Slide, ...] = ()
    slid: float | None = None


def points_of(trace: Trace, samples: float = 1.0, delay: int = 0) -> Points:
    """Points at which a trace was at rest; ``samples``: of how many each row is the mean."""
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
    sheared = [_sheared(each, normal) for each in _of_kind(phases, "shear")]
    sticking, stiffness = rising(sorted(sheared, key=itemgetter(0)))
    found = Calibration(
        gage_x=np.asarray(gage_x, dtype=float),
        normal=normal,
        full_stick=np.abs(sticking.readings[0]),
        tangential_stiffness=float(stiffness[0]),
        sticking=sticking,
        stiffness=stiffness,
        approach=approach,
        delay=_delay(phases, normal, approach),
        cross_talk=cross_talk,
    )
    tilted = tuple((p.tilt_deg, pressed(p.points)[0]) for p in _of_kind(phases, "tilt"))
    slides = [_slid(each, normal, cross_talk) for each in _of_kind(phases, "slide")]
    slides.sort(key=lambda each: -float(each[0].shear[-1]))  # The one toward +x comes first.
    ratio = next((ratio for each, ratio in slides if each.shear[-1] > 0.0), None)
    return BenchCurves(found, tilted, tuple(each for each, _ in slides), ratio)


def _slid(phase: Phase, normal: NormalCalibration, cross_talk: float) -> tuple[Slide, float]:
    """The curve of a slide, and F_t / F_n at its end."""
    at = phase.points
    moved = at.shear != 0.0
    forces = at.normal_force[moved]
    pulls = at.tangential_force[moved] - cross_talk * forces
    alone = np.array([normal.at(float(force)) for force in forces])
    responses = (at.readings[moved] - alone) / pulls[-1]
    return Slide(at.shear[moved], pulls, responses), float(pulls[-1] / forces[-1])


def _delay(phases: Sequence[Phase], normal: NormalCalibration, approach: Array) -> int:
    """Samples of the last quick press until it is measured; 0 without one. Raises SolverError."""
    delay = 0
    for quick in _of_kind(phases, "quick"):
        if quick.trace is not None:
            depth = float(quick.trace.dy.sum())
            first = int(np.argmax(quick.trace.dy > 0.0))
            pressing = float(np.interp(depth, approach, normal.normal_force))
            try:
                delay = delay_of(quick.trace.normal_force[first:], pressing)
            except SolverError as error:
                due = f"75 % of the {pressing:.3g} N that the press has at its depth"
                raise SolverError(f"{quick.name}, the quick press, never reaches {due}") from error
    return delay


def _cross_talk(phases: Sequence[Phase]) -> float:
    """Cross-talk of F_n in F_t: half the sum of F_t / F_n as it slides to either
    side; 0 where it was not slid to both."""
    slides = [each.points for each in _of_kind(phases, "slide")]
    ends = [(at.shear[-1], at.tangential_force[-1] / at.normal_force[-1]) for at in slides]
    ratios = {way > 0.0: float(ratio) for way, ratio in ends}
    return 0.5 * sum(ratios.values()) if len(ratios) == 2 else 0.0


def _of_kind(phases: Sequence[Phase], kind: Kind) -> list[Phase]:
    return [each for each in phases if each.kind == kind]


def _sheared(phase: Phase, normal: NormalCalibration) -> Shear:
    at = phase.points
    last = int(np.flatnonzero(at.shear == 0.0)[-1])
    rise = float(at.tangential_force[-1] - at.tangential_force[last])
    alone = normal.at(float(at.normal_force[-1])) - normal.at(float(at.normal_force[last]))
    change = at.readings[-1] - at.readings[last] - alone
    return float(at.normal_force[last]), change / rise, rise / float(at.shear[-1])
