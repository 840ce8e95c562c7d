"""A grip from the preload to the lift, the slip or the end of the stage."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from fingerdesign.arrays import Array, BoolArray
from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.turning import MOST_TURN_DEG
from fingerdesign.control.calibration import Bounds
from fingerdesign.control.controllers.flow_chart import PaperController
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.foresight import judge_warnings
from fingerdesign.control.metrics import unsure_at_the_end
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
from fingerdesign.control.roster import Command, Controller, make_controller
from fingerdesign.control.signals import Calibration, Sample
from fingerdesign.design.grip import Grip
from fingerdesign.errors import SolverError
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.result import GripEnding, GripResult

# The arm raises a lifted object by so much a step, mm: else a tug at an object that barely hangs
# would only set it down.
_RAISE = 0.03


@dataclass(frozen=True)
class Episode:
    """One grip, its trace, and what its hand measured. slip_step: the first of the trace in which
    the whole contact has slipped, None where none is."""

    result: GripResult
    trace: GripTrace
    slip_step: int | None = None
    samples: tuple[Sample, ...] = ()

    @property
    def to_slip(self) -> GripTrace:
        """The trace up to the first complete slip, whatever came of it; whole where none is."""
        return self.trace if self.slip_step is None else self.trace.until(self.slip_step + 1)


@dataclass
class _Run:
    """A grip while it runs, step by step; preload moves first.

    lift: the step that lifted the object. preload_moves: how many steps the press took, 0 where it
    failed.
    """

    plant: Plant
    controller: Controller
    calibration: Calibration
    bounds: Bounds
    object_mass_g: float
    samples: list[Sample] = field(default_factory=list)
    truths: list[Truth] = field(default_factory=list)
    commands: list[Command] = field(default_factory=list)
    lift: int | None = None
    preload_moves: int = 0

    @property
    def approach(self) -> float:
        return self.truths[-1].approach if self.truths else 0.0

    @property
    def slip(self) -> int | None:
        """The first step in which the whole contact has slipped."""
        return next((k for k, truth in enumerate(self.truths) if truth.complete_slip), None)

    def press(self) -> None:
        """Close to the preload, and start the controller there."""
        for sample in press(self.plant, self.bounds.preload, self.bounds.approach_step):
            truth = self.plant.truth()
            self._add(sample, truth, Command(0.0, truth.approach - self.approach, False))
        self.preload_moves = len(self.samples)
        self.controller.start(self.calibration, self.calibration.corrected(self.samples[-1]))

    def grip(self, after_lift: int) -> tuple[GripEnding, str]:
        """Move as the controller commands until something ends the grip; how, and a sentence."""
        steps, most = 0, self.bounds.max_approach
        while self.lift is not None or steps < self.bounds.max_steps:
            steps += 1
            command = self.controller.command(self.calibration.corrected(self.samples[-1]))
            raising = 0.0
            if self.lift is not None:  # A hand at the end of its stage still holds the object.
                command = replace(command, dy=min(command.dy, most - self.approach))
                raising = _RAISE
            if self.approach + command.dy > most + 1e-9:
                return "stage travel", f"not lifted within an approach of {most:g} mm"
            sample = self.plant.move(command.dx + raising, command.dy)
            truth = self.plant.truth()
            self._add(sample, truth, command)
            if truth.complete_slip and not may_be_caught(truth):
                return "complete slip", self._why_slipped(truth)
            if self.lift is None and is_lifted(truth, self.object_mass_g):
                self.lift = len(self.truths) - 1
            if self.lift is not None and (ended := self._ended(truth, self.lift, after_lift)):
                return ended
        return "steps", f"not lifted in {self.bounds.max_steps} steps"

    def _ended(self, truth: Truth, lift: int, after_lift: int) -> tuple[GripEnding, str] | None:
        """The end of a grip whose object hangs since the step ``lift``; None while it goes on."""
        hanging = len(self.truths) - 1 - lift
        if hanging >= after_lift + self.bounds.max_steps:  # The slide does not end.
            return "complete slip", f"the object still slides at F_n = {truth.normal_force:.2f} N"
        if hanging < after_lift or truth.sliding:
            return None
        if self.slip is not None:
            return "caught", _why_caught(truth)
        why = "2 F_t is over the weight" if truth.lifted is None else "the object hangs"
        turned = f", turned by {abs(truth.rotation):.1f} degrees" if truth.rotation else ""
        return "lifted", f"{why} at F_n = {self.truths[lift].normal_force:.2f} N{turned}"

    def _why_slipped(self, truth: Truth) -> str:
        what = "the whole contact slips" if self.lift is None else "the object drops"
        if abs(truth.rotation) > MOST_TURN_DEG:
            what = f"the object turns by {abs(truth.rotation):.1f} degrees"
        if truth.caught is False:
            what = f"the object slides {truth.slid:.2f} mm and drops"
        return f"{what} at F_n = {truth.normal_force:.2f} N"

    def _add(self, sample: Sample, truth: Truth, command: Command) -> None:
        self.samples.append(sample)
        self.truths.append(truth)
        self.commands.append(command)


def _why_caught(truth: Truth) -> str:
    """A sentence: how much slid until when; measured slip of an object that stayed where it was."""
    if not truth.caught:
        return "the object hangs, but its whole contact has slipped"
    ms = 1e3 * (truth.catch_time or 0.0)
    return f"the object slid {truth.slid:.2f} mm and was caught, within {ms:.0f} ms at the longest"


def run_episode(
    plant: Plant,
    controller: Controller,
    calibration: Calibration,
    bounds: Bounds,
    friction_coefficient: float,
    object_mass_g: float,
    after_lift: int = 0,
    most_pull: float | None = None,
) -> Episode:
    """Press to the preload, then move as the controller commands until something ends the grip.

    after_lift: steps for which the lifted object is held on, while the arm raises it clear of its
    support; it can still slip then, and the result is lifted as well as gross_slip. An object
    with inertia that slides is held on until it is caught or dropped: both are gross_slip.
    Friction, mass and most_pull (N, see GripResult) are for the judge alone. A SolverError of the
    plant ends the grip as failed, with the plant's sentence as its reason; ZoneExhausted is raised
    on: a model with a wider zone of contact candidates is needed, the grip has not failed.
    """
    run = _Run(plant, controller, calibration, bounds, object_mass_g)
    try:
        run.press()
        outcome, reason = run.grip(after_lift)
    except ZoneExhausted:
        raise
    except SolverError as error:
        outcome, reason = "failed", str(error)
    trace = _trace(run, friction_coefficient)
    result = replace(_result(run, trace, outcome, reason), most_pull_N=most_pull)
    episode = Episode(result, trace, run.slip, tuple(run.samples))
    unsure = unsure_at_the_end(episode.to_slip, result.gross_slip, result.crushing_force_N)
    return replace(episode, result=replace(result, unsure=unsure))


def _result(run: _Run, trace: GripTrace, outcome: GripEnding, reason: str) -> GripResult:
    truths = run.truths
    gripping = truths[run.preload_moves :] if run.preload_moves else []
    last = truths[-1] if truths else Truth()
    lift, friction = run.lift, trace.friction_coefficient
    return GripResult(
        controller=trace.controller,
        friction_coefficient=friction,
        object_mass_g=run.object_mass_g,
        lifted=lift is not None,
        gross_slip=outcome in ("complete slip", "caught"),
        final_normal_force_N=last.normal_force,
        final_tangential_force_N=last.tangential_force,
        safety_margin=None if lift is None else safety_margin(truths[lift], friction),
        minimum_stick_ratio=minimum_stick_ratio(gripping),
        peak_normal_force_N=max((truth.normal_force for truth in truths), default=0.0),
        slip_distance_mm=last.slip_distance,
        steps=len(gripping),
        holds=len(trace.hold_starts),
        ending=reason,
        slid_mm=last.slid,
        caught=last.caught,
        catch_s=last.catch_time,
        swing_Hz=last.frequency,
        rotation_deg=last.rotation,
        outcome=outcome,
        steps_to_lift=len(gripping) if lift is None else lift - run.preload_moves + 1,
        slip_ratio=last.slip_ratio if lift is None else truths[lift].slip_ratio,
    )


def _trace(run: _Run, friction_coefficient: float) -> GripTrace:
    truths, commands, gages = run.truths, run.commands, len(run.calibration.gage_x)
    supported = any(truth.lifted is not None for truth in truths)
    reports = any(command.stick_ratio is not None for command in commands)

    def numbers(of: Sequence[Truth | Command], name: str) -> Array:
        return np.array([getattr(each, name) for each in of], dtype=float)  # None: NaN

    def flags(name: str, of_press: bool) -> BoolArray | None:
        """None of a controller that never reports them."""
        found = [getattr(each, name) for each in commands]
        if all(each is None for each in found):
            return None
        return np.array([of_press if each is None else each for each in found])

    names = "approach", "shear", "normal_force", "tangential_force", "stick_ratio"
    moved: dict[str, Any] = {name: numbers(truths, name) for name in names}
    return GripTrace(
        controller=run.controller.name,
        friction_coefficient=friction_coefficient,
        object_mass_g=run.object_mass_g,
        **moved,
        gage_area_mm=numbers(commands, "area"),
        dx=numbers(commands, "dx"),
        dy=numbers(commands, "dy"),
        hold=np.array([command.hold for command in commands], dtype=bool),
        gage_readings=np.array([s.readings for s in run.samples]).reshape(len(truths), gages),
        lift_step=run.lift,
        rise=numbers(truths, "rise") if supported else None,
        unsure=flags("unsure", True),
        reported_stick_ratio=numbers(commands, "stick_ratio") if reports else None,
        warns=flags("warns", False),
    )


def judged_warnings(episode: Episode, grip: Grip) -> GripResult:
    """The result with its warnings judged by the rate and the threshold of a ``[grip]`` table."""
    result = episode.result
    return judge_warnings(
        result,
        episode.to_slip,
        len(episode.trace.dx) - result.steps,
        grip.hardware.sample_rate_Hz,
        grip.warning_stick_ratio,
    )


def run_episodes(
    rig: Rig,
    friction_coefficients: Iterable[float],
    object_mass_g: float,
    estimator: GripEstimator | None = None,
    without_rule: bool = True,
) -> list[Episode]:
    """One grip per friction coefficient by the rig's ``[grip]`` table, one calibration for all.

    The table sets plant, hardware and controller; the oracles are given the friction and the mass.
    A grip by the paper's rule is run a second time with the rule off, where ``without_rule`` asks
    for it: ``slips_without_rule`` and ``trace.without_rule``. estimator: the regulator's, which is
    given the noise of the table's hardware. A problem of another law than Coulomb's keeps its law:
    the coefficient is then for oracle and judge alone (contact/gross_slip.py). Raises SolverError
    where the calibration itself fails.
    """
    grip = rig.grip
    bounds = Bounds.of(grip)
    calibration = rig.calibration()
    if estimator is not None and grip.hardware.gage_noise_microstrain > 0.0:
        estimator = estimator.at_noise(grip.hardware.gage_noise_microstrain)

    law = rig.problem.law.name
    most = grip.most_pull(object_mass_g)

    def run(plant: Plant, friction: float, hand: Controller) -> Episode:
        after = grip.hold_steps
        given = calibration, bounds, friction, object_mass_g, after, most
        episode = run_episode(plant, hand, *given)
        judged = judged_warnings(episode, grip)
        return replace(episode, result=replace(judged, friction_law=law))

    episodes = []
    for number, friction in enumerate(friction_coefficients):
        plant = rig.plant(friction, object_mass_g, number)
        # An oracle knows at which ratio of forces the object slips, also where it turns.
        known = plant.truth().slip_ratio or friction
        hand = make_controller(
            grip.controller, grip, estimator=estimator, friction=known, mass_g=object_mass_g
        )
        episode = run(plant, friction, hand)
        if without_rule and grip.controller == "paper":
            again = rig.plant(friction, object_mass_g, number)
            free = run(again, friction, PaperController(grip, rule=False))
            # A comparison that failed shows nothing either way.
            slips = None if free.result.outcome == "failed" else free.result.gross_slip
            episode = replace(
                episode,
                result=replace(episode.result, slips_without_rule=slips),
                trace=replace(episode.trace, without_rule=free.trace),
            )
        episodes.append(episode)
    return episodes
