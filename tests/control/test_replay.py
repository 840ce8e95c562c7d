"""A controller and an estimator along a recorded grip."""

import numpy as np
import pytest

from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.estimator import LAGS, Estimated
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.plants.recorded import RecordedPlant, replay, trace_of
from fingerdesign.control.roster import Command
from fingerdesign.errors import DesignError


@pytest.fixture(scope="module")
def bench(half_plane):
    return calibrate(
        lambda: CondensedPlant(half_plane, "both"),
        half_plane.model.gage_x,
        Bounds(0.04, 0.01, 0.2, 0),
    )


@pytest.fixture(scope="module")
def trace(half_plane):
    plant = CondensedPlant(half_plane, "both")
    moves = [(0.002 if k > 4 else 0.0, 0.01) for k in range(20)]
    return trace_of([plant.move(*move) for move in moves], moves, 100.0)


class Echo:
    """Asks for a hundredth of what it feels."""

    name = "echo"

    def start(self, calibration, sample):
        self.began = sample.normal_force

    def command(self, sample):
        return Command(0.01 * sample.normal_force, 0.0, False)


class Counting:
    """An estimator that tells how long its history is, and how far it has been sheared."""

    gages = 11

    def estimate(self, history):
        return Estimated(float(len(history)), float(sum(each.dx for each in history)), 0.0)


def test_a_controller_is_requested_from_the_preload_on(bench, trace):
    hand = Echo()
    steps = list(replay(RecordedPlant(trace), bench, 0.04, hand))
    assert hand.began == trace.normal_force[3]
    assert [step.row for step in steps] == list(range(6, 22))
    assert [step.requested.dx for step in steps] == pytest.approx(0.01 * trace.normal_force[4:])
    assert [step.dx for step in steps] == trace.dx[4:].tolist()
    assert np.array_equal(steps[0].sample.readings, trace.readings[4])
    assert steps[0].estimated is None


def test_an_estimator_samples_the_moves_that_the_rig_made(bench, trace):
    steps = list(replay(RecordedPlant(trace), bench, 0.04, Echo(), Counting()))
    most = max(LAGS) + 1
    assert [step.estimated.stick_ratio for step in steps] == [min(k, most) for k in range(5, 21)]
    assert steps[-1].estimated.used == pytest.approx(trace.dx[-most:].sum())


def test_what_does_not_fit_is_refused(bench, trace):
    with pytest.raises(DesignError, match=r"row 21, column dy_mm = 0.2: must be rows that close"):
        list(replay(RecordedPlant(trace), bench, 0.5, Echo()))
    other = Counting()
    other.gages = 7
    with pytest.raises(DesignError, match="11 gages: must be 7, for which the estimator"):
        list(replay(RecordedPlant(trace), bench, 0.04, Echo(), other))
