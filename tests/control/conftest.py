"""The closed-form finger's bench."""

import pytest

from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.plants.plant import CondensedPlant


@pytest.fixture(scope="session")
def bench(half_plane):
    bounds = Bounds(preload=0.04, approach_step=0.01, max_approach=0.3, max_steps=40)
    return calibrate(lambda: CondensedPlant(half_plane, "both"), half_plane.model.gage_x, bounds)
