"""The grid that controllers are judged on: friction x weight x noise, or perturbed fingers.

A cell is one grip. A batch of cells is the unit of work of a process: on the model's own finger all
noises of one friction and weight and its tugged grip, which share what their plant remembers; of a
perturbed finger all that is lifted with it. The tug comes when the other grips end, so that a
tugged grip goes on from one that is there already.

Seeds follow from the conditions alone, not from the grid, and are the same for every controller:
each meets the same noise. Every draw has a stream of its own (runtime/streams.py), so no finger and
no object of one fault is one of another fault, of a tuning or of a training.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from fingerdesign.control.plants.lift import Disturbance
from fingerdesign.design.grip import GRAVITY, LEAST_FRICTION, LEAST_MASS_G
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.registry import CONTROLLERS
from fingerdesign.runtime.streams import seed_for, stream
from fingerdesign.sensing.perturb.faults import ALL, FAULTS

FRICTIONS = tuple(float(f"{value:.4f}") for value in np.linspace(0.2, 0.8, 10))
MASSES_G = tuple(float(f"{value:.1f}") for value in np.geomspace(100.0, 1000.0, 10))
NOISES = (0.0, 0.5, 1.0, 2.0, 5.0, 10.0)  # microstrain, standard deviation of a gage's sample
GOOD_AMPLIFIER = 0.5  # microstrain at 100 Hz
NONE, EVERY = "none", "all"  # labels of faults: the model itself, and every fault at once
# The seed of published tables. Development never runs it, and a table is run once by it. After a
# change of a controller or a training that follows such a table, take another one.
SEALED_SEED = 640_118_277
_MOST = 1000  # values of one axis
_MOST_GRIPS = 100_000  # of one controller: they take an hour
LABELS = (NONE, *FAULTS, EVERY)


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
        """Steps from the first with the pull to the end of the watch."""
        return sum(steps_in(part, rate_Hz) for part in (self.rise_s, self.stay_s, self.after_s))

    def pulls(self, object_mass_g: float, begin: int, rate_Hz: float) -> tuple[Disturbance, ...]:
        """The pull as a staircase of one disturbance a step, N, from ``begin`` steps after the lift
        on."""
        rise = steps_in(self.rise_s, rate_Hz)
        end = begin + rise + steps_in(self.stay_s, rate_Hz)
        part = self.share * 1e-3 * GRAVITY * object_mass_g / rise
        return tuple(Disturbance(begin + k, part, end - begin - k) for k in range(rise))


@dataclass(frozen=True)
class Cell:
    """One grip; noise in microstrain; tug: share of the weight, 0 without; fault: the label of what
    is perturbed, and plant: the number of the finger that was drawn for it. values: of the design's
    keys that are tried on it."""

    controller: str
    friction: float
    mass_g: float
    noise: float
    tug: float = 0.0
    fault: str = NONE
    plant: int = 0
    values: tuple[tuple[str, float], ...] = ()


@dataclass(frozen=True)
class Perturbed:
    """Fingers drawn with faults in place of the model's own.

    faults: labels, see :func:`faults_of`; plants: fingers of each; lifts: objects a finger,
    friction and weight drawn between the ends of the grid's axes.
    """

    faults: tuple[str, ...] = ()
    plants: int = 25
    lifts: int = 4

    @property
    def labels(self) -> tuple[str, ...]:
        """The faults in their order; without any the model itself, each alone, and all at once."""
        return tuple(dict.fromkeys(self.faults or (NONE, *ALL, EVERY)))


def faults_of(label: str) -> tuple[str, ...]:
    """The faults of a label: one of LABELS, or some of them joined by plus signs.

    Raises KeyError for another one.

    >>> faults_of("gains+off_centre")
    ('gains', 'off_centre')
    """
    of = {NONE: (), EVERY: ALL, **{name: (name,) for name in FAULTS}}
    return tuple(dict.fromkeys(name for part in label.split("+") for name in of[part]))


@dataclass(frozen=True)
class ControlGrid:
    """The axes. seed: of all noise. hold_s: for which a lifted object is held on, seconds.

    tug: an additional grip at ``tug_noise`` microstrain whose object is tugged, None for none.
    perturbed: fingers with faults, which are not tugged; None for the model's own.
    """

    frictions: tuple[float, ...] = FRICTIONS
    masses_g: tuple[float, ...] = MASSES_G
    noises: tuple[float, ...] = NOISES
    seed: int = 0
    hold_s: float = 0.2
    tug: Tug | None = Tug()
    tug_noise: float = GOOD_AMPLIFIER
    perturbed: Perturbed | None = None

    @classmethod
    def quick(cls) -> Self:
        """A look in seconds: 4 frictions, 4 masses, 3 noises."""
        return cls(FRICTIONS[::3], MASSES_G[::3], (0.0, 0.5, 5.0))

    @classmethod
    def of_perturbed(
        cls,
        perturbed: Perturbed,
        seed: int = 0,
        frictions: tuple[float, ...] = FRICTIONS,
        masses_g: tuple[float, ...] = MASSES_G,
        noises: tuple[float, ...] = (GOOD_AMPLIFIER,),
    ) -> Self:
        """A grid of perturbed fingers, with the gages of a good amplifier and without the tug."""
        return cls(frictions, masses_g, noises, seed, tug=None, perturbed=perturbed)

    @property
    def cells_of_one(self) -> int:
        """Grips of one controller."""
        if (own := self.perturbed) is not None:
            return len(own.labels) * own.plants * own.lifts * len(self.noises)
        of_one_object = len(self.noises) + (self.tug is not None)
        return len(self.frictions) * len(self.masses_g) * of_one_object

    def batches(self, controllers: Sequence[str]) -> Iterator[tuple[Cell, ...]]:
        """Batches of cells: of one controller and object at a time, the longest (heavy, slippery)
        first; of perturbed fingers all controllers on one finger."""
        if self.perturbed is not None:
            yield from self._batches_of_plants(controllers, self.perturbed)
            return
        for name in controllers:
            for friction in sorted(self.frictions):
                for mass in sorted(self.masses_g, reverse=True):
                    cells = [Cell(name, friction, mass, noise) for noise in self.noises]
                    if self.tug is not None:
                        cells.append(Cell(name, friction, mass, self.tug_noise, self.tug.share))
                    yield tuple(cells)

    def _batches_of_plants(
        self, controllers: Sequence[str], own: Perturbed
    ) -> Iterator[tuple[Cell, ...]]:
        for label in own.labels:
            for plant in range(own.plants):
                objects = self._objects(label, plant, own.lifts)
                yield tuple(
                    Cell(name, friction, mass, noise, fault=label, plant=plant)
                    for name in controllers
                    for friction, mass in objects
                    for noise in self.noises
                )

    def plant_seed(self, label: str, plant: int) -> int:
        """The seed of a finger's faults."""
        return seed_for(self.seed, "judged finger", label, plant)

    def _objects(self, label: str, plant: int, lifts: int) -> list[tuple[float, float]]:
        """Friction, evenly, and weight, evenly in its logarithm, of the objects of a finger."""
        rng = stream(self.seed, "friction of judged objects", label, plant)
        friction = rng.uniform(min(self.frictions), max(self.frictions), lifts)
        ends = np.log(min(self.masses_g)), np.log(max(self.masses_g))
        rng = stream(self.seed, "mass of judged objects", label, plant)
        mass = np.exp(rng.uniform(*ends, lifts))
        return [
            (round(float(mu), 4), round(float(grams), 1))
            for mu, grams in zip(friction, mass, strict=True)
        ]

    def faults(self) -> list[Fault]:
        """Faults of the axes, by the option that gives them."""
        found = _axis_faults("--friction", self.frictions, LEAST_FRICTION, 5.0)
        found += _axis_faults("--mass-g", self.masses_g, LEAST_MASS_G, 1e5)
        found += _axis_faults("--noise", self.noises, 0.0, 1e4)
        if self.perturbed is not None:
            bound = f"one of {', '.join(LABELS)}, or some of them, each once, joined by +"
            found += [
                Fault("--fault", label, bound, "correct it")
                for label in self.perturbed.labels
                if label != NONE and not _joined(label)
            ]
        if self.cells_of_one > _MOST_GRIPS:
            bound = f"at most {_MOST_GRIPS} grips a controller"
            found.append(Fault("grid", self.cells_of_one, bound, "give fewer values of an axis"))
        if not 0 <= self.seed < 2**32:
            found.append(Fault("--seed", self.seed, f"from 0 to {2**32 - 1}", "choose another"))
        return found


def _joined(label: str) -> bool:
    """True of a fault's name, or of some joined by +, each once."""
    names = label.split("+")
    return {*names} <= {*LABELS} - {NONE} and len({*names}) == len(names)


def _axis_faults(key: str, values: tuple[float, ...], least: float, most: float) -> list[Fault]:
    """Faults of an axis whose values are from ``least`` to ``most``, each once."""
    found = []
    if len(values) > _MOST:
        found.append(Fault(key, len(values), f"given at most {_MOST} times", "give fewer"))
    bound = f"from {least:g} to {most:g}"
    found += [Fault(key, each, bound, "correct it") for each in values if not least <= each <= most]
    return found + _given_twice(key, values)


def _given_twice(key: str, values: Sequence[float] | Sequence[str]) -> list[Fault]:
    again = {each: None for each in values if [*values].count(each) > 1}  # in their order
    return [Fault(key, each, "given once", "leave the second one out") for each in again]


def refuse(grid: ControlGrid, controllers: Sequence[str]) -> None:
    """Raise DesignError with every fault of the axes and of the controllers' names."""
    faults = grid.faults() + _given_twice("--controller", controllers)
    for name in controllers:
        try:
            CONTROLLERS.find(name, "--controller")
        except DesignError as error:
            faults += error.faults
    if faults:
        raise DesignError(faults)


def seed_of(cell: Cell, seed: int) -> int:
    """The seed of a cell's noise: of finger and object and noise alone, the controller apart.

    A tugged grip has that of the same grip without the tug, and is the same until the tug.
    """
    conditions = (round(1e6 * value) for value in (cell.friction, cell.mass_g, cell.noise))
    return seed_for(seed, "noise of a judged grip", cell.fault, cell.plant, *conditions)


def steps_in(seconds: float, rate_Hz: float) -> int:
    """Control steps in so many seconds, at least one."""
    return max(1, round(seconds * rate_Hz))
