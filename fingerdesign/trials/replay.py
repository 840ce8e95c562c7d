"""A recorded grip put before a design's controller: what it would have asked for, row by row.

The rig's own bench moves are not in the trace, so the controller is calibrated on the design's
model in plane strain, at rest, with its ``[grip.hardware]``.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.analysis.case import gage_array
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.plants.recorded import RecordedPlant, Replayed, replay
from fingerdesign.control.plants.rig import Rig
from fingerdesign.control.roster import holds, make_controller
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import csv_text
from fingerdesign.runtime.registry import CONTROLLERS


@dataclass(frozen=True)
class Replay:
    """What came of a trace. steps: the samples after the preload, in their order."""

    design: str
    digest: str
    trace: str
    controller: str
    samples: int
    steps: tuple[Replayed, ...]

    def record(self) -> dict[str, Any]:
        """What replay.json holds; lengths in mm."""
        estimated = [step.estimated for step in self.steps if step.estimated is not None]
        return {
            "design": self.design,
            "digest": self.digest,
            "trace": self.trace,
            "controller": self.controller,
            "samples": self.samples,
            "first_row": self.steps[0].row,
            "last_row": self.steps[-1].row,
            "closed_mm": sum(step.dy for step in self.steps),
            "asked_closing_mm": sum(step.requested.dy for step in self.steps),
            "sheared_mm": sum(step.dx for step in self.steps),
            "asked_shear_mm": sum(step.requested.dx for step in self.steps),
            "holds": holds([step.requested for step in self.steps]),
            "least_stick_ratio_told": min((each.stick_ratio for each in estimated), default=None),
            "most_friction_used_told": max((each.used for each in estimated), default=None),
        }

    def table(self) -> str:
        """The text of replay.csv: a row for each sample, empty cells where nothing is reported."""
        names = ["row", "time_s", "normal_force_N", "tangential_force_N", "dx_mm", "dy_mm"]
        names += ["asked_dx_mm", "asked_dy_mm", "hold", "gage_area_mm"]
        names += ["stick_ratio_told", "friction_used_told", "friction_told"]
        return csv_text(names, map(_cells, self.steps))


def replay_trace(
    design: Design,
    path: Path,
    name: str = "paper",
    estimator: GripEstimator | None = None,
    report: Callable[[str], None] = lambda message: None,
    fidelity: str = "plane-strain",
) -> Replay:
    """Put the trace of a file before a controller by its name.

    Raises DesignError for a faulty trace (row and column), for a trace or an estimator of another
    finger, and for a controller that must be given the object's friction and weight: a trace does
    not hold them.
    """
    from fingerdesign.sensing.model import grip_problem
    from fingerdesign.sensing.train.result import estimator_faults

    faults = [] if estimator is None else estimator_faults(design, estimator)
    if faults:
        raise DesignError(faults)
    plates = gage_array(design)
    plant = RecordedPlant(path, len(plates))  # a faulty one is refused before any work
    if CONTROLLERS.find(name, "--controller").knows is not None:
        remedy = "take one that feels its way"
        bound = "a controller that is given neither friction nor weight: a trace holds neither"
        raise DesignError([Fault("--controller", name, bound, remedy)])
    hand = make_controller(name, design.grip, estimator=estimator)
    problem = grip_problem(design, fidelity, report=report)
    report("calibrating")
    calibration = Rig(problem, design.gages.face, design.rig, plates).calibration()
    report("replaying")
    try:
        steps = tuple(replay(plant, calibration, design.grip.preload_mm, hand, estimator))
    except DesignError as error:
        raise DesignError(error.faults, error.source or str(path)) from None
    return Replay(
        design=design.design.name,
        digest=design.digest(),
        trace=path.name,
        controller=hand.name,
        samples=len(plant.trace),
        steps=steps,
    )


def _cells(step: Replayed) -> list[str]:
    sample, requested, estimated = step.sample, step.requested, step.estimated
    values = [step.time, sample.normal_force, sample.tangential_force, step.dx, step.dy]
    values += [requested.dx, requested.dy]
    cells = [str(step.row), *(f"{value:.9g}" for value in values), str(int(requested.hold))]
    cells.append("" if requested.area is None else f"{requested.area:.6g}")
    if estimated is None:
        return [*cells, "", "", ""]
    loaded = estimated.used > 0.0 and sample.normal_force > 0.0
    friction = sample.tangential_force / (estimated.used * sample.normal_force) if loaded else None
    last = "" if friction is None else f"{friction:.4g}"
    return [*cells, f"{estimated.stick_ratio:.4f}", f"{estimated.used:.4f}", last]
