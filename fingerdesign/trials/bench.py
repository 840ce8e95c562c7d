"""What controllers are judged on: the cells of a grid, and a design's rig, on which they are run.

A cell of the grid becomes an episode here: two like fingers, an object on a support, imperfect
hardware, and a controller that knows of them what a hand would know. A rig (model, hardware,
settings, estimator) is in a form that is sent to a process.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import cached_property

import numpy as np

from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds, Calibration
from fingerdesign.control.episode import Episode, foreseen, run_episode
from fingerdesign.control.estimator import GripEstimator
from fingerdesign.control.metrics import JudgedGrip, outcome
from fingerdesign.control.plants.lift import Disturbance, LiftPlant, Timed
from fingerdesign.control.plants.plant import Memory, RememberedPlant
from fingerdesign.control.plants.rig import Hardware, ImperfectPlant, calibrated
from fingerdesign.control.roster import Controller, make_controller
from fingerdesign.design.grip import GRAVITY, Grip
from fingerdesign.errors import DesignError, Fault, SolverError
from fingerdesign.runtime.registry import CONTROLLERS

# The grid that controllers are judged on: friction x weight x noise, and a tug at what is lifted.
#
# A cell is one grip. All noises of one friction and mass, and its tugged grip, are one batch, the
# unit of work of a process (run.py): they share the object, and what their plant remembers. The tug
# comes when the others end, so that a tugged grip goes on from one that is there already.
# Seeds follow from the conditions alone, not from the grid that they stand in, and are the same for
# every controller: each meets the same noise.

FRICTIONS = tuple(float(f"{value:.4f}") for value in np.linspace(0.2, 0.8, 10))
MASSES_G = tuple(float(f"{value:.1f}") for value in np.geomspace(100.0, 1000.0, 10))
NOISES = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0)  # microstrain, standard deviation of a gage's sample
GOOD_AMPLIFIER = 0.5  # microstrain at 100 Hz
_MOST = 1000  # values of one axis
_MOST_GRIPS = 100_000  # of one controller: an hour


@dataclass(frozen=True)
class Tug:
    """A pull at the lifted object along its weight, risen to ``share`` of it evenly.

    In seconds: the pull rises during ``rise_s``, stays for ``stay_s`` and is gone; the hand is
    watched for ``after_s`` more.
    """

    share: float = 0.3
    rise_s: float = 0.1
    stay_s: float = 0.3
    after_s: float = 0.1

    def steps(self, rate_Hz: float) -> int:
        """Steps from the first that feels it to the end of the watch."""
        return sum(steps_in(part, rate_Hz) for part in (self.rise_s, self.stay_s, self.after_s))

    def pulls(self, object_mass_g: float, begin: int, rate_Hz: float) -> tuple[Disturbance, ...]:
        """The pull as a staircase of one disturbance a step, N; first felt ``begin`` steps after
        the lift."""
        rise = steps_in(self.rise_s, rate_Hz)
        end = begin + rise + steps_in(self.stay_s, rate_Hz)
        part = self.share * 1e-3 * GRAVITY * object_mass_g / rise
        return tuple(Disturbance(begin + k, part, end - begin - k) for k in range(rise))


@dataclass(frozen=True)
class Cell:
    """One grip; noise in microstrain; tug: share of the weight, 0 without."""

    controller: str
    friction: float
    mass_g: float
    noise: float
    tug: float = 0.0


@dataclass(frozen=True)
class ControlGrid:
    """What is varied. seed: of all noise. hold_s: for which a lifted object is held on, seconds.

    tug: what then befalls it in one more grip, None for nothing; tug_noise: of that, microstrain.
    """

    frictions: tuple[float, ...] = FRICTIONS
    masses_g: tuple[float, ...] = MASSES_G
    noises: tuple[float, ...] = NOISES
    seed: int = 0
    hold_s: float = 0.2
    tug: Tug | None = Tug()
    tug_noise: float = GOOD_AMPLIFIER

    @staticmethod
    def quick() -> ControlGrid:
        """A look in seconds: 4 frictions, 4 masses, 3 noises."""
        return ControlGrid(FRICTIONS[::3], MASSES_G[::3], (0.0, 0.5, 5.0))

    @property
    def cells_of_one(self) -> int:
        """Grips of one controller."""
        of_one_object = len(self.noises) + (self.tug is not None)
        return len(self.frictions) * len(self.masses_g) * of_one_object

    def batches(self, controllers: Iterable[str]) -> Iterator[tuple[Cell, ...]]:
        """Cells of one controller and object at a time; the longest (heavy, slippery) first."""
        for name in controllers:
            for friction in sorted(self.frictions):
                for mass in sorted(self.masses_g, reverse=True):
                    cells = [Cell(name, friction, mass, noise) for noise in self.noises]
                    if self.tug is not None:
                        cells.append(Cell(name, friction, mass, self.tug_noise, self.tug.share))
                    yield tuple(cells)

    def faults(self) -> list[Fault]:
        """What is wrong with the axes, by the option that gives them."""
        found = []
        axes = {
            "--friction": (self.frictions, 0.0, 5.0, False),
            "--mass-g": (self.masses_g, 0.0, 1e5, False),
            "--noise": (self.noises, 0.0, 1e4, True),
        }
        for key, (values, low, high, zero) in axes.items():
            above = "from 0" if zero else "over 0"
            if len(values) > _MOST:
                found.append(Fault(key, len(values), f"given at most {_MOST} times", "give fewer"))
            for value in values:
                if not (low < value <= high or (zero and value == low)):
                    bound = f"{above} and at most {high:g}"
                    found.append(Fault(key, value, bound, "correct it"))
            again = sorted({each for each in values if values.count(each) > 1})
            found += [Fault(key, each, "given once", "leave the second one out") for each in again]
        if self.cells_of_one > _MOST_GRIPS:
            bound = f"at most {_MOST_GRIPS} grips a controller"
            found.append(Fault("grid", self.cells_of_one, bound, "give fewer values of an axis"))
        if not 0 <= self.seed < 2**32:
            found.append(Fault("--seed", self.seed, f"from 0 to {2**32 - 1}", "choose another"))
        return found


def refuse(grid: ControlGrid, controllers: Iterable[str]) -> None:
    """Raise DesignError with every fault of the axes and of the controllers' names."""
    faults = grid.faults()
    for name in controllers:
        try:
            CONTROLLERS.find(name, "--controller")
        except DesignError as error:
            faults += error.faults
    if faults:
        raise DesignError(faults)


def seed_of(cell: Cell, seed: int) -> int:
    """The seed (32 bits) of a cell's noise: of its conditions alone, the controller apart.

    A tugged grip has that of the same grip without the tug, and is the same until it is felt.
    """
    conditions = (cell.friction, cell.mass_g, cell.noise)
    words = [seed, *(round(1e6 * value) for value in conditions)]
    return int(np.random.SeedSequence(words).generate_state(1)[0])


def steps_in(seconds: float, rate_Hz: float) -> int:
    """Control steps in so many seconds, at least one."""
    return max(1, round(seconds * rate_Hz))


_ANSWER = 0.5  # of an approach step: closing by more against a tug is an answer


@dataclass(frozen=True)
class GripBench:
    """What all grips of a study share.

    problem: at the bench's friction. plates: numbers of those whose gages are read, in the order of
    the readings. grip: its hardware counts but for the gages' noise, which a cell says. opposite:
    the other finger at any friction, None for a mirror image. held: the finger against what it
    grips, None where that is the bench's plane.
    """

    problem: ContactProblem
    face: str
    plates: tuple[int, ...]
    grip: Grip
    grid: ControlGrid
    estimator: GripEstimator | None = None
    opposite: ContactProblem | None = None
    held: ContactProblem | None = None

    @cached_property
    def bounds(self) -> Bounds:
        """The stage and the patience of the design's ``[grip]`` table."""
        return Bounds.of(self.grip)

    @cached_property
    def _calibrations(self) -> dict[float, Calibration]:
        return {}

    def calibration(self, noise: float) -> Calibration:
        """The bench moves with the same rig at rest, which takes the mean of many samples."""
        if noise not in self._calibrations:
            rng = np.random.default_rng([self.grid.seed, round(1e6 * noise)])
            own = (self._noisy(noise), rng, self.bounds, self.plates)
            self._calibrations[noise] = calibrated(self.problem, self.face, *own)
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
            return failed_grip(cell, seed, str(error))
        judged = outcome(
            episode,
            cell.noise,
            seed,
            cell.tug,
            self._held + 1 if cell.tug > 0.0 else None,
            _ANSWER * self.bounds.approach_step,
            foreseen(episode, self.grip),
        )
        return replace(judged, controller=cell.controller)  # a class may call itself otherwise

    def episode(self, cell: Cell, memory: Memory | None = None) -> Episode:
        """One grip, step by step. Raises SolverError where the bench itself fails."""
        rate, tug = self.grip.hardware.sample_rate_Hz, self.grid.tug
        after, pulls = self._held, tuple[Disturbance, ...]()
        if tug is not None:  # it comes when grips without it are over: one plant serves both
            pulls = tug.pulls(cell.mass_g, self._held + 1, rate)
            after += tug.steps(rate) if cell.tug > 0.0 else 0
        problem, other = (self.held or self.problem).with_friction(cell.friction), self.opposite
        other = None if other is None else other.with_friction(cell.friction)
        own = Timed.of(self.grip), self.grip.kinetic_share
        remembered = RememberedPlant(
            lambda: LiftPlant(problem, self.face, cell.mass_g, other, pulls, *own),
            Memory() if memory is None else memory,
        )
        rng = np.random.default_rng(seed_of(cell, self.grid.seed))
        return run_episode(
            ImperfectPlant(remembered, self._noisy(cell.noise), rng, self.plates),
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
        return steps_in(self.grid.hold_s, self.grip.hardware.sample_rate_Hz)

    def _noisy(self, noise: float) -> Hardware:
        own = {"gage_noise_microstrain": noise, "gage_noise_microvolt_per_V": 0.0}
        return self.grip.hardware.model_copy(update=own)


def failed_grip(cell: Cell, seed: int, reason: str) -> JudgedGrip:
    """The outcome of a cell whose model or bench failed."""
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
