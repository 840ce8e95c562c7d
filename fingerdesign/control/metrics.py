"""Judgements of a grip's trace: whether its controller was unsure, and its reaction to a tug."""

import numpy as np

from fingerdesign.records.arrays import GripTrace


def unsure_at_the_end(trace: GripTrace, dropped: bool, most: float) -> bool | None:
    """True if the controller was unsure at the step that went wrong: the first whose F_n reaches
    ``most`` (N), else the end of an object that is dropped; where none did, at the lift."""
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
