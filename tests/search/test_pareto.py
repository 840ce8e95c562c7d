"""Dominance and hypervolume, against answers known by hand and by counting."""

import numpy as np
import pytest

from fingerdesign.search.optimise.confirm import beats, hypervolume, most_volume


def test_dominance():
    own = np.array([1.0, 2.0])
    assert beats(own, np.array([1.0, 3.0]))
    assert not beats(own, own)
    assert not beats(own, np.array([0.5, 3.0]))


def test_volume_of_one_and_of_what_adds_nothing():
    corner = np.array([2.0, 3.0, 4.0])
    one = np.array([[1.0, 1.0, 1.0]])
    assert hypervolume(one, corner) == pytest.approx(6.0)
    worse = np.array([[1.0, 1.0, 1.0], [1.5, 1.0, 1.0], [1.0, 1.0, 1.0], [0.0, 0.0, 4.0]])
    assert hypervolume(worse, corner) == pytest.approx(6.0)
    assert hypervolume(np.empty((0, 3)), corner) == 0.0


@pytest.mark.parametrize("objectives", [2, 3, 4])
def test_volume_is_the_share_of_points_dominated(objectives):
    rng = np.random.default_rng(objectives)
    points = rng.uniform(size=(12, objectives))
    probes = rng.uniform(size=(40_000, objectives))
    hit = (points[None] <= probes[:, None]).all(axis=2).any(axis=1).mean()
    # Three standard deviations of a count.
    assert hypervolume(points, np.ones(objectives)) == pytest.approx(hit, abs=0.0075)


def test_most_volume_spreads_and_stops():
    front = np.array([[0.0, 0.9], [0.4, 0.4], [0.42, 0.38], [0.9, 0.0]])
    corner = np.array([1.0, 1.0])
    assert most_volume(front, corner, 1) in ((1,), (2,))
    taken = most_volume(front, corner, 3)
    assert {0, 3} < set(taken)
    beyond = np.array([[0.5, 0.5], [2.0, 2.0]])
    assert most_volume(beyond, corner, 2) == (0,)
