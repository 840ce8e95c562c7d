"""Draws of fingers, objects and noise: each of its own stream, none of a training."""

from dataclasses import replace
from itertools import combinations

import numpy as np
import pytest
from scipy.special import ndtri

from fingerdesign.checks.load import load_design
from fingerdesign.design.grip import HardwareTable
from fingerdesign.design.scene import SceneObject
from fingerdesign.layout.rows import plate_frames
from fingerdesign.runtime.streams import stream
from fingerdesign.sensing.perturb.faults import ALL, TRAINING_FAULTS
from fingerdesign.sensing.perturb.finger import PerturbedFinger, drawn_changes, places_of
from fingerdesign.sensing.train.family import finger_seeds
from fingerdesign.trials.grid import EVERY, Cell, ControlGrid, Perturbed, seed_of

PLANTS, LIFTS = 1000, 2
# A false alarm once in so many tests of all pairs.
ALARM = 1e-3


@pytest.fixture(scope="module")
def design():
    return load_design("sensitive")


def drawn_values(design, places, grid, plant):
    """Numbers that are drawn of one plant and of its lifts, by name."""
    draw = drawn_changes(design, places, ALL, grid.plant_seed(EVERY, plant))
    own, hardware = draw.design, "grip.hardware."
    values = {key: value for key, value in own.items() if isinstance(value, float)}
    specimen = HardwareTable(
        specimen=own[f"{hardware}specimen"], gain_spread=0.03, force_gain_spread=0.01
    )
    patches = PerturbedFinger(design, SceneObject(), patches=draw.own["patches"])
    values |= {
        "dying": own[f"{hardware}dying_gages"][0],
        "tilt": draw.object.get("tilt_deg", 0.0),
        "curvature": 1.0 / draw.object.get("radius_mm", np.inf),
        "patch": patches.friction_fractions(np.zeros((1, 2)))[0],
        "gain": specimen.gains([0])[0],
        "force_gain": specimen.force_gains()[0],
        "bench": stream(grid.seed, "noise on a bench", EVERY, plant, 500_000).standard_normal(),
    }
    values |= {f"plate_{k}": each for k, each in enumerate(draw.plates[0])}
    for k, (friction, mass) in enumerate(grid._objects(EVERY, plant, LIFTS)):
        cell = Cell("paper", friction, mass, 0.5, fault=EVERY, plant=plant)
        noise = stream(seed_of(cell, grid.seed), "samples").standard_normal()
        values |= {f"friction_{k}": friction, f"mass_{k}": np.log(mass), f"noise_{k}": noise}
    return values


@pytest.mark.slow
def test_no_two_draws_of_a_plant_are_correlated(design):
    """|r| sqrt(n) is normal for independent draws: over all pairs the bound is passed once in a
    thousand such tests. Before, friction of the first lift and modulus had r = 1."""
    grid = ControlGrid.of_perturbed(Perturbed((EVERY,), PLANTS, LIFTS), seed=0)
    places = places_of(plate_frames(design))
    rows = [drawn_values(design, places, grid, plant) for plant in range(PLANTS)]
    names = [name for name in rows[0] if len({row[name] for row in rows}) > 1]
    assert len(names) >= 20
    # By ranks: the bound is then the same for every distribution.
    table = np.array([[row[name] for name in names] for row in rows]).argsort(0).argsort(0)
    found = np.abs(np.corrcoef(table.T))
    pairs = list(combinations(range(len(names)), 2))
    bound = -ndtri(0.5 * ALARM / len(pairs)) / np.sqrt(PLANTS - 1)
    # Objects that would lean and be round are half of either kind, so these two exclude each other.
    # A mesh's two sizes are one draw.
    known = [{"tilt", "curvature"}, {"mesh.section.plate_size_mm", "mesh.plate_size_mm"}]
    wrong = [
        (names[i], names[j], found[i, j])
        for i, j in pairs
        if found[i, j] > bound and {names[i], names[j]} not in known
    ]
    assert wrong == []


@pytest.mark.slow
def test_no_judged_finger_is_a_trained_one(design):
    """For seeds 0 to 20, of both: every seed that is drawn from, and the values of the first."""
    trained = {seed for own in range(21) for n in range(200) for seed in finger_seeds(own, n, 60)}
    judged = {
        ControlGrid(seed=seed).plant_seed(label, plant)
        for seed in range(21)
        for label in ("none", *ALL, EVERY)
        for plant in range(25)
    }
    assert len(trained) == 21 * 200 * 61
    assert len(judged) == 21 * (len(ALL) + 2) * 25
    assert not trained & judged
    places = places_of(plate_frames(design))

    def moduli(seeds):
        draws = (drawn_changes(design, places, TRAINING_FAULTS, seed).design for seed in seeds)
        return {draw["materials.silicone.youngs_modulus_MPa"] for draw in draws}

    own = moduli(finger_seeds(0, number, 0)[0] for number in range(200))
    others = moduli(ControlGrid().plant_seed(EVERY, plant) for plant in range(100))
    assert (len(own), len(others), own & others) == (200, 100, set())


def test_faults_seeds_and_tunings_have_fingers_objects_and_noise_of_their_own():
    grid = ControlGrid.of_perturbed(Perturbed(("gains", EVERY), 25, 4))
    other = ControlGrid.of_perturbed(Perturbed(("gains", EVERY), 25, 4), seed=1)
    cells = [cell for each in (grid, other) for batch in each.batches(["paper"]) for cell in batch]
    assert len({(cell.friction, cell.mass_g) for cell in cells}) == len(cells) == 400
    assert len({seed_of(cell, 0) for cell in cells}) == 400


def test_a_grid_names_counts_and_orders_all_that_it_draws():
    axes = (0.8, 0.2), (200.0, 400.0, 100.0), (0.0, 1.0)
    grid = ControlGrid.of_perturbed(Perturbed((), 2, 3), 1, *axes)
    cells = [cell for batch in grid.batches(["paper"]) for cell in batch]
    assert len(cells) == grid.cells_of_one == (len(ALL) + 2) * 2 * 3 * 2
    assert max(cell.mass_g for cell in cells) > 330.0
    assert len({grid.plant_seed(label, plant) for label in ALL for plant in (0, 1)}) == 2 * len(ALL)
    first = next(replace(grid, perturbed=None).batches(["paper"]))[0]
    assert (first.friction, first.mass_g) == (0.2, 400.0)  # the longest: slippery and heavy
