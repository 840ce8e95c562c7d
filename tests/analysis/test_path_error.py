"""The path's share of the errors: estimated by Richardson, against ever shorter increments."""

import dataclasses

import pytest

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.path_error import path_error
from fingerdesign.records.result import ErrorEstimate
from tests.support.path_errors import GOAL, condensed, errors, followed


@pytest.mark.parametrize("name", ["maeno2000", "narrow"])
def test_estimates_are_of_the_size_of_the_errors(name):
    """All fingers and scenes: python -m tests.support.path_errors."""
    ratios = errors(name, "", "plane-strain")
    assert len(ratios) == len(GOAL) == len(dataclasses.fields(ErrorEstimate))
    assert all(1 / 3 < ratio < 3 for ratio in ratios)


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
