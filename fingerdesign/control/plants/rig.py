"""The plants that a design's ``[grip]`` table asks for, on one condensed model.

``plant``: a finger on a stage, or two fingers with an object on its support. ``[grip.hardware]``
goes around either, and around the bench on which the same rig is calibrated, at rest.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.plants.hardware import Hardware, ImperfectPlant
from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.control.plants.plant import CondensedPlant, Plant
from fingerdesign.control.signals import Calibration
from fingerdesign.design.grip import Grip
from fingerdesign.design.schema import Design
from fingerdesign.runtime.streams import stream


def calibrated(
    bench: ContactProblem,
    face: str,
    hardware: Hardware,
    rng: np.random.Generator,
    bounds: Bounds,
    plates: Sequence[int] | None,
) -> Calibration:
    """Calibrate a finger's rig by the bench moves, at rest at each point, and measure its delay.

    Raises SolverError where nothing is measured.
    """

    def plant(hardware: Hardware) -> Plant:
        return ImperfectPlant(CondensedPlant(bench, face), hardware, rng, plates)

    gage_x = bench.model.gage_x
    return calibrate(lambda: plant(hardware.at_rest()), gage_x, bounds, lambda: plant(hardware))


@dataclass(frozen=True)
class Rig:
    """A finger's model, its gages, and the table of its grips.

    face: which face the gages read. plates: numbers of the plates whose gages are read, in the
    order of the model's gages; None for all. opposite: the other finger's problem in a lift, at any
    friction; None for a mirror image. calibrations: those made before, shared with the rigs of
    :meth:`with_grip`.
    """

    problem: ContactProblem
    face: str
    grip: Grip
    plates: Sequence[int] | None = None
    opposite: ContactProblem | None = None
    calibrations: dict[tuple[object, ...], Calibration] = field(default_factory=dict, compare=False)

    @classmethod
    def of(
        cls,
        problem: ContactProblem,
        design: Design,
        plates: Sequence[int] | None = None,
        opposite: ContactProblem | None = None,
    ) -> Self:
        """The rig of a design's finger."""
        return cls(problem, design.gages.face, design.rig, plates, opposite)

    def with_grip(self, grip: Grip) -> Self:
        """The same finger with another table of grips."""
        return replace(self, grip=grip)

    def calibration(self) -> Calibration:
        """The bench moves, at rest at each point. Raises SolverError where nothing is measured."""
        grip = self.grip
        friction, bounds = grip.bench_friction_coefficient, Bounds.of(grip)
        known = (friction, bounds, grip.hardware, grip.seed)
        if known not in self.calibrations:
            bench = self.problem.with_friction(friction)
            rng = stream(grip.seed, "noise on the bench")
            found = calibrated(bench, self.face, grip.hardware, rng, bounds, self.plates)
            self.calibrations[known] = found
        return self.calibrations[known]

    def plant(self, friction_coefficient: float, object_mass_g: float, number: int = 0) -> Plant:
        """A fresh plant; grips of the same ``number`` meet the same noise.

        Where the problem's law is not Coulomb's it stays, and the coefficient sets nothing.
        """
        own = self.problem.law
        friction = friction_coefficient if own.is_coulomb else own
        rng = stream(self.grip.seed, "noise of a grip", number)
        inner: Plant
        if self.grip.plant == "finger":
            problem = self.problem.with_friction(friction)
            inner = CondensedPlant(problem, self.face, self.grip.kinetic_share)
        else:
            inner = LiftPlant.of(
                self.grip, self.problem, self.face, friction, object_mass_g, self.opposite
            )
        return ImperfectPlant(inner, self.grip.hardware, rng, self.plates)
