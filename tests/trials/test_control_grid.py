"""The grid's axes, its seeds and its tug."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.control.plants.lift import LiftPlant
from fingerdesign.design.grip import GRAVITY
from fingerdesign.errors import DesignError
from fingerdesign.trials.bench import Cell, ControlGrid, Tug, refuse, seed_of


def test_the_standard_grid_is_the_issues():
    grid = ControlGrid()
    assert (len(grid.frictions), len(grid.masses_g)) == (10, 10)
    assert (grid.frictions[0], grid.frictions[-1]) == (0.2, 0.8)
    assert (grid.masses_g[0], grid.masses_g[-1]) == (100.0, 1000.0)
    assert {0.5, 1.0, 2.0, 5.0, 10.0} <= set(grid.noises)
    cells = [cell for batch in grid.batches(["a", "b"]) for cell in batch]
    assert len(set(cells)) == len(cells) == 2 * grid.cells_of_one
    assert sum(cell.tug > 0.0 for cell in cells) == 2 * 100
    assert grid.faults() == []


def test_a_batch_is_one_object_at_all_noises():
    grid = ControlGrid.quick()
    batch = next(grid.batches(["paper"]))
    assert len({(cell.friction, cell.mass_g) for cell in batch}) == 1
    assert [cell.noise for cell in batch if not cell.tug] == list(grid.noises)
    assert [cell.noise for cell in batch if cell.tug] == [grid.tug_noise]
    bare = replace(grid, tug=None)
    assert bare.cells_of_one == 4 * 4 * 3


def test_seeds_are_of_the_conditions_and_the_same_for_all_controllers():
    cell = Cell("paper", 0.3, 200.0, 0.5)
    assert seed_of(cell, 0) == seed_of(replace(cell, controller="reactive"), 0)
    others = [
        replace(cell, friction=0.31),
        replace(cell, mass_g=201.0),
        replace(cell, noise=1.0),
    ]
    assert len({seed_of(each, 0) for each in [cell, *others]} | {seed_of(cell, 1)}) == 5
    assert seed_of(cell, 0) == seed_of(replace(cell, tug=0.3), 0)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"frictions": (0.0,)}, "--friction = 0.0: must be over 0 and at most 5"),
        ({"masses_g": (100.0, -1.0)}, "--mass-g = -1.0"),
        ({"noises": (float("nan"),)}, "--noise = nan"),
        ({"noises": (0.5, 0.5)}, "given once"),
        ({"seed": -1}, "--seed = -1"),
        (
            {"frictions": tuple(np.linspace(0.1, 1.0, 400)), "masses_g": tuple(range(1, 401))},
            "at most 100000 grips",
        ),
    ],
)
def test_a_wrong_axis_is_refused_by_its_option(change, said):
    with pytest.raises(DesignError, match=said):
        refuse(replace(ControlGrid(), **change), ())


def test_a_tug_rises_stays_and_goes(half_plane_problem):
    tug, rate, begin = Tug(0.3, rise_s=0.1, stay_s=0.2, after_s=0.05), 100.0, 6
    pulls = tug.pulls(400.0, begin, rate)
    plant = LiftPlant(half_plane_problem, "upper", 400.0, disturbances=pulls)
    weight = 0.4 * GRAVITY
    steps = range(begin + tug.steps(rate))
    pull = np.array([plant.weight(step) / weight - 1.0 for step in steps])
    assert np.abs(pull[:begin]).max() < 1e-12
    assert pull[begin : begin + 10] == pytest.approx(0.03 * np.arange(1, 11))
    assert pull[begin + 10 : begin + 30] == pytest.approx(0.3)
    assert np.abs(pull[begin + 30 :]).max() < 1e-12
    assert len(pull[begin + 30 :]) == 5
