"""Rivals of the paper's rule: hands that measure forces, and one that knows the object.

All of them steer two things. F_n is brought to a target force and held there; once it is there the
hand pulls, by steps that let F_t rise by at most a share of F_n. They differ in the target force:

    fixed force   one number, for the worst friction and the heaviest object expected
    fixed ratio   F_t / ratio: both forces grow together, as if the friction were known
    reactive      a small force, raised by a factor whenever the pull slips
    oracle        margin times the least force that can hold: it knows friction and mass

None reads the gages. What the three hands know is what the paper's rule and the regulator know too:
their own two forces, their own moves, a press on the bench. The oracle knows what no hand can.

Once the object hangs, nothing is pulled any more and the target force is held: the ratio and the
oracle follow F_t when it is tugged, the reactive hand keeps the ratio of its forces at the lift.

Slip shows in F_t, which stops rising while the hand pulls. Gages that jump as the contact breaks
away, a rig's other sign, are not in a model without inertia.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.roster import Command, Object, Range, controller
from fingerdesign.control.signals import Calibration, Sample
from fingerdesign.design.grip import Grip, weight_per_finger
from fingerdesign.runtime.registry import key

# Of what is missing, in one step: a step late or a stiffness wrong by two does not make it swing.
_GAIN = 0.5
_REACHED = 0.98  # At this fraction of the target force the hand pulls.
_CREEP = 0.1  # of a pull: the least that the oracle moves while the object is supported
_TUG = 1.05  # times F_t at the lift: less may be noise


def _pull_range(table: str) -> Range:
    """The range of a hand's pulls: two moves to the limit of a slippery object, or sixty."""
    return Range(f"grip.{table}.pull_share", 0.003, 0.06)


@dataclass(frozen=True)
class Rival:
    """Keys of every rival's table."""

    pull_share: float = key(
        0.02, "F_t rises by about this share of F_n in one control step, no more", gt=0, le=1
    )


@dataclass(frozen=True)
class FixedForce(Rival):
    """``[grip.fixed_force]``: one normal force for every object."""

    force_N: float = key(
        14.7,
        "normal force of one finger; the default is 1.2 times what holds 500 g at a "
        "friction of 0.2, taken for the worst",
        gt=0,
        le=1e5,
    )


@dataclass(frozen=True)
class FixedRatio(Rival):
    """``[grip.fixed_ratio]``: both forces grow in one ratio."""

    ratio: float = key(
        0.17,
        "F_t / F_n; the default is a friction of 0.2, taken for the worst, over 1.2",
        gt=0,
        lt=5,
    )


@dataclass(frozen=True)
class Reactive(Rival):
    """``[grip.reactive]``: pull lightly gripped, grip harder once it slips.

    The defaults lift most objects with `sensitive` and `maeno2000`. A hand that pulls faster, or
    waits for F_t to fall further, feels the slip when the whole contact slips.
    """

    pull_share: float = key(
        0.007, "F_t rises by about this share of F_n in one control step, no more", gt=0, le=1
    )
    first_force_N: float = key(3.0, "normal force before anything has slipped", gt=0, le=1e5)
    slip_share: float = key(
        0.75,
        "it slips where F_t rises by less than this share of what the stiffest pull at "
        "this normal force gave",
        gt=0,
        lt=1,
    )
    force_floor_N: float = key(0.1, "rise of F_t over which that is judged", gt=0, le=1e3)
    step_up: float = key(1.9, "the normal force grows by this factor at a slip", gt=1, le=10)


@dataclass(frozen=True)
class Oracle(Rival):
    """``[grip.oracle]``: given friction and mass; its margin is in its name."""


class _Hand:
    """Brings F_n to a target force, which each controller sets, and pulls."""

    name: str
    _own: Any

    def __init__(self, grip: Grip, own: Rival, held: Object) -> None:
        self._approach_step, self._shear_step = grip.approach_step_mm, grip.shear_step_mm
        self._preload, self._bench_travel = grip.preload_mm, grip.max_approach_mm
        self._own = own

    def start(self, calibration: Calibration, sample: Sample) -> None:
        self._forces = calibration.normal.normal_force
        self._travel = np.linspace(0.0, self._bench_travel, len(self._forces))
        self._stiffness = calibration.tangential_stiffness
        # The sample may be late; the bench knows the force of a preload.
        self._preloaded = max(sample.normal_force, self._force_at(self._preload))

    def command(self, sample: Sample) -> Command:
        target = self._target_force(sample)
        dx = 0.0 if sample.lifted else self._pull(sample, target)
        return Command(dx, self._closing(sample.normal_force, target), hold=False)

    def _target_force(self, sample: Sample) -> float:
        """The normal force that is right now, N."""
        raise NotImplementedError

    def _pull(self, sample: Sample, target: float) -> float:
        """The next tangential move of an object that is still supported, mm."""
        reached = sample.normal_force >= _REACHED * target
        return self._largest_pull(sample) if reached else 0.0

    def _largest_pull(self, sample: Sample) -> float:
        rise = float(self._own.pull_share) * max(sample.normal_force, 0.0)
        return min(self._shear_step, rise / self._stiffness)

    def _closing(self, now: float, target: float) -> float:
        """dy toward ``target``, by the travel that the bench press took between the two forces.

        Past the bench's end its last slope goes on.
        """
        step = self._approach_step
        missing = self._depth_at(target) - self._depth_at(now)
        return min(max(_GAIN * missing, -step), step)

    def _depth_at(self, force: float) -> float:
        return _line_through(self._forces, self._travel, force)

    def _force_at(self, depth: float) -> float:
        return _line_through(self._travel, self._forces, depth)


@controller(
    "fixed_force",
    place=2,
    table=FixedForce,
    tuned=(Range("grip.fixed_force.force_N", 0.5, 40.0), _pull_range("fixed_force")),
    look=("purple", (0, (1.5, 1.5)), "^"),
)
class FixedForceHand(_Hand):
    """Presses to one force, then pulls, whatever the object."""

    name = "fixed_force"

    def _target_force(self, sample: Sample) -> float:
        return float(self._own.force_N)


@controller(
    "fixed_ratio",
    place=3,
    table=FixedRatio,
    tuned=(Range("grip.fixed_ratio.ratio", 0.05, 0.8), _pull_range("fixed_ratio")),
    look=("#a67c00", (0, (6, 2, 1.5, 2)), "v"),  # ochre, on light and dark paper alike
)
class FixedRatioHand(_Hand):
    """Keeps F_t / F_n at ``ratio`` from the preload on: margin mu / ratio, whatever the weight.

    It grips ahead of its next pull, and pulls no more than that grip is good for.
    """

    name = "fixed_ratio"

    def _target_force(self, sample: Sample) -> float:
        ahead = 0.0 if sample.lifted else self._largest_pull(sample) * self._stiffness
        return max(self._preloaded, (sample.tangential_force + ahead) / float(self._own.ratio))

    def _pull(self, sample: Sample, target: float) -> float:
        now = sample.normal_force
        after = self._force_at(self._depth_at(now) + self._closing(now, target))
        allowed = float(self._own.ratio) * after - sample.tangential_force
        return min(max(_GAIN * allowed / self._stiffness, 0.0), self._largest_pull(sample))


@controller(
    "reactive",
    place=4,
    table=Reactive,
    tuned=(
        Range("grip.reactive.first_force_N", 0.3, 20.0),
        Range("grip.reactive.slip_share", 0.1, 0.99, logarithmic=False),
        Range("grip.reactive.force_floor_N", 0.003, 0.3),
        Range("grip.reactive.step_up", 1.05, 2.5),
        _pull_range("reactive"),
    ),
    look=("vermilion", (0, (6, 2)), "s"),
)
class ReactiveHand(_Hand):
    """Pulls at ``first_force_N``; at a slip it holds, grips ``step_up`` times harder, pulls on.

    It slips where F_t rose by less than ``slip_share`` of what it should: by the stiffest pull
    since the last step-up, or the bench's. Both are measured over pulls that should raise F_t by
    ``force_floor_N``. A share of a half and less waits until the whole contact slips: F_t follows
    the bulk of the finger, and falls short by a quarter only just before. A share near 1 detects
    partial slip, if the force cell is good enough.
    """

    name = "reactive"

    def start(self, calibration: Calibration, sample: Sample) -> None:
        super().start(calibration, sample)
        self._target: float = max(self._own.first_force_N, self._preloaded)
        self._waiting = False  # a pull waits for a larger normal force
        self._lift: Sample | None = None
        self._begin_pulls()

    def command(self, sample: Sample) -> Command:
        command = super().command(sample)
        if command.dx > 0.0:
            self._waiting = False
            self._since.append((self._way, sample.tangential_force))
            self._way += command.dx
        return replace(command, hold=self._waiting, warns=self._waiting and not sample.lifted)

    def _begin_pulls(self) -> None:
        self._stiffest: float = self._stiffness
        self._way = 0.0
        self._since: list[tuple[float, float]] = []  # (way, F_t) before each pull

    def _target_force(self, sample: Sample) -> float:
        if sample.lifted:
            return self._after_lift(sample)
        stiffness = self._measured_stiffness(sample.tangential_force)
        if stiffness is not None and stiffness < self._own.slip_share * self._stiffest:
            self._target = self._own.step_up * max(self._target, sample.normal_force)
            self._waiting = True
            self._begin_pulls()
        elif stiffness is not None:
            self._stiffest = max(self._stiffest, stiffness)
        return self._target

    def _measured_stiffness(self, force: float) -> float | None:
        """dF_t/dx over the last pulls that should raise F_t by the floor; None of fewer."""
        least = self._own.force_floor_N / self._stiffest
        far = [(way, before) for way, before in self._since if self._way - way >= least]
        if not far:
            return None
        way, before = far[-1]
        return (force - before) / (self._way - way)

    def _after_lift(self, sample: Sample) -> float:
        if self._lift is None:
            self._lift = sample
            self._target = max(self._target, sample.normal_force)
        carried = self._lift.tangential_force
        tugged = carried > 0.0 and sample.tangential_force > _TUG * carried
        return self._target * (sample.tangential_force / carried if tugged else 1.0)


class OracleHand(_Hand):
    """Given friction and mass: grips ``margin`` times the least force that holds, then pulls.

    On level objects it is the bound that no hand without that knowledge can beat. A tug that it
    measures counts as weight.
    """

    margin: float

    def __init__(self, grip: Grip, own: Oracle, held: Object) -> None:
        super().__init__(grip, own, held)
        assert held.friction is not None
        assert held.mass_g is not None
        self.name = f"oracle_{self.margin:g}"
        self._per_force = self.margin / held.friction
        self._weight = weight_per_finger(held.mass_g)

    def _target_force(self, sample: Sample) -> float:
        return self._per_force * max(self._weight, sample.tangential_force)

    def _pull(self, sample: Sample, target: float) -> float:
        """Slower as F_t nears the weight: what it overshoots by would come off the margin."""
        pull = super()._pull(sample, target)
        missing = self._weight - sample.tangential_force
        return min(max(_GAIN * missing / self._stiffness, _CREEP * pull), pull)


def _line_through(x: Array, y: Array, at: float) -> float:
    """Linear between points of rising x, the last slope going on past either end."""
    k = int(np.clip(np.searchsorted(x, at) - 1, 0, len(x) - 2))
    return float(y[k] + (at - x[k]) * (y[k + 1] - y[k]) / (x[k + 1] - x[k]))


_ORACLE: dict[str, Any] = {"table": Oracle, "table_name": "oracle", "knows": "friction and weight"}
_ORACLE["tuned"] = (_pull_range("oracle"),)


@controller("oracle_1.2", place=5, look=("ink", (0, (3, 1, 1, 1, 1, 1)), "P"), **_ORACLE)
class OracleNear(OracleHand):
    """1.2 times the least force that holds."""

    margin = 1.2


@controller("oracle_1.5", place=6, look=("muted", (0, (4, 2)), "X"), **_ORACLE)
class OracleSafe(OracleHand):
    """1.5 times the least force that holds."""

    margin = 1.5
