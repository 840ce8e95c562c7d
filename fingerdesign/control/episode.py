"""A grip from the preload to the lift, the slip or the end of the stage."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds, Calibration
from fingerdesign.control.controllers.flow_chart import PaperController
from fingerdesign.control.foresight import Foresight, foresight
from fingerdesign.control.plants.plant import (
    Plant,
    Truth,
    is_lifted,
    may_be_caught,
    minimum_stick_ratio,
    press,
    safety_margin,
)
from fingerdesign.control.plants.rig import Rig
from fingerdesign.control.roster import Command, Controller, holds, make_controller
from fingerdesign.control.signals import Sample
from fingerdesign.errors import SolverError
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.result import GripResult

if TYPE_CHECKING:
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.grip import Grip
    from fingerdesign.design.schema import Design

Ending = Literal["lifted", "caught", "complete slip", "stage travel", "steps", "failed"]


_RAISE = 0.03  # mm a step: a tug at an object that barely hangs would only set it down


@dataclass(frozen=True)
class Episode:
    """One grip. ``reason`` is a sentence: why it ended as it did. slip_step: the first of the trace
    in which the whole contact has slipped, None where none is."""

    result: GripResult
    trace: GripTrace
    ending: Ending
    reason: str
    slip_step: int | None = None

    @property
    def to_slip(self) -> GripTrace:
        """The trace up to the first complete slip, whatever came of it; whole where none is."""
        return self.trace if self.slip_step is None else self.trace.until(self.slip_step + 1)


@dataclass
class _Record:
    """What happened, move by move; preload moves first. lift: the step that lifted the object."""

    samples: list[Sample] = field(default_factory=list)
    truths: list[Truth] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    lift: int | None = None

    def add(self, sample: Sample, truth: Truth, command: Command) -> None:
        self.samples.append(sample)
        self.truths.append(truth)
        self.commands.append(command)

    @property
    def approach(self) -> float:
        return self.truths[-1].approach if self.truths else 0.0

    @property
    def slip(self) -> int | None:
        """The first step in which the whole contact has slipped."""
        return next((k for k, truth in enumerate(self.truths) if truth.complete_slip), None)


def run_episode(
    plant: Plant,
    controller: Controller,
    calibration: Calibration,
    bounds: Bounds,
    friction_coefficient: float,
    object_mass_g: float,
    after_lift: int = 0,
) -> Episode:
    """Press to the preload, then move as the controller says until something ends the grip.

    after_lift: steps for which the lifted object is held on, while the arm raises it clear of its
    support; it can still slip then, and the result says lifted as well as gross_slip. An object
    with inertia that slides is held on until it is caught or dropped: both are gross_slip. Friction
    and mass are for the judge alone. A SolverError of the plant ends the grip as failed, with the
    plant's sentence as its reason; ZoneExhausted is raised on: a model with a wider zone of contact
    candidates is needed, the grip has not failed.
    """
    record = _Record()
    preload_moves = 0
    try:
        for sample in press(plant, bounds.preload, bounds.approach_step):
            truth = plant.truth()
            closed = truth.approach - record.approach
            record.add(sample, truth, Command(0.0, closed, False))
        preload_moves = len(record.samples)
        controller.start(calibration, calibration.felt(sample))
        felt = plant, controller, calibration, record, sample
        ending, reason = _grip(*felt, bounds, object_mass_g, after_lift)
    except ZoneExhausted:
        raise
    except SolverError as error:
        ending, reason = "failed", str(error)
    gripping = record.truths[preload_moves:] if preload_moves else []
    last = record.truths[-1] if record.truths else None
    lifted = record.lift is not None
    at_lift = record.truths[record.lift] if record.lift is not None else None
    result = GripResult(
        controller=controller.name,
        friction_coefficient=friction_coefficient,
        object_mass_g=object_mass_g,
        lifted=lifted,
        gross_slip=ending in ("complete slip", "caught"),
        final_normal_force_N=last.normal_force if last else 0.0,
        final_tangential_force_N=last.tangential_force if last else 0.0,
        safety_margin=safety_margin(at_lift, friction_coefficient) if at_lift else None,
        minimum_stick_ratio=minimum_stick_ratio(gripping),
        peak_normal_force_N=max((truth.normal_force for truth in record.truths), default=0.0),
        slip_distance_mm=last.slip_distance if last else 0.0,
        steps=len(gripping),
        holds=holds(record.commands),
        ending=reason,
        slid_mm=last.slid if last else 0.0,
        caught=last.caught if last else None,
        catch_s=last.catch_time if last else None,
        swing_Hz=last.frequency if last else None,
    )
    trace = _trace(record, result, len(calibration.gage_x))
    return Episode(result, trace, ending, reason, record.slip)


def _grip(
    plant: Plant,
    controller: Controller,
    calibration: Calibration,
    record: _Record,
    sample: Sample,
    bounds: Bounds,
    object_mass_g: float,
    after_lift: int,
) -> tuple[Ending, str]:
    held = steps = 0
    while record.lift is not None or steps < bounds.max_steps:
        steps += 1
        command = controller.command(calibration.felt(sample))
        left = bounds.max_approach - record.approach
        raising = 0.0
        if record.lift is not None:  # a hand at the end of its stage goes on holding
            command = replace(command, dy=min(command.dy, left))
            raising = _RAISE
        if record.approach + command.dy > bounds.max_approach + 1e-9:
            return "stage travel", f"not lifted within an approach of {bounds.max_approach:g} mm"
        sample = plant.move(command.dx + raising, command.dy)
        truth = plant.truth()
        record.add(sample, truth, command)
        if truth.complete_slip and not may_be_caught(truth):
            what = "the whole contact slips" if record.lift is None else "the object drops"
            if truth.caught is False:
                what = f"the object slides {truth.slid:.2f} mm and drops"
            return "complete slip", f"{what} at F_n = {truth.normal_force:.2f} N"
        if record.lift is None and is_lifted(truth, object_mass_g):
            record.lift = len(record.truths) - 1
        if record.lift is not None:
            if held >= after_lift + bounds.max_steps:  # as good as ever
                return (
                    "complete slip",
                    f"the object still slides at F_n = {truth.normal_force:.2f} N",
                )
            if held >= after_lift and not truth.sliding:
                force = record.truths[record.lift].normal_force
                if record.slip is not None:
                    return "caught", _caught(truth)
                why = "2 F_t is over the weight" if truth.lifted is None else "the object hangs"
                return "lifted", f"{why} at F_n = {force:.2f} N"
            held += 1
    return "steps", f"not lifted in {bounds.max_steps} steps"


def _caught(truth: Truth) -> str:
    """A sentence: how much slid until when; measured slip of an object that stayed where it was."""
    if not truth.caught:
        return "the object hangs, but its whole contact has slipped"
    ms = 1e3 * (truth.catch_time or 0.0)
    return f"the object slid {truth.slid:.2f} mm and was caught, within {ms:.0f} ms at the longest"


def _trace(record: _Record, result: GripResult, gages: int) -> GripTrace:
    truths, commands = record.truths, record.commands
    supported = any(truth.lifted is not None for truth in truths)
    reports = any(command.stick_ratio is not None for command in commands)
    warns = any(command.warns is not None for command in commands)

    def numbers(of: Sequence[Truth | Command], name: str) -> Array:
        values = [getattr(each, name) for each in of]
        return np.array([np.nan if value is None else value for value in values], dtype=float)

    names = "approach", "shear", "normal_force", "tangential_force", "stick_ratio"
    moved: dict[str, Any] = {name: numbers(truths, name) for name in names}
    return GripTrace(
        controller=result.controller,
        friction_coefficient=result.friction_coefficient,
        object_mass_g=result.object_mass_g,
        **moved,
        gage_area_mm=numbers(commands, "area"),
        dx=numbers(commands, "dx"),
        dy=numbers(commands, "dy"),
        hold=np.array([command.hold for command in commands], dtype=bool),
        gage_readings=np.array([s.readings for s in record.samples]).reshape(len(truths), gages),
        lift_step=record.lift,
        rise=numbers(truths, "rise") if supported else None,
        unsure=_unsure(commands),
        reported_stick_ratio=numbers(commands, "stick_ratio") if reports else None,
        warns=np.array([bool(command.warns) for command in commands]) if warns else None,
    )


def _unsure(commands: Sequence[Command]) -> BoolArray | None:
    """By step; None of a controller that cannot tell. Of the press nothing is known."""
    if all(each.unsure is None for each in commands):
        return None
    return np.array([each.unsure is not False for each in commands])


def foreseen(episode: Episode, grip: Grip) -> Foresight:
    """What the controller said of slip, by the rate and the threshold of a ``[grip]`` table."""
    result = episode.result
    return foresight(
        episode.to_slip,
        len(episode.trace.dx) - result.steps,
        result.gross_slip,
        grip.hardware.sample_rate_Hz,
        grip.warning_stick_ratio,
    )


def run_episodes(
    problem: ContactProblem,
    design: Design,
    friction_coefficients: Iterable[float],
    object_mass_g: float,
    plates: Sequence[int] | None = None,
    opposite: ContactProblem | None = None,
    estimator: GripEstimator | None = None,
) -> list[Episode]:
    """One grip per friction coefficient by the design's ``[grip]`` table, one calibration for all.

    The table says plant, hardware and controller; the oracles are given the friction and the mass.
    A grip by the paper's rule is run a second time with the rule off: ``slips_without_rule`` and
    ``trace.without_rule``. plates: numbers of those whose gages the problem's model has, None for
    all; opposite: the other finger of a lift, None for a mirror image; estimator: the regulator's,
    which is given the noise of the table's hardware. Raises SolverError where the calibration
    itself fails.
    """
    grip = design.rig
    rig = Rig(problem, design.gages.face, grip, plates, opposite)
    bounds = Bounds.of(grip)
    calibration = rig.calibration()
    if estimator is not None and grip.hardware.gage_noise_microstrain > 0.0:
        estimator = estimator.at_noise(grip.hardware.gage_noise_microstrain)

    def run(number: int, friction: float, hand: Controller) -> Episode:
        plant = rig.plant(friction, object_mass_g, number)
        after = grip.hold_steps
        episode = run_episode(plant, hand, calibration, bounds, friction, object_mass_g, after)
        seen = vars(foreseen(episode, grip))
        own = {field.name for field in fields(GripResult)}
        told = {name: value for name, value in seen.items() if name in own}
        return replace(episode, result=replace(episode.result, **told))

    episodes = []
    for number, friction in enumerate(friction_coefficients):
        hand = make_controller(
            grip.controller, grip, estimator=estimator, friction=friction, mass_g=object_mass_g
        )
        episode = run(number, friction, hand)
        if grip.controller == "paper":
            free = run(number, friction, PaperController(grip, rule=False))
            # A comparison that failed shows nothing either way.
            slips = None if free.ending == "failed" else free.result.gross_slip
            episode = replace(
                episode,
                result=replace(episode.result, slips_without_rule=slips),
                trace=replace(episode.trace, without_rule=free.trace),
            )
        episodes.append(episode)
    return episodes
