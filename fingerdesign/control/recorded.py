"""A recorded grip in the place of a plant: the same controllers and estimators beside a real rig.

    plant = RecordedPlant("grip.csv", gages=15)
    for step in replay(plant, controller, calibration, preload=0.03):
        print(step.asked.dx, "asked;", step.dx, "done")

A record cannot answer to what is asked of it: each move returns its next sample, whatever the
controller would have done.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from fingerdesign.control.calibration import Calibration
from fingerdesign.control.controller import Command, Controller
from fingerdesign.control.plant import Truth
from fingerdesign.control.signals import Sample
from fingerdesign.control.trace import Trace, read_trace
from fingerdesign.errors import DesignError, Fault, SolverError


class TraceEnded(SolverError):
    """More samples were asked for than the trace has."""


class RecordedPlant:
    """Plays a trace back, sample by sample; see trace.py for the file.

    source: a CSV file or a Trace. gages: how many the finger has, where that is known. Raises
    DesignError, with row and column, for a file that is faulty.
    """

    def __init__(self, source: Path | str | Trace, gages: int | None = None) -> None:
        self.trace = source if isinstance(source, Trace) else read_trace(source, gages)
        self._next = 0
        self._truth = Truth(0.0, 0.0, 0.0, 0.0, None, 0.0, False)

    def move(self, dx: float, dy: float) -> Sample:
        """The next sample; what is asked for is not done. Raises TraceEnded after the last."""
        trace, k = self.trace, self._next
        if k >= len(trace):
            raise TraceEnded(
                f"the trace has {len(trace)} samples and ends in row {trace.rows[-1]}; "
                "record a longer one"
            )
        self._next += 1
        normal, tangential = float(trace.normal_force[k]), float(trace.tangential_force[k])
        lifted = None if trace.lifted is None else bool(trace.lifted[k])
        self._truth = Truth(
            approach=self._truth.approach + float(trace.dy[k]),
            shear=self._truth.shear + float(trace.dx[k]),
            normal_force=normal,
            tangential_force=tangential,
            stick_ratio=None,
            slip_distance=0.0,
            complete_slip=False,
            lifted=lifted,
        )
        return Sample(trace.readings[k].copy(), normal, tangential, bool(lifted))

    def truth(self) -> Truth:
        """Where the stage is and what was felt; nobody knows what stuck or slipped."""
        return self._truth

    def __len__(self) -> int:
        """Samples left."""
        return len(self.trace) - self._next


@dataclass(frozen=True)
class Replayed:
    """One sample of a trace: its row, what the rig did before it, what is asked for after it."""

    row: int
    time: float
    dx: float
    dy: float
    sample: Sample
    asked: Command


def replay(
    plant: RecordedPlant, controller: Controller, calibration: Calibration, preload: float
) -> Iterator[Replayed]:
    """What a controller asks for at each sample from the preload (mm of closing) on.

    It judges the controller's senses, not its grip: the rig went its own way. Raises DesignError
    where the trace never closes so far, or has not the calibration's gages.
    """
    trace = plant.trace
    gages = trace.readings.shape[1]
    if gages != len(calibration.gage_x):
        bound = f"{len(calibration.gage_x)}, as the controller is calibrated for"
        raise DesignError([Fault("row 1, column gage_1", f"{gages} gages", bound, "match them")])
    started = False
    while len(plant):
        k = len(trace) - len(plant)
        sample = plant.move(0.0, 0.0)
        if not started and plant.truth().approach >= preload * (1.0 - 1e-6):
            started = True
            controller.start(calibration, sample)
            continue
        if started:
            asked = controller.command(sample)
            row, time = int(trace.rows[k]), float(trace.time[k])
            yield Replayed(row, time, float(trace.dx[k]), float(trace.dy[k]), sample, asked)
    if not started:
        bound = f"rows that close by {preload:g} mm in all, the preload"
        closed = f"{plant.truth().approach:.4g}"
        fault = Fault(f"row {trace.rows[-1]}, column dy_mm", closed, bound, "record from touch on")
        raise DesignError([fault])
