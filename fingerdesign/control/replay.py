"""What a controller and an estimator make of a recorded grip (numpy only).

    for step in replay(RecordedPlant("grip.csv", gages=15), calibration, 0.03, controller):
        print(step.row, step.asked.dx, "asked;", step.dx, "done")

This judges their senses, not a grip: the rig went its own way, and a controller believes all along
that it is obeyed.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from fingerdesign.control.calibration import Calibration
from fingerdesign.control.estimator import LAGS, Estimated, GripEstimator, Moment
from fingerdesign.control.plants.recorded import RecordedPlant
from fingerdesign.control.roster import Command, Controller
from fingerdesign.control.signals import Sample
from fingerdesign.errors import DesignError, Fault


@dataclass(frozen=True)
class Replayed:
    """One sample of a trace: its row and time (s), and the move (mm) that the rig made before it.

    asked: what the controller asks for after it. told: what the estimator makes of all up to it,
    the rig's own moves among it; None without one.
    """

    row: int
    time: float
    dx: float
    dy: float
    sample: Sample
    requested: Command
    estimated: Estimated | None = None


def replay(
    plant: RecordedPlant,
    calibration: Calibration,
    preload: float,
    controller: Controller,
    estimator: GripEstimator | None = None,
) -> Iterator[Replayed]:
    """Every sample after the one at which the stage has closed by ``preload`` mm in all.

    Raises DesignError where the trace never closes so far, or where calibration or estimator are of
    a finger with other gages.
    """
    _refuse_other_gages(plant, len(calibration.gage_x), "the controller is calibrated")
    if estimator is not None:
        _refuse_other_gages(plant, estimator.gages, "the estimator was taught")
    trace = plant.trace
    history: list[Moment] = []
    started, first = False, None
    for k in range(len(trace)):
        sample = plant.move(0.0, 0.0)
        dx, dy = float(trace.dx[k]), float(trace.dy[k])
        history = [*history[-max(LAGS) :], Moment(sample, dx, dy)]
        if started:
            estimated = None if estimator is None else estimator.estimate(history)
            requested = controller.command(sample)
            row, time = int(trace.rows[k]), float(trace.time[k])
            yield Replayed(row, time, dx, dy, sample, requested, estimated)
        elif plant.truth().approach >= preload * (1.0 - 1e-6):
            started, first = True, sample
            controller.start(calibration, sample)
    if not started or history[-1].sample is first:
        bound = f"rows that close by {preload:g} mm in all, the preload, and samples after them"
        closed = f"{plant.truth().approach:.4g}"
        where = f"row {trace.rows[-1]}, column dy_mm"
        raise DesignError([Fault(where, closed, bound, "record from the first touch on")])


def _refuse_other_gages(plant: RecordedPlant, wanted: int, who: str) -> None:
    gages = plant.trace.readings.shape[1]
    if gages != wanted:
        bound = f"{wanted}, for which {who}"
        remedy = "take the design of this finger"
        raise DesignError([Fault("row 1, column gage_1", f"{gages} gages", bound, remedy)])
