"""What is known beforehand of each assumption's cost, on a finger of one plate, 4 mm deep."""

import json

import jsonschema
import numpy as np
import pytest

from fingerdesign.analysis.fidelity.readings import QUANTITIES
from fingerdesign.checks.load import parse_design
from fingerdesign.design.io import parse_scene
from fingerdesign.records.base import DATA
from fingerdesign.validate.assumptions import nu_values
from fingerdesign.validate.run import validate

pytestmark = pytest.mark.slow  # Two validations serve all.
ONE_PLATE = """
[design]
name = "one"
[body]
depth_mm = 4.0
[plates]
count = 1
length_mm = 2.0
"""
SCENE = """
[object]
friction_coefficient = 0.5
[path]
increments_mm = [[0.1, 0.0], [0.2, 0.02], [0.2, 0.08], [0.2, 0.6]]
"""


@pytest.fixture(scope="module")
def found():
    return validate(
        parse_design(ONE_PLATE),
        parse_scene(SCENE),
        keys=[
            "plane_strain",
            "gage_depth_average",
            "youngs_modulus",
            "relaxation",
            "temperature",
            "small_strain",
        ],
    )


@pytest.fixture(scope="module")
def bare():
    """Without plates."""
    design = parse_design(ONE_PLATE.replace("count = 1", "count = 0"))
    keys = [
        "plane_strain",
        "youngs_modulus",
        "sheets",
        "gage_point",
        "poissons_ratio",
        "temperature",
    ]
    return validate(design, parse_scene(SCENE), keys=keys)


def forces(row, which, label=0):
    return np.array(getattr(row.comparisons[label], which).normal_force_N)


@pytest.mark.parametrize("which", ["found", "bare"])
def test_plane_strain_is_stiffer_at_equal_motion(which, request):
    row = request.getfixturevalue(which).row("plane_strain")
    assert np.all(forces(row, "assumed") > 1.05 * forces(row, "better"))
    assert row.greatest("equal_motion", "normal_force") > 0.05


def test_what_is_prescribed_absent_or_past_complete_slip_has_no_error(found, bare):
    for row in (each for each in found.assumptions if each is not found.row("relaxation")):
        assert row.equal_force.errors["normal_force"] is None
        assert row.greatest("equal_force", "tangential_force") is None
    row = bare.row("plane_strain")
    for side in (row.equal_motion, row.equal_force):
        assert (side.errors["gage"], side.gages) == (None, ())
        assert side.errors["contact_width"].greatest > 0.0
    side = found.row("plane_strain").equal_force
    assert (side.rows, side.rows_left_out) == (3, 1)
    assert "complete slip" in side.note
    assert found.row("plane_strain").equal_motion.rows == 4


def test_forces_of_a_bare_finger_go_with_youngs_modulus_exactly(bare):
    row = bare.row("youngs_modulus")
    force = row.equal_motion.errors["normal_force"]
    assert (force.greatest, force.median) == pytest.approx((0.2, 0.2), abs=1e-6)
    assert row.greatest("equal_motion", "stick_ratio") < 1e-6
    assert row.greatest("equal_motion", "contact_width") < 1e-6
    # A softer finger is touched over a wider place by the same force.
    assert row.greatest("equal_force", "contact_width") > 0.05


def test_softer_rubber_strains_stiff_plates_less_at_equal_motion(found):
    # A plate 27000 times stiffer than the rubber carries what the rubber loads it with.
    row = found.row("youngs_modulus")
    assert row.greatest("equal_motion", "gage") == pytest.approx(0.2, abs=0.01)
    assert row.verdict == "measure"
    assert row.saving is None
    assert row.better_seconds is None


def test_finite_strain_and_how_gages_are_read_cost_what_they_must(found):
    row = found.row("small_strain")
    assert 1e-5 < row.greatest("equal_motion", "normal_force") < 0.05
    assert row.saving > 1.0
    row = found.row("gage_depth_average")
    for side in ("equal_motion", "equal_force"):
        assert row.greatest(side, "gage") > 0.0
        assert all(row.greatest(side, name) is None for name in QUANTITIES if name != "gage")


def test_both_poissons_ratios_are_reported(bare):
    row = bare.row("poissons_ratio")
    labels = ["nu 0.45 for 0.49", "nu 0.4999 for 0.49"]
    assert [each.label for each in row.comparisons] == labels
    softer, stiffer = (forces(row, "assumed", k)[1] for k in (0, 1))
    assert softer < forces(row, "better")[1] < stiffer
    each = [c.equal_motion.errors["normal_force"].greatest for c in row.comparisons]
    assert row.greatest("equal_motion", "normal_force") == max(each)
    soft = ONE_PLATE + "[materials.silicone]\nyoungs_modulus_MPa = 1.0\npoissons_ratio = 0.3\n"
    assert nu_values(parse_design(soft)) == (0.25, 0.35)


@pytest.mark.parametrize("which", ["found", "bare"])
def test_the_record_is_whole(which, request):
    data = json.loads(request.getfixturevalue(which).to_json())
    jsonschema.validate(data, json.loads((DATA / "validate.schema.json").read_text("utf-8")))
    assert data["thresholds"] == {"keep": 0.02, "limit": 0.1}
    for row in data["assumptions"]:
        for each in row["comparisons"]:
            assert len(each["better"]["normal_force_N"]) == 4
            assert len(each["better"]["gages_microstrain"][0]) == data["gages"]


def test_forces_of_relaxed_rubber_are_fresh_ones_scaled(found):
    row = found.row("relaxation")
    assert row.greatest("equal_motion", "normal_force") < 0.01
    assert row.greatest("equal_motion", "stick_ratio") < 0.01
    (pair,) = row.comparisons
    assert pair.equal_force is None
    assert forces(row, "assumed") == pytest.approx(forces(row, "better"), rel=0.01)


def test_a_warmer_finger_fills_more_room(found, bare):
    row = found.row("temperature")
    assert np.all(forces(row, "assumed") > forces(row, "better"))
    assert row.greatest("equal_motion", "gage") > row.greatest("equal_force", "gage") > 0.0
    assert "plates" in bare.row("temperature").reason
