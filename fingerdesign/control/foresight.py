"""What a controller said of slip before it came, and how true its stick ratio was.

A controller *warns* at a sample where the stick ratio that it reports (``Command.stick_ratio``) is
below a threshold, ``grip.warning_stick_ratio``; one that reports none, where it says so itself
(``Command.warns``): the paper's rule while it holds, the reactive hand while it grips harder. Of
all others nothing is judged here. A command answers the sample before it, so that a warning is
given at that sample's time, and is held against what was true then.

Lead        from the first sample of the warning that stands as the whole contact slips, without a
            break since then, to the sample that finds it slipping: at least one. Where no warning
            stands then, it is missed: withdrawn, or never given.
False       a warning given while the true stick ratio is more than :data:`CLEARLY` over the
            threshold: of a reported stick ratio at any of its samples, of a rule at the first, for
            what follows is what the hand does about it.
Error       root mean square of the reported less the true stick ratio, over the samples after the
            preload at which F_t > 0, before the lift and after. Late samples make it larger.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal

import numpy as np

from fingerdesign.arrays import Array, BoolArray

if TYPE_CHECKING:
    from fingerdesign.records.arrays import GripTrace

CLEARLY = 0.2  # stick ratio over the threshold: more still sticks than any estimator's error hides

SlipWarning = Literal["standing", "withdrawn", "none"]


@dataclass(frozen=True)
class Foresight:
    """Of one grip.

    slip_warning: as the whole contact slipped; None where it did not, or where nothing ever warns.
    lead_s, lead_force_share: of a standing warning, the time to complete slip and F_t at the
    warning over F_t at complete slip. alarms, false_alarms: warnings, and those that were false;
    None where nothing ever warns. stick_error: see the module, over stick_error_samples; None of
    none. samples: that the controller answered.
    """

    slip_warning: SlipWarning | None = None
    lead_s: float | None = None
    lead_force_share: float | None = None
    alarms: int | None = None
    false_alarms: int | None = None
    stick_error: float | None = None
    stick_error_samples: int = 0
    samples: int = 0


def foresight(
    trace: GripTrace, preload: int, slipped: bool, rate_Hz: float, threshold: float
) -> Foresight:
    """Judge a grip whose first ``preload`` steps are the press, at ``rate_Hz`` samples a second.

    slipped: it ended in complete slip.
    """
    asked = slice(preload, None)  # the steps that the controller has commanded
    answered = slice(max(preload - 1, 0), -1)  # the samples that it answered with them
    samples = len(trace.dx[asked])
    true, pulled = trace.stick_ratio[answered], trace.tangential_force[answered]
    reported = None if trace.reported_stick_ratio is None else trace.reported_stick_ratio[asked]
    said = None if trace.warns is None else trace.warns[asked]
    error, count = _error(reported, true, pulled) if samples else (None, 0)
    warns = said if reported is None else reported < threshold
    if warns is None or not samples:
        return Foresight(stick_error=error, stick_error_samples=count, samples=samples)
    first = np.flatnonzero(np.diff(warns.astype(int), prepend=0) == 1)
    claims = warns if reported is not None else np.isin(np.arange(samples), first)
    number = np.searchsorted(first, np.flatnonzero(claims & (true > threshold + CLEARLY)), "right")
    standing = lead = share = None
    if slipped:
        standing = _standing(warns)
    if standing == "standing":
        lead = (samples - int(first[-1])) / rate_Hz
        at_slip = float(trace.tangential_force[-1])
        share = float(pulled[first[-1]]) / at_slip if at_slip > 0.0 else None
    alarms, false = len(first), len(np.unique(number))
    return Foresight(standing, lead, share, alarms, false, error, count, samples)


def _standing(warns: BoolArray) -> SlipWarning:
    if warns[-1]:
        return "standing"
    return "withdrawn" if warns.any() else "none"


def _error(reported: Array | None, true: Array, pulled: Array) -> tuple[float | None, int]:
    """Root mean square where F_t > 0 and both are known, and over how many samples."""
    if reported is None:
        return None, 0
    known = (pulled > 0.0) & np.isfinite(true) & np.isfinite(reported)
    if not known.any():
        return None, 0
    return float(np.sqrt(((reported - true)[known] ** 2).mean())), int(known.sum())
