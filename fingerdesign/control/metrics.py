"""What a grip came to: success, margins, slip, reaction to a tug.

Success is to lift the object, never to let the whole contact slip, and to stay under
:data:`MOST_FORCE` times the least force that would hold. All forces are those of one finger; the
least normal force that holds m g / 2 at mu is m g / 2 mu.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.control.foresight import Foresight, SlipWarning
from fingerdesign.design.grip import weight_per_finger

if TYPE_CHECKING:
    from fingerdesign.control.episode import Episode
    from fingerdesign.records.arrays import GripTrace


MOST_FORCE = 3.0  # times the least force that would hold: from there on the object is crushed


@dataclass(frozen=True)
class JudgedGrip:
    """One grip of a grid: its conditions, and what came of it.

    noise: standard deviation of a gage's sample, microstrain. tug: extra load as a share of the
    weight, 0 for none. lifted and dropped (complete slip at any time) may both be: dropped later.
    margin_at_lift: mu F_n / F_t, None where it was not lifted. peak_ratio: largest F_n over
    m g / 2 mu. minimum_stick_ratio: over the steps with F_t > 0. steps: to the lift, or to the end
    where there is none. reaction_steps: from the tug to the hand's answer, None without one.
    unsure: what the controller said of itself as it dropped or crushed the object, or lifted it;
    None where it never tells. From slip_warning to samples: see
    :class:`fingerdesign.control.foresight.Foresight`.
    slid_mm, caught, catch_s: of an object with inertia, as in the result; what was caught has
    dropped all the same, for it slipped completely.
    ending: "lifted", "caught", "complete slip", "stage travel", "steps" or "failed"; reason: a
    sentence.
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
    unsure: bool | None = None
    slip_warning: SlipWarning | None = None
    lead_s: float | None = None
    lead_force_share: float | None = None
    alarms: int | None = None
    false_alarms: int | None = None
    stick_error: float | None = None
    stick_error_samples: int = 0
    samples: int = 0
    slid_mm: float = 0.0
    caught: bool | None = None
    catch_s: float | None = None

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
    seen: Foresight | None = None,
) -> JudgedGrip:
    """The outcome of an episode. seen: what its controller said of slip, where that is judged.

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
        unsure=_unsure(episode.to_slip, result.gross_slip, MOST_FORCE * least),
        **vars(seen or Foresight()),
        slid_mm=result.slid_mm,
        caught=result.caught,
        catch_s=result.catch_s,
    )


def _unsure(trace: GripTrace, dropped: bool, most: float) -> bool | None:
    """At the step that went wrong: the first whose F_n reaches ``most`` (N), else the end of an
    object that is dropped; where none did, at the lift."""
    if trace.unsure is None:
        return None
    crushed = np.flatnonzero(trace.normal_force >= most)
    step = -1 if dropped or trace.lift_step is None else trace.lift_step
    return bool(trace.unsure[crushed[0] if len(crushed) else step])


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
