"""What ``check`` says of a lift beforehand, compared with what the model finds."""

import json
import re

import pytest

from fingerdesign.analysis.forecast.lift import lifts
from fingerdesign.checks.load import load_design, parse_design, with_values
from fingerdesign.contact.force_control import Forces, solve_forces
from fingerdesign.contact.measures import measure
from fingerdesign.contact.problem import ContactState
from fingerdesign.control.episode import run_episodes
from fingerdesign.control.plants.rig import Rig
from fingerdesign.sensing.model import grip_problem

APPROACH_OFF, WIDTH_OFF = 1.5, 1.25  # factors that the forecasts keep on straight fingers
SOFT_DOME = """
[design]
name = "soft_dome"
[body]
shape = "dome"
width_mm = 20.0
base_height_mm = 10.0
arc_radius_mm = 20.0
depth_mm = 14.0
dome_radius_mm = 25.0
material = "soft"
[plates]
count = 9
angle_deg = 30.0
span_mm = 8.0
material = "polyimide"
[materials.soft]
youngs_modulus_MPa = 0.5
poissons_ratio = 0.49
"""


def soft_dome(mass_g):
    return with_values(parse_design(SOFT_DOME), {"grip.object_mass_g": mass_g})


def against_the_model(design, problem):
    """(forecast over model) of approach and contact width, friction by friction."""
    for lift in lifts(design):
        force = Forces(lift.normal_force_N, 0.0)
        found = solve_forces(problem, ContactState.untouched(problem), force)
        width = measure(problem, found).contact_width
        yield lift.approach_mm / found.motion.approach, 2.0 * lift.contact_half_width_mm / width


@pytest.mark.slow
@pytest.mark.parametrize("name", ["narrow", "sensitive", "wide"])
def test_approach_and_width_are_forecast_within_a_factor(name):
    design = load_design(name)
    for approach, width in against_the_model(design, grip_problem(design, "plane-strain")):
        assert 1.0 / APPROACH_OFF < approach < APPROACH_OFF
        assert 1.0 / WIDTH_OFF < width < WIDTH_OFF


def crushing(values):
    """The sentences on moves that crush, of film_tees with these values."""
    found = lifts(with_values(load_design("film_tees"), values))
    return [words for each in found for words in each.remedies if "crush" in words]


def test_moves_that_crush_a_lighter_object_or_in_stiffer_rubber_are_forecast():
    mass, stiff = "grip.object_mass_g", "materials.silicone.youngs_modulus_MPa"
    for values in ({}, {mass: 300.0}, {mass: 2000.0}, {stiff: 1.0}):
        assert crushing(values) == []
    (words,) = crushing({mass: [50.0, 500.0]})
    assert "9.7 times" in words  # 9.5 in plane strain
    assert "240 g or more" in words
    assert crushing({mass: 240.0}) == []
    assert "4.6 times" in crushing({stiff: 30.0})[0]  # 4.5 in plane strain
    held = crushing({mass: 50.0, "grip.controller": "regulator"})
    assert "6.4 times" in held[0]  # without hold_force_N, which is the paper's


def test_a_lift_is_forecast_for_the_most_that_pulls_until_the_end():
    keys = {"grip.plant": "lift", "grip.hold_steps": 9, "grip.defaults": "follow"}
    keys |= {"grip.max_approach_mm": "auto", "grip.preload_mm": "auto"}
    light, heavy = (
        with_values(load_design("film_tees"), {**keys, "grip.object_mass_g": mass})
        for mass in (500.0, 5000.0)
    )
    heavier = {"grip.weight_changes": [{"step_after_lift": 3, "object_mass_g": 5000.0}]}
    later = with_values(light, heavier)
    for own, alone in zip(lifts(later), lifts(heavy), strict=True):
        assert own.object_mass_g == 500.0
        for key in ("normal_force_N", "tangential_force_N", "approach_mm"):
            assert getattr(own, key) == pytest.approx(getattr(alone, key))
    assert later.grip.max_approach_mm == heavy.grip.max_approach_mm > light.grip.max_approach_mm
    assert later.grip.preload_mm == pytest.approx(light.grip.preload_mm, rel=0.01)
    fixed = {"grip.max_approach_mm": light.grip.max_approach_mm}
    words = [each for lift in lifts(with_values(later, fixed)) for each in lift.remedies]
    assert any("a lift of 500 g, pulled later as by 5000 g, at a friction" in e for e in words)


@pytest.mark.slow
def test_the_soft_dome_s_are_in_3d():
    """The heavier object needs the larger contact zone: its model serves both. Two thick plates,
    not nine thin ones, and coarse facets make the model a sixth as dear."""
    keys = {"plates.count": 2, "plates.pitch_mm": 3.0, "plates.thickness_mm": 0.3}
    keys |= {"plates.length_mm": 1.5, "mesh.plate_size_mm": 1.5}
    light, heavy = (with_values(soft_dome(each), keys) for each in (100.0, 500.0))
    problem = grip_problem(with_values(heavy, {"mesh.contact_size_mm": 0.7}), "3d")
    for design in (light, heavy):
        for approach, width in against_the_model(design, problem):
            assert 1.0 / APPROACH_OFF < approach < APPROACH_OFF
            assert 1.0 / WIDTH_OFF < width < WIDTH_OFF


def test_gages_are_forecast_against_their_target():
    assert all(lift.measurable for lift in lifts(load_design("sensitive")))
    assert any(lift.measurable is False for lift in lifts(load_design("maeno2000")))
    assert not any(lift.measurable for lift in lifts(load_design("maeno2000")))


def test_what_the_small_strains_do_not_bear_is_reported_with_a_remedy():
    heavy = soft_dome(500.0)
    remedies = [words for lift in lifts(heavy) for words in lift.remedies]
    assert any("materials.soft.youngs_modulus_MPa" in words for words in remedies)
    assert not [words for lift in lifts(soft_dome(100.0)) for words in lift.remedies]
    short = with_values(soft_dome(100.0), {"grip.max_approach_mm": 0.4, "grip.preload_mm": 0.03})
    remedies = [words for lift in lifts(short) for words in lift.remedies]
    assert any("grip.max_approach_mm = 0.4" in words and "'auto'" in words for words in remedies)


@pytest.mark.parametrize(
    ("grams", "about", "pattern", "key"),
    [
        (1e5, "small strains", r"_g to ([\d.]+)", "grip.object_mass_g"),
        (1e5, "small strains", r"MPa from [\d.]+ to ([\d.]+)", "body"),
        (20.0, "nodes in 3d", r"mm to ([\d.]+)", "mesh.contact_size_mm"),
    ],
)
def test_a_remedy_stands_once_and_ends_what_it_is_for(grams, about, pattern, key):
    def stated(design):
        return [each for lift in lifts(design) for each in lift.remedies if about in each]

    design = with_values(load_design("film_tees"), {"grip.object_mass_g": grams})
    key = f"materials.{design.body.material}.youngs_modulus_MPa" if key == "body" else key
    (words,) = stated(design)
    assert not stated(with_values(design, {key: float(re.search(pattern, words)[1])}))


def test_check_tells_the_lifts(terminal, tmp_path):
    file = tmp_path / "dome.toml"
    file.write_text(SOFT_DOME)
    (report,) = json.loads(terminal("check", file, "--json").out)
    assert [lift["friction_coefficient"] for lift in report["lifts"]] == [0.3, 0.5, 0.8]
    assert any("small strains end" in note for note in report["notes"])
    assert "Lift with a margin" in terminal("check", file).out


@pytest.mark.slow
@pytest.mark.parametrize(
    ("mass_g", "values", "carried"),
    [
        (100.0, {}, (0.3, 0.5, 0.8)),
        # At 0.3 all nine gages answer over the threshold: the rule sees no area that shrinks.
        (500.0, {}, (0.5, 0.8)),
        (500.0, {"grip.threshold_share": 0.6}, (0.3, 0.5, 0.8)),
    ],
)
def test_the_soft_dome_lifts_by_defaults(mass_g, values, carried):
    design = with_values(soft_dome(mass_g), values)
    problem = grip_problem(design, "plane-strain")
    found = run_episodes(Rig.of(problem, design), design.grip.friction_coefficients, mass_g)
    lifted = [each.result for each in found if each.result.lifted and not each.result.gross_slip]
    assert tuple(each.friction_coefficient for each in lifted) == carried
    beforehand = {each.friction_coefficient: each.remedies for each in lifts(design)}
    assert all(beforehand[friction] for friction in {0.3, 0.5, 0.8} - set(carried))
