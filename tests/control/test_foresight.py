"""Warnings of slip and reported stick ratios, judged on episodes made by hand."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.control.calibration import Bounds
from fingerdesign.control.controllers.flow_chart import PaperController
from fingerdesign.control.episode import judged_warnings, run_episode
from fingerdesign.control.foresight import judge_warnings
from fingerdesign.control.plants.plant import Truth
from fingerdesign.control.roster import Command
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import Grip
from tests.support.grips import grip as grip_result
from tests.support.grips import path_of

RATE, THRESHOLD, PRELOAD = 100.0, 0.3, 2


def grip(stick, reported=None, warns=None, pulled=None):
    """A grip of two steps of press, after which ``stick`` is true step by step.

    reported, warns: of the commands that led to these steps; they answer the sample before.
    """
    true = np.array([1.0] * PRELOAD + list(stick))
    count = len(true)
    pulled = np.arange(count, dtype=float) if pulled is None else np.asarray(pulled, dtype=float)
    made = path_of(np.ones(count), pulled, np.ones(count), 0.5, 200.0)
    before = [np.nan] * PRELOAD
    return replace(
        made,
        stick_ratio=true,
        reported_stick_ratio=None if reported is None else np.array([*before, *reported]),
        warns=None if warns is None else np.array([False] * PRELOAD + list(warns)),
    )


def judged(trace, slipped=True):
    result = grip_result(gross_slip=slipped)
    return judge_warnings(result, trace, PRELOAD, RATE, THRESHOLD)


FALLING = [0.9, 0.8, 0.7, 0.4, 0.2, 0.2, 0.1, 0.05, 0.0]
SEEN = [1.0, *FALLING[:-1]]  # what a perfect reporter says: the truth of the sample before


def test_a_perfect_reporter_has_no_error_and_warns_five_steps_before_the_slip():
    found = judged(grip(FALLING, SEEN))
    assert found.stick_error == 0.0
    # The sample of step 4 (true and reported 0.2) is four steps before that of step 8, the slip.
    assert found.slip_warning == "standing"
    assert found.lead_s == pytest.approx(4 / RATE)
    assert found.lead_force_share == pytest.approx((PRELOAD + 4) / (PRELOAD + 8))
    assert (found.alarms, found.false_alarms, found.samples) == (1, 0, 9)
    one_sooner = [*SEEN[:4], 0.29, *SEEN[5:]]  # it says so of step 3, where 0.4 sticks
    found = judged(grip(FALLING, one_sooner))
    assert found.lead_s == pytest.approx(5 / RATE)
    assert found.lead_force_share == pytest.approx((PRELOAD + 3) / (PRELOAD + 8))
    assert (found.alarms, found.false_alarms) == (1, 0)
    assert found.stick_error == pytest.approx(0.11 / np.sqrt(9))  # F_t > 0 from the press's end on


def test_a_warning_that_is_taken_back_counts_from_where_it_stands_again():
    flicker = [*SEEN[:6], 0.31, *SEEN[7:]]
    found = judged(grip(FALLING, flicker))
    assert (found.slip_warning, found.alarms) == ("standing", 2)
    assert found.lead_s == pytest.approx(2 / RATE)
    back = judged(grip(FALLING, [*SEEN[:-1], 0.31]))
    assert (back.slip_warning, back.lead_s, back.lead_force_share) == ("withdrawn", None, None)
    never = judged(grip(FALLING, [0.9] * 9))
    assert (never.slip_warning, never.lead_s, never.alarms) == ("none", None, 0)
    # Nothing slips: there is nothing to be warned of, and no lead.
    still = judged(grip([0.9] * 9, [0.9] * 9), slipped=False)
    assert (still.slip_warning, still.lead_s, still.false_alarms) == (None, None, 0)
    last = judged(grip(FALLING, [*[0.9] * 8, 0.1]))
    assert last.lead_s == pytest.approx(1 / RATE)  # the least


@pytest.mark.parametrize(
    ("true", "reported", "alarms", "false"),
    [
        ([0.51] * 4, [0.9, 0.29, 0.9, 0.9], 1, 1),
        ([0.49] * 4, [0.9, 0.29, 0.9, 0.9], 1, 0),  # over 0.3, yet not by more than 0.2
        ([0.9] * 4, [0.9, 0.1, 0.9, 0.1], 2, 2),
        ([0.9] * 4, [0.1, 0.1, 0.1, 0.1], 1, 1),
        # True as it begins, and continued while 0.4 sticks again, or 0.9.
        ([0.2, 0.2, 0.4, 0.9], [0.9, 0.9, 0.1, 0.1], 1, 0),
        ([0.2, 0.9, 0.9, 0.9], [0.9, 0.1, 0.1, 0.1], 1, 1),
        ([np.nan] * 4, [0.9, 0.1, 0.1, 0.1], 1, 0),  # no contact: nothing to be wrong about
        ([0.9] * 4, [0.9, 0.3, np.nan, 0.31], 0, 0),
    ],
)
def test_a_false_alarm_is_a_report_far_below_the_truth(true, reported, alarms, false):
    found = judged(grip(true, reported), slipped=False)
    assert (found.alarms, found.false_alarms) == (alarms, false)


def test_a_rule_is_judged_as_it_fires_and_a_hand_that_says_nothing_not_at_all():
    stick = [0.9, 0.2, 0.9, 0.9, 0.9, 0.9]
    holds = [False, False, True, True, False, True]  # fires at 0.2, and while 0.9 sticks
    found = judged(grip(stick, warns=holds), slipped=False)
    assert (found.alarms, found.false_alarms) == (2, 1)
    assert (found.stick_error, found.stick_error_samples) == (None, 0)
    slips = judged(grip(stick, warns=holds))
    assert (slips.slip_warning, slips.lead_s) == ("standing", pytest.approx(1 / RATE))
    assert judged(grip(stick)) == replace(grip_result(gross_slip=True), samples=6)
    nothing = path_of([], [], [], 0.5, 200.0)
    assert judge_warnings(grip_result(), nothing, 0, RATE, THRESHOLD) == grip_result()


def test_the_error_is_taken_where_the_finger_is_pulled():
    pulled = [0, 0, 0, 0, 1, 1, 1]
    found = judged(grip([1.0] * 5, [0.0, 0.0, 0.0, 0.5, 0.7], pulled=pulled), slipped=False)
    assert found.stick_error_samples == 2
    assert found.stick_error == pytest.approx(np.sqrt((0.5**2 + 0.3**2) / 2))


# Of the rig, all that the episode asks for; one move of press.
RIG = (
    SimpleNamespace(gage_x=np.zeros(2), corrected=lambda sample: sample),
    Bounds(0.01, 0.01, 1.0, 50),
)


class Slipping:
    """A plant whose contact slips a tenth more at each pull, wholly at the tenth."""

    def __init__(self):
        self.pulls = 0

    def move(self, dx, dy):
        self.pulls += dx > 0.0
        return Sample(np.zeros(2), 1.0, 0.1 * self.pulls)

    def truth(self):
        left = 1.0 - 0.1 * self.pulls
        return Truth(0.1, 0.1, 1.0, 0.1 * self.pulls, left, 0.0, self.pulls == 10)


class Watcher:
    """Pulls, and reports what it knows of that plant."""

    name = "watcher"

    def start(self, calibration, sample):
        pass

    def command(self, sample):
        return Command(0.01, 0.0, False, stick_ratio=1.0 - sample.tangential_force)


def test_an_episode_carries_what_was_reported():
    grip = Grip(warning_stick_ratio=0.45)
    episode = run_episode(Slipping(), Watcher(), *RIG, 0.5, 200.0)
    assert np.isnan(episode.trace.reported_stick_ratio[0])
    found = judged_warnings(episode, grip)
    assert episode.result.gross_slip
    assert found.stick_error == pytest.approx(0.0, abs=1e-12)
    # 0.4 is reported at the sixth pull's sample, four before the tenth.
    assert (found.slip_warning, found.lead_s) == ("standing", pytest.approx(0.04))
    assert found.lead_force_share == pytest.approx(0.6)
    assert (found.false_alarms, found.samples) == (0, 10)
    assert episode.result.false_alarms is None
    assert PaperController(grip, rule=False)._warns(True) is None
