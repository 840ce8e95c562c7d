"""Grips that an estimator is taught on: seeded random grip paths of a hand, with the truth beside
them.

Friction is drawn evenly in its logarithm; a random grip path presses to a small force and then
strings together what hands do: press on, pull until some share of the friction is in use, climb
with both forces growing in some ratio, ease off. The steps are as long as a controller's. Noise is
no part of it: it is added when lessons are made (teach.py), as often as wanted.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from fingerdesign.contact.increment import ZoneExhausted
from fingerdesign.contact.problem import ContactProblem
from fingerdesign.control.estimator import Moment
from fingerdesign.control.plants.plant import CondensedPlant, Truth
from fingerdesign.errors import SolverError

FRICTIONS = (0.15, 1.0)
_PRELOAD = (0.15, 1.0)  # N
_PRESS = (0.001, 0.01)  # mm a step
_PULL = (0.02, 0.2)  # of the friction limit a step
_USED = (0.3, 1.05)  # where a pull ends
_SLOPE = (0.2, 1.3)  # dF_t / (mu dF_n) of a climb
_SOFT = 5.0  # N/mm: a finger's least stiffness against shear that is reckoned with
_SLIPS = 2  # steps of complete slip, then the grip is over
_KINDS, _SHARES = ("press", "pull", "climb", "ease"), (0.2, 0.35, 0.35, 0.1)


@dataclass(frozen=True)
class RandomGripPath:
    """One grip without noise: moments and truths, step by step, and its friction coefficient."""

    friction_coefficient: float
    moments: tuple[Moment, ...]
    truths: tuple[Truth, ...]

    @property
    def used(self) -> tuple[float, ...]:
        """F_t / (mu F_n) of each step, 0 without contact."""
        mu = self.friction_coefficient
        return tuple(
            t.tangential_force / (mu * t.normal_force) if t.normal_force > 0.0 else 0.0
            for t in self.truths
        )


def wander(
    problem: ContactProblem,
    face: str,
    rng: np.random.Generator,
    steps: int,
    max_approach: float,
) -> RandomGripPath:
    """A random grip path of ``steps`` steps, fewer where it slips or reaches ``max_approach``."""
    friction = float(np.exp(rng.uniform(*np.log(FRICTIONS))))
    plant = CondensedPlant(problem.with_friction(friction), face)
    moments: list[Moment] = []
    truths: list[Truth] = []
    slipped = 0
    for dx, dy in _moves(plant, friction, rng):
        try:
            sample = plant.move(dx, dy)
        except ZoneExhausted:
            break
        except SolverError:
            break  # what no model can say teaches nothing; the steps before it stand
        truth = plant.truth()
        moments.append(Moment(sample, dx, dy))
        truths.append(truth)
        slipped += truth.complete_slip
        if len(moments) == steps or slipped == _SLIPS or truth.approach > max_approach:
            break
    return RandomGripPath(friction, tuple(moments), tuple(truths))


def _moves(
    plant: CondensedPlant, friction: float, rng: np.random.Generator
) -> Iterator[tuple[float, float]]:
    """Moves without end, each decided on the truth after the last."""
    preload, step = rng.uniform(*_PRELOAD), rng.uniform(*_PRESS)
    while plant.truth().normal_force < preload:
        yield 0.0, step
    stiffness = _Stiffness(plant)
    while True:
        kind = str(rng.choice(_KINDS, p=_SHARES))
        dy = float(rng.uniform(*_PRESS))
        if kind == "press":
            for _ in range(rng.integers(1, 7)):
                yield 0.0, dy
        elif kind == "pull":
            until, share = rng.uniform(*_USED), rng.uniform(*_PULL)
            for _ in range(12):
                limit = friction * plant.truth().normal_force
                if plant.truth().tangential_force >= until * limit:
                    break
                yield stiffness.motion(share * limit), 0.0
        elif kind == "climb":
            slope = float(rng.uniform(*_SLOPE)) * friction
            for _ in range(rng.integers(3, 13)):
                yield stiffness.motion(slope * stiffness.pressing * dy), dy
        else:
            for _ in range(rng.integers(1, 4)):
                limit = friction * plant.truth().normal_force
                yield -stiffness.motion(rng.uniform(0.01, 0.05) * limit), 0.0


class _Stiffness:
    """dF_t/dx and dF_n/dy, N/mm, as the last moves showed them."""

    def __init__(self, plant: CondensedPlant) -> None:
        self._plant = plant
        self._before = plant.truth()
        self._pulling = 0.0

    @property
    def pressing(self) -> float:
        truth = self._plant.truth()
        return 1.5 * truth.normal_force / max(truth.approach, 1e-6)

    def motion(self, force: float) -> float:
        """dx, mm, for so much more F_t, N."""
        now, before = self._plant.truth(), self._before
        moved = now.shear - before.shear
        if moved > 1e-6:
            self._pulling = (now.tangential_force - before.tangential_force) / moved
        self._before = now
        return force / max(self._pulling, 0.3 * self.pressing, _SOFT)
