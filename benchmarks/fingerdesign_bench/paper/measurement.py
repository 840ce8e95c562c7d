"""Figure 12: the paper's measurement, as a rig would make it.

Gages and force cells with noise and a stage of whole steps (control/plants/rig.py), at the paper's
friction coefficients 0.3 and 0.6, several seeds. The paper does not state its noise. Here one
sample of a gage has SAMPLE_NOISE, that of a good strain amplifier at 100 Hz. The hand stops at each
step for SAMPLES samples and takes their mean.

A noisy gage area falls now and then by chance. A rule that then holds is safe but blind: it lifts
every object with the same force. So the ratio of the forces at the lift at the two frictions is
reported too: 2 if each is the least, 1 if the rule is blind. The rig's rule needs a larger change
of F_t and a larger fall of A than the design's own (RIG_SETTINGS). Of the pairs tried (falls of
0.05 to 0.4 mm, changes of 0.1 to 0.8 N) it distinguishes the frictions at the most noise; larger
ones come too late at a friction of 0.3.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import takewhile
from typing import Literal

import numpy as np

from fingerdesign.checks.load import with_values
from fingerdesign.control.episode import Episode
from fingerdesign.control.plants.hardware import Hardware
from fingerdesign_bench.paper.case import PaperCase
from fingerdesign_bench.paper.lifts import calibration, grip

HowItEnded = Literal["lifted", "slipped", "not lifted"]

MEASURED_FRICTIONS = (0.3, 0.6)
SAMPLE_NOISE = 0.5  # microstrain
SAMPLE_FORCE_NOISE = 0.01  # N, of both force cells
SAMPLES = (10_000, 1_000, 100, 1)  # A step; from 100 s to 0.01 s at 100 Hz.
SEEDS = 5
RIG_SETTINGS = {"grip.dead_band_mm": 0.1, "grip.force_floor_N": 0.4}
DISTINGUISHED = 1.5  # Ratio of forces: halfway between 1 (blind) and 2 (the least forces).
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
        """Return the object's end."""
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
        own = (each for each in self.grips if each.samples == samples)
        return [each for each in own if friction in (None, each.friction)]

    def force_ratio(self, samples: int | None) -> float:
        """Median F_n at the lift at the lower friction over that at the higher; NaN without."""
        low, high = (_lift_forces(self.at(samples, mu)) for mu in sorted(MEASURED_FRICTIONS))
        return float(np.median(low) / np.median(high)) if low and high else float("nan")

    def works(self, samples: int | None) -> bool:
        """Every object lifted, none slipped, and the frictions distinguished."""
        lifted = all(each.ended == "lifted" for each in self.at(samples))
        return lifted and self.force_ratio(samples) >= DISTINGUISHED

    @property
    def least_samples(self) -> tuple[int | None, ...]:
        """The levels that work, from no noise on up to the first that does not."""
        return tuple(takewhile(self.works, self.levels))


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
