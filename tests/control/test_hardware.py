"""Imperfect hardware: each imperfection does what it says, and equal seeds read alike."""

import numpy as np
import pytest

from fingerdesign.control.plants.plant import CondensedPlant, Truth, press
from fingerdesign.control.plants.rig import Hardware, ImperfectPlant
from fingerdesign.control.signals import Sample


class Ramp:
    """Feels its own way: gage k reads (k + 1) 100 x, the forces are y and x."""

    def __init__(self, gages=4):
        self.x = self.y = 0.0
        self.factors = 100.0 * np.arange(1, gages + 1)

    def move(self, dx, dy):
        self.x += dx
        self.y += dy
        return Sample(self.factors * self.x, self.y, self.x, lifted=self.x > 0.5)

    def truth(self):
        return Truth(self.y, self.x, self.y, self.x, 0.5, 0.0, False)


def imperfect(seed=0, plates=None, **hardware):
    return ImperfectPlant(Ramp(), Hardware(**hardware), np.random.default_rng(seed), plates)


def read(plant, moves=200, dx=0.0):
    return np.array([plant.move(dx, 0.01).readings for _ in range(moves)])


def test_perfect_hardware_changes_nothing(half_plane):
    plain = list(press(CondensedPlant(half_plane, "upper"), 0.05, 0.01))
    plant = ImperfectPlant(
        CondensedPlant(half_plane, "upper"), Hardware(), np.random.default_rng(1)
    )
    through = list(press(plant, 0.05, 0.01))
    for a, b in zip(plain, through, strict=True):
        assert np.array_equal(a.readings, b.readings)
        assert (a.normal_force, a.tangential_force) == (b.normal_force, b.tangential_force)


def test_noise_has_its_size_and_the_truth_has_none():
    plant = imperfect(gage_noise_microstrain=0.5, force_noise_N=0.02)
    samples = [plant.move(0.0, 0.0) for _ in range(2000)]
    assert np.std([s.readings for s in samples]) == pytest.approx(0.5, rel=0.05)
    assert np.std([s.normal_force for s in samples]) == pytest.approx(0.02, rel=0.1)
    assert np.std([s.tangential_force for s in samples]) == pytest.approx(0.02, rel=0.1)
    assert plant.truth().normal_force == 0.0


def test_equal_seeds_read_alike_and_levels_differ_in_scale_alone():
    one, same, other, louder = (
        read(imperfect(seed, gage_noise_microstrain=level))
        for seed, level in ((3, 1.0), (3, 1.0), (4, 1.0), (3, 10.0))
    )
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
    assert louder == pytest.approx(10.0 * one)


def test_each_gage_drifts_at_a_steady_rate_of_its_own():
    readings = read(imperfect(drift_microstrain_per_s=2.0, sample_rate_Hz=50.0))
    rates = np.diff(readings, axis=0) * 50.0
    assert rates == pytest.approx(np.broadcast_to(rates[0], rates.shape))
    assert len(set(np.round(rates[0], 6))) == 4
    many = [read(imperfect(seed, drift_microstrain_per_s=2.0), 1) * 100.0 for seed in range(200)]
    assert np.std(many) == pytest.approx(2.0, rel=0.1)


def test_gains_belong_to_the_specimen_and_its_plates():
    first, again = (read(imperfect(seed, gain_spread=0.05), 5, 0.01) for seed in (1, 2))
    assert np.array_equal(first, again)
    clean = read(imperfect(), 5, 0.01)
    gains = first / clean
    assert gains == pytest.approx(np.broadcast_to(gains[0], gains.shape))
    assert np.ptp(gains[0]) > 0.01
    other = read(imperfect(gain_spread=0.05, specimen=1), 5, 0.01)
    assert not np.allclose(other, first)
    chosen = read(imperfect(plates=[3, 2, 1, 0], gain_spread=0.05), 5, 0.01)
    assert (chosen / clean)[0] == pytest.approx(gains[0][::-1])
    wide = Hardware(gain_spread=0.05).gains(list(range(2000)))
    assert (wide.mean(), wide.std()) == pytest.approx((1.0, 0.05), abs=5e-3)


def test_a_dead_gage_reads_nothing_useful():
    readings = read(imperfect(dead_gages=(1,), plates=[0, 1, 2, 3]), 5, 0.01)
    assert (readings[:, 1] == 0.0).all()
    assert (readings[:, [0, 2, 3]] > 0.0).all()
    noisy = read(imperfect(dead_gages=(1,), gage_noise_microstrain=0.5), 400, 0.01)[:, 1]
    assert abs(np.corrcoef(noisy, np.arange(400))[0, 1]) < 0.2


def test_the_converter_has_steps():
    readings = read(imperfect(quantisation_microstrain=0.8, gage_noise_microstrain=1.0))
    assert readings / 0.8 == pytest.approx(np.round(readings / 0.8))
    assert len(np.unique(np.round(readings / 0.8))) > 3


def test_the_hand_samples_all_of_it_late():
    plant, prompt = imperfect(delay_samples=3), imperfect()
    late = [plant.move(0.1, 0.02) for _ in range(12)]
    now = [prompt.move(0.1, 0.02) for _ in range(12)]
    for sampled, felt in zip(late[3:], now, strict=False):
        assert np.array_equal(sampled.readings, felt.readings)
        assert sampled.normal_force == felt.normal_force
        assert sampled.lifted == felt.lifted
    assert all((s.readings == 0).all() and s.normal_force == 0.0 for s in late[:3])
    assert plant.truth() == prompt.truth()


def test_the_stage_moves_in_whole_steps_and_forgets_nothing():
    plant = imperfect(stage_step_mm=0.01)
    ways = []
    for _ in range(100):
        plant.move(0.0, 0.004)
        ways.append(plant.truth().approach)
    steps = np.array(ways) / 0.01
    assert steps == pytest.approx(np.round(steps))
    assert np.abs(np.array(ways) - 0.004 * np.arange(1, 101)).max() <= 0.005 + 1e-12
    assert ways[-1] == pytest.approx(0.4)


def test_a_turn_of_the_stage_loses_the_backlash_once():
    plant = imperfect(backlash_mm=0.03)
    ways = []
    for dx in (0.1, 0.1, -0.02, -0.02, -0.1, 0.02, 0.1):
        plant.move(dx, 0.0)
        ways.append(plant.truth().shear)
    assert ways == pytest.approx([0.1, 0.2, 0.2, 0.19, 0.09, 0.09, 0.18])


def test_at_rest_the_mean_of_many_samples_is_left():
    hardware = Hardware(
        gage_noise_microstrain=2.0,
        drift_microstrain_per_s=1.0,
        gain_spread=0.05,
        dead_gages=(3,),
        quantisation_microstrain=0.1,
        force_noise_N=0.5,
        delay_samples=4,
        backlash_mm=0.01,
        stage_step_mm=0.001,
    )
    rest = hardware.at_rest(100)
    assert (rest.gage_noise_microstrain, rest.force_noise_N) == pytest.approx((0.2, 0.05))
    assert (rest.drift_microstrain_per_s, rest.delay_samples) == (0.0, 0)
    assert np.array_equal(rest.gains(range(5)), hardware.gains(range(5)))
    assert (rest.stage_step_mm, rest.backlash_mm) == (0.001, 0.01)
