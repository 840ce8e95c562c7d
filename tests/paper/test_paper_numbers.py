"""The numbers behind the remade figures of the paper, on a coarse mesh of its finger."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.analysis.case import fundamental_scene
from fingerdesign.analysis.stages import one_thread, zone_of
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.errors import DesignError
from fingerdesign.paper import case as paper_case
from fingerdesign.paper import lifts as paper_rig
from fingerdesign.paper.lifts import ROUTE_FRICTION, SQUEEZE, lifts, squeeze
from fingerdesign.paper.places import (
    area_under_curve,
    best_threshold,
    gage_verdicts,
    likeness,
    roc_curve,
    rubber_verdicts,
)
from fingerdesign.paper.rectangles import COUNT, rectangles
from fingerdesign.paper.relation import (
    make_bench,
    relation,
    relation_errors,
    spread_at_equal_area,
)

SCENE = fundamental_scene()
FEW = (0.2, 0.3, 0.5, 1.0)  # two of them teach the threshold, two judge it
COARSE = {
    "mesh.section.contact_size_mm": 0.1,
    "mesh.section.plate_size_mm": 0.2,
    "mesh.section.plate_end_size_mm": 0.05,
    "mesh.section.far_size_mm": 2.0,
    "mesh.section.gradation": 0.5,
}


def coarse_case(**values):
    design = with_values(load_design("designs/maeno2000.toml"), {**COARSE, **values})
    requested = paper_case.check_case(design, SCENE)
    return paper_case.build_case(requested, SCENE, zone_of(requested, SCENE))


@pytest.fixture(scope="module", autouse=True)
def single_thread():
    with one_thread():
        yield


@pytest.fixture(scope="module")
def case():
    return coarse_case()


@pytest.fixture(scope="module")
def bench(case):
    return make_bench(case)


def test_the_twin_is_the_same_finger_without_plates(case):
    assert case.twin.model.nodes == case.finger.model.nodes
    assert len(case.gage_x) == 15
    assert case.twin.model.point_readout.shape[0] == 6 * 15 * (1 + len(case.depths))
    assert case.depths == paper_case.DEPTHS
    pressed = [
        next(paper_case.follow_rows(problem, [(0.1, 0.0)])).measures.normal_force
        for problem in (case.finger, case.twin)
    ]
    assert pressed[0] == pytest.approx(pressed[1], rel=0.05)
    assert pressed[0] > pressed[1]  # plates stiffen


@pytest.mark.parametrize("count", [0, 2])
def test_a_design_without_an_array_of_gages_is_refused(count):
    design = with_values(load_design("designs/maeno2000.toml"), {"plates.count": count})
    with pytest.raises(DesignError, match=r"plates\.count") as raised:
        paper_case.check_case(design, SCENE)
    assert len(raised.value.faults) == 1


def test_the_three_paths(case):
    rows = paper_case.path_rows(case, "similar", 0.5)
    whole = rows[paper_case.PIECES - 1 :: paper_case.PIECES]
    assert np.array(whole) == pytest.approx(np.array(case.rows))
    twice = paper_case.path_rows(case, "similar", 1.0)
    assert [s for _, s in twice] == pytest.approx([2 * s for _, s in rows])
    assert paper_case.path_rows(case, "same", 0.2) == paper_case.path_rows(case, "same", 1.0)
    approach = [a for a, _ in paper_case.path_rows(case, "growing", 0.5)]
    assert (np.diff(approach) > 0.0).all()
    assert approach[-1] == case.approach
    with pytest.raises(ValueError, match="must be one of similar"):
        paper_case.path_rows(case, "other", 0.5)


@pytest.mark.parametrize("path", ["same", "growing"])
def test_a_path_ends_with_its_first_increment_of_complete_slip(case, path):
    problem = case.finger.with_friction(0.3)
    steps = list(paper_case.follow_rows(problem, paper_case.path_rows(case, path, 0.3)))
    ratios = [step.measures.stick_ratio for step in steps]
    assert ratios[-1] < 0.01
    assert min(ratios[:-1]) >= 0.01


def test_the_relation_hardly_depends_on_friction_while_the_approach_is_held(case, bench):
    found = relation(case, bench, "same", FEW)
    assert found.frictions == FEW
    assert set(found.friction) == set(FEW)
    assert min(found.rank) > 0.99
    assert found.pooled_rank > 0.99
    assert found.other_share < 0.05
    assert found.own_share <= found.other_share
    assert found.spread_median_mm < 0.1 * found.largest_mm


def test_where_the_approach_grows_the_area_does_not_tell_complete_slip(case, bench):
    found = relation(case, bench, "growing", FEW)
    assert found.before_share < 0.06
    assert found.other_share > 1.5 * found.before_share


def test_equal_relations_have_no_spread_and_no_error_and_shifted_ones_theirs():
    area = np.linspace(5.0, 1.0, 20)
    stick = 0.5 * area
    assert spread_at_equal_area([area, area], [stick, stick]).max() == pytest.approx(0.0)
    shifted = spread_at_equal_area([area, area], [stick, stick + 0.3])
    assert shifted == pytest.approx(np.full(len(shifted), 0.3))
    assert len(spread_at_equal_area([area, area + 9.0], [stick, stick])) == 0
    label = np.repeat([0.2, 0.5], 20)
    own, other = relation_errors(label, np.tile(area, 2), np.tile(stick, 2))
    assert own == pytest.approx(np.zeros(2))
    assert other == pytest.approx(np.zeros(2))
    own, other = relation_errors(label, np.tile(area, 2), np.concatenate([stick, stick + 0.3]))
    assert own == pytest.approx(np.zeros(2))
    assert other == pytest.approx(np.full(2, 0.3))


def test_plates_feel_the_rubbers_shear_strain_in_shape_but_not_in_size(case):
    alike = likeness(case)
    assert alike.membrane.shape == alike.shear.shape == (8, 15)
    assert min(alike.correlation) > 0.95
    assert min(alike.change_correlation) > 0.9
    assert max(alike.upper_correlation) < 0.0  # bending: nothing like it
    assert 5e-5 < alike.overall_slope < 2e-4
    assert alike.stick_ratio[-1] < 0.01
    assert alike.read_correlation == pytest.approx(alike.correlation)  # face = "both"


def test_where_a_plate_is_rubber_its_strain_is_half_the_shear():
    """At 45 degrees in plane strain, where nearly nothing changes its volume."""
    alike = likeness(coarse_case(**{"plates.model": "none"}))
    assert alike.overall_slope == pytest.approx(0.5, abs=0.02)
    assert min(alike.correlation) > 0.99


def test_what_slip_ends_is_the_growth_of_the_shear_not_the_shear(case):
    turned = rectangles(case)
    assert len(turned.status) == len(turned.corners) == COUNT
    assert {"stick", "slip"} <= set(turned.status)
    assert turned.status[0] == turned.status[-1] == "slip"  # from both edges
    pressed = turned.angle["pressed"]
    assert pressed == pytest.approx(-pressed[::-1], abs=0.02)
    assert (turned.angle["added"] > 0.0).all()
    change = {s: turned.mean("change", s) for s in ("stick", "slip")}
    assert change["stick"] > 2.0 * change["slip"] > 0.0
    assert turned.mean("added", "slip") > 0.7 * turned.mean("added", "stick")
    assert turned.shear_mm[0] == 0.0 < turned.shear_mm[1] < turned.shear_mm[2]
    assert (turned.change_per_N > 0.0).all()


def test_a_rectangle_that_turns_as_a_whole_is_not_sheared(case):
    """The angle is of the two middle lines against each other."""
    turned = rectangles(case)
    corners = turned.corners
    x, y = corners[..., 0], corners[..., 1]
    area = 0.5 * np.sum(x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1), axis=1)
    assert (area > 0.0).all()  # anticlockwise
    width = x[:, 1] - x[:, 0]
    assert width == pytest.approx(y[:, 3] - y[:, 0])  # squares
    moved = turned.moved["sheared"] - turned.moved["pressed"]
    by_corners = ((moved[:, 3] + moved[:, 2] - moved[:, 0] - moved[:, 1])[:, 0]) / (2 * width)
    by_corners += ((moved[:, 1] + moved[:, 2] - moved[:, 0] - moved[:, 3])[:, 1]) / (2 * width)
    assert np.degrees(by_corners) == pytest.approx(turned.angle["added"], rel=0.2)


def test_one_gage_hardly_reports_stick_from_slip_but_the_rubber_near_the_surface_does(case, bench):
    gages = gage_verdicts(case, bench.floor, FEW)
    rubber = rubber_verdicts(case, bench.floor, FEW)
    assert [v.reading for v in gages[::2]] == ["plate, both faces", "plate, upper face"]
    under = next(v for v in gages if v.touching)
    skin = next(v for v in rubber if v.touching and v.depth_mm == 0.1)
    assert skin.right > 0.85
    assert skin.gain > 0.5
    assert under.gain < 0.25
    assert under.auc < 0.75 < skin.auc
    every = gages[0]
    assert every.right > every.constant + 0.05  # near the contact or not: that it tells
    for each in (*gages, *rubber):
        assert 0.5 <= each.constant <= 1.0
        assert (np.diff(each.roc) >= 0.0).all()
        requested = np.isfinite(each.by_place)
        assert requested.all() or each.touching
    right = {v.depth_mm: v.right for v in rubber if v.touching}
    assert right[0.1] > right[0.4] > right[1.2]


def test_threshold_and_curve_of_a_classifier():
    scores = np.array([3.0, 1.0, 2.0, 4.0])
    truth = np.array([True, False, False, True])
    assert best_threshold(scores, truth) == 2.5
    assert best_threshold(scores, np.ones(4, dtype=bool)) < 1.0
    assert best_threshold(scores, np.zeros(4, dtype=bool)) > 4.0
    assert np.isnan(best_threshold(scores[:0], truth[:0]))
    assert area_under_curve(scores, truth) == 1.0
    assert area_under_curve(-scores, truth) == 0.0
    assert np.isnan(area_under_curve(scores, np.ones(4, dtype=bool)))
    misses, hits = roc_curve(scores, truth)
    assert (misses[0], hits[0], misses[-1], hits[-1]) == (0.0, 0.0, 1.0, 1.0)


def test_lifts_by_the_rule_and_two_other_routes(case):
    low, high = lifts(case, (ROUTE_FRICTION, 0.8))
    for lift in (low, high):
        assert lift.ruled.result.lifted
        assert not lift.ruled.result.gross_slip
        assert lift.ruled.result.safety_margin > 1.0
    assert low.free.result.gross_slip
    assert not high.free.result.gross_slip
    route = squeeze(case)
    least = 0.5 * 9.80665e-3 * 500.0 / ROUTE_FRICTION
    assert route.forces[0].max() == pytest.approx(SQUEEZE * least, rel=0.03)
    assert not route.slips
    assert route.forces[1][-1] > ROUTE_FRICTION * least


def test_a_squeeze_that_is_not_enough_slips(case):
    design = with_values(case.design, {"grip.max_approach_mm": 0.05})
    assert squeeze(replace(case, design=design)).slips


def test_the_rig_repeats_itself_and_noise_changes_it(case):
    rig = paper_rig.rig_of(case, "bronze", levels=(100,), seeds=2)
    assert rig.levels == (None, 100)
    assert rig.works(None)  # without noise
    assert len(rig.at(None)) == 2  # one a friction
    assert len(rig.at(100, 0.3)) == 2
    again = paper_rig.measured(
        replace(case, design=with_values(case.design, paper_rig.RIG_SETTINGS)), 100, 1
    )
    for first, second in zip(rig.at(100)[2:], again, strict=True):
        assert (first.seed, first.friction) == (second.seed, second.friction)
        assert first.episode.result == second.episode.result
    forces = [g.episode.trace.normal_force for g in rig.at(100, 0.3)]
    readings = [g.episode.trace.gage_readings[0] for g in rig.at(100, 0.3)]
    assert len(forces[0]) > 10
    assert np.std(readings[0] - readings[1]) == pytest.approx(0.05 * np.sqrt(2), rel=0.5)


def test_noise_falls_with_the_root_of_the_samples():
    assert paper_rig.noise_of(None) == 0.0
    assert paper_rig.noise_of(10_000) == pytest.approx(0.005)


def test_a_rig_works_where_all_is_lifted_and_the_frictions_are_distinguished(case):
    whole = paper_rig.rig_of(case, "bronze", levels=(), seeds=1)
    low, high = whole.at(None)
    alike = replace(high, episode=low.episode)
    blind = paper_rig.Rig("blind", (low, alike))
    assert blind.force_ratio(None) == 1.0
    assert not blind.works(None)
    assert blind.least_samples == ()
    slipped = replace(low.episode.result, lifted=False, gross_slip=True)
    lost = replace(low, episode=replace(low.episode, result=slipped))
    assert lost.outcome == "slipped"
    assert not paper_rig.Rig("lost", (lost, high)).works(None)
    assert np.isnan(paper_rig.Rig("lost", (lost, high)).force_ratio(None))
