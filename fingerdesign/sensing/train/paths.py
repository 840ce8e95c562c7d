"""Random grip paths: seeded grips on a condensed model, without noise, to train an estimator on.

A random grip path presses to a small force and then strings together what hands do: press on, pull
until some fraction of the friction is in use, climb with both forces growing in some ratio, ease
off. The steps are as long as a controller's. Noise is added later, when the grips are sampled.
"""

from collections.abc import Iterable, Iterator
from contextlib import nullcontext, suppress
from dataclasses import dataclass
from itertools import islice

import numpy as np

from fingerdesign.contact.gross_slip import meeting
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.calibration import Bounds
from fingerdesign.control.features import FingerCurves, Moment
from fingerdesign.control.plants.plant import CondensedPlant, Plant, Truth
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import FORCE_NOISE_N
from fingerdesign.errors import SolverError
from fingerdesign.runtime.pool import Pool
from fingerdesign.runtime.progress import Report
from fingerdesign.runtime.streams import stream

# Friction coefficients are drawn evenly in their logarithm between these two.
FRICTIONS = (0.15, 1.0)
# Where friction falls with the pressure, the coefficient holds at a force in this range, N.
_HOLDS_AT = (1.0, 20.0)
_STEPS = 60  # The most steps of a path.
_PRELOAD = (0.15, 1.0)  # The range of the first press, N.
_PRESS = (0.001, 0.01)  # The range of a pressing step, mm.
_PULL = (0.02, 0.2)  # The range of a pulling step, as a fraction of the friction limit.
_PULL_END = (0.3, 1.05)  # The range of the friction utilisation at which a pull ends.
_SLOPE = (0.2, 1.3)  # The range of dF_t / (mu dF_n) of a climb.
_LEAST_STIFFNESS = 5.0  # No finger is taken to be softer against shear than this, N/mm.
_SLIPS = 2  # The grip ends after so many steps of complete slip.
_KINDS, _CHANCES = ("press", "pull", "climb", "ease"), (0.2, 0.35, 0.35, 0.1)
PART = 50  # A worker makes so many grips in one job.


@dataclass(frozen=True)
class Settings:
    """The amount of training. face, bounds, force_noise (N) and torque_noise (N mm; None: its cell
    measures no torque) are the rig's.

    replicates: how often each grip is sampled, each time with other noise; fingers: the number of
    perturbed fingers that share the grips (1: the design's own model alone).
    """

    face: str
    bounds: Bounds
    grips: int = 3000
    replicates: int = 2
    force_noise: float = FORCE_NOISE_N
    torque_noise: float | None = None
    seed: int = 0
    fingers: int = 1


@dataclass(frozen=True)
class RandomGripPath:
    """One grip without noise: moments and truths, step by step, and its friction coefficient.

    curves: those of its own finger, where that is not the one that the estimator is for.
    """

    friction_coefficient: float
    moments: tuple[Moment, ...]
    truths: tuple[Truth, ...]
    curves: FingerCurves | None = None

    @property
    def friction_utilisation(self) -> tuple[float, ...]:
        """F_t / F_n of each step over that at which the whole contact slips; 0 without contact.

        On an object that leans by two degrees that ratio is off the friction coefficient by 0.035,
        a sixth of a coefficient of 0.2: a hand that held a share of the coefficient would slip.
        """
        return tuple(
            t.tangential_force / (t.slip_ratio * t.normal_force) if t.slip_ratio else 0.0
            for t in self.truths
        )


class RecordingPlant:
    """A plant that records the true samples and states, before any noise."""

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._moments: list[Moment] = []
        self._truths: list[Truth] = []

    def move(self, dx: float, dy: float) -> Sample:
        sample = self._plant.move(dx, dy)
        self._moments.append(Moment(sample, dx, dy))
        self._truths.append(self._plant.truth())
        return sample

    def truth(self) -> Truth:
        return self._plant.truth()

    def path(self, friction: float) -> RandomGripPath:
        return RandomGripPath(friction, tuple(self._moments), tuple(self._truths))


def drawn_evenly(rng: np.random.Generator, low: float, high: float) -> float:
    """Draw a number evenly in its logarithm."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))


def random_grip_paths(
    problem: ContactProblem,
    settings: Settings,
    report: Report = lambda message: None,
    workers: int = 1,
) -> list[RandomGripPath]:
    """Make the grips, each from its own seed: the same for any number of worker processes."""
    parts = [range(k, min(k + PART, settings.grips)) for k in range(0, settings.grips, PART)]
    found: list[RandomGripPath] = []
    with Pool(workers, shared=(problem, settings)) if workers > 1 else nullcontext() as pool:
        here = (_paths_of_part(problem, settings, part) for part in parts)
        for each in pool.in_order(_paths_of_part, [(part,) for part in parts]) if pool else here:
            found += each
            report(f"grips: {len(found)} of {settings.grips}")
    return found


def _paths_of_part(
    problem: ContactProblem, settings: Settings, part: range
) -> list[RandomGripPath]:
    return grip_paths_on([problem] * len(part), settings, settings.seed, part.start)


def grip_paths_on(
    problems: Iterable[ContactProblem], settings: Settings, seed: int, first: int = 0
) -> list[RandomGripPath]:
    """Make a random grip path on each problem, numbered from ``first``; each from its own seed."""
    return [
        random_grip_path(each, settings, stream(seed, "random grip path", number))
        for number, each in enumerate(problems, first)
    ]


def random_grip_path(
    problem: ContactProblem, settings: Settings, rng: np.random.Generator
) -> RandomGripPath:
    """Make a random grip path; it is short where it slips or reaches the stage's end."""
    friction = drawn_evenly(rng, *FRICTIONS)
    if problem.law.exponent:
        problem = meeting(problem, friction, drawn_evenly(rng, *_HOLDS_AT))
    else:
        problem = problem.with_friction(friction)
    plant, slipped = RecordingPlant(CondensedPlant(problem, settings.face)), 0
    # A step that the model cannot solve trains nothing; the earlier ones are valid.
    with suppress(SolverError):
        for dx, dy in islice(_moves(plant, friction, rng), _STEPS):
            plant.move(dx, dy)
            slipped += plant.truth().complete_slip
            if slipped == _SLIPS or plant.truth().approach > settings.bounds.max_approach:
                break
    return plant.path(friction)


def _slip_ratio(truth: Truth, friction: float) -> float:
    """F_t / F_n at which the whole contact slips: less than the friction where an object turns."""
    return friction if truth.slip_ratio is None else truth.slip_ratio


def _moves(
    plant: Plant, friction: float, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Moves (dx, dy) without end, each chosen by the truth after the last."""
    preload, step = rng.uniform(*_PRELOAD), rng.uniform(*_PRESS)
    while plant.truth().normal_force < preload:
        yield 0.0, step
    stiffness = _Stiffness(plant, friction)
    while True:
        ratio = _slip_ratio(plant.truth(), friction)
        kind = str(rng.choice(_KINDS, p=_CHANCES))
        dy = float(rng.uniform(*_PRESS))
        if kind == "press":
            for _ in range(rng.integers(1, 7)):
                yield 0.0, dy
        elif kind == "pull":
            until, fraction = rng.uniform(*_PULL_END), rng.uniform(*_PULL)
            for _ in range(12):
                limit = ratio * plant.truth().normal_force
                if plant.truth().tangential_force >= until * limit:
                    break
                yield stiffness.motion(fraction * limit), 0.0
        elif kind == "climb":
            slope = float(rng.uniform(*_SLOPE)) * ratio
            for _ in range(rng.integers(3, 13)):
                yield stiffness.motion(slope * stiffness.pressing * dy), dy
        else:
            for _ in range(rng.integers(1, 4)):
                limit = ratio * plant.truth().normal_force
                yield -stiffness.motion(rng.uniform(0.01, 0.05) * limit), 0.0


class _Stiffness:
    """dF_t/dx and dF_n/dy, N/mm, as the last moves showed them."""

    def __init__(self, plant: Plant, friction: float) -> None:
        self._plant, self._friction = plant, friction
        self._before, self._pulling = plant.truth(), 0.0

    @property
    def pressing(self) -> float:
        truth = self._plant.truth()
        return 1.5 * truth.normal_force / max(truth.approach, 1e-6)

    def motion(self, force: float) -> float:
        """The shear dx, mm, that raises F_t by a force, N."""
        now, before = self._plant.truth(), self._before
        moved = now.shear - before.shear
        if moved > 1e-6:
            self._pulling = (now.tangential_force - before.tangential_force) / moved
        self._before = now
        # An object that turns gives way, about as much as it slips sooner.
        gives = min(1.0, _slip_ratio(now, self._friction) / self._friction)
        return force / max(self._pulling, gives * max(0.3 * self.pressing, _LEAST_STIFFNESS))
