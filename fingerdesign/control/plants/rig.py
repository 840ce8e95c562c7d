"""The plants that a design's ``[grip]`` table asks for, on one condensed model.

``plant``: a finger on a stage, or two fingers with an object on its support. ``[grip.hardware]``
goes around either, and around the bench on which the same rig is calibrated, at rest.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Calibration, calibrate
from fingerdesign.control.plants.hardware import Hardware, ImperfectPlant
from fingerdesign.control.plants.lift import Disturbance, LiftPlant, WeightChange
from fingerdesign.control.plants.plant import CondensedPlant, Plant

if TYPE_CHECKING:
    from fingerdesign.design.grip import Grip

_BENCH, _GRIP = 0, 1  # streams of random numbers from one seed


@dataclass(frozen=True)
class Rig:
    """A finger's model, what its gages are, and the table that says how it grips.

    face: which face the gages read. plates: numbers of the plates whose gages are read, in the
    order of the model's gages; None for all. opposite: the other finger's problem in a lift, at any
    friction; None for a mirror image.
    """

    problem: ContactProblem
    face: str
    grip: Grip
    plates: Sequence[int] | None = None
    opposite: ContactProblem | None = None

    @cached_property
    def hardware(self) -> Hardware:
        """``[grip.hardware]``."""
        return Hardware(**self.grip.hardware.model_dump())

    def calibration(self) -> Calibration:
        """The bench moves, at rest at each point. Raises SolverError where nothing is felt."""
        bench = self.problem.with_friction(self.grip.bench_friction_coefficient)
        hardware = self.hardware.at_rest()
        rng = np.random.default_rng([self.grip.seed, _BENCH])
        return calibrate(
            lambda: ImperfectPlant(CondensedPlant(bench, self.face), hardware, rng, self.plates),
            self.problem.model.gage_x,
            self.grip.preload_mm,
            self.grip.approach_step_mm,
            self.grip.max_approach_mm,
        )

    def plant(self, friction_coefficient: float, object_mass_g: float, number: int = 0) -> Plant:
        """A fresh plant; grips of the same ``number`` hear the same noise."""
        rng = np.random.default_rng([self.grip.seed, _GRIP, number])
        inner = self._perfect(friction_coefficient, object_mass_g)
        return ImperfectPlant(inner, self.hardware, rng, self.plates)

    def _perfect(self, friction_coefficient: float, object_mass_g: float) -> Plant:
        problem = self.problem.with_friction(friction_coefficient)
        if self.grip.plant == "finger":
            return CondensedPlant(problem, self.face)
        other = self.opposite
        events = [Disturbance(**tug.model_dump()) for tug in self.grip.tugs]
        changes = [WeightChange(**each.model_dump()) for each in self.grip.weight_changes]
        return LiftPlant(
            problem,
            self.face,
            object_mass_g,
            None if other is None else other.with_friction(friction_coefficient),
            [*events, *changes],
        )
