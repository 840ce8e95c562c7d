"""Warnings of a controller before slip, and the error of the stick ratio that it reports.

A controller *warns* at a sample where the stick ratio that it reports (``Command.stick_ratio``) is
below a threshold, ``grip.warning_stick_ratio``; one that reports none, where it warns by itself
(``Command.warns``): the paper's rule while it holds, the reactive hand while it grips harder. All
others are not judged here. A command answers the sample before it, so that a warning is given at
that sample's time, and is compared with what was true then.

Lead        from the first sample of the warning that is given as the whole contact slips, without a
            break since then, to the sample that finds it slipping: at least one. Without a warning
            then it is missed: withdrawn, or never given.
False       a warning given while the true stick ratio is more than :data:`CLEARLY` over the
            threshold: of a reported stick ratio at any of its samples, of a rule at the first, for
            what follows is what the hand does about it.
Error       root mean square of the reported less the true stick ratio, over the samples after the
            preload at which F_t > 0, before the lift and after. Late samples make it larger.
"""

from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.records.arrays import GripTrace
from fingerdesign.records.result import GripResult, SlipWarning

# A warning is clearly false if the true stick ratio exceeds the threshold by more than this: no
# estimator's error is so large.
CLEARLY = 0.2


def judge_warnings(
    result: GripResult, trace: GripTrace, preload: int, rate_Hz: float, threshold: float
) -> GripResult:
    """Fill in what concerns warnings and reports: the keys from slip_warning to samples.

    trace: up to the first complete slip, its first ``preload`` steps the press; ``rate_Hz``:
    samples a second.
    """
    commanded = slice(preload, None)
    answered = slice(max(preload - 1, 0), -1)  # the samples that the commands answer
    samples = len(trace.dx[commanded])
    true, pulled = trace.stick_ratio[answered], trace.tangential_force[answered]
    ratio = trace.reported_stick_ratio
    reported = None if ratio is None else ratio[commanded]
    error, count = _error(reported, true, pulled) if samples else (None, 0)
    result = replace(result, stick_error=error, stick_error_samples=count, samples=samples)
    rule = None if trace.warns is None else trace.warns[commanded]
    warns = rule if reported is None else reported < threshold
    if not samples or warns is None:
        return result
    first = np.flatnonzero(np.diff(warns.astype(int), prepend=0) == 1)
    claims = warns if reported is not None else np.isin(np.arange(samples), first)
    number = np.searchsorted(first, np.flatnonzero(claims & (true > threshold + CLEARLY)), "right")
    result = replace(result, alarms=len(first), false_alarms=len(np.unique(number)))
    if not result.gross_slip:
        return result
    at_slip = float(trace.tangential_force[-1])
    if not warns[-1]:
        withdrawn: SlipWarning = "withdrawn" if warns.any() else "none"
        return replace(result, slip_warning=withdrawn)
    return replace(
        result,
        slip_warning="standing",
        lead_s=(samples - int(first[-1])) / rate_Hz,
        lead_force_share=float(pulled[first[-1]]) / at_slip if at_slip > 0.0 else None,
    )


def _error(reported: Array | None, true: Array, pulled: Array) -> tuple[float | None, int]:
    """Root mean square where F_t > 0 and both are known, and over how many samples."""
    if reported is None:
        return None, 0
    known = (pulled > 0.0) & np.isfinite(true) & np.isfinite(reported)
    if not known.any():
        return None, 0
    return float(np.sqrt(((reported - true)[known] ** 2).mean())), int(known.sum())
