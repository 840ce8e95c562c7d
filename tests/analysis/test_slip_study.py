"""The slip study on plain arrays: correlation, calibration, full stick; no mesh, no CAD."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import spearmanr

from fingerdesign.analysis import slip_study as study
from fingerdesign.analysis.case import Case, fundamental_scene
from fingerdesign.analysis.stages import slip_studies
from fingerdesign.checks.load import load_design, with_values
from fingerdesign.contact.path import follow
from fingerdesign.contact.problem import Motion, contact_problem
from fingerdesign.control.signals import FACES
from fingerdesign.design.scene import SceneObject
from fingerdesign.errors import SolverError
from fingerdesign.shapes.friction import FrictionLaw
from fingerdesign.shapes.objects import Plane
from tests.support.reduced import reduced_model

ROWS = [(0.06, 0.004), (0.1, 0.01), (0.1, 0.02), (0.1, 0.03), (0.1, 0.045), (0.1, 0.2)]
PLATES = 9


def model(seed=0, nodes=61, half=4.0, radius=20.0):
    """A parabola of a uniform elastic foundation with gages that see the load above them."""
    rng = np.random.default_rng(seed)
    x = np.linspace(-half, half, nodes)
    areas = np.full(nodes, x[1] - x[0])
    areas[[0, -1]] *= 0.5
    stiffness = 20.0  # N/mm per mm
    compliance = np.diag(np.repeat(1.0 / (stiffness * areas), 2))
    gage_x = np.linspace(-3.0, 3.0, PLATES)
    below = np.exp(-(((x[None] - gage_x[:, None]) / 0.3) ** 2))
    readout = np.zeros((2 * PLATES, 2 * nodes))
    readout[0::2, 0::2] = 1e-6 * below  # both faces see the shear,
    readout[1::2, 0::2] = 1e-6 * below
    pressed = 1e-5 * rng.random((PLATES, 1)) * below
    readout[0::2, 1::2] = pressed + 1e-4 * below  # each its own part of the pressure
    readout[1::2, 1::2] = pressed - 1e-4 * below
    points = np.column_stack([x, -(x**2) / (2 * radius)])
    return reduced_model(
        points, compliance, facet_areas=np.diff(x), areas=areas, gage_readout=readout, gage_x=gage_x
    )


@pytest.fixture(scope="module")
def problem():
    return contact_problem(model(), Plane(0.0), 0.5)


def follow_last(problem, rows):
    """What is measured at the end of the rows."""
    *_, last = follow(problem, [Motion(*row) for row in rows])
    return last.measures


def test_rank_correlation_is_spearmans_with_and_without_ties():
    for seed in range(5):
        rng = np.random.default_rng(seed)
        first, second = rng.integers(0, 4 + 3 * seed, 25), rng.normal(size=25)
        second[5:9] = second[4]
        expected = spearmanr(first, second).statistic
        rounded = second * (1.0 + 1e-14 * rng.normal(size=25))  # as another processor has it
        for each in (second, rounded):
            assert study.rank_correlation(first, each) == pytest.approx(expected, abs=1e-12)
    assert study.rank_correlation(np.ones(4), np.arange(4.0)) is None
    assert study.rank_correlation(np.arange(4.0), np.ones(4)) is None
    assert study.rank_correlation(np.ones(1), np.ones(1)) is None


def test_refined_rows_keep_the_given_rows_and_scaled_rows_the_approach():
    fine = study.refined_rows(ROWS, 4)
    assert len(fine) == 4 * len(ROWS)
    assert fine[3::4] == ROWS
    assert fine[0] == pytest.approx((0.015, 0.001))
    assert study.scaled_rows(ROWS, 2.0)[4] == (0.1, 0.09)


def test_full_stick_response_is_the_first_response_of_a_rough_object(problem):
    """What is solved for without friction must come out of an increment that cannot slip."""
    rough = problem.with_friction(3.0)
    full = study.full_stick_response(rough, "both", 0.1)
    rows = [(0.1, 0.0), (0.1, 1e-6)]
    calibration = study.normal_calibration(rough, "both", 0.12)
    seen = study.slip_study(
        rough, rows, "both", rough.model.gage_x, study.HandKnowledge(calibration, 0.1, 1e-9)
    ).response[1]
    tangential = follow_last(rough, rows).tangential_force
    assert study.full_stick_stiffness(rough, 0.1) == pytest.approx(tangential / 1e-6, rel=0.05)
    assert full.min() >= 0.0
    np.testing.assert_allclose(seen, full, rtol=0.05, atol=0.02 * full.max())
    assert study.full_stick_threshold(rough, "both", 0.1, 0.25) == 0.25 * full.max()
    with pytest.raises(SolverError, match="no contact"):
        study.full_stick_response(problem, "both", 0.0)


def test_the_area_follows_the_stick_area_at_every_friction(problem):
    coarse = study.slip_studies(problem, ROWS, "both", (0.2, 0.5, 1.0))
    fine = study.slip_studies(problem, ROWS, "both", (0.2, 0.5, 1.0), pieces=5)
    assert [len(s.stick_ratio) for s in (*coarse, *fine)] == [6, 6, 6, 30, 30, 30]
    assert len({s.threshold for s in (*coarse, *fine)}) == 1
    for each in (*coarse, *fine):
        assert each.stick_length_mm[-1] == 0.0
        assert each.rank_correlation > 0.85
        used = np.isfinite(each.response).all(axis=1)
        used = np.logical_or.accumulate(used) & (each.normal_force > 0.0)
        alone = study.rank_correlation(np.flatnonzero(used), each.stick_length_mm[used])
        assert each.step_correlation == pytest.approx(abs(alone), abs=1e-12)
    # On a foundation of springs the similarity in mu is exact.
    np.testing.assert_allclose(coarse[0].stick_ratio, coarse[2].stick_ratio, atol=1e-9)


def test_compensation_leaves_what_the_shear_does_while_the_approach_grows(problem):
    """One face sees the pressure a hundred times stronger than the shear, the mean hardly does."""
    rows = [(0.02 * k, 0.001 * k**2) for k in range(1, 8)]
    x = problem.model.gage_x
    calibrations = {face: study.normal_calibration(problem, face, 0.16, 60) for face in FACES}
    one, mean = (
        study.slip_study(
            problem, rows, face, x, study.HandKnowledge(calibrations[face], 0.01, 1e-6)
        )
        for face in ("upper", "both")
    )
    wrong = np.abs(one.response_raw - mean.response).max()
    assert np.abs(one.response - mean.response).max() < 0.05 * wrong


def test_a_small_step_is_read_from_further_back_and_gages_may_stand_in_any_order(problem):
    calibration, x = study.normal_calibration(problem, "both", 0.12), problem.model.gage_x
    rows = [(0.1, 0.0), (0.1, 1e-6), (0.1, 0.01), (0.1, 0.010001), (0.1, 0.02)]
    got, turned = (
        study.slip_study(
            problem, rows, "both", places, study.HandKnowledge(calibration, 0.05, 0.01)
        )
        for places in (x, x[::-1])
    )
    assert (got.gage_area_mm[:2] == 0.0).all()  # No F_t differs by the floor yet.
    assert got.gage_area_mm[3] == pytest.approx(got.gage_area_mm[2], rel=1e-4)
    assert got.gage_area_mm[2] > 0.0
    assert np.isnan(got.response[:2]).all()
    assert np.isfinite(got.response[2:]).all()
    assert (np.diff(turned.gage_x_mm) > 0).all()
    np.testing.assert_array_equal(turned.response[:, ::-1], got.response)


def test_gages_of_a_row_along_z_are_no_part_of_the_area(problem):
    """They read nothing of a shear along x; the study is that of a finger without them."""
    first, x = [0, 2, 3, 5, 6, 8], problem.model.gage_x.copy()
    alone = contact_problem(problem.model.with_gages(first), Plane(0.0), 0.5)
    x[[1, 4, 7]] = np.nan
    got, expected = (
        study.slip_study(
            *(each, ROWS, "both", places),
            study.HandKnowledge(study.normal_calibration(each, "both", 0.12), 0.05, 0.01),
        )
        for each, places in ((problem, x), (alone, x[first]))
    )
    assert got.gage_area_mm.max() > 0.0
    np.testing.assert_allclose(got.gage_area_mm, expected.gage_area_mm, rtol=1e-9)
    np.testing.assert_allclose(got.response, expected.response, rtol=1e-6, atol=1e-9)
    assert got.rank_correlation == expected.rank_correlation


def test_a_response_goes_back_to_where_the_force_differs_by_the_floor(problem):
    """Ten times as many increments make the same area wherever both paths have a point."""
    calibration, x = study.normal_calibration(problem, "both", 0.12), problem.model.gage_x
    known = study.HandKnowledge(calibration, 0.05, 0.02)
    rows = [(0.1, 0.0), (0.1, 0.004), (0.1, 0.008), (0.1, 0.012)]
    coarse, fine = (
        study.slip_study(problem, study.refined_rows(rows, pieces), "both", x, known)
        for pieces in (1, 40)
    )
    change = np.diff(fine.tangential_force, prepend=0.0)
    assert np.abs(change).max() < known.floor  # No increment alone reaches the floor,
    assert (fine.gage_area_mm[80:] > 0.0).all()
    np.testing.assert_allclose(fine.gage_area_mm[79::40], coarse.gage_area_mm[1:], atol=0.5)


def test_the_area_is_held_in_complete_slip(problem):
    """F_t is flat there; gages that go on changing are no response to it."""
    rows = [(0.1, 0.01), (0.1, 0.02), (0.1, 0.03), (0.1, 0.2), (0.095, 0.3), (0.1, 0.4)]
    x, calibration = problem.model.gage_x, study.normal_calibration(problem, "both", 0.12)
    stiffness = study.full_stick_stiffness(problem, 0.1)
    known = study.HandKnowledge(calibration, 0.05, 0.015, stiffness)
    held = study.slip_study(problem, rows, "both", x, known)
    assert held.stick_length_mm[-2:] == pytest.approx(0.0)
    assert np.abs(np.diff(held.tangential_force)[-2:]).min() > known.floor  # F_n alone moves it.
    assert np.isnan(held.response[-2:]).all()
    assert (held.gage_area_mm[-2:] == held.gage_area_mm[-3]).all()
    unknown = replace(known, stiffness=0.0)
    assert np.isfinite(study.slip_study(problem, rows, "both", x, unknown).response[-2:]).all()


def studied(problem, values=None, **changes):
    """The studies of a case whose path is shallow."""
    shallow = {"grip.fundamental_approach_mm": 0.05}
    case = Case(with_values(load_design("maeno2000"), shallow | (values or {})), **changes)
    return slip_studies(case, case.path_scene, problem)


def test_a_study_is_at_the_frictions_the_noise_and_the_share_of_its_case(problem):
    found = studied(problem, surface=SceneObject(friction_coefficient=0.6))
    assert [each.friction_coefficient for each in found] == [0.2, 0.35, 0.5, 0.6, 0.7, 1.0]
    values = {"grip.hardware.force_noise_N": 0.02, "gages.area_share": 0.25}
    plain, other = found[0], studied(problem, values)[0]
    assert (plain.force_floor_N, other.force_floor_N) == pytest.approx((0.015, 0.06))
    assert other.threshold == pytest.approx(0.5 * plain.threshold)
    assert len(plain.stick_ratio) == 4 * 8
    by_share = dict(plain.rank_by_share)
    for share in (0.4, 0.5, 0.7):
        same = studied(problem, {"gages.area_share": share})[0]
        assert same.rank_correlation == pytest.approx(by_share[share])
    for nothing in ({"studied": False}, {"scene": fundamental_scene()}):
        assert not studied(problem, **nothing)
    assert not studied(replace(problem, law=FrictionLaw(0.3, exponent=0.3, reference=0.1)))
