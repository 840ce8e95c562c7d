"""Figures 2 and 10: lifts by the paper's rule.

Fig. 10  the rule at several friction coefficients, unknown to it, and the same path without it
Fig. 2   one of these lifts, its target point (mg/2mu, mg/2), and two other routes to the weight:
         the path that never holds, and a squeeze that needs no feeling, SQUEEZE times the least
         force and then shear alone
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Literal

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.load import with_values
from fingerdesign.contact.measures import completely_slips
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion
from fingerdesign.control.calibration import Bounds, Calibration, calibrate
from fingerdesign.control.controllers.flow_chart import PaperController
from fingerdesign.control.episode import Episode, run_episode
from fingerdesign.control.plants.plant import CondensedPlant, Plant
from fingerdesign.control.plants.rig import Hardware, ImperfectPlant
from fingerdesign.design.grip import weight_per_finger

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign_bench.paper.case import PaperCase


LIFTED_FRICTIONS = (0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8)
ROUTE_FRICTION = 0.3
SQUEEZE = 4.0
_SHEAR_PART = 0.25  # of the controller's largest shear step: a step of the squeeze
_MOST_SHEARS = 400


@dataclass(frozen=True)
class Lift:
    """One grip by the rule, and the same path without it."""

    friction: float
    ruled: Episode
    free: Episode


@dataclass(frozen=True)
class Route:
    """A way to the weight that feels nothing: forces (2, k), normal and tangential, N; slips: it
    ended in complete slip."""

    forces: Array
    slips: bool


def lifts(case: PaperCase) -> list[Lift]:
    """Fig. 10: one calibration, one set of parameters, a lift at each friction coefficient."""
    learnt = calibration(case)
    return [
        Lift(friction, *(grip(case, learnt, friction, rule=rule) for rule in (True, False)))
        for friction in LIFTED_FRICTIONS
    ]


def squeeze(case: PaperCase) -> Route:
    """Press to SQUEEZE times the least force, or as far as the stage goes, then shear alone."""
    hand = case.design.grip
    weight = weight_per_finger(hand.object_mass_g)
    moves = max(1, round(hand.max_approach_mm / hand.approach_step_mm))
    forces: list[tuple[float, float]] = [(0.0, 0.0)]
    slips = False

    def path() -> Iterator[Motion]:
        approach = 0.0
        for k in range(1, moves + 1):
            approach = hand.max_approach_mm * k / moves
            yield Motion(approach, 0.0)
            if forces[-1][0] >= SQUEEZE * weight / ROUTE_FRICTION:
                break
        for k in range(1, _MOST_SHEARS + 1):
            yield Motion(approach, _SHEAR_PART * hand.shear_step_mm * k)

    for step in follow(case.finger.with_friction(ROUTE_FRICTION), path()):
        measures = step.measures
        forces.append((measures.normal_force, measures.tangential_force))
        slips = completely_slips(measures, 2)
        if slips or measures.tangential_force > weight:
            break
    return Route(np.array(forces).T, slips)


Around = tuple[Hardware, np.random.Generator]  # a plant, and what its noise is drawn from


def _plant(case: PaperCase, friction: float, around: Around | None) -> Plant:
    plant = CondensedPlant(case.finger.with_friction(friction), case.face)
    return plant if around is None else ImperfectPlant(plant, *around)


def calibration(case: PaperCase, around: Around | None = None) -> Calibration:
    """What a rig learns of the finger; around: its hardware, None: a perfect one."""
    hand = case.design.grip
    plant = lambda: _plant(case, hand.bench_friction_coefficient, around)  # noqa: E731
    return calibrate(plant, case.gage_x, Bounds.of(hand))


def grip(
    case: PaperCase,
    learnt: Calibration,
    friction: float,
    around: Around | None = None,
    rule: bool = True,
) -> Episode:
    """One grip by the design's ``[grip]`` table."""
    hand = case.design.grip
    plant, controller = _plant(case, friction, around), PaperController(hand, rule=rule)
    return run_episode(plant, controller, learnt, Bounds.of(hand), friction, hand.object_mass_g)


# Figure 12: the paper's measurement, as a rig would make it.
#
# Gages and force cells with noise and a stage of whole steps (control/plants/rig.py), at the
# paper's friction coefficients 0.3 and 0.6, several seeds. The paper tells nothing of its noise.
# Here one sample of a gage has SAMPLE_NOISE, that of a good strain amplifier at 100 Hz, and the
# hand stands still at each step for so many samples (SAMPLES) and takes their mean.
#
# A noisy gage area falls now and then by chance, and a rule that then holds is safe but blind: it
# lifts every object with the same force. So beside slip it is reported by how much the forces at
# the lift differ between the two frictions: as 2 to 1 if each is the least, as 1 to 1 if nothing
# was felt. The rig's rule asks for a larger change of F_t and a larger fall of A than the design's
# own (RIG_SETTINGS): of the pairs tried (falls of 0.05 to 0.4 mm, changes of 0.1 to 0.8 N) the one
# that tells the frictions apart at the most noise; larger ones come too late at a friction of 0.3.

HowItEnded = Literal["lifted", "slipped", "not lifted"]

MEASURED_FRICTIONS = (0.3, 0.6)
SAMPLE_NOISE = 0.5  # microstrain
SAMPLE_FORCE_NOISE = 0.01  # N, of both force cells
SAMPLES = (10_000, 1_000, 100, 1)  # a step; from 100 s to 0.01 s at 100 Hz
SEEDS = 5
RIG_SETTINGS = {"grip.dead_band_mm": 0.1, "grip.force_floor_N": 0.4}
TOLD_APART = 1.5  # ratio of forces: halfway between blind and the least forces' 2
_CALIBRATION_SAMPLES = 10_000  # at each point, once in a finger's life
_STAGE_STEP_MM = 0.0005


@dataclass(frozen=True)
class Measured:
    """A grip on the rig; samples: that each step is the mean of, None without any noise."""

    friction: float
    samples: int | None
    seed: int
    episode: Episode

    @property
    def ended(self) -> HowItEnded:
        """What became of the object."""
        if self.episode.result.gross_slip:
            return "slipped"
        return "lifted" if self.episode.result.lifted else "not lifted"


@dataclass(frozen=True)
class Rig:
    """All grips of one finger on the rig: every number of samples, friction and seed."""

    finger: str
    grips: tuple[Measured, ...]

    @property
    def levels(self) -> tuple[int | None, ...]:
        """Numbers of samples a step, from no noise to the most."""
        return tuple(dict.fromkeys(each.samples for each in self.grips))

    def at(self, samples: int | None, friction: float | None = None) -> list[Measured]:
        """The grips at one level, of one friction coefficient or of all."""
        return [
            each
            for each in self.grips
            if each.samples == samples and friction in (None, each.friction)
        ]

    def force_ratio(self, samples: int | None) -> float:
        """Median F_n at the lift at the lower friction over that at the higher; NaN without."""
        low, high = (_lift_forces(self.at(samples, mu)) for mu in sorted(MEASURED_FRICTIONS))
        return float(np.median(low) / np.median(high)) if low and high else float("nan")

    def works(self, samples: int | None) -> bool:
        """Every object lifted, none slipped, and the frictions distinguished."""
        every = self.at(samples)
        return all(g.ended == "lifted" for g in every) and self.force_ratio(samples) >= TOLD_APART

    @property
    def least_samples(self) -> tuple[int | None, ...]:
        """The levels that work, from no noise on up to the first that does not."""
        found = []
        for samples in self.levels:
            if not self.works(samples):
                break
            found.append(samples)
        return tuple(found)


def noise_of(samples: int | None) -> float:
    """Noise of one step's readings, microstrain.

    >>> noise_of(100), noise_of(None)
    (0.05, 0.0)
    """
    return 0.0 if samples is None else SAMPLE_NOISE / samples**0.5


def rig_of(case: PaperCase, name: str, levels: Sequence[int] = SAMPLES, seeds: int = SEEDS) -> Rig:
    """Fig. 12 for one finger: without noise (one seed: they would be the same), then each level."""
    tried = replace(case, design=with_values(case.design, RIG_SETTINGS))
    grips = measured(tried, None, 0)
    for samples in levels:
        for seed in range(seeds):
            grips += measured(tried, samples, seed)
    return Rig(name, tuple(grips))


def measured(case: PaperCase, samples: int | None, seed: int) -> list[Measured]:
    """A grip a friction coefficient on the rig, calibrated on itself."""
    rng = np.random.default_rng([case.design.grip.seed, seed, samples or 0])
    hardware = Hardware(stage_step_mm=_STAGE_STEP_MM)
    resting = calibrating = hardware
    if samples is not None:
        noise = {"gage_noise_microstrain": SAMPLE_NOISE, "force_noise_N": SAMPLE_FORCE_NOISE}
        noisy = hardware.model_copy(update=noise)
        resting = noisy.at_rest(samples)
        calibrating = noisy.at_rest(max(samples, _CALIBRATION_SAMPLES))
    learnt = calibration(case, (calibrating, rng))
    return [
        Measured(friction, samples, seed, grip(case, learnt, friction, (resting, rng)))
        for friction in MEASURED_FRICTIONS
    ]


def _lift_forces(grips: list[Measured]) -> list[float]:
    return [g.episode.result.final_normal_force_N for g in grips if g.ended == "lifted"]
