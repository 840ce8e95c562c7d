"""Estimator files of former formats: real files, written by the code that had them, answer alike.

former/: files of a random network of three gages, and the answers that the code of their time gave
on the histories below, at two noises and after 1, 4, 9 and 20 steps.
"""

import json
from pathlib import Path

import numpy as np
import pytest

from fingerdesign.control.estimator import EstimatorError, GripEstimator
from fingerdesign.control.features import Moment
from fingerdesign.control.signals import Sample

FORMER = Path(__file__).parent / "former"


def histories():
    rng = np.random.default_rng(100)
    for _ in range(12):
        found, normal, tangential = [], 0.8, 0.0
        for k in range(20):
            dx, dy = (0.0, 0.003) if k < 6 else (0.004, 0.001)
            normal += 0.05 + 0.02 * rng.random()
            tangential += (0.06 if k >= 6 else 0.0) * (1 + 0.3 * rng.random())
            readings = rng.normal(size=3) * 0.4 + np.array([1.0, 2.0, 3.0]) * normal
            found.append(Moment(Sample(readings + 10 * tangential, normal, tangential), dx, dy))
        yield found


@pytest.mark.parametrize("number", [3, 4, 5, 6, 7])
def test_a_former_file_answers_as_its_own_version_did(number):
    text = (FORMER / f"estimator_{number}.json").read_text("utf-8")
    estimator = GripEstimator.from_json(text)
    found = []
    for history in histories():
        for noise in (0.5, 5.0):
            for steps in (1, 4, 9, 20):
                reported = estimator.at_noise(noise).estimate(history[:steps])
                found.append([reported.stick_ratio, reported.friction_utilisation, reported.std])
    answers = np.array(json.loads((FORMER / f"answers_{number}.json").read_text("utf-8")))
    assert answers.std(axis=0).min() > 0.01  # they tell something
    np.testing.assert_allclose(found, answers, rtol=0.0, atol=1e-9)
    again = GripEstimator.from_json(estimator.to_json())
    last = estimator.estimate(history)
    # Its weights are rounded to 16 bits, as those of any file.
    assert again.estimate(history).friction_utilisation == pytest.approx(
        last.friction_utilisation, abs=1e-3
    )


def test_a_format_that_holds_too_little_says_what_and_how_to_train_again():
    text = (FORMER / "estimator_2.json").read_text("utf-8")
    with pytest.raises(EstimatorError, match=r"neither approach nor stiffness.*train DESIGN"):
        GripEstimator.from_json(text)


@pytest.mark.parametrize("name", ["fingerdesign grip estimator, 9", "another 3", "5", "", None, []])
def test_a_format_that_is_not_known_is_named(name):
    record = json.loads((FORMER / "estimator_3.json").read_text("utf-8"))
    with pytest.raises(EstimatorError, match="its format is not"):
        GripEstimator.from_json(json.dumps(record | {"format": name}))


@pytest.mark.parametrize(
    "wrong",
    [
        {"curves": {"pressed_microstrain": []}},
        {"curves": {"pressed_microstrain": [[]]}},
        {"bands": [{}]},
        {"bands": [{"layers": []}]},
        {"bands": None},
        {"lags": [1, 2, 3]},
    ],
)
def test_a_former_file_that_is_broken_is_refused(wrong):
    record = json.loads((FORMER / "estimator_3.json").read_text("utf-8"))
    with pytest.raises(EstimatorError):
        GripEstimator.from_json(json.dumps(record | wrong))
