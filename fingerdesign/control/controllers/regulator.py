"""The stick-ratio regulator: the paper's open question, "decreasing x or increasing y", answered.

The estimator (estimator.py) reports at each step how much sticks and how much of the friction is in
use, used = F_t / (mu F_n). The regulator holds ``used`` at ``target`` (1 / target is the safety
margin that it keeps) while both forces grow:

0. *Settle.* It moves nothing until all that it senses is of the present: samples come ``delay``
   late, as the bench has measured. From then on each sample belongs to the move that it answers,
   and forces are carried on by the moves that are on their way.
1. *Probe.* Pressed to ``probe_force_N`` it pulls without closing until ``used`` comes near the
   target: now the edge of the contact slips, and that reveals the friction. On a straight climb
   nothing would; so it probes again where F_n has doubled, and what it knew then counts for a
   third: gages drown in noise at small forces. Where samples come late it pulls the more slowly,
   and ever more slowly towards a probe's end: at a low friction a step is a twelfth of all of it.
2. *Climb.* The friction of each step, mu = F_t / (F_n used), is averaged by how sure the
   estimator is of it, the past fading slowly: errors that last do less harm so. Where F_n rises, it
   falls by an exponent that probes at other forces show (friction_belief.py). Steps of the climb
   count for a fifth: there the network reports what is usual, and the hand would follow its own
   belief from step to step. Each step closes by ``approach_step``, less where that would raise F_n
   by more than ``press_share`` of it, and shears toward F_t = target mu F_n, mu less one of its
   standard deviations.
3. *Guard.* Where the stick ratio falls under ``least_stick``, or ``used`` over ``most_used``, it
   closes without pulling until both are well again, and trusts the lower friction.
4. *Hold.* Once the object hangs it pulls no more, and learns no more: gages that do not move give
   of friction nothing but their noise. A tug shows in F_t: where F_t / F_n is an eighth over that
   at the lift, or F_t / (mu F_n), mu as believed at the lift, is over ``most_held``, it closes; a
   friction unknown at the lift counts as small.

While the friction's standard deviation is over a tenth of it, the regulator reports to be unsure.
Forces are measured, friction and weight are never given.
"""

from collections import deque
from dataclasses import dataclass, replace
from math import inf, sqrt

import numpy as np

from fingerdesign.control.controllers.friction_belief import FrictionBelief
from fingerdesign.control.estimator import Estimated
from fingerdesign.control.features import LEAST_FORCE, Moment
from fingerdesign.control.roster import Command, Object, Range, controller
from fingerdesign.control.signals import Calibration, Sample
from fingerdesign.design.grip import Grip
from fingerdesign.runtime.registry import key

_LEAST_USED = 0.15  # A smaller utilisation does not reveal the friction.
_FRICTION = (0.03, 2.0)  # what is believed of any friction, and of objects that turn
_STIFFNESS_FADES = 0.7  # share of dF_t/dx that stays as it was
_LEAST_CLOSING = 0.1  # of a step: by less, a noisy force cell would make it ever stiffer
_NEAR = 0.9  # of the target: where a probe ends
_NEWS = 0.5  # share of the last sample in what is believed of the friction in use
_OF_ROOM = 0.25  # of the way that is left to a probe's end: its largest step
_SLOWEST = 0.2  # of a step: no less
_AGAIN = 2.0  # F_n over the last probe's, where it probes again
_KEPT = 0.3  # of the weight of what it knew before
_CLIMBING = 0.2  # Weight of a step that also closes, as part of that of a pull alone.
_SURE = 100.0  # weight from which the friction is known
_UNKNOWN = 0.3  # friction that a hanging object of unknown friction is held by
# Of F_t / F_n as the object began to hang: over it the object is tugged. Of 300 lifts with all
# faults at once 2 drop then and 9 are crushed; with 1.05 it is 1 and 14, without any 3 and 9.
_TUGGED = 1.12


@dataclass(frozen=True)
class RegulatorTable:
    """Parameters of the stick-ratio regulator, one set for all objects, and of its teaching."""

    target: float = key(
        0.76,
        "share of the friction in use, F_t / (mu F_n), that is held; its inverse is "
        "the safety margin",
        gt=0,
        lt=1,
    )
    probe_force_N: float = key(
        1.5, "F_n that it presses to before it first pulls: gages drown in noise at less", ge=0
    )
    pull_share: float = key(0.03, "F_t of a step of the first pull, as part of F_n", gt=0, le=1)
    press_share: float = key(
        0.1, "of F_n, the most that it rises in a step of the climb", gt=0, le=1
    )
    memory: float = key(0.9, "weight of what earlier steps showed of the friction", ge=0, lt=1)
    least_stick: float = key(0.3, "stick ratio below which it closes without pulling", ge=0, lt=1)
    most_used: float = key(0.88, "share in use above which it does the same", gt=0, le=1)
    most_held: float = key(
        0.82, "share in use over which a hanging object is pressed harder", gt=0, le=1
    )
    training_grips: int = key(
        7200, "simulated grips that its estimator learns from", ge=50, le=100_000
    )
    training_fingers: int = key(
        120,
        "fingers and objects, perturbed from the model, that share these grips; 1: the model alone",
        ge=1,
        le=1000,
    )


@controller(
    "regulator",
    place=7,
    table=RegulatorTable,
    tuned=(
        Range("grip.regulator.target", 0.5, 0.9, logarithmic=False),
        Range("grip.regulator.probe_force_N", 0.3, 5.0),
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
        self.estimator = self._taught.on_rig(calibration)
        self._stiffness = calibration.tangential_stiffness
        self._pressing = 0.0  # dF_n/dy, N/mm, once it has been measured
        self._history = [Moment(sample, 0.0, 0.0)]
        self._pending = deque([(0.0, 0.0)] * (calibration.delay + 1))  # moves on their way
        self._settling = calibration.delay  # samples of the press to the preload
        self._belief = FrictionBelief()
        self._pulled = False  # Before it is, nothing reveals the friction.
        self._utilisation = 0.0  # F_t / (mu F_n) as the last few samples say
        self._probed = inf  # F_n of the last probe, N; inf while one goes on
        self._carried = 0.0  # F_t / F_n as the object began to hang

    @property
    def friction(self) -> float | None:
        """Its estimate of the friction coefficient, at the mean force of its samples; None before
        it knows anything."""
        return self._belief.mean

    def command(self, sample: Sample) -> Command:
        if self._settling > 0:
            self._settling -= 1
            self._history = [Moment(sample, 0.0, 0.0)]
            stick_ratio = self.estimator.estimate(self._history).stick_ratio
            return Command(0.0, 0.0, False, unsure=True, stick_ratio=stick_ratio)
        before = self._history[-1].sample
        moment = Moment(sample, *self._pending.popleft())
        self._history.append(moment)
        self._learn_stiffness(before, moment)
        reported = self.estimator.estimate(self._history)
        self._pulled = self._pulled or moment.dx > 0.0
        if self._pulled and not sample.lifted:
            self._learn_friction(sample, reported)
        dx, dy = self._next(self._ahead(sample), reported)
        self._pending.append((dx, dy))
        hold, unsure = dx == 0.0 and not sample.lifted, self._belief.weight < _SURE
        return Command(dx, dy, hold, unsure=unsure, stick_ratio=reported.stick_ratio)

    def _ahead(self, sample: Sample) -> Sample:
        """Forces once the moves on their way are measured."""
        dx, dy = np.sum(self._pending, axis=0) if self._pending else (0.0, 0.0)
        return replace(
            sample,
            normal_force=sample.normal_force + self._pressing * float(dy),
            tangential_force=sample.tangential_force + self._stiffness * float(dx),
        )

    def _next(self, sample: Sample, reported: Estimated) -> tuple[float, float]:
        """The next move, of forces as they will be."""
        own, pressed = self._own, self._pressed(sample)
        friction = self._belief.at(pressed)
        ratio = sample.tangential_force / pressed
        believed = 0.0 if friction is None else ratio / friction
        if sample.lifted:
            return 0.0, self._close(sample) if self._tugged(ratio, pressed) else 0.0
        self._utilisation += _NEWS * (reported.friction_utilisation - self._utilisation)
        in_use = max(self._utilisation, believed)
        if reported.stick_ratio < own.least_stick or in_use > own.most_used:
            self._probe_ends(pressed)
            return 0.0, self._close(sample)
        if pressed > _AGAIN * self._probed:
            self._probed = inf
            self._belief.fade(_KEPT)
        if self._probed == inf:
            if pressed < own.probe_force_N:
                return 0.0, self._close(sample)
            if (step := self._probing_pull(ratio, pressed, friction)) > 0.0:
                return self._shear(step), 0.0
            self._probe_ends(pressed)
        if friction is None:
            return self._shear(own.pull_share * pressed), 0.0
        closing = self._close(sample)
        force = pressed + max(self._pressing, 0.0) * closing
        aim = own.target * self._belief.surely(force) * force
        return self._shear(aim - sample.tangential_force), closing

    def _tugged(self, ratio: float, pressed: float) -> bool:
        """True if a hanging object, at this F_t / F_n, needs more than it is held by."""
        known = self._belief.weight > 0.0
        in_use = ratio / (self._belief.surely(pressed) if known else _UNKNOWN)
        self._carried = self._carried or ratio
        return in_use > self._own.most_held or ratio > _TUGGED * self._carried

    def _probing_pull(self, ratio: float, pressed: float, friction: float | None) -> float:
        """The rise of F_t of a probe's next step, N; 0 where the probe is at its end."""
        own = self._own
        pulled = ratio - self._history[-1].sample.tangential_force / pressed
        unfelt = max(pulled, 0.0) / friction if friction is not None else 0.0
        room = _NEAR * own.target - self._utilisation - unfelt
        if not room > 0.0:
            return 0.0
        step = own.pull_share * pressed / sqrt(1 + len(self._pending))
        if friction is not None:
            step = max(min(step, _OF_ROOM * room * friction * pressed), _SLOWEST * step)
        return step

    def _probe_ends(self, pressed: float) -> None:
        if self._probed == inf:
            self._probed = pressed
            self._belief.probe_ends()

    def _close(self, sample: Sample) -> float:
        """dy of the next step; half of the largest before the stiffness has been measured."""
        if not self._pressing > 0.0:
            return 0.5 * self._approach_step
        gentle = self._own.press_share * self._pressed(sample) / self._pressing
        return min(self._approach_step, max(gentle, _LEAST_CLOSING * self._approach_step))

    def _shear(self, force: float) -> float:
        return min(max(force / self._stiffness, 0.0), self._shear_step)

    @staticmethod
    def _pressed(sample: Sample) -> float:
        return max(sample.normal_force, LEAST_FORCE)

    def _learn_stiffness(self, before: Sample, moment: Moment) -> None:
        """Update dF_t/dx and dF_n/dy; shears too small to be measured are left out."""
        sample, dx, dy = moment.sample, moment.dx, moment.dy
        rise = sample.normal_force - before.normal_force
        if dy > 0.0 and rise > 0.0:
            self._pressing = rise / dy
        change = sample.tangential_force - before.tangential_force
        if dx > 0.02 * self._shear_step and change > 0.0:
            faded = _STIFFNESS_FADES * self._stiffness
            self._stiffness = faded + (1.0 - _STIFFNESS_FADES) * change / dx

    def _learn_friction(self, sample: Sample, reported: Estimated) -> None:
        used, pressed = reported.friction_utilisation, sample.normal_force
        if used < _LEAST_USED or pressed < 2.0 * LEAST_FORCE:
            return
        low, high = _FRICTION
        friction = sample.tangential_force / (pressed * used)
        sure = (used / max(reported.std, 1e-3)) ** 2  # 1 / relative variance
        memory = self._own.memory
        if self._history[-1].dy > 0.0:
            sure, memory = _CLIMBING * sure, 1.0 - _CLIMBING * (1.0 - memory)
        self._belief.learn(min(max(friction, low), high), pressed, sure, memory)
