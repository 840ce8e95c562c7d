"""Our detectors on a foreign array of taxels, and their score. Nothing is tuned on a recording.

*Stick share.* The paper's area A on taxels: d_i is the change of taxel i per change of the load,
between now and the last sample whose load differs by the floor (control/signals.py). The load is
the taxels' mean tangential signal, along its own change. A is the number of taxels whose d_i is
over THRESHOLD of the strongest taxel's at the first such change, when all sticks; the share is A
over its largest so far. The lesser of the fingers counts.

*Change of load.* A plain rival: the load's change within WINDOW_S over its noise at rest.

A hand's ratio of F_t to F_n, and its pull dF_t/dx, are in no public set: normal signals begin under
load, and no hand's move against the object is recorded.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.controllers.regulator import RegulatorTable
from fingerdesign.control.signals import Sample, response
from fingerdesign.design.grip import Grip
from fingerdesign.records.statistics import Share, clustered_share
from fingerdesign.trials.recorded.recording import REST_S, Recording

# Both are the shipped defaults of a grip, set on simulated fingers before any recording was read.
THRESHOLD = float(Grip.model_fields["threshold_share"].default)
LEAST_STICK = RegulatorTable.least_stick
NOISES = 5.0  # Deviations of one taxel's noise: once in two million samples by chance.
WINDOW_S = 0.1  # A person answers a slip in 0.07 to 0.1 s.
ANSWER_S = WINDOW_S  # An alarm so long after the gross slip still finds it.
SPAN_S = 1.0  # Of a window: all windows are equally long, else a longer one has more alarms.


@dataclass(frozen=True)
class Detector:
    """A detector. scores: of a recording (k,), larger where slip is more likely; alarm: the score
    over which it alarms; note: where its parameters are from."""

    name: str
    scores: Callable[[Recording], Array]
    alarm: float
    note: str
    ours: bool = True


def stick_share(recording: Recording) -> Array:
    """The share of taxels that follow the load (k,); 1 before the first change of the load."""
    return np.min([_share(taxels, rest(recording)) for taxels in recording.fingers], axis=0)


def _share(taxels: Array, quiet: Array) -> Array:
    shear, floor = _shear(taxels, quiet)
    load = shear.mean(axis=1)
    share = np.ones(len(load))
    most, scale = 0, np.nan
    for k in range(1, len(load)):
        share[k] = share[k - 1]
        far = np.flatnonzero(np.hypot(*(load[:k] - load[k]).T) >= floor)
        if not far.size:
            continue
        along = load[k] - load[far[-1]]
        along = along / np.hypot(*along)
        before, now = (Sample(shear[j] @ along, 0.0, float(load[j] @ along)) for j in (far[-1], k))
        d = response(before, now)
        scale = d.max() if np.isnan(scale) else scale
        area = int((d > THRESHOLD * scale).sum())
        most = max(most, area)
        share[k] = area / most
    return share


def change_of_load(recording: Recording) -> Array:
    """Change of the load within WINDOW_S over the noise of one taxel's (k,); the larger finger's.

    The floor of NOISES is 1.
    """
    reach = max(1, round(WINDOW_S / float(np.median(np.diff(recording.time)))))
    found = np.zeros(len(recording.time))
    for taxels in recording.fingers:
        shear, floor = _shear(taxels, rest(recording))
        load = shear.mean(axis=1)
        step = np.hypot(*(load[reach:] - load[:-reach]).T) / floor
        found[reach:] = np.maximum(found[reach:], step)
    return found


def rest(recording: Recording) -> Array:
    """Samples (k,) of the rest at the begin of a recording, as true."""
    return np.asarray(recording.time <= recording.time[0] + REST_S)


def _shear(taxels: Array, quiet: Array) -> tuple[Array, float]:
    """Tangential signals (k, n, 2) from rest, and the least change of the load that means
    anything: NOISES of the difference of two samples, or of its largest 1/1000 without noise."""
    shear = taxels[:, :, :2] - np.median(taxels[quiet, :, :2], axis=0)
    noise = float(np.sqrt(np.mean(np.var(shear[quiet], axis=0))))
    least = 1e-3 * float(np.abs(shear.mean(axis=1)).max(initial=0.0))
    return shear, max(NOISES * np.sqrt(2.0) * noise, least, 1e-12)


OURS = (
    Detector(
        "stick share",
        lambda recording: 1.0 - stick_share(recording),
        1.0 - LEAST_STICK,
        f"alarms under {LEAST_STICK:g}, the regulator's default",
    ),
    Detector(
        "first fall of the area",
        lambda recording: 1.0 - stick_share(recording),
        0.0,
        "alarms as the area is below its largest: the rule of Maeno et al. 2000",
    ),
    Detector(
        "change of load",
        change_of_load,
        1.0,
        f"alarms over {NOISES:g} deviations in {WINDOW_S:g} s",
    ),
)


@dataclass(frozen=True)
class Score:
    """A detector's score on windows of recordings. right: those judged right; found: of those with
    slip, with an alarm; false: of those without; early: of those whose moment of gross slip is
    known, alarmed before it; lead: median time before it (s); rank: the probability that a window
    with slip scores more than one without, whatever the alarm's level."""

    detector: Detector
    right: Share
    found: Share
    false: Share
    early: Share | None
    lead: float | None
    rank: float | None


@dataclass(frozen=True)
class _Window:
    """A stretch of a recording: its number, whether it slips there, the largest score, and the
    time from the first alarm to the gross slip, None where either is absent."""

    recording: int
    slips: bool
    most: float
    alarm: bool
    lead: float | None


def score(detector: Detector, recordings: Sequence[Recording]) -> Score:
    """The score of a detector on recordings. One that is labelled as a whole is one window."""
    found = [w for k, each in enumerate(recordings) for w in _windows(detector, k, each)]
    leads = [w.lead for w in found if w.lead is not None and w.slips]
    timed = any(each.slip is not None for each in recordings)

    def share(of: Callable[[_Window], bool], count: Callable[[_Window], bool]) -> Share:
        """Of the windows of a kind those that count; windows of one recording are a cluster."""
        own = [[w for w in found if w.recording == k and of(w)] for k in range(len(recordings))]
        return clustered_share([sum(map(count, each)) for each in own], map(len, own))

    return Score(
        detector,
        share(lambda w: True, lambda w: w.alarm == w.slips),
        share(lambda w: w.slips, lambda w: w.alarm),
        share(lambda w: not w.slips, lambda w: w.alarm),
        share(lambda w: w.slips, lambda w: (w.lead or 0.0) > 0.0) if timed else None,
        float(np.median(leads)) if leads else None,
        _rank([w.most for w in found], [w.slips for w in found]),
    )


def _windows(detector: Detector, number: int, recording: Recording) -> Iterator[_Window]:
    """The windows of one recording.

    The last one ends ANSWER_S after the gross slip and begins SPAN_S before it; those in front of
    it, and all of a recording without slip, have no slip. What follows the slip is no window.
    """
    scores, time = detector.scores(recording), recording.time
    if recording.slip is None:
        most = float(scores.max())
        yield _Window(number, recording.slips, most, most > detector.alarm, None)
        return
    onset = recording.onset()
    begin, end = float(time[0]) + REST_S, float(time[-1])
    last = end if onset is None else onset - SPAN_S
    spans = [(begin + k * SPAN_S, False) for k in range(int((last - begin) / SPAN_S))]
    for start, slips in [*spans, *([] if onset is None else [(max(last, begin), True)])]:
        stop = onset + ANSWER_S if slips and onset is not None else start + SPAN_S
        inside = (time >= start) & (time < stop)
        over = np.flatnonzero(inside & (scores > detector.alarm))
        lead = onset - float(time[over[0]]) if onset is not None and over.size else None
        yield _Window(number, slips, float(scores[inside].max(initial=0.0)), bool(over.size), lead)


def _rank(values: Sequence[float], slips: Sequence[bool]) -> float | None:
    """Mann and Whitney's statistic over its largest; None where one of the two kinds is absent."""
    found, of = np.array(values), np.array(slips, dtype=bool)
    above, below = found[of][:, None], found[~of][None, :]
    if not above.size or not below.size:
        return None
    return float(((above > below) + 0.5 * (above == below)).mean())
