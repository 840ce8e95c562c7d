"""The plant that a controller moves and measures, and its truth, for the judge alone."""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

from fingerdesign.contact.history import FrictionHistory
from fingerdesign.contact.increment import Increment, solve_increment
from fingerdesign.contact.measures import completely_slips, measure
from fingerdesign.contact.problem import ContactProblem, Motion
from fingerdesign.contact.turning import carried_turning
from fingerdesign.control.signals import Sample, gage_readings
from fingerdesign.design.grip import weight_per_finger


@dataclass(frozen=True)
class Truth:
    """The plant's true state, for the judge alone; mm and N, forces of one finger.

    stick_ratio: stick area / contact area; slip_ratio: F_t / F_n at which the whole contact would
    slip, the friction coefficient unless the object leans or turns; both None without contact, the
    second under another law than Coulomb's too.
    slip_distance: least accumulated slip over the points in contact. complete_slip: loaded, and
    (nearly) nothing sticks. lifted: the object hangs free of its support; None where the plant
    holds no object with a weight. rise: of the object above its support, mm. rotation: by which it
    has turned about the contact's normal, degrees.

    Of an object with inertia (plants/slide.py), else None or 0. sliding: it slides through the
    fingers at the end of the move. slid: how far it has in all its slides, mm. caught: the last of
    them has ended by sticking; None before the first. catch_time: the longest from the first motion
    of a slide to the catch, s. frequency: Hz at which it swings on the fingers as it was lifted.
    """

    approach: float = 0.0
    shear: float = 0.0
    normal_force: float = 0.0
    tangential_force: float = 0.0
    stick_ratio: float | None = None
    slip_distance: float = 0.0
    complete_slip: bool = False
    slip_ratio: float | None = None
    lifted: bool | None = None
    rise: float = 0.0
    sliding: bool | None = None
    slid: float = 0.0
    caught: bool | None = None
    catch_time: float | None = None
    frequency: float | None = None
    rotation: float = 0.0


class Plant(Protocol):
    """One finger against an object, moved in steps."""

    def move(self, dx: float, dy: float) -> Sample:
        """Move the object by ``dx`` toward +x and ``dy`` onto the finger (closing > 0), mm.

        Raises SolverError where a simulated plant has no accepted answer.
        """

    def truth(self) -> Truth:
        """The state after the last move. For the judge; never handed to a controller."""


PlantMaker = Callable[[], Plant]


def observe(problem: ContactProblem, increment: Increment, face: str) -> tuple[Truth, Sample]:
    """The truth of an increment, and the sample that its hand measures."""
    found = measure(problem, increment)
    truth = Truth(
        approach=increment.motion.approach,
        shear=increment.motion.shear,
        normal_force=found.normal_force,
        tangential_force=found.tangential_force,
        stick_ratio=found.stick_ratio,
        slip_distance=found.slip_distance,
        complete_slip=completely_slips(found, problem.model.dimension),
        slip_ratio=problem.slip_ratio(increment.multiplier[:, 0]),
        rotation=increment.state.motion.twist_deg,
    )
    readings = gage_readings(found.gages, face)
    torque = found.twist_moment
    return truth, Sample(readings, found.normal_force, found.tangential_force, torque=torque)


def with_turning_ratio(truth: Truth, problem: ContactProblem, increment: Increment) -> Truth:
    """The truth of an object that turns with the slip ratio of this moment; else unchanged."""
    if problem.softness is None or not truth.normal_force > 0.0:
        return truth
    normal, carried = carried_turning(problem, increment.multiplier[:, 0])
    return replace(truth, slip_ratio=carried / normal)


class CondensedPlant:
    """A finger's condensed model against a rigid object, friction history and all.

    Motions are those of the object relative to the finger's base, from touch. kinetic_share: of the
    friction coefficient, what is left of it where the contact slides (contact/history.py).
    """

    def __init__(self, problem: ContactProblem, face: str, kinetic_share: float = 1.0) -> None:
        self._face = face
        self._history = FrictionHistory(problem, kinetic_share)
        self._truth = Truth()

    def move(self, dx: float, dy: float) -> Sample:
        """Move the object by (dx, dy) mm and read gages and forces; see :class:`Plant`."""
        history, now = self._history, self._history.state.motion
        motion = Motion(now.approach + dy, now.shear + dx)
        increment = solve_increment(history.problem, history.state, motion, history.workspace)
        self._truth, sample = observe(history.problem, increment, self._face)
        self._truth = with_turning_ratio(self._truth, history.problem, increment)
        history.accept(increment)
        return sample

    def truth(self) -> Truth:
        """The state after the last move, for the judge."""
        return self._truth


def press(plant: Plant, depth: float, step: float) -> Iterator[Sample]:
    """Close by ``depth`` mm without shear, in equal moves of at most ``step``; a sample each."""
    moves = max(1, math.ceil(depth / step - 1e-9))
    for _ in range(moves):
        yield plant.move(0.0, depth / moves)


def is_lifted(truth: Truth, object_mass_g: float) -> bool:
    """The object hangs, or in a plant without one the paper's end of a grip, mg < 2 F_t; and it
    does not slide through."""
    if truth.lifted is not None:
        return truth.lifted and not truth.complete_slip
    return not truth.complete_slip and truth.tangential_force > weight_per_finger(object_mass_g)


def may_be_caught(truth: Truth) -> bool:
    """An object with inertia that slips as a whole is in the fingers yet."""
    return truth.sliding is not None and bool(truth.lifted)


def safety_margin(truth: Truth, friction_coefficient: float) -> float | None:
    """Normal force over the one that just holds F_t; None without F_t.

    friction_coefficient: counts where the truth has no slip ratio.

    >>> safety_margin(Truth(0.1, 0.1, 10.0, 2.0, 0.5, 0.0, False), 0.3)
    1.5
    """
    if not truth.tangential_force > 0.0:
        return None
    ratio = friction_coefficient if truth.slip_ratio is None else truth.slip_ratio
    return ratio * truth.normal_force / truth.tangential_force


def minimum_stick_ratio(path: Sequence[Truth]) -> float | None:
    """Least stick ratio where F_t > 0; None where there is none."""
    ratios = [t.stick_ratio for t in path if t.tangential_force > 0.0 and t.stick_ratio is not None]
    return min(ratios, default=None)
