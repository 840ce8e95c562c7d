"""Our detectors on a foreign array of taxels, and their score. Nothing is tuned on a recording.

*Stick share.* The paper's area A on taxels: d_i is the change of taxel i per change of the load,
between now and the last sample whose load differs by the floor (control/signals.py). The load is
the taxels' mean tangential signal, along its own change. A is the number of taxels whose d_i is
over THRESHOLD of the strongest taxel's at the first such change, when all sticks; the share is A
over its largest so far. The lesser of the fingers counts.

*Change of load.* A plain rival: the load's change within ANSWER_S over that floor.

F_t / F_n, and the pull dF_t/dx of our reactive hand, can be had of no public set: signals are in
counts or begin under load, and no move of the hand against the object is recorded.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.control.controllers.regulator import RegulatorTable
from fingerdesign.control.signals import Sample, response
from fingerdesign.design.grip import Grip
from fingerdesign.records.base import closed
from fingerdesign.records.statistics import Rate, Share, clustered_share
from fingerdesign.trials.recorded.recording import REST_S, SPAN_S, Recording

# Both are shipped defaults of a grip, set on simulated fingers before any recording was read.
THRESHOLD = float(Grip.model_fields["threshold_share"].default)
LEAST_STICK = float(RegulatorTable.least_stick)
NOISES = 5.0  # Deviations of one taxel's noise: once in two million samples by chance.
ANSWER_S = 0.1  # A person answers a slip in 0.07 to 0.1 s: so late an alarm still finds it.


@dataclass(frozen=True)
class Detector:
    """A detector. scores: of a recording (k,), larger where slip is more likely, or (1,) of all of
    it; it alarms over ``alarm``; note: where its parameters are from."""

    name: str
    scores: Callable[[Recording], Array]
    alarm: float
    note: str
    ours: bool = True


def slipping(recording: Recording) -> Array:
    """1 less the share of taxels that follow the load (k,); 0 before its first change."""
    found = [1.0 - _share(*_shear(taxels, recording.rest)) for taxels in recording.fingers]
    return np.asarray(np.max(found, axis=0))


def _share(shear: Array, floor: float) -> Array:
    load = shear.mean(axis=1)
    share = np.ones(len(load))
    most, scale = 0, np.nan
    for k in range(1, len(load)):
        share[k] = share[k - 1]
        far = _last_apart(load[: k + 1], floor)
        if far is None:
            continue
        along = load[k] - load[far]
        along = along / np.hypot(*along)
        before, now = (Sample(shear[j] @ along, 0.0, load[j] @ along) for j in (far, k))
        d = response(before, now)
        scale = d.max() if np.isnan(scale) else scale
        area = int((d > THRESHOLD * scale).sum())
        most = max(most, area)
        share[k] = area / most
    return share


def _last_apart(load: Array, floor: float, reach: int = 64) -> int | None:
    """The last sample whose load differs from the newest one's by the floor; near ones first."""
    begin = max(0, len(load) - reach)
    far = np.flatnonzero(np.hypot(*(load[begin:] - load[-1]).T) >= floor)
    if far.size or not begin:
        return begin + int(far[-1]) if far.size else None
    return _last_apart(load, floor, 8 * reach)


def change_of_load(recording: Recording) -> Array:
    """Change of the load within ANSWER_S over the floor (k,), the larger finger's."""
    reach = max(1, round(ANSWER_S / float(np.median(np.diff(recording.time)))))
    found = np.zeros(len(recording.time))
    for taxels in recording.fingers:
        shear, floor = _shear(taxels, recording.rest)
        load = shear.mean(axis=1)
        step = np.hypot(*(load[reach:] - load[:-reach]).T) / floor
        found[reach:] = np.maximum(found[reach:], step)
    return found


def _shear(taxels: Array, rest: Array) -> tuple[Array, float]:
    """Tangential signals (k, n, 2) from rest, and the floor of the load: NOISES deviations of the
    difference of two samples of a taxel, or 1/1000 of the largest load without noise."""
    shear = taxels[:, :, :2] - np.median(taxels[rest, :, :2], axis=0)
    noise = float(np.sqrt(2.0 * np.mean(np.var(shear[rest], axis=0))))
    return shear, max(NOISES * noise, 1e-3 * float(np.abs(shear.mean(axis=1)).max()), 1e-12)


_UNDER = f"alarm under {LEAST_STICK:g}, the regulator's default"
_FALL = "alarm at the first fall of the area, the rule of Maeno et al. 2000"
_OVER = f"alarm over {NOISES:g} deviations of the noise in {ANSWER_S:g} s"
OURS = (
    Detector("stick share", slipping, 1.0 - LEAST_STICK, _UNDER),
    Detector("stick share, first fall", slipping, 0.0, _FALL),
    Detector("change of load", change_of_load, 1.0, _OVER),
)


@closed
@dataclass(frozen=True)
class Score:
    """A detector's score on windows. right: windows judged right; found: of those with slip, with
    an alarm; false: of those without; early: of those with slip, alarmed before it, null where its
    moment is not labelled; lead_s: median time before it; rank: the probability that a window with
    slip scores more than one without, whatever the alarm's level."""

    detector: str
    ours: bool
    note: str
    right: Share
    found: Share
    false: Share
    early: Share | None
    lead_s: float | None
    rank: Rate | None


class _Window(NamedTuple):
    recording: int
    slips: bool
    most: float  # the largest score
    alarm: bool
    lead: float = 0.0  # s from the first alarm to the gross slip


def score(detector: Detector, recordings: Sequence[Recording]) -> Score:
    """The score of a detector on recordings; windows of one recording are a cluster."""
    found = [w for k, each in enumerate(recordings) for w in _windows(detector, k, each)]
    slip, none = ([w for w in found if w.slips == wanted] for wanted in (True, False))
    share = partial(_share_of, len(recordings))
    timed = any(each.slip is not None for each in recordings)
    leads = [w.lead for w in slip if timed and w.alarm]
    return Score(
        detector.name,
        detector.ours,
        detector.note,
        share(found, lambda w: w.alarm == w.slips),
        share(slip, lambda w: w.alarm),
        share(none, lambda w: w.alarm),
        share(slip, lambda w: w.lead > 0.0) if timed else None,
        float(np.median(leads)) if leads else None,
        _rank(slip, none),
    )


def _share_of(
    recordings: int, windows: Sequence[_Window], count: Callable[[_Window], bool]
) -> Share:
    """The share of windows that count; those of one recording are a cluster."""
    own = [[w for w in windows if w.recording == k] for k in range(recordings)]
    return clustered_share([sum(map(count, each)) for each in own], map(len, own))


def _rank(slip: Sequence[_Window], none: Sequence[_Window]) -> float | None:
    """Mann and Whitney's statistic over its largest; None where one kind is missing."""
    if not (slip and none):
        return None
    above, below = np.array([w.most for w in slip])[:, None], np.array([w.most for w in none])
    return float(np.mean((above > below) + 0.5 * (above == below)))


def _windows(detector: Detector, number: int, recording: Recording) -> Iterator[_Window]:
    """The windows of a recording: all of it, where it is labelled as a whole. Else the last one is
    from SPAN_S before the gross slip to ANSWER_S after it; those in front of it have no slip."""
    scores, time, onset = detector.scores(recording), recording.time, recording.onset
    if recording.slip is None:
        most = float(scores.max())
        yield _Window(number, recording.slips, most, most > detector.alarm)
        return
    begin = float(time[0]) + REST_S
    last = float(time[-1]) if onset is None else max(onset - SPAN_S, begin)
    starts = [begin + k * SPAN_S for k in range(int((last - begin) / SPAN_S))]
    spans = [(start, start + SPAN_S) for start in starts]
    for start, stop in spans if onset is None else [*spans, (last, onset + ANSWER_S)]:
        inside = (time >= start) & (time < stop)
        alarms = time[inside & (scores > detector.alarm)]
        lead = onset - float(alarms[0]) if onset is not None and alarms.size else 0.0
        slips = onset is not None and stop > onset
        yield _Window(number, slips, float(scores[inside].max()), bool(alarms.size), lead)
