"""Fingers that warm: a surface that rises, gages that shift, a hold that presses harder."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.contact.memory import Rubber
from fingerdesign.control.plants.fingers import Warming
from fingerdesign.control.plants.lift import LiftPlant, Timed
from fingerdesign.control.plants.plant import CondensedPlant

RATE = 100.0
RISE = 1e-3  # mm per kelvin
WARMING = Warming(8.0, 0.5, RATE)


@pytest.fixture(scope="module")
def rising(half_plane):
    """A finger whose whole surface rises with the temperature, and whose gages shift."""
    model = half_plane.model
    moved = np.zeros(model.points.shape)
    moved[:, 1] = RISE
    plates = len(model.gage_x)
    alone = 1e-6 * np.arange(2.0 * plates).reshape(plates, 2)
    modes = half_plane.modes.copy()
    modes[4] = np.einsum("mab,mb->ma", half_plane.frames, moved)
    model = replace(model, load_displacement=moved, load_gage_strain=alone)
    return replace(half_plane, model=model, modes=modes)


def test_the_temperature_comes_with_its_time():
    assert WARMING.after(0) == 0.0
    assert WARMING.after(50) == pytest.approx(8.0 * (1.0 - np.exp(-1.0)))
    assert WARMING.after(10**6) == pytest.approx(8.0)


@pytest.mark.parametrize("unlike", [False, True])
def test_what_warms_presses_as_what_closes_on(rising, unlike):
    """A surface that rises evenly is one that is closed on by as much, friction and all."""
    other = rising if unlike else None
    plant = LiftPlant(rising, "upper", 1e4, other, timed=Timed(warming=WARMING))
    stage, risen = CondensedPlant(rising, "upper"), 0.0
    moves = [(0.0, 0.02)] * 5 + [(0.004, 0.0)] * 20 + [(0.0, 0.0)] * 100
    for number, (dx, dy) in enumerate(moves, 1):
        rise = RISE * WARMING.after(number)
        felt, expected = plant.move(dx, dy), stage.move(dx, dy + rise - risen)
        risen = rise
        assert felt.normal_force == pytest.approx(expected.normal_force, rel=1e-7)
        assert felt.tangential_force == pytest.approx(expected.tangential_force, rel=1e-7, abs=1e-9)
        shift = 1e6 * WARMING.after(number) * rising.model.load_gage_strain[:, 0]
        assert felt.readings == pytest.approx(expected.readings + shift, rel=1e-7, abs=1e-9)
    assert risen > 0.9 * 8.0 * RISE


def test_rubber_with_a_memory_warms_too(rising):
    """Held still, a finger that warms far more slowly than it relaxes presses as if closed on."""
    rubber, slow = Rubber((0.3,), (0.05,), 1.0 / RATE), Warming(8.0, 5.0, RATE)
    plant = LiftPlant(rising, "upper", 1e4, timed=Timed(rubber=rubber, warming=slow))
    closed = LiftPlant(rising, "upper", 1e4, timed=Timed(rubber=rubber))
    risen = 0.0
    for number in range(1, 400):
        rise = RISE * slow.after(number)
        dy = 0.05 if number == 1 else 0.0
        felt, expected = plant.move(0.0, dy), closed.move(0.0, dy + rise - risen)
        risen = rise
        assert felt.normal_force == pytest.approx(expected.normal_force, rel=1e-7)
