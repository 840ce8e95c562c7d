"""Outcomes and summaries of made-up grips with known answers; no model."""

import numpy as np
import pytest

from fingerdesign.control.episode import Episode
from fingerdesign.control.metrics import (
    outcome,
    reaction_steps,
)
from fingerdesign.records.result import GripResult
from fingerdesign.trials.record import Share, share_of, spread_of, summarise
from tests.support.grips import judged, path_of

WEIGHT = 0.5e-3 * 9.80665 * 200.0


def trace(approach, lift=None):
    """A grip whose normal force is ten times its approach, at mu = 0.5 with 200 g."""
    approach = np.asarray(approach, dtype=float)
    return path_of(10.0 * approach, np.full(len(approach), WEIGHT), approach, 0.5, 200.0, lift)


def episode(made, ending="lifted", slip=False, preload=2):
    lifted = made.lift_step is not None
    margin = 0.5 * made.normal_force[made.lift_step] / WEIGHT if lifted else None
    result = GripResult(
        controller="made up",
        friction_coefficient=0.5,
        object_mass_g=200.0,
        lifted=lifted,
        gross_slip=slip,
        final_normal_force_N=float(made.normal_force[-1]),
        final_tangential_force_N=WEIGHT,
        safety_margin=margin,
        minimum_stick_ratio=0.6,
        peak_normal_force_N=float(made.normal_force.max()),
        slip_distance_mm=0.01,
        steps=len(made.approach) - preload,
        holds=0,
        ending="a sentence",
    )
    return Episode(result, made, ending, "a sentence")


def test_a_judged_grip_reports_margins_in_units_of_the_least_force():
    made = trace([0.1, 0.2, 0.25, 0.26, 0.3], lift=3)
    found = outcome(episode(made), noise=0.5, seed=7)
    assert found.margin_at_lift == pytest.approx(2.6 / (WEIGHT / 0.5))
    assert found.peak_ratio == pytest.approx(3.0 / (WEIGHT / 0.5))
    assert (found.noise, found.seed, found.reason) == (0.5, 7, "a sentence")
    assert found.steps == 2  # of the controller's, to the lift
    assert (found.held, found.crushed, found.success) == (True, False, True)


@pytest.mark.parametrize(
    ("change", "held", "success"),
    [
        ({}, True, True),
        ({"dropped": True, "ending": "complete slip"}, False, False),
        ({"peak_ratio": 3.0}, True, False),
        ({"lifted": False, "ending": "stage travel"}, False, False),
        ({"ending": "failed"}, False, False),
    ],
)
def test_success_is_lifted_held_and_not_crushed(change, held, success):
    changed = judged(**change)
    assert (changed.held, changed.success) == (held, success)


def test_reaction_counts_from_the_tug_to_the_first_answer():
    still = [0.1, 0.2] + [0.25] * 10
    made = trace([*still, 0.25, 0.26, 0.27], lift=3)
    # The tug is felt at step 9; steps 10 to 12 do nothing, 13 closes.
    assert reaction_steps(made, 9, 0.005) == 4
    assert reaction_steps(made, 9, 0.015) == 5
    assert reaction_steps(made, 9, 0.05) is None
    assert reaction_steps(made, 99, 0.005) is None
    assert reaction_steps(trace(still), 9, 0.005) is None


def test_a_hand_that_closes_anyway_has_not_answered():
    creeping = trace(0.1 + 0.001 * np.arange(40), lift=5)
    assert reaction_steps(creeping, 20, 0.002) is None
    faster = np.concatenate([0.001 * np.arange(22), 0.021 + 0.003 * np.arange(1, 19)])
    assert reaction_steps(trace(0.1 + faster, lift=5), 20, 0.0035) == 3


def test_wilson_is_scipys():
    from scipy.stats import binomtest

    for count, of in [(0, 10), (1, 10), (5, 10), (99, 100), (100, 100), (499, 500)]:
        theirs = binomtest(count, of).proportion_ci(0.95, "wilson")
        own = share_of(count, of)
        assert (own.low, own.high) == pytest.approx((theirs.low, theirs.high), abs=1e-7)


def test_nothing_gives_no_rate_and_no_spread():
    assert share_of(0, 0) == Share(0, 0, None, None, None)
    assert spread_of([None]) is None
    empty = summarise([])
    assert (empty.grips, empty.success.rate, empty.margin_at_lift) == (0, None, None)


def test_a_summary_counts_each_reason():
    every = [
        judged(),
        judged(margin_at_lift=1.5),
        judged(dropped=True, ending="complete slip"),
        judged(peak_ratio=4.0, tug=0.3, reaction_steps=6),
        judged(lifted=False, margin_at_lift=None, ending="failed"),
        judged(lifted=True, tug=0.3),
    ]
    reported = summarise(every)
    assert (reported.grips, reported.success.count, reported.held.count) == (6, 3, 4)
    others = reported.dropped, reported.crushed, reported.not_lifted, reported.failed
    assert others == (1, 1, 1, 1)
    assert reported.margin_at_lift.count == 5
    assert reported.margin_at_lift.most == 1.5
    assert (reported.answered.count, reported.answered.of) == (1, 2)
    assert reported.reaction_steps.median == 6
