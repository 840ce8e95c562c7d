"""Defaults that follow finger and object: which do, when they stay, what is written."""

import numpy as np
import pytest

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.checks.follow import lift_approach, lift_force
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.design.grip import Grip, weight_per_finger
from fingerdesign.design.io import design_data, dump_design
from fingerdesign.design.scene import SceneObject
from fingerdesign.design.shipped import shipped_names
from fingerdesign.design.starter import starter_text
from fingerdesign.errors import DesignError
from fingerdesign.layout.zone import approach_for, contact_reach

TEXT = 'design.name = "a"\n'


def follows(**values):
    return with_values(parse_design(TEXT), values).grip


@pytest.mark.parametrize("name", shipped_names())
def test_shipped_designs_keep_their_values(name):
    grip = load_design(name).grip
    assert grip.defaults == "fixed"
    left_out = {"approach_step_mm", "shear_step_mm"} - grip.model_fields_set
    fixed = {"approach_step_mm": 0.004, "shear_step_mm": 0.03}
    assert {key: getattr(grip, key) for key in left_out} == {key: fixed[key] for key in left_out}
    assert grip.fundamental_approach_mm is None


def test_travel_and_steps_follow_stiffness_and_object():
    stiff, soft = follows(), follows(**{"materials.silicone.youngs_modulus_MPa": 0.5})
    heavy = follows(**{"grip.object_mass_g": 1000.0})
    for key in ("max_approach_mm", "preload_mm", "approach_step_mm", "shear_step_mm"):
        assert getattr(soft, key) > 3.0 * getattr(stiff, key)
        assert getattr(heavy, key) > 1.2 * getattr(stiff, key)
    assert soft.fundamental_approach_mm > 3.0 * stiff.fundamental_approach_mm
    assert heavy.hold_force_N == pytest.approx(2.0 * stiff.hold_force_N, rel=0.01)
    assert heavy.curve_per_N == pytest.approx(0.5 * stiff.curve_per_N, rel=0.01)
    assert stiff.max_steps * stiff.approach_step_mm > stiff.max_approach_mm


def test_the_fundamental_case_presses_with_four_thirds_of_what_holds_at_a_half():
    design = parse_design(TEXT)
    force = 4.0 / 3.0 * weight_per_finger(max(design.grip.masses_g)) / 0.5
    deep = approach_for(design, SceneObject(), force)
    assert design.grip.fundamental_approach_mm == pytest.approx(deep, rel=0.01)
    shipped, own = (
        np.array(s.path.increments_mm) for s in (fundamental_scene(), fundamental_scene(design))
    )
    assert own == pytest.approx(
        shipped * (design.grip.fundamental_approach_mm / shipped[:, 0].max())
    )


@pytest.mark.parametrize("name", ["domed", "pin"])
def test_off_the_middle_of_an_ellipse_the_force_grows_by_its_mean_distance(name):
    """0.9 of its root mean square, and that of Hertz's pressure is (a^2 + b^2) / 5; four rounds
    find the force to 3 %."""
    design = with_values(load_design(name), {"grip.plant": "lift", "grip.off_centre_mm": 10.0})
    force = lift_force(design, 0.5, 1.2, 200.0)
    deep = approach_for(design, SceneObject(), force)
    across, along = contact_reach(design, SceneObject(), deep)
    mean = 0.9 * np.sqrt((across**2 + along**2) / 5.0)
    centred = 1.2 * weight_per_finger(200.0) / 0.5
    assert force == pytest.approx(centred * np.hypot(1.0, 10.0 / mean), rel=0.03)


def test_a_value_that_is_given_stays_and_others_follow_it():
    given = follows(**{"grip.max_approach_mm": 0.3, "grip.max_steps": 77})
    assert (given.max_approach_mm, given.max_steps) == (0.3, 77)
    assert given.approach_step_mm == pytest.approx(0.002)
    again = follows(**{"grip.max_approach_mm": "auto"})
    assert again.max_approach_mm == follows().max_approach_mm


def test_at_500_g_and_5_MPa_what_follows_is_near_the_tables_defaults():
    grip = follows()
    for key in ("preload_mm", "approach_step_mm", "shear_step_mm", "max_approach_mm"):
        assert getattr(grip, key) == pytest.approx(Grip.model_fields[key].default, rel=0.3)
    for key in ("curve_per_N", "force_floor_N", "hold_force_N", "max_steps"):
        assert getattr(grip, key) == pytest.approx(Grip.model_fields[key].default, rel=0.03)
    parts = grip.approach_step_mm * 150.0, grip.preload_mm * 20.0
    assert parts == pytest.approx((grip.max_approach_mm,) * 2, rel=0.01)
    needed = lift_approach(parse_design(TEXT), 0.3, 2.0, 500.0)
    assert grip.max_approach_mm == pytest.approx(1.5 * needed, rel=0.01)
    low = follows(**{"body.base_height_mm": 0.5, "plates.count": 0, "grip.object_mass_g": 5e4})
    assert low.max_approach_mm == 0.5


def test_fixed_defaults_are_those_of_the_table():
    fixed = follows(**{"grip.defaults": "fixed"})
    assert fixed.max_approach_mm == Grip.model_fields["max_approach_mm"].default
    assert fixed.preload_mm == Grip.model_fields["preload_mm"].default


def test_what_followed_is_written_and_reads_back():
    design = parse_design(TEXT)
    written = parse_design(dump_design(design))
    assert written.digest() == design.digest()
    assert written.grip.max_approach_mm == design.grip.max_approach_mm
    assert "max_approach_mm" not in design_data(design)["grip"]
    assert 'max_approach_mm = "auto"' in starter_text("a")


def test_another_word_than_auto_is_a_fault():
    with pytest.raises(DesignError, match=r"grip\.max_approach_mm"):
        follows(**{"grip.max_approach_mm": "some"})
