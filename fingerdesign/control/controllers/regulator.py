"""The stick-ratio regulator: the paper's open question, "decreasing x or increasing y", answered.

The estimator (estimator.py) tells at each step how much sticks and how much of the friction is in
use, used = F_t / (mu F_n). The regulator holds ``used`` at ``target`` (1 / target is the safety
margin that it keeps) while both forces grow:

1. *Probe.* From the preload it pulls without closing until ``used`` comes near the target: now the
   edge of the contact slips, and that tells of the friction. On a straight climb nothing would.
2. *Climb.* What each step says of the friction, mu = F_t / (F_n used), is averaged by how sure it
   is, the past fading slowly: mu does not change, but errors that last do less harm so. Each step
   closes by ``approach_step``, less where that would raise F_n by more than ``press_step`` of it,
   and shears toward F_t = target mu F_n.
3. *Guard.* Where the stick ratio falls under ``least_stick``, or ``used`` over ``most_used``, it
   closes without pulling until both are well again, and trusts the lower friction.
4. *Hold.* Once the object hangs it pulls no more, and learns no more: gages that do not move tell
   of friction nothing but their noise. A tug shows in F_t: where F_t / (mu F_n), mu as believed at
   the lift, is over ``most_held``, it closes.

Forces are felt, friction and weight are never given.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from fingerdesign.control.estimator import LAGS, LEAST_FORCE, Estimated, Moment
from fingerdesign.control.roster import Command, Object, Range, controller
from fingerdesign.control.signals import Sample
from fingerdesign.runtime.registry import key

if TYPE_CHECKING:
    from fingerdesign.control.calibration import Calibration
    from fingerdesign.design.grip import Grip

_LEAST_USED = 0.15  # less tells nothing of the friction
_FRICTION = (0.05, 2.0)  # what is believed of any friction
_STIFFNESS_FADES = 0.7  # share of dF_t/dx that stays as it was
_NEAR = 0.9  # of the target: where the probe ends


@dataclass(frozen=True)
class RegulatorTable:
    """Parameters of the stick-ratio regulator, one set for all objects, and of its teaching."""

    target: float = key(
        0.74,
        "share of the friction in use, F_t / (mu F_n), that is held; its inverse is "
        "the safety margin",
        gt=0,
        lt=1,
    )
    pull_share: float = key(0.03, "F_t of a step of the first pull, as part of F_n", gt=0, le=1)
    press_share: float = key(
        0.1, "of F_n, the most that it rises in a step of the climb", gt=0, le=1
    )
    memory: float = key(0.9, "of what earlier steps said of the friction", ge=0, lt=1)
    least_stick: float = key(0.3, "stick ratio below which it closes without pulling", ge=0, lt=1)
    most_used: float = key(0.88, "share in use above which it does the same", gt=0, le=1)
    most_held: float = key(
        0.82, "share in use over which a hanging object is pressed harder", gt=0, le=1
    )
    taught_grips: int = key(
        3000, "simulated grips that its estimator learns from", ge=50, le=100_000
    )
    taught_fingers: int = key(
        1,
        "fingers and objects, drawn unlike the model, that share these grips; 1: the model alone",
        ge=1,
        le=1000,
    )


@controller(
    "regulator",
    place=7,
    table=RegulatorTable,
    tuned=(
        Range("grip.regulator.target", 0.5, 0.9, logarithmic=False),
        Range("grip.regulator.pull_share", 0.003, 0.06),
        Range("grip.regulator.memory", 0.5, 0.99, logarithmic=False),
        Range("grip.regulator.least_stick", 0.0, 0.6, logarithmic=False),
        Range("grip.regulator.most_used", 0.75, 1.0, logarithmic=False),
    ),
    look=("green", "-", "D"),
    trained=True,
)
class Regulator:
    """See the module."""

    name = "regulator"

    def __init__(self, grip: Grip, own: RegulatorTable, held: Object) -> None:
        assert held.estimator is not None
        self._own = own
        self._approach_step, self._shear_step = grip.approach_step_mm, grip.shear_step_mm
        self._taught = self.estimator = held.estimator

    def start(self, calibration: Calibration, sample: Sample) -> None:
        """Begin a grip; see Controller."""
        self.estimator = self._taught.on_rig(calibration)
        self._stiffness = calibration.tangential_stiffness
        self._pressing = 0.0  # dF_n/dy, N/mm, once it has been felt
        self._history = [Moment(sample, 0.0, 0.0)]
        self._weight = self._sum = 0.0
        self._probing = True
        self._move = (0.0, 0.0)

    @property
    def friction(self) -> float | None:
        """What it believes of the friction coefficient; None before it knows anything."""
        return self._sum / self._weight if self._weight > 0.0 else None

    def command(self, sample: Sample) -> Command:
        """The next move; see Controller."""
        before = self._history[-1].sample
        self._history.append(Moment(sample, *self._move))
        del self._history[: -max(LAGS) - 1]
        self._learn_stiffness(before, sample)
        reported = self.estimator.estimate(self._history)
        if not sample.lifted:
            self._learn_friction(sample, reported)
        dx, dy = self._next(sample, before, reported)
        self._move = (dx, dy)
        return Command(dx, dy, dx == 0.0 and not sample.lifted, reported.stick_ratio)

    def _next(self, sample: Sample, before: Sample, reported: Estimated) -> tuple[float, float]:
        own, friction = self._own, self.friction
        believed = 0.0
        if friction is not None:
            believed = sample.tangential_force / (friction * self._pressed(sample))
        if sample.lifted:
            return 0.0, self._close(sample) if believed > own.most_held else 0.0
        in_use = max(reported.used, believed)
        if reported.stick_ratio < own.least_stick or in_use > own.most_used:
            self._probing = False
            return 0.0, self._close(sample)
        if self._probing:
            if in_use < _NEAR * own.target:
                return self._shear(own.pull_share * self._pressed(sample)), 0.0
            self._probing = False
        if friction is None:
            return self._shear(own.pull_share * self._pressed(sample)), 0.0
        rise = max(sample.normal_force - before.normal_force, 0.0) if self._move[1] > 0.0 else 0.0
        aim = own.target * friction * (sample.normal_force + rise)
        return self._shear(aim - sample.tangential_force), self._close(sample)

    def _close(self, sample: Sample) -> float:
        """dy of the next step; half of the largest before the finger's stiffness has been felt."""
        if not self._pressing > 0.0:
            return 0.5 * self._approach_step
        gentle = self._own.press_share * self._pressed(sample) / self._pressing
        return min(self._approach_step, gentle)

    def _shear(self, force: float) -> float:
        return min(max(force / self._stiffness, 0.0), self._shear_step)

    @staticmethod
    def _pressed(sample: Sample) -> float:
        return max(sample.normal_force, LEAST_FORCE)

    def _learn_stiffness(self, before: Sample, sample: Sample) -> None:
        """dF_t/dx and dF_n/dy as last felt; shears too small to be felt teach nothing."""
        dx, dy = self._move
        rise = sample.normal_force - before.normal_force
        if dy > 0.0 and rise > 0.0:
            self._pressing = rise / dy
        change = sample.tangential_force - before.tangential_force
        if dx > 0.02 * self._shear_step and change > 0.0:
            felt = change / dx
            self._stiffness = _STIFFNESS_FADES * self._stiffness + (1.0 - _STIFFNESS_FADES) * felt

    def _learn_friction(self, sample: Sample, reported: Estimated) -> None:
        if reported.used < _LEAST_USED or sample.normal_force < 2.0 * LEAST_FORCE:
            return
        low, high = _FRICTION
        friction = sample.tangential_force / (sample.normal_force * reported.used)
        sure = (reported.used / max(reported.spread, 1e-3)) ** 2  # 1 / relative variance
        memory = self._own.memory
        self._weight = memory * self._weight + sure
        self._sum = memory * self._sum + sure * min(max(friction, low), high)
