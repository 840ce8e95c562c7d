"""One design's rig, in a form that is sent to a process: model, hardware, settings, estimator.

A cell of the grid becomes an episode here: two like fingers, an object on a support, imperfect
hardware, and a controller that knows of them what a hand would know.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np

from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Calibration, calibrate
from fingerdesign.control.episode import Bounds, Episode, run_episode
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.metrics import JudgedGrip, outcome
from fingerdesign.control.plants.lift import Disturbance, LiftPlant
from fingerdesign.control.plants.plant import CondensedPlant, Memory, Plant, RememberedPlant
from fingerdesign.control.plants.rig import Hardware, ImperfectPlant
from fingerdesign.control.roster import Controller, make_controller
from fingerdesign.design.grip import Grip
from fingerdesign.errors import SolverError
from fingerdesign.trials.grid import Cell, ControlGrid, seed_of, steps_in

_ANSWER = 0.5  # of an approach step: closing by more against a tug is an answer


@dataclass(frozen=True)
class GripBench:
    """What all grips of a study share.

    problem: at the bench's friction. plates: numbers of those whose gages are read, in the order of
    the readings. hardware: but for the gages' noise, which a cell says. opposite: the other finger
    at any friction, None for a mirror image.
    """

    problem: ContactProblem
    face: str
    plates: tuple[int, ...]
    grip: Grip
    hardware: Hardware
    grid: ControlGrid
    estimator: GripEstimator | None = None
    opposite: ContactProblem | None = None

    @cached_property
    def bounds(self) -> Bounds:
        """The stage and the patience of the design's ``[grip]`` table."""
        grip = self.grip
        return Bounds(grip.preload_mm, grip.approach_step_mm, grip.max_approach_mm, grip.max_steps)

    @cached_property
    def _calibrations(self) -> dict[float, Calibration]:
        return {}

    def calibration(self, noise: float) -> Calibration:
        """The bench moves with the same rig at rest, which takes the mean of many samples."""
        if noise not in self._calibrations:
            rng = np.random.default_rng([self.grid.seed, round(1e6 * noise)])
            hardware = self._noisy(noise).at_rest()
            self._calibrations[noise] = calibrate(
                lambda: self._imperfect(CondensedPlant(self.problem, self.face), hardware, rng),
                self.problem.model.gage_x,
                self.bounds.preload,
                self.bounds.approach_step,
                self.bounds.max_approach,
            )
        return self._calibrations[noise]

    def with_grip(self, grip: Grip) -> GripBench:
        """The same bench for other settings of the controllers.

        What it has learnt on the bench is kept where the stage moves there as before.
        """
        other = replace(self, grip=grip)
        if other.bounds == self.bounds:
            vars(other)["_calibrations"] = self._calibrations
        return other

    def controller(self, cell: Cell) -> Controller:
        """A fresh one; the estimator is given its rig's noise, the oracles friction and mass."""
        estimator = self.estimator
        return make_controller(
            cell.controller,
            self.grip,
            estimator=None if estimator is None else estimator.at_noise(cell.noise),
            friction=cell.friction,
            mass_g=cell.mass_g,
        )

    def run_batch(self, cells: Iterable[Cell]) -> list[JudgedGrip]:
        """Cells of one object; a grip whose model fails is a failed grip, with the reason."""
        memory = Memory()
        return [self.run_cell(cell, memory) for cell in cells]

    def run_cell(self, cell: Cell, memory: Memory) -> JudgedGrip:
        """One grip's outcome; ``memory`` is shared by cells of one object alone."""
        seed = seed_of(cell, self.grid.seed)
        try:
            episode = self.episode(cell, memory)
        except SolverError as error:
            return _failed(cell, seed, str(error))
        return outcome(
            episode,
            cell.noise,
            seed,
            cell.tug,
            self._held + 1 if cell.tug > 0.0 else None,
            _ANSWER * self.bounds.approach_step,
        )

    def episode(self, cell: Cell, memory: Memory | None = None) -> Episode:
        """One grip, step by step. Raises SolverError where the bench itself fails."""
        rate, tug = self.hardware.sample_rate_Hz, self.grid.tug
        after, pulls = self._held, tuple[Disturbance, ...]()
        if tug is not None:  # it comes when grips without it are over: one plant serves both
            pulls = tug.pulls(cell.mass_g, self._held + 1, rate)
            after += tug.steps(rate) if cell.tug > 0.0 else 0
        problem, other = self.problem.with_friction(cell.friction), self.opposite
        other = None if other is None else other.with_friction(cell.friction)
        remembered = RememberedPlant(
            lambda: LiftPlant(problem, self.face, cell.mass_g, other, pulls),
            Memory() if memory is None else memory,
        )
        rng = np.random.default_rng(seed_of(cell, self.grid.seed))
        return run_episode(
            self._imperfect(remembered, self._noisy(cell.noise), rng),
            self.controller(cell),
            self.calibration(cell.noise),
            self.bounds,
            cell.friction,
            cell.mass_g,
            after,
        )

    @property
    def _held(self) -> int:
        """Steps for which a lifted object is held on."""
        return steps_in(self.grid.hold_s, self.hardware.sample_rate_Hz)

    def _noisy(self, noise: float) -> Hardware:
        return self.hardware.model_copy(update={"gage_noise_microstrain": noise})

    def _imperfect(self, plant: Plant, hardware: Hardware, rng: np.random.Generator) -> Plant:
        return ImperfectPlant(plant, hardware, rng, self.plates)


def _failed(cell: Cell, seed: int, reason: str) -> JudgedGrip:
    return JudgedGrip(
        **asdict(cell),
        seed=seed,
        lifted=False,
        dropped=False,
        slip_distance_mm=0.0,
        margin_at_lift=None,
        peak_normal_force_N=0.0,
        peak_ratio=0.0,
        minimum_stick_ratio=None,
        steps=0,
        ending="failed",
        reason=reason,
    )
