"""The hand of a finger: its travel, and the search for values of the rule that lift gently."""

import math

import pytest

from fingerdesign.checks.load import load_design
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.hands import BATCH, MOST_HANDS, STEP_FACTORS, hand_of, with_travel
from tests.support.passing import outcome


def test_travel_presses_with_twice_the_least_force():
    design = load_design("maeno2000")
    found = with_travel(design, outcome(design, 0.0))
    force = 300.0 * found.grip.max_approach_mm**1.5
    least = 0.5e-3 * 9.80665 * 500.0 / min(design.grip.friction_coefficients)
    assert force == pytest.approx(2.0 * least, rel=0.01)


def test_hand_is_found_and_its_search_ends_early():
    design = load_design("maeno2000")
    judged = []

    def judge(designs):
        judged.extend(designs)
        short = [abs(math.log(each.grip.curve_per_N / 0.3)) for each in designs]
        return [
            outcome(each, s if s > 0.5 else 0.0) for each, s in zip(designs, short, strict=True)
        ]

    hand = hand_of(design, judge, lambda count: None)
    assert hand.shortfall == 0.0
    assert abs(math.log(hand.values["grip.curve_per_N"] / 0.3)) <= 0.5
    assert len(judged) < 22
    assert len(judged[0].grip.friction_coefficients) == 5  # Three of the design's, two between.


@pytest.mark.slow
def test_hand_that_passes_with_its_own_steps_alone_is_not_taken_where_another_is_steady():
    """Hands with a small dead band fail with longer steps."""
    design, counts = load_design("maeno2000"), []
    own = design.grip.approach_step_mm

    def judge(designs):
        return [outcome(g, float(longer(g) and g.grip.dead_band_mm < 0.06)) for g in designs]

    def longer(each):
        return each.grip.approach_step_mm > own

    hand = hand_of(design, judge, counts.append)
    assert hand.steady
    assert hand.values["grip.dead_band_mm"] >= 0.06
    fails = hand_of(
        design,
        lambda designs: [
            outcome(each, float(each.grip.approach_step_mm > own)) for each in designs
        ],
        counts.append,
    )
    assert fails.shortfall == 0.0
    assert fails.stepped == 1.0
    assert counts[-1] <= MOST_HANDS + BATCH


@pytest.mark.slow
def test_a_hand_that_the_widest_steps_rule_out_is_tried_with_no_others():
    """All hands are short by 1 with the widest steps: only the first is tried with the others."""
    design, factors = load_design("maeno2000"), []
    own = design.grip.approach_step_mm

    def judge(designs):
        factors.extend(each.grip.approach_step_mm / own for each in designs)
        return [outcome(each, float(each.grip.approach_step_mm != own)) for each in designs]

    hand = hand_of(design, judge, lambda count: None)
    assert (hand.shortfall, hand.stepped) == (0.0, 1.0)
    wide, narrow = (sum(map(pytest.approx(by).__eq__, factors)) for by in (1.05, 1.025))
    assert narrow == 1 < wide


def test_a_finger_whose_hands_all_fail_is_left_after_half_of_them():
    design, counts = load_design("maeno2000"), []
    hand_of(design, lambda designs: [outcome(each, 1.0) for each in designs], counts.append)
    assert MOST_HANDS // 2 <= counts[-1] < MOST_HANDS // 2 + BATCH


@pytest.mark.parametrize("keep", ["grip", "grip.curve_per_N"])
def test_keys_of_the_hand_that_are_to_stay_do_stay(keep):
    design, tried = load_design("maeno2000"), []

    def judge(designs):
        tried.extend(designs)
        return [outcome(each, 1.0) for each in designs]

    allows = Freedom(keep=(keep,)).allows
    assert with_travel(design, outcome(design, 0.0), allows).grip.curve_per_N == 0.1
    hand_of(design, judge, lambda count: None, allows)
    assert {each.grip.curve_per_N for each in tried} == {design.grip.curve_per_N}
    # A hand that is to stay is tried once, and with other steps.
    assert (len(tried) == 1 + sum(map(len, STEP_FACTORS))) == (keep == "grip")
