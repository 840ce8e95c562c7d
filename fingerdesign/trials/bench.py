"""Benches: a design's rig, on which the cells of a grid are run.

A cell becomes an episode here: two like fingers, an object on a support, imperfect hardware, and a
controller that knows of them what a hand would know. A bench is in a form that is sent to a
process.
"""

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from itertools import groupby
from operator import attrgetter
from typing import Self

from fingerdesign.analysis.case import gage_array
from fingerdesign.contact.gross_slip import meeting
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds
from fingerdesign.control.episode import Episode, judged_warnings, run_episode
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.metrics import reaction_steps
from fingerdesign.control.plants.hardware import Hardware, ImperfectPlant
from fingerdesign.control.plants.lift import Disturbance, LiftPlant, Timed, off_centre
from fingerdesign.control.plants.remembered import Memory, RememberedPlant
from fingerdesign.control.plants.rig import calibrated
from fingerdesign.control.roster import make_controller
from fingerdesign.control.signals import Calibration
from fingerdesign.design.grip import Grip, weight_per_finger
from fingerdesign.design.keys import set_value
from fingerdesign.design.schema import Design
from fingerdesign.errors import FingerDesignError, SolverError
from fingerdesign.records.result import GripResult
from fingerdesign.runtime.streams import stream
from fingerdesign.sensing.perturb.finger import perturb, perturbed_problems
from fingerdesign.trials.grid import NONE, Cell, ControlGrid, Tug, faults_of, seed_of, steps_in

# A hand that closes against a tug by more than this fraction of an approach step has answered it.
_ANSWER = 0.5


def tuned_grip(grip: Grip, values: Mapping[str, float]) -> Grip:
    """A ``[grip]`` table with dotted keys of the design set, checked like a file."""
    if not values:
        return grip
    data = {"grip": grip.model_dump(mode="json", exclude_none=True)}
    for key, value in values.items():
        set_value(data, key, value)
    return Grip.model_validate(data["grip"])


@dataclass(frozen=True)
class GripBench:
    """The model, hardware and settings that all grips of a study share.

    problem: at the bench's friction. plates: numbers of those whose gages are read, in the order of
    the readings. grip: its hardware counts but for the gages' noise, which a cell sets. opposite:
    the other finger at any friction, None for a mirror image. gripping: the finger against what
    it grips, None where that is the bench's plane. finger: fault and number of the one drawn.
    calibrations: those made before, shared with the benches of :meth:`with_grip`.
    """

    problem: ContactProblem
    face: str
    plates: tuple[int, ...]
    grip: Grip
    grid: ControlGrid
    estimator: GripEstimator | None = None
    opposite: ContactProblem | None = None
    gripping: ContactProblem | None = None
    finger: tuple[str, int] = (NONE, 0)
    calibrations: dict[Hashable, Calibration] = field(
        default_factory=dict, init=False, compare=False
    )

    @property
    def bounds(self) -> Bounds:
        """The stage and the patience of the design's ``[grip]`` table."""
        return Bounds.of(self.grip)

    def calibration(self, noise: float) -> Calibration:
        """The bench moves with the same rig at rest, which takes the mean of many samples."""
        known = hardware, bounds = self._noisy(noise), self.bounds
        if known not in self.calibrations:
            rng = stream(self.grid.seed, "noise on a bench", *self.finger, round(1e6 * noise))
            own = (hardware, rng, bounds, self.plates)
            self.calibrations[known] = calibrated(self.problem, self.face, *own)
        return self.calibrations[known]

    def with_grip(self, grip: Grip) -> Self:
        """The same bench for other settings of the controllers."""
        other = replace(self, grip=grip)
        vars(other)["calibrations"] = self.calibrations
        return other

    def run_batch(self, cells: Iterable[Cell]) -> list[GripResult]:
        """Run cells; a grip whose model fails is a failed grip, with the reason."""
        return [rig.run_cell(cell, memory) for rig, cell, memory in self._prepared(cells)]

    def episodes(self, cells: Iterable[Cell]) -> Iterator[tuple[Cell, Episode]]:
        """Cells with their grips, step by step; without those whose bench fails."""
        for rig, cell, memory in self._prepared(cells):
            with suppress(SolverError):
                yield cell, rig.episode(cell, memory)

    def _prepared(self, cells: Iterable[Cell]) -> Iterator[tuple[Self, Cell, Memory]]:
        """Cells, each with a bench of the values tried on it; neighbours share a memory, where one
        controller grips one object."""
        alike = attrgetter("controller", "friction", "mass_g", "values")
        for (*_, values), own in groupby(cells, alike):
            rig, memory = self.with_grip(tuned_grip(self.grip, dict(values))), Memory()
            yield from ((rig, cell, memory) for cell in own)

    def run_cell(self, cell: Cell, memory: Memory) -> GripResult:
        """Run one grip; ``memory`` is shared by cells of one object alone."""
        try:
            episode = self.episode(cell, memory)
        except SolverError as error:
            return failed_grip(cell, str(error))
        trace, answered = episode.trace, None
        if cell.tug > 0.0 and trace.lift_step is not None:
            least = _ANSWER * self.bounds.approach_step
            answered = reaction_steps(trace, trace.lift_step + self._holding_steps + 1, least)
        result = judged_warnings(episode, self.grip)
        # A class may have another name than the reference to it.
        return replace(result, controller=cell.controller, reaction_steps=answered)

    def episode(self, cell: Cell, memory: Memory | None = None) -> Episode:
        """One grip, step by step. Raises SolverError where the bench itself fails."""
        rate, tug = self.grip.hardware.sample_rate_Hz, self.grid.tug
        after, pulls = self._holding_steps, tuple[Disturbance, ...]()
        if tug is not None:  # it comes when grips without it are over: one plant serves both
            pulls = tug.pulls(cell.mass_g, self._holding_steps + 1, rate)
            after += tug.steps(rate) if cell.tug > 0.0 else 0
        lifting = weight_per_finger(cell.mass_g) / cell.friction
        problem, other = meeting(self.gripping or self.problem, cell.friction, lifting), None
        if self.opposite is not None:
            other = self.opposite.with_friction(cell.friction)
        own = Timed.of(self.grip), self.grip.kinetic_share
        problem = off_centre(problem, self.grip, cell.mass_g)
        remembered = RememberedPlant(
            lambda: LiftPlant(problem, self.face, cell.mass_g, other, pulls, *own),
            Memory() if memory is None else memory,
        )
        # An oracle knows at which ratio of forces the object slips.
        known = remembered.truth().slip_ratio or cell.friction
        hand = make_controller(
            cell.controller,
            self.grip,
            estimator=None if self.estimator is None else self.estimator.at_noise(cell.noise),
            friction=known,
            mass_g=cell.mass_g,
        )
        rng = stream(seed_of(cell, self.grid.seed), "samples")
        weight = 2.0 * weight_per_finger(cell.mass_g)
        most_pull = (1.0 + cell.tug) * weight if cell.tug > 0.0 else None
        episode = run_episode(
            ImperfectPlant(remembered, self._noisy(cell.noise), rng, self.plates),
            hand,
            self.calibration(cell.noise),
            self.bounds,
            cell.friction,
            cell.mass_g,
            after,
            most_pull,
        )
        return replace(episode, result=replace(episode.result, friction_law=problem.law.name))

    @property
    def _holding_steps(self) -> int:
        """Steps for which a lifted object is held on."""
        return steps_in(self.grid.hold_s, self.grip.hardware.sample_rate_Hz)

    def _noisy(self, noise: float) -> Hardware:
        own = {"gage_noise_microstrain": noise, "gage_noise_microvolt_per_V": 0.0}
        return self.grip.hardware.model_copy(update=own)


def failed_grip(cell: Cell, reason: str) -> GripResult:
    """The result of a cell whose model or bench failed."""
    return GripResult(
        controller=cell.controller,
        friction_coefficient=cell.friction,
        object_mass_g=cell.mass_g,
        lifted=False,
        gross_slip=False,
        final_normal_force_N=0.0,
        final_tangential_force_N=0.0,
        safety_margin=None,
        minimum_stick_ratio=None,
        peak_normal_force_N=0.0,
        slip_distance_mm=0.0,
        steps=0,
        ending=reason,
        outcome="failed",
        steps_to_lift=0,
    )


@dataclass(frozen=True)
class PerturbedBench:
    """Benches of the fingers that a grid draws with faults; each measures itself, then lifts."""

    design: Design
    grid: ControlGrid
    estimator: GripEstimator | None
    fidelity: str

    def run_batch(self, cells: Sequence[Cell]) -> list[GripResult]:
        """Run cells of one finger; a finger whose model or bench fails is a failure of each."""
        try:
            rig, pulled = self._rig(cells)
        except FingerDesignError as error:
            return [failed_grip(each, str(error)) for each in cells]
        return rig.run_batch(pulled)

    def episodes(self, cells: Sequence[Cell]) -> Iterator[tuple[Cell, Episode]]:
        """Yield the episodes of one finger, for :meth:`GripBench.episodes`."""
        with suppress(FingerDesignError):
            rig, pulled = self._rig(cells)
            yield from rig.episodes(pulled)

    def _rig(self, cells: Sequence[Cell]) -> tuple[GripBench, list[Cell]]:
        """The bench of the finger that is drawn for these cells, and the cells with the tug that is
        drawn with it. Raises FingerDesignError."""
        finger = cells[0].fault, cells[0].plant
        found = perturb(self.design, faults_of(finger[0]), self.grid.plant_seed(*finger))
        bench, gripping = perturbed_problems(found, self.fidelity)
        rig = GripBench(
            bench,
            found.design.gages.face,
            gage_array(found.design),
            found.design.grip,
            ControlGrid(seed=self.grid.seed, tug=Tug(found.tug) if found.tug else None),
            self.estimator,
            gripping=gripping,
            finger=finger,
        )
        return rig, [replace(each, tug=found.tug or 0.0) for each in cells]


Bench = GripBench | PerturbedBench
