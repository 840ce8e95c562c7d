"""Advice follows the numbers, whatever they are."""

import numpy as np
import pytest

from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.validate.advice import advise, worst_of
from fingerdesign.validate.comparison import Answer, Comparison, side_of


def answer(forces=1.0, stick=0.0, gages=1.0, seconds=1.0):
    base = np.array([1.0, 2.0])
    readings = Readings(
        forces * base,
        0.1 * forces * base,
        base,
        np.array([0.9, 0.5]) + stick,
        gages * np.array([[[10.0, 10.0]], [[20.0, 20.0]]]),
    )
    return Answer("a model", readings, (), seconds, 100, 3)


def comparison(seconds=1.0, better_seconds=12.0, **off):
    found, truth = answer(seconds=seconds, **off), answer(seconds=better_seconds)
    side = side_of(found.readings, truth.readings)
    return Comparison("test", found, truth, side, side)


def test_small_errors_are_kept_with_their_saving():
    verdict, sentence = advise("model", [comparison(forces=1.003)])
    assert verdict == "keep"
    assert sentence.startswith("Keep: it costs 0.3 % at the most (F_n, equal motion)")
    assert "saves a factor 12 (1 s instead of 12 s)." in sentence


def test_what_costs_nothing_is_kept():
    verdict, sentence = advise("model", [comparison()])
    assert verdict == "keep"
    assert "below 0.01 %" in sentence


def test_large_errors_everywhere_are_dropped():
    verdict, sentence = advise("model", [comparison(forces=1.5, stick=0.3, gages=2.0)])
    assert verdict == "drop"
    assert sentence.startswith("Drop it: F_n 50 %")
    assert "gage strain 100 %" in sentence


def test_groups_are_distinguished():
    verdict, sentence = advise("model", [comparison(stick=0.05, gages=1.4)])
    assert verdict == "limited"
    assert "Keep for forces" in sentence
    assert "keep for contact where stick ratio 5 %" in sentence
    assert "drop it for gages (gage strain 40 %" in sentence


@pytest.mark.parametrize(("better", "words"), [(1.1, "saves nothing"), (30.0, "a factor 30")])
def test_the_saving_is_what_was_measured(better, words):
    _, sentence = advise("model", [comparison(better_seconds=better)])
    assert words in sentence


def test_a_value_is_measured_or_not():
    verdict, sentence = advise("value", [comparison(forces=1.2)])
    assert verdict == "measure"
    assert sentence.startswith("Measure it before trusting forces (F_n 20 %")
    assert advise("value", [comparison(forces=1.001)])[0] == "keep"


def test_where_it_does_not_matter_is_reported():
    off, same = comparison(gages=1.3), comparison()
    _, sentence = advise(
        "value", [Comparison("x", off.assumed, off.better, off.motion, same.force)]
    )
    assert "where the force is given, it hardly moves the gages" in sentence


def test_the_worst_of_several_comparisons_counts():
    worst = {each.group: each for each in worst_of([comparison(), comparison(gages=3.0)])}
    assert worst["gages"].error == pytest.approx(2.0)
    assert worst["forces"].error == 0.0


@pytest.mark.parametrize(("gages", "wanted"), [(1.01, "keep"), (1.06, "limited"), (0.5, "drop")])
def test_a_reading_is_reported_of_its_gages_alone(gages, wanted):
    verdict, sentence = advise("reading", [comparison(gages=gages)])
    assert verdict == wanted
    assert f"up to {100 * abs(gages - 1):.0f} %" in sentence
    assert "F_n" not in sentence


def test_nothing_compared_is_no_advice():
    with pytest.raises(ValueError, match="nothing was compared"):
        advise("model", [])
