"""The estimator that ships with a design: for its finger and stage, and for no other."""

from dataclasses import replace

import numpy as np
import pytest
from fingerdesign_cli.inputs import estimator_for

from fingerdesign.analysis.analysis import of_choices
from fingerdesign.analysis.case import Case
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.control.completion import Relations
from fingerdesign.control.estimator import Band, GripEstimator, Layer
from fingerdesign.control.features import FingerCurves, feature_count
from fingerdesign.control.former_estimator import OLDEST, PRESENT
from fingerdesign.design.shipped import ESTIMATOR_SUFFIX, estimator_texts, shipped_path
from fingerdesign.errors import DesignError
from fingerdesign.sensing.train import ready
from fingerdesign.sensing.train.result import estimator_faults, finger_key
from fingerdesign.trials import gripbench


class TrainedAnew(Exception):
    pass


@pytest.fixture
def film_tees(monkeypatch):
    """The design with an estimator next to it whose numbers mean nothing; training is an error."""
    design, gages = load_design("film_tees"), 11
    forces, ones = np.array([0.0, 5.0]), np.ones((2, gages))
    curves = FingerCurves(
        forces, np.zeros((2, gages)), ones, 0.01 * forces, np.full(2, 10.0), np.zeros(2)
    )
    count = feature_count(gages)
    layer = Layer(np.ones((count, 3)), np.array([0.7, 0.4, 0.1]))
    relations = Relations.of_neighbours(gages)
    numbers = np.zeros(count), np.ones(count), relations, (layer,), np.array([[1.0, 0.1]])
    band = Band(10.0, *numbers)
    text = GripEstimator(finger_key(design, "3d"), curves, 0.5, (band,)).to_json()

    def train(*_, **__):
        raise TrainedAnew

    monkeypatch.setattr(ready, "training_result_for", train)
    monkeypatch.setattr(ready, "estimator_texts", lambda: {"film_tees": text})
    return design


def test_each_shipped_estimator_is_its_designs_and_small():
    """It fails where a design or the meshes of grips changed: train it again, and copy the file."""
    for name in estimator_texts():
        design = load_design(name)
        path = shipped_path(name).with_name(f"{name}{ESTIMATOR_SUFFIX}")
        assert path.stat().st_size < 180_000  # 15 gages; 11 have 145 kB
        found = ready.shipped_estimator(design)
        assert found is not None
        # GripBench's finger is gripped in plane strain.
        fidelity = "plane-strain" if name == gripbench.DESIGN else "3d"
        assert estimator_faults(design, found, fidelity) == []
        assert ready.unused_estimator(design) is None


def test_a_file_of_a_former_format_is_of_its_design_still(film_tees):
    found = ready.shipped_estimator(film_tees)
    for number in range(OLDEST, PRESENT):
        former = replace(found, design=finger_key(film_tees, "3d", number))
        assert estimator_faults(film_tees, former, "3d") == []
        assert estimator_faults(film_tees, former, "plane-strain") != []


def test_the_command_line_reports_it_where_a_hand_would_use_it(film_tees, capsys):
    other = with_values(film_tees, {"plates.cover_mm": 0.61})
    sizes, fidelity = "is not used: finger, gages or stage", "was not trained for --fidelity plane"
    for design, hand, model, words in (
        (other, "regulator", "3d", sizes),
        (other, "paper", "3d", ""),
        (film_tees, "regulator", "3d", ""),
        (film_tees, "regulator", "plane-strain", fidelity),
        (with_values(film_tees, {"design.name": "mine"}), "regulator", "plane-strain", fidelity),
        (with_values(other, {"design.name": "mine"}), "regulator", "3d", ""),
    ):
        assert estimator_for(design, None, model, [hand]) is None
        reported = capsys.readouterr().err.splitlines()
        assert len(reported) == bool(words)
        assert all(words in line for line in reported)


@pytest.mark.parametrize(
    "values",
    [
        {},
        {"design.name": "mine", "grip.regulator.target": 0.7, "grip.object_mass_g": 300.0},
        {"gages.area_share": 0.6, "grip.approach_step_mm": 0.004, "grip.curve_per_N": 0.2},
        {"mesh.mesher": "sweep"},
    ],
)
def test_it_is_used_without_a_training_for_the_same_finger(film_tees, values):
    design = with_values(film_tees, {"grip.controller": "regulator"} | values)
    found = ready.with_estimator(Case(design, None, "3d"), print)
    assert found.estimator.design == finger_key(film_tees, "3d")
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


def test_a_finger_near_to_a_shipped_one_takes_its_estimator_by_name(terminal):
    near = with_values(load_design("film_tees"), {"plates.pitch_mm": 0.97})
    found = ready.adopted_estimator(near, "film_tees")
    assert estimator_faults(near, found, "3d") == []
    assert found.adopted_from == "film_tees"
    own = ready.adopted_estimator(load_design("film_tees"), "film_tees")
    assert own.adopted_from == ""
    cases = (Case(near, None, "3d", estimator=each) for each in (found, own, None))
    facts = (of_choices(case, case.path_scene).get("other_estimator") for case in cases)
    assert list(facts) == [{"trained_on": "film_tees"}, None, None]
    assert "trained in 3d" in str(estimator_faults(near, found, "plane-strain"))
    assert "for 11 gages" in str(
        estimator_faults(
            load_design("feeler"), ready.adopted_estimator(load_design("feeler"), "film_tees")
        )
    )
    assert ready.adopted_estimator(near, "maeno2000") is None
    refused = terminal("grip", "feeler", "--estimator", "film_tees", code=2).err
    assert "is of another finger" in refused
    assert "11 gages" in refused
