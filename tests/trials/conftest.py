"""The closed-form finger as a design of eleven plates, and its bench."""

import pytest

from fingerdesign import parse_design
from fingerdesign.trials.bench import GripBench
from fingerdesign.trials.grid import ControlGrid, Tug
from tests.support.fingers import COARSE

DESIGN = """[design]
name = "half-plane"
[plates]
count = 11
[grip]
defaults = "fixed"
preload_mm = 0.03
approach_step_mm = 0.01
max_approach_mm = 0.25
max_steps = 120
"""
GRID = ControlGrid((0.4, 0.6), (150.0, 300.0), (0.0, 1.0), tug=Tug(stay_s=0.1), hold_s=0.05)


@pytest.fixture(scope="module")
def design():
    return parse_design(DESIGN)


@pytest.fixture(scope="module")
def bench(half_plane, design):
    plates = tuple(range(11))
    return GripBench(half_plane, "both", plates, design.grip, GRID)


@pytest.fixture(scope="session")
def coarse():
    """A finger of five plates whose section is meshed coarsely."""
    return parse_design(COARSE)


@pytest.fixture
def coarse_file(tmp_path):
    path = tmp_path / "coarse.toml"
    path.write_text(COARSE, encoding="utf-8")
    return path
