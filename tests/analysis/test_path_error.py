"""The path's share of the errors: estimated by Richardson, against ever shorter increments."""

import dataclasses

import numpy as np
import pytest

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.fidelity.estimate import (
    Estimate,
    difference,
    discretisation,
    goal_errors,
)
from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.analysis.fidelity.readings import errors as row_errors
from fingerdesign.analysis.path_error import distances, path_error
from fingerdesign.records.result import ErrorEstimate
from tests.support.path_errors import GOAL, condensed, errors, followed


@pytest.mark.parametrize("name", ["maeno2000", "narrow"])
def test_estimates_are_of_the_size_of_the_errors(name):
    """All fingers and scenes: python -m tests.support.path_errors."""
    ratios = errors(name, "", "plane-strain")
    assert len(ratios) == len(GOAL) == len(dataclasses.fields(ErrorEstimate))
    assert all(1 / 3 < ratio < 3 for ratio in ratios)


def two_rows(normal, pull, stick, reading, width=(1.0, 2.0)):
    """Readings of one gage, of which the upper face says half and the lower 1.5 times as much."""
    gages = np.outer(reading, [0.5, 1.5])[:, None]
    return Readings(*map(np.array, (normal, pull, width, stick)), gages)


TRUTH = two_rows((0.5, 100.0), (0.05, 20.0), (0.5, 0.25), (20.0, 200.0))
FOUND = two_rows((0.6, 101.0), (0.03, 19.5), (0.5, 0.3), (22.0, 190.0), (1.1, 2.0))


def test_distances_are_over_each_rows_own_or_a_hundredth_of_the_paths():
    """0.1 N of 1 N; 0.02 N of 0.2 N, a hundredth of 20 N; 2 of 20 microstrain."""
    expected = {"normal_force": 0.1, "tangential_force": 0.1, "stick_ratio": 0.05, "gages": 0.1}
    assert distances(FOUND, TRUTH) == pytest.approx(expected)
    still = two_rows((1.0, 100.0), (1e-5, 1e-5), (1.0, 1.0), (20.0, 200.0))
    moved = two_rows((1.0, 100.0), (2e-5, 1e-5), (1.0, 1.0), (20.0, 200.0))
    assert distances(moved, still)["tangential_force"] == pytest.approx(1e-5 / 0.01)


def test_errors_are_over_the_rows_force_and_the_paths_pull_and_width():
    found = row_errors(FOUND, TRUTH)
    assert found["normal_force"] == pytest.approx([0.2, 0.01])
    assert found["tangential_force"] == pytest.approx([0.001, 0.025])
    assert found["contact_width"] == pytest.approx([0.05, 0.0])
    assert found["stick_ratio"] == pytest.approx([0.0, 0.05])
    assert found["gage"][:, 0] == pytest.approx([0.1, 0.05])
    # Where hardly anything pulls, the stick ratio is none of the goals.
    unpulled = two_rows((0.5, 100.0), (0.019, 20.0), (0.9, 0.25), (20.0, 200.0))
    assert goal_errors(FOUND, unpulled)["stick_ratio"] == pytest.approx([0.05])
    twice = FOUND.times(2.0)
    assert twice.reading[:, 0] == pytest.approx([44.0, 380.0])
    assert (twice.stick_ratio.tolist(), twice.contact_width.tolist()) == ([0.5, 0.3], [1.1, 2.0])


def test_estimates_add_up_and_shrink_by_their_orders():
    """F_n and gages by the first power of the size, F_t and stick ratio by the second."""
    apart = difference(FOUND, TRUTH).by_quantity
    for name, share in {"normal_force": 1.0, "tangential_force": 3.0, "gage": 1.0}.items():
        left = discretisation(TRUTH, FOUND, 2.0).by_quantity[name]  # of the finer one, TRUTH
        assert left == pytest.approx(apart[name] / share)
    assert apart["normal_force"] == pytest.approx(0.01 + 0.95 * 0.19)  # that of 95 of 100
    one = Estimate({"normal_force": 0.4, "stick_ratio": 0.4})
    assert one.refined(2.0).by_quantity == {"normal_force": 0.2, "stick_ratio": 0.1}
    both = one.plus(Estimate({"stick_ratio": 0.1, "gage": 0.3}))
    assert both.by_quantity == {"normal_force": 0.4, "stick_ratio": 0.5, "gage": 0.3}
    assert (both.worst, both.worst_quantity) == (0.5, "stick_ratio")


def test_more_increments_have_smaller_estimates():
    scene = fundamental_scene()
    problem = condensed("narrow", scene, "plane-strain")
    found = []
    for substeps in (1, 2, 5, 16):
        path = scene.path.model_copy(update={"substeps": substeps})
        steps, _ = followed(problem, scene, substeps)
        found.append(path_error(problem, path, "both", steps))
    forces = [each.tangential_force for each in found]
    assert forces == sorted(forces, reverse=True)
    # One increment a row: 3.8 % against 256.
    assert 0.019 < forces[0] < 0.076
