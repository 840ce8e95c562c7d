"""Front and recommended finger, on outcomes whose answer is known by hand."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.records.outcome import Outcome
from fingerdesign.search.compare.recommend import Bound, Wanted, dominated, recommend, why_not
from tests.support.any_outcomes import any_outcomes

LEAST_ERROR, LEAST_COST = Wanted("stick_error", "min"), Wanted("cost", "min")
MOST_MARGIN = Wanted("safety_margin", "max")


def outcome(name, **metrics):
    kept = {"digest": name, "values": {}, "design": {}, "scene": "s", "fidelity": "plane-strain"}
    return Outcome(name=name, **kept, status="ok", metrics=metrics)


def test_knee_of_a_front():
    found = recommend(
        [
            outcome("accurate", stick_error=0.0, cost=10.0),
            outcome("knee", stick_error=0.2, cost=2.0),
            outcome("cheap", stick_error=1.0, cost=0.0),
            outcome("worse than knee", stick_error=0.3, cost=2.0),
        ],
        [LEAST_ERROR, LEAST_COST],
        [],
    )
    assert found.front == (0, 1, 2)
    assert found.chosen == 1
    assert found.best == (0, 2)


def test_goals_turn_round():
    both = [outcome("low", safety_margin=1.0), outcome("high", safety_margin=2.0)]
    assert recommend(both, [MOST_MARGIN], []).chosen == 1
    assert recommend(both, [Wanted("safety_margin", "min")], []).chosen == 0


def test_constraints_missing_values_and_failures_leave_the_race():
    good = outcome("good", stick_error=0.5, cost=5.0)
    dear = outcome("dear", stick_error=0.1, cost=50.0)
    silent = outcome("silent", stick_error=None, cost=1.0)
    failed = replace(outcome("failed", stick_error=0.0, cost=0.0), status="failed")
    bound = Bound("cost", at_most=10.0)
    found = recommend([dear, silent, failed, good], [LEAST_ERROR, LEAST_COST], [bound])
    assert found.feasible == (3,)
    assert found.chosen == 3


def test_three_d_is_chosen_among_where_there_is_a_choice():
    shallow = [outcome(f"p{i}", cost=float(i)) for i in range(5)]
    deep = [replace(outcome(f"d{i}", cost=10.0 + i), fidelity="3d") for i in range(2)]
    found = recommend([*shallow, *deep], [LEAST_COST], [])
    assert (found.fidelity, found.chosen, found.group) == ("3d", 5, (5, 6))
    assert recommend([*shallow, deep[0]], [LEAST_COST], []).chosen == 0


def test_a_tie_is_reported_and_broken_by_the_range_of_all():
    pair = [outcome("a", stick_error=0.2, cost=1.0), outcome("b", stick_error=0.1, cost=9.0)]
    rest = [outcome("c", stick_error=0.21, cost=10.0)]  # widens costs more than errors
    found = recommend([*pair, *rest], [LEAST_ERROR, LEAST_COST], [])
    assert (found.front, found.chosen, found.alike) == ((0, 1), 1, (0,))


def test_nothing_to_recommend():
    assert recommend([], [LEAST_COST], []).chosen is None
    assert recommend([outcome("a", cost=1.0)], [], []).chosen is None
    assert recommend([outcome("a", cost=1.0)], [MOST_MARGIN], []).chosen is None


def test_equal_designs_are_all_on_the_front():
    found = recommend([outcome("a", cost=1.0), outcome("b", cost=1.0)], [LEAST_COST], [])
    assert (found.front, found.chosen) == ((0, 1), 0)


@pytest.mark.parametrize("seed", range(3))
def test_front_is_what_the_definition_says(seed):
    made = any_outcomes(60, seed)
    found = recommend(made, [LEAST_ERROR, LEAST_COST, MOST_MARGIN], [])

    def beats(p, q):
        a, b = made[p].metrics, made[q].metrics
        pairs = [(a["stick_error"], b["stick_error"]), (a["cost"], b["cost"])]
        pairs.append((-a["safety_margin"], -b["safety_margin"]))
        return all(x <= y for x, y in pairs) and any(x < y for x, y in pairs)

    for number in found.group:
        alone = not any(beats(other, number) for other in found.group)
        assert alone == (number in found.front)


def test_dominated_of_none():
    assert dominated(np.zeros((0, 2))).tolist() == []


def test_runner_up_is_the_next_of_the_front():
    knee = [
        outcome("accurate", stick_error=0.0, cost=10.0),
        outcome("knee", stick_error=0.2, cost=2.0),
        outcome("next", stick_error=0.3, cost=1.9),
        outcome("cheap", stick_error=1.0, cost=0.0),
    ]
    assert recommend(knee, [LEAST_ERROR, LEAST_COST], []).runner_up == 2
    # Where one beats all, the nearest of those beaten; of one alone, none.
    assert recommend(knee, [LEAST_COST], []).runner_up == 2
    assert recommend(knee[:1], [LEAST_COST], []).runner_up is None


def test_why_one_is_not_feasible():
    bounds = (Bound("cost", at_most=10.0), Bound("safety_margin", at_least=1.2))
    dear = outcome("dear", cost=12.5, safety_margin=1.0)
    assert why_not(dear, [LEAST_ERROR], bounds) == (
        "no stick_error, an objective",
        "cost 12.5, asked is at most 10 (off by 2.5)",
        "safety_margin 1, asked is at least 1.2 (off by 0.2)",
    )
    assert why_not(outcome("good", cost=1.0, safety_margin=2.0), [LEAST_COST], bounds) == ()
    assert "no cost" in why_not(outcome("dumb", safety_margin=2.0), [], bounds)[0]
