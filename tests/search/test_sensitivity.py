"""What an objective hangs on, where it is known because the objective is a formula."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.records.outcome import Outcome
from fingerdesign.search.optimise.sensitivity import WEAK, sensitivities
from fingerdesign.search.study.file import parse_study

STUDY = parse_study(
    """
study = { name = "s", base = "maeno2000", count = 8, seed = 4 }
objectives = [{ metric = "cost" }, { metric = "stick_error" }, { metric = "plates" }]
[parameters]
"body.arc_radius_mm" = { low = 20.0, high = 60.0 }
"plates.length_mm" = { low = 0.6, high = 1.2 }
"plates.material" = ["phosphor_bronze", "polyimide"]
"""
)


def outcomes(count, seed=0):
    rng = np.random.default_rng(seed)
    found = []
    for number in range(count):
        radius, length = rng.uniform(20.0, 60.0), rng.uniform(0.6, 1.2)
        material = ("phosphor_bronze", "polyimide")[rng.integers(2)]
        metrics = {
            "cost": -radius + (8.0 if material == "polyimide" else 0.0),
            "stick_error": float(rng.uniform()),
            "plates": 15.0,
        }
        values = {
            "body.arc_radius_mm": radius,
            "plates.length_mm": length,
            "plates.material": material,
        }
        kept = {"digest": "d", "design": {}, "scene": "s", "fidelity": "plane-strain"}
        found.append(Outcome(name=str(number), values=values, **kept, status="ok", metrics=metrics))
    return found


def test_what_decides_comes_first_and_which_way():
    cost, noise, same = sensitivities(STUDY, outcomes(100))
    first, second, third = cost.effects
    names = [effect.parameter for effect in cost.effects]
    assert names == ["body.arc_radius_mm", "plates.material", "plates.length_mm"]
    assert first.direction == pytest.approx(-1.0, abs=0.1)
    assert second.direction is None  # materials have no order
    assert 1.05 > first.share > 0.7 > second.share > third.share
    assert abs(third.share) < 0.05
    assert cost.explained is not None
    assert cost.explained > 0.9
    assert noise.explained is not None
    assert noise.explained < WEAK
    assert "hints" in noise.words
    assert same.explained is None
    assert same.effects == ()


def test_same_seed_same_shares_and_few_trials_tell_nothing():
    first, again = (sensitivities(STUDY, outcomes(40), ["cost"]) for _ in range(2))
    assert first == again
    (few,) = sensitivities(STUDY, outcomes(10), ["cost"])
    assert few.explained is None
    assert "nothing" in few.words


@pytest.mark.parametrize(
    ("weights", "shares"), [((1.0, 0.0), (1.0, 0.0)), ((2.0, -1.0), (0.8, 0.2))]
)
def test_shares_of_a_sum_are_those_of_its_variance(weights, shares):
    rng = np.random.default_rng(1)
    found = []
    for each in outcomes(400):
        radius, length = rng.uniform(size=2)
        values = each.values | {
            "body.arc_radius_mm": 20.0 + 40.0 * radius,
            "plates.length_mm": 0.6 + 0.6 * length,
        }
        cost = float(weights[0] * radius + weights[1] * length)
        found.append(replace(each, values=values, metrics={"cost": cost}))
    (cost,) = sensitivities(STUDY, found, ["cost"])
    by_key = {effect.parameter: effect.share for effect in cost.effects}
    for key, share in zip(("body.arc_radius_mm", "plates.length_mm"), shares, strict=True):
        assert by_key[key] == pytest.approx(share, abs=0.08)
    assert by_key["plates.material"] == pytest.approx(0.0, abs=0.03)
