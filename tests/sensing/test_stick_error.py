"""The gage error of the stick ratio: what it must see in gages, and that it is repeatable."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.control.signals import NormalCalibration
from fingerdesign.design.grip import HardwareTable
from fingerdesign.errors import SolverError
from fingerdesign.sensing.model import grip_problem
from fingerdesign.sensing.train.stick_error import (
    GRIPS,
    Instants,
    SensorErrors,
    instants,
    sampled_error,
    stick_error,
)

REACH = 0.3


@pytest.fixture(scope="module")
def problem():
    coarse = {"mesh.section.plate_size_mm": 0.2, "mesh.section.contact_size_mm": 0.2}
    fewer = {"plates.count": 7, "plates.pitch_mm": 1.5}
    return grip_problem(with_values(load_design("sensitive"), coarse | fewer))


@pytest.fixture(scope="module")
def found(problem):
    return instants(problem, "upper", REACH)


def made(answer, noise=0.5):
    """The error of made-up instants whose two gages answer to the stick ratio so strongly."""
    rng = np.random.default_rng(5)
    grip = np.repeat(np.arange(GRIPS), 10)
    stick = np.tile(np.linspace(1.0, 0.1, 10), GRIPS)
    normal = np.exp(rng.uniform(0.0, 2.0, len(grip)))
    readings = normal[:, None] * answer * np.column_stack([stick, stick**2])
    forces = np.column_stack([normal, rng.uniform(0.1, 0.5, len(grip)) * normal])
    flat = NormalCalibration(np.array([0.0, 100.0]), np.zeros((2, 2)))
    return sampled_error(Instants(readings, forces, stick, grip), flat, SensorErrors(noise))


def test_it_falls_with_what_gages_answer_over_their_noise():
    found = [made(answer) for answer in (0.0, 0.5, 5.0, 500.0)]
    assert found == sorted(found, reverse=True)
    assert found[0] == pytest.approx(np.std(np.linspace(1.0, 0.1, 10)), rel=0.25)  # a guess
    assert found[-1] < 0.05
    assert made(50.0, 5.0) == pytest.approx(found[2], rel=1e-6)


def test_no_tested_grip_is_trained_on():
    """Each grip has a gage of its own, and one stick ratio by lot: only a learner that has seen the
    grip knows it."""
    rng = np.random.default_rng(8)
    grip = np.repeat(np.arange(GRIPS), 10)
    stick = rng.integers(0, 2, GRIPS).astype(float)[grip]
    readings = 100.0 * np.eye(GRIPS)[grip]
    forces = np.ones((len(grip), 2))
    flat = NormalCalibration(np.array([0.0, 100.0]), np.zeros((2, GRIPS)))
    error = sampled_error(Instants(readings, forces, stick, grip), flat, SensorErrors(0.5))
    assert error > 0.45  # half is a guess


def test_grips_cover_stick_and_slip(found):
    assert len(np.unique(found.grip)) == GRIPS
    assert found.stick.min() < 0.1
    assert found.stick.max() > 0.9
    assert (found.forces > 0.0).all()


def test_noise_raises_it_and_a_seed_has_its_own(problem):
    errors = [stick_error(problem, "upper", REACH, SensorErrors(noise)) for noise in (0.5, 20, 1e4)]
    assert errors[0] < 0.8 * errors[1] < errors[2]
    assert errors[2] > 0.18
    first, again, other = (stick_error(problem, "upper", REACH, seed=seed) for seed in (3, 3, 4))
    assert first == again != other


def test_gages_far_from_the_contact_tell_less_and_none_is_an_error(problem):
    def sampled(*gages):
        few = replace(problem, model=problem.model.with_gages(gages))
        return stick_error(few, "upper", REACH, seed=1)

    assert sampled(2, 3, 4) < sampled(0, 6)
    with pytest.raises(SolverError, match="no gages"):
        sampled()


def test_what_hardware_leaves_perfect_is_a_good_amplifiers():
    assert SensorErrors.of(HardwareTable()) == SensorErrors()
    given = HardwareTable(gage_noise_microstrain=3.0, force_noise_N=0.1, gain_spread=0.05)
    assert SensorErrors.of(given) == SensorErrors(3.0, 0.1, 0.05)
    stepped = SensorErrors.of(HardwareTable(quantisation_microstrain=12.0))
    assert stepped.noise == pytest.approx(np.hypot(0.5, 12.0**0.5))
