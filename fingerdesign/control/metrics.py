"""What a grip came to, and what many grips amount to: success, margins, slip, reaction to a tug.

Success is to lift the object, never to let the whole contact slip, and to stay under
:data:`MOST_FORCE` times the least force that would hold. All forces are those of one finger; the
least normal force that holds m g / 2 at mu is m g / 2 mu.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.control.plants.plant import weight_per_finger

if TYPE_CHECKING:
    from fingerdesign.control.episode import Episode
    from fingerdesign.records.arrays import GripTrace


MOST_FORCE = 3.0  # times the least force that would hold: from there on the object is crushed
_Z = 1.959964  # of the normal distribution, for 95 %


@dataclass(frozen=True)
class JudgedGrip:
    """One grip of a grid: its conditions, and what came of it.

    noise: standard deviation of a gage's sample, microstrain. tug: extra load as a share of the
    weight, 0 for none. lifted and dropped (complete slip at any time) may both be: dropped later.
    margin_at_lift: mu F_n / F_t, None where it was not lifted. peak_ratio: largest F_n over
    m g / 2 mu. minimum_stick_ratio: over the steps with F_t > 0. steps: to the lift, or to the end
    where there is none. reaction_steps: from the tug to the hand's answer, None without one.
    ending: "lifted", "complete slip", "stage travel", "steps" or "failed"; reason: a sentence.
    """

    controller: str
    friction: float
    mass_g: float
    noise: float
    seed: int
    lifted: bool
    dropped: bool
    slip_distance_mm: float
    margin_at_lift: float | None
    peak_normal_force_N: float
    peak_ratio: float
    minimum_stick_ratio: float | None
    steps: int
    ending: str
    reason: str
    tug: float = 0.0
    reaction_steps: int | None = None

    @property
    def held(self) -> bool:
        """Lifted, and never wholly slipping."""
        return self.lifted and not self.dropped and self.ending != "failed"

    @property
    def crushed(self) -> bool:
        """The peak force is :data:`MOST_FORCE` times the least one, or more."""
        return self.peak_ratio >= MOST_FORCE

    @property
    def success(self) -> bool:
        """Held, and not crushed."""
        return self.held and not self.crushed


def outcome(
    episode: Episode,
    noise: float = 0.0,
    seed: int = 0,
    tug: float = 0.0,
    tug_step: int | None = None,
    least_answer: float = 0.0,
) -> JudgedGrip:
    """The outcome of an episode.

    tug_step: steps from the lift to the one at which the tug begins; least_answer: see
    :func:`reaction_steps`.
    """
    result, trace = episode.result, episode.trace
    least = weight_per_finger(result.object_mass_g) / result.friction_coefficient
    answered = None
    if tug_step is not None and trace.lift_step is not None:
        answered = reaction_steps(trace, trace.lift_step + tug_step, least_answer)
    preload = len(trace.dx) - result.steps
    to_lift = result.steps if trace.lift_step is None else trace.lift_step - preload + 1
    return JudgedGrip(
        controller=result.controller,
        friction=result.friction_coefficient,
        mass_g=result.object_mass_g,
        noise=noise,
        seed=seed,
        lifted=result.lifted,
        dropped=result.gross_slip,
        slip_distance_mm=result.slip_distance_mm,
        margin_at_lift=result.safety_margin,
        peak_normal_force_N=result.peak_normal_force_N,
        peak_ratio=result.peak_normal_force_N / least,
        minimum_stick_ratio=result.minimum_stick_ratio,
        steps=to_lift,
        ending=episode.ending,
        reason=episode.reason,
        tug=tug,
        reaction_steps=answered,
    )


def reaction_steps(trace: GripTrace, begin: int, least: float) -> int | None:
    """Steps from ``begin``, the first that feels the tug, to the first that closes against it.

    A hand may be closing anyway: what counts is the approach beyond the rate of the steps between
    the lift and the tug, once it exceeds ``least`` (mm). None where the grip ended before the tug
    or the hand never answered. A command can only follow a sample, so 1 is the soonest.
    """
    start = trace.lift_step
    if start is None or begin >= len(trace.approach):
        return None
    before = trace.approach[start:begin]
    rate = (before[-1] - before[0]) / (len(before) - 1) if len(before) > 1 else 0.0
    after = trace.approach[begin:]
    beyond = after - before[-1] - max(rate, 0.0) * np.arange(1, len(after) + 1)
    answers = np.flatnonzero(beyond[1:] - max(float(beyond[0]), 0.0) > least)
    return int(answers[0]) + 1 if len(answers) else None


@dataclass(frozen=True)
class Share:
    """``count`` of ``of`` trials, with the 95 % interval of the rate behind it.

    >>> Share(99, 100).rate
    0.99
    """

    count: int
    of: int

    @property
    def rate(self) -> float | None:
        """count / of; None of nothing."""
        return self.count / self.of if self.of else None

    @property
    def interval(self) -> tuple[float, float] | None:
        """Wilson's 95 % interval, as if the trials were independent; None of nothing."""
        return wilson_interval(self.count, self.of) if self.of else None


def wilson_interval(count: int, of: int, z: float = _Z) -> tuple[float, float]:
    """Score interval of a rate (Wilson, J. Am. Stat. Assoc. 22 (1927) 209): good near 0 and 1 too.

    (p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n)

    >>> low, high = wilson_interval(100, 100)
    >>> round(low, 4), high
    (0.963, 1.0)
    """
    p, share = count / of, z * z / of
    middle = p + 0.5 * share
    half = z * math.sqrt(p * (1.0 - p) / of + 0.25 * share / of)
    low = (middle - half) / (1.0 + share) if count else 0.0
    high = (middle + half) / (1.0 + share) if count < of else 1.0
    return low, high


@dataclass(frozen=True)
class Spread:
    """Median and quartiles of what has a value; ``most`` and ``least`` of all."""

    count: int
    least: float
    low: float
    median: float
    high: float
    most: float


def spread_of(values: Iterable[float | None]) -> Spread | None:
    """The spread of those values that are there; None where none is."""
    found = np.array([value for value in values if value is not None], dtype=float)
    if not len(found):
        return None
    least, low, median, high, most = np.quantile(found, [0.0, 0.25, 0.5, 0.75, 1.0]).tolist()
    return Spread(len(found), least, low, median, high, most)


@dataclass(frozen=True)
class Summary:
    """Many grips. Shares are of all of them; spreads of those that have the value.

    held: lifted without complete slip. dropped, crushed, not_lifted, failed say why others did not
    succeed; a grip may be in more than one. margin_at_lift, peaks, steps: of lifted ones;
    slip_distance_mm: of held ones. reaction_steps: of those tugged that answered.
    """

    grips: int
    success: Share
    held: Share
    dropped: int
    crushed: int
    not_lifted: int
    failed: int
    margin_at_lift: Spread | None
    peak_ratio: Spread | None
    peak_normal_force_N: Spread | None
    minimum_stick_ratio: Spread | None
    slip_distance_mm: Spread | None
    steps: Spread | None
    answered: Share
    reaction_steps: Spread | None


def summarise(outcomes: Sequence[JudgedGrip]) -> Summary:
    """What these grips amount to; the caller chooses which belong together."""
    tugged = [each for each in outcomes if each.tug > 0.0 and each.lifted]
    count = len(outcomes)
    return Summary(
        grips=count,
        success=Share(sum(each.success for each in outcomes), count),
        held=Share(sum(each.held for each in outcomes), count),
        dropped=sum(each.dropped for each in outcomes),
        crushed=sum(each.crushed for each in outcomes),
        not_lifted=sum(not each.lifted for each in outcomes),
        failed=sum(each.ending == "failed" for each in outcomes),
        margin_at_lift=spread_of(each.margin_at_lift for each in outcomes),
        peak_ratio=spread_of(each.peak_ratio for each in outcomes if each.lifted),
        peak_normal_force_N=spread_of(each.peak_normal_force_N for each in outcomes if each.lifted),
        minimum_stick_ratio=spread_of(each.minimum_stick_ratio for each in outcomes),
        slip_distance_mm=spread_of(each.slip_distance_mm for each in outcomes if each.held),
        steps=spread_of(each.steps for each in outcomes if each.lifted),
        answered=Share(sum(each.reaction_steps is not None for each in tugged), len(tugged)),
        reaction_steps=spread_of(each.reaction_steps for each in tugged),
    )
