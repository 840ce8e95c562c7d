"""The remembering plant: the same answers, fewer moves."""

import numpy as np
import pytest

from fingerdesign.control.plants.plant import CondensedPlant, Memory, RememberedPlant

MOVES = [(0.0, 0.02), (0.0, 0.02), (0.002, 0.01), (0.004, 0.01), (0.004, 0.0)]


class Counting:
    """A plant that counts the moves of all of its kind."""

    def __init__(self, problem, count):
        self._plant = CondensedPlant(problem, "both")
        self._count = count

    def move(self, dx, dy):
        self._count.append((dx, dy))
        return self._plant.move(dx, dy)

    def truth(self):
        return self._plant.truth()


@pytest.fixture
def shared(half_plane):
    moved, memory = [], Memory()
    return moved, lambda: RememberedPlant(lambda: Counting(half_plane, moved), memory)


def test_the_same_moves_are_solved_once(half_plane, shared):
    moved, make = shared
    plain, first, second = CondensedPlant(half_plane, "both"), make(), make()
    for move in MOVES:
        expected = plain.move(*move)
        for plant in (first, second):
            sample = plant.move(*move)
            assert np.array_equal(sample.readings, expected.readings)
            assert plant.truth() == plain.truth()
    assert moved == MOVES


def test_another_move_goes_its_own_way(half_plane, shared):
    moved, make = shared
    first = make()
    for move in MOVES:
        first.move(*move)
    other = make()
    plain = CondensedPlant(half_plane, "both")
    for move in [*MOVES[:3], (0.0, 0.01), (0.001, 0.01)]:
        assert np.array_equal(other.move(*move).readings, plain.move(*move).readings)
        assert other.truth() == plain.truth()
    assert moved == [*MOVES, *MOVES[:3], (0.0, 0.01), (0.001, 0.01)]


def test_truth_is_there_before_any_move(shared):
    _, make = shared
    assert make().truth().normal_force == 0.0


def test_a_longer_grip_goes_on_from_where_the_shorter_stood(half_plane, shared):
    moved, make = shared
    for moves in (MOVES[:3], MOVES):
        plant = make()
        for move in moves:
            sample = plant.move(*move)
    assert moved == MOVES
    plain = CondensedPlant(half_plane, "both")
    *_, expected = [plain.move(*move) for move in MOVES]
    assert np.array_equal(sample.readings, expected.readings)
