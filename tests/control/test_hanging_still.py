"""A hand that only raises what hangs: nothing is solved, and the answer is that of solving."""

import numpy as np
import pytest

from fingerdesign.control.plants.lift import Disturbance, LiftPlant

LIFT = [(0.0, 0.02)] * 5 + [(0.01, 0.0)] * 30
MASS = 60.0


@pytest.fixture
def hanging(half_plane):
    def make():
        tug = Disturbance(40, 0.1, 3)
        plant = LiftPlant(half_plane, "upper", MASS, disturbances=[tug])
        for move in LIFT:
            plant.move(*move)
        assert plant.truth().lifted
        return plant

    return make


def test_raising_changes_the_height_alone(hanging):
    still, solved = hanging(), hanging()
    for _ in range(3):
        before = still.truth()
        sample = still.move(0.02, 0.0)
        other = solved.move(0.02, 1e-13)  # not quite nothing: solved anew
        assert still.truth().rise == pytest.approx(before.rise + 0.02)
        assert sample.readings == pytest.approx(other.readings, abs=1e-6)
        reported, anew = still.truth(), solved.truth()
        assert reported.normal_force == pytest.approx(anew.normal_force, rel=1e-9)
        assert reported.stick_ratio == pytest.approx(anew.stick_ratio, abs=1e-6)
        assert reported.rise == pytest.approx(anew.rise, abs=1e-6)


def test_a_tug_and_a_landing_are_still_felt(hanging):
    plant = hanging()
    forces = np.array([plant.move(0.01, 0.0).tangential_force for _ in range(30)])
    assert np.ptp(forces) == pytest.approx(0.05, abs=1e-6)  # half of the tug each
    assert plant.move(-plant.truth().rise - 0.01, 0.0).lifted is False
