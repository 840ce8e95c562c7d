"""The hand of a finger: its travel, and the search for values of the rule that lift gently."""

import math
from dataclasses import replace

import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.records.outcome import Traces
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.hands import BATCH, MOST_HANDS, STEP_FACTORS, hand_of, with_travel
from tests.support.passing import outcome


def test_travel_presses_with_twice_the_least_force():
    design = load_design("maeno2000")
    found = with_travel(design, outcome(design, 0.0))
    force = 300.0 * found.grip.max_approach_mm**1.5
    least = 0.5e-3 * 9.80665 * 500.0 / min(design.grip.friction_coefficients)
    assert force == pytest.approx(2.0 * least, rel=0.01)


def test_the_travel_follows_the_ends_of_the_path_and_ends_within_the_finger():
    """As the square of the approach from the first load to the last; 24.5 N is twice the least."""
    design = load_design("maeno2000")

    def travelled(loads, keep=""):
        traces = Traces(approach_mm=(0.0, 0.05, 0.1, 0.2), normal_force_N=loads)
        sensed = replace(outcome(design, 0.0), traces=traces)
        return with_travel(design, sensed, Freedom(keep=(keep,)).allows).grip

    found = travelled((0.0, 1.0, 9.0, 16.0))
    travel = pytest.approx(0.2 * (24.516625 / 16.0) ** 0.5, rel=5e-3)
    steps = 75 * found.approach_step_mm, 10 * found.shear_step_mm, 10 * found.preload_mm
    assert [found.max_approach_mm, *steps] == [travel] * 4
    soft = travelled((0.0, 0.001, 0.002, 0.004), "grip.preload_mm")
    assert soft.max_approach_mm == pytest.approx(0.25 * 8.24, abs=0.01)  # A quarter of its height.
    assert soft.preload_mm == design.grip.preload_mm
    for loads in ((0.0, 0.0, 0.0, 1.0), (0.0, 2.0, 2.0, 2.0)):
        assert travelled(loads) == design.grip


def tried_by(design):
    tried = []

    def judge(designs):
        tried.extend(each.grip for each in designs)
        return [outcome(each, 0.0) for each in designs]

    return hand_of(design, judge, lambda count: None), tried


def test_the_first_hands_have_forces_in_proportion_to_the_weight():
    """Of 1 to 4 kg the middle is 2 kg, four times that of the feeler."""
    design, known = load_design("maeno2000"), load_design("feeler").grip
    first = tried_by(with_values(design, {"grip.object_mass_g": [1000.0, 4000.0]}))[1][0]
    powers = {"force_floor_N": 1, "hold_force_N": 1, "curve_per_N": -1, "threshold_share": 0}
    for key, power in powers.items():
        assert getattr(first, key) == pytest.approx(4.0**power * getattr(known, key), rel=5e-3)
    for name in ("paper", "fixed_force"):  # Another rule has none of these values.
        own = with_values(design, {"grip.dead_band_mm": 0.77, "grip.controller": name})
        hand, tried = tried_by(own)
        assert 0.77 in {each.dead_band_mm for each in tried}
        assert bool(hand.values) is (name == "paper")


def test_a_hand_is_lifted_between_the_frictions_too_and_both_its_steps_vary():
    design = with_values(load_design("maeno2000"), {"grip.friction_coefficients": [0.2, 0.8]})
    tried, own = tried_by(design)[1], design.grip
    assert {each.friction_coefficients for each in tried} == {(0.2, 0.4, 0.8)}
    steps = sorted({(each.approach_step_mm, each.shear_step_mm) for each in tried})
    by = [(one / own.approach_step_mm, two / own.shear_step_mm) for one, two in steps]
    assert by == [pytest.approx((each, each)) for each in (0.95, 0.975, 1.0, 1.025, 1.05)]


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
