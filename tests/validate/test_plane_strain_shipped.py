"""The shipped plane-strain map: what was known, that it is smooth, and that its rules hold."""

from types import SimpleNamespace

import numpy as np
import pytest
from fingerdesign_bench.plane_strain.file import points_of, read_study, shipped_study
from fingerdesign_bench.plane_strain.judge import beyond_the_grid, checks_of, judged
from fingerdesign_bench.plane_strain.rule import Rule

from fingerdesign import parse_scene, with_values
from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.checks.load import load_design
from fingerdesign.errors import DesignError
from fingerdesign.layout.bodies import crest_height
from fingerdesign.layout.zone import contact_reach
from fingerdesign.validate.plane_strain import (
    _STUDY_LENGTH,
    _STUDY_PULL,
    QUANTITIES,
    PlaneStrainEstimate,
    _uncertainty,
    _widen_to_bare,
    plane_strain_error,
    shipped_map,
)

FINGER = load_design("homogeneous")


@pytest.mark.parametrize(("depth", "known"), [(10.0, 0.31), (40.0, 0.12)])
def test_the_shipped_map_says_what_was_known(depth, known):
    """Known before: R = 20, nu = 0.49, approach 0.4; without plates."""
    scene = parse_scene("path.increments_mm = [[0.4, 0.0]]")
    found = plane_strain_error(with_values(FINGER, {"body.depth_mm": depth}), scene)
    assert found.errors["normal_force"] == pytest.approx(known, abs=0.02)
    assert found.inside
    assert found.uncertainty["normal_force"] < 0.5 * known


# `fingerdesign validate maeno2000`: greatest errors at equal motion.
MAENO = {"normal_force": 0.259, "tangential_force": 0.258}


def test_the_papers_finger_lies_within_its_estimate():
    """Its plates are half as long as the study's and it is pulled to complete slip."""
    found = plane_strain_error(load_design("maeno2000"), fundamental_scene())
    for quantity, true in MAENO.items():
        assert found.least(quantity) <= true <= found.most(quantity), quantity
    assert found.most("stick_ratio") >= found.most("normal_force") - 1e-12
    assert "pulled further than 0.4 of the approach" in found.words
    assert "between those with and without plates" in found.words
    tees = plane_strain_error(
        with_values(load_design("maeno2000"), {"gages.grid": "tee"}), fundamental_scene()
    )
    assert tees.errors["normal_force"] == found.errors["normal_force"]
    assert not any("gage" in quantity for quantity in tees.errors)
    assert "tee gages is not known" in tees.words


def test_an_estimate_goes_by_the_design_s_own_ratios_and_gages():
    one = with_values(load_design("maeno2000"), {"plates.span_mm": 4.0, "gages.face": "upper"})
    bare = with_values(one, {"plates.model": "none"})
    short, none = (plane_strain_error(each, half_width=2.0) for each in (one, bare))
    assert [each.ratios["span_over_depth"] for each in (short, none)] == [0.4, 0.0]
    assert short.errors["gage"] == short.errors["gage_face"] != short.errors["gage_both"]
    for half_width, times in ((2.0, 1.0), (0.01, 2.0)):  # The second is outside the map.
        found = plane_strain_error(FINGER, half_width=half_width)
        for name, known in shipped_map().table["uncertainty"].items():
            own = known["absolute"] + known["relative"] * abs(found.errors.get(name, np.nan))
            assert found.uncertainty.get(name, np.nan) == pytest.approx(times * own, nan_ok=True)


def test_short_plates_reach_the_error_without_plates():
    design = load_design("maeno2000")
    half = 2.0
    found = plane_strain_error(design, half_width=half)
    bare = plane_strain_error(with_values(design, {"plates.count": 0}), half_width=half)
    assert found.most("normal_force") == pytest.approx(bare.errors["normal_force"])
    assert bare.notes == ()
    assert len(found.notes) == 1
    long = with_values(design, {"plates.count": 3, "plates.length_mm": 1.5, "plates.pitch_mm": 2.0})
    assert plane_strain_error(long, half_width=half).notes == ()


@pytest.mark.parametrize(
    ("path", "further"),
    [
        ("increments_mm = [[0.2, 0.0], [0.4, 0.16]]", False),
        ("increments_mm = [[0.0, 0.1], [0.4, 0.0], [0.4, 0.17]]", True),
        ("increments_mm = [[0.4, 0.1], [0.2, 0.1]]", True),
        ("increments_mm = [[0.4, 0.1, 0.15]]", True),
        ('control = "force"\nincrements_N = [[1.0, 0.0]]', False),
        ('control = "force"\nincrements_N = [[1.0, 0.0], [1.0, 0.3]]', True),
    ],
)
def test_a_pull_beyond_the_studys_widens_what_the_pull_changes(path, further):
    scene = parse_scene("[path]\n" + path)
    found = plane_strain_error(FINGER, scene, half_width=2.0)
    plain = plane_strain_error(FINGER, half_width=2.0)
    assert bool(found.notes) == further
    reached = found.most("tangential_force")
    if further:
        assert reached == pytest.approx(found.most("normal_force"))
        assert "pulled further" in found.words
    else:
        assert reached == plain.most("tangential_force")
    assert found.most("normal_force") == plain.most("normal_force")


def test_the_shipped_map_is_smooth_falls_with_depth_and_is_of_the_shipped_study():
    chart, study = shipped_map(), read_study(shipped_study())
    assert chart.depth[0] < 0.5
    assert chart.depth[-1] > 3.0
    force = chart.errors["normal_force"]
    assert np.isfinite(force).all()
    assert (np.diff(force, axis=2) < 0.0).all()  # deeper is nearer to plane strain
    assert (force > 0.0).all()
    assert np.isfinite(chart.errors["gage_face"]).all()
    assert (np.diff(force, axis=0) > 0.0).all()  # less compressible: farther from it
    points = list(points_of(study))
    assert len(chart.table["points"]) == sum(not point.name for point in points)
    assert [each["name"] for each in chart.table["also"]] == [p.name for p in points if p.name]
    assert set(chart.table["uncertainty"]) == set(QUANTITIES)
    assert study.scene.shear_per_approach == _STUDY_PULL
    assert study.fixed["plates.length_mm"] / 12.679 == pytest.approx(_STUDY_LENGTH, rel=1e-3)


@pytest.mark.parametrize("number", [0, 1])
def test_the_rules_for_the_force_hold_on_the_grid_and_beyond_it(number):
    """To the accuracy that they state, 3 points of F_n; 2 on fingers four times as deep."""
    chart = shipped_map()
    rule = Rule(**chart.table["rules"][number])
    assert (rule.quantity, rule.span) == ("normal_force", float(number))
    at = int(np.flatnonzero(chart.span == rule.span)[0])
    errors = chart.errors["normal_force"][:, at]
    for i, poisson in enumerate(chart.poisson):
        for j, depth in enumerate(chart.depth):
            away = rule.error(poisson, depth, np.exp(chart.width[i, at, j])) - errors[i, j]
            assert np.abs(away).max() <= rule.off + 2e-3
    assert rule.off < 0.035
    beyond = beyond_the_grid(chart, rule)
    assert (beyond is None) == (number == 1)
    assert (beyond or 0.0) < 0.02


def test_what_ships_is_what_the_bench_makes_of_its_points():
    chart, rules = judged({name: shipped_map().table[name] for name in ("points", "also")})
    assert chart.table["uncertainty"] == shipped_map().table["uncertainty"]
    assert [rule.as_dict() for rule in rules] == shipped_map().table["rules"]
    assert all(check.holds for check in checks_of(chart, rules))


def test_gages_on_stiff_plates_are_wrong_through_the_plates_own_poissons_effect():
    """The study's one-off model says why: without it they are a few per cent off, not half."""
    table = shipped_map().table
    rows = {each["name"]: each["rows"] for each in table["also"]}
    without = [row["gage_both"] for row in rows["plates without Poisson's effect"]]
    soft = [row["gage_both"] for row in rows["plates a hundredth as stiff"]]
    assert max(without[:-1]) < 0.1  # at the deepest approach the contact reaches the outer plates
    assert min(soft) > 0.4


def test_the_contact_of_a_scene_is_forecast_and_what_no_section_shows_is_refused():
    block, press = load_design("block"), "path.increments_mm = [[0.3, 0.0]]\n"
    height = crest_height(block.body)
    near = parse_scene(f"{press}object.tilt_deg = 0.1\n")  # a plane that meets the whole top
    rod = parse_scene(f'{press}object.shape = "cylinder"\nobject.radius_mm = 10.0\n')
    wide = contact_reach(block, rod.object, 0.3)[0] / height
    places = (plane_strain_error(block, scene).ratios for scene in (near, rod))
    found = [each["half_width_over_height"] for each in places]
    assert found == pytest.approx([0.5 * block.body.width_mm / height, wide * (0.93 - 0.5 * wide)])
    ball = parse_scene(f'{press}object.shape = "sphere"\nobject.radius_mm = 10.0\n')
    for design, scene, key in ((FINGER, ball, "object.shape"), (load_design("domed"), rod, "body")):
        with pytest.raises(DesignError, match=key):
            plane_strain_error(design, scene)


def test_an_error_below_zero_is_as_uncertain_as_one_above():
    table = {"uncertainty": {"normal_force": {"relative": 0.5, "absolute": 0.1}}}
    chart = SimpleNamespace(table=table, error=lambda *_: -0.3)
    for value in (-0.4, 0.4):
        errors = {"normal_force": value}
        assert _uncertainty(chart, errors, 2.0) == {"normal_force": pytest.approx(0.6)}
        half = PlaneStrainEstimate(errors, {"normal_force": 0.3}, {}, True)
        assert (half.least("normal_force"), half.most("normal_force")) == pytest.approx((0.1, 0.7))
    unsure = {"normal_force": 0.1, "contact_width": 0.7, "gage_face": 0.1}
    _widen_to_bare(dict.fromkeys(unsure, 0.2), unsure, chart, (0.49, 1.0, 1.0, 0.2))
    assert list(unsure.values()) == pytest.approx([0.5, 0.7, 0.1])  # of gages: those on plates
