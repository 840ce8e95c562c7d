"""The estimator that ships with a design: for its finger and stage, and for no other."""

import pytest

from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.shipped import ESTIMATOR_SUFFIX, estimator_texts, shipped_path
from fingerdesign.errors import DesignError
from fingerdesign.sensing.train import ready
from fingerdesign.sensing.train.result import estimator_faults, finger_key


class TrainedAnew(Exception):
    pass


@pytest.fixture
def film_tees(monkeypatch):
    def train(*_, **__):
        raise TrainedAnew

    monkeypatch.setattr(ready, "training_result_for", train)
    return load_design("film_tees")


def test_a_shipped_estimator_is_its_designs_and_small(film_tees):
    assert set(estimator_texts()) == {"film_tees"}
    path = shipped_path("film_tees").with_name(f"film_tees{ESTIMATOR_SUFFIX}")
    assert path.stat().st_size < 150_000
    found = ready.shipped_estimator(film_tees)
    assert found is not None
    assert (found.design, found.gages) == (finger_key(film_tees, "3d"), 11)
    assert estimator_faults(film_tees, found, "3d") == []
    assert ready.unused_estimator(film_tees) is None


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"design.name": "mine", "grip.regulator.target": 0.7, "grip.object_mass_g": 300.0},
        {"mesh.mesher": "sweep"},
    ],
)
def test_it_is_used_without_a_training_for_the_same_finger(film_tees, values):
    design = with_values(film_tees, {"grip.controller": "regulator"} | values)
    found = ready.with_estimator(Case(design, None, "3d"), print)
    assert found.estimator == ready.estimator_of(design, fidelity="3d")
    assert ready.unused_estimator(design) is None


@pytest.mark.parametrize(
    ("values", "fidelity"),
    [
        ({"plates.cover_mm": 0.61}, "3d"),
        ({"grip.max_approach_mm": 0.3}, "3d"),
        ({"materials.silicone.youngs_modulus_MPa": 4.9}, "3d"),
        ({"gages.width_mm": 1.1}, "3d"),
        ({}, "plane-strain"),
    ],
)
def test_another_finger_stage_or_fidelity_is_trained(film_tees, values, fidelity):
    design = with_values(film_tees, values)
    with pytest.raises(TrainedAnew):
        ready.estimator_of(design, fidelity=fidelity)
    note = ready.unused_estimator(design)
    assert (note is None) == (not values)
    if values:
        assert note.startswith("film_tees.estimator.json is not used")
        shipped = ready.shipped_estimator(film_tees)
        own = with_values(design, {"grip.controller": "regulator"})
        with pytest.raises(DesignError, match="on this design"):
            ready.with_estimator(Case(own, None, "3d", estimator=shipped), print)
