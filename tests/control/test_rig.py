"""The plants that a design's [grip] table asks for, their imperfections, whole grips, docs."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign import parse_design
from fingerdesign.checks.load import with_values
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.episode import run_episodes
from fingerdesign.control.plants.hardware import Hardware, ImperfectPlant
from fingerdesign.control.plants.plant import CondensedPlant, Truth
from fingerdesign.control.plants.remembered import Memory, RememberedPlant
from fingerdesign.control.plants.rig import Rig
from fingerdesign.control.signals import Sample
from fingerdesign.control.trace import read_trace
from fingerdesign.records.result_files import write_grip_csv
from tests.support.pages import blocks, run_python

MASS = 300.0
PAGE = "explanation/plants.md"


def lifting(design, **values):
    return with_values(design, {"grip.plant": "lift", "grip.hold_steps": 20, **values})


def test_tables_that_move_alike_share_a_calibration(half_plane, design):
    rig = Rig(half_plane, "both", design.grip)
    own = rig.calibration()
    held = design.grip.model_copy(update={"hold_force_N": 2.0 * design.grip.hold_force_N})
    assert rig.with_grip(held).calibration() is own
    for key in ("preload_mm", "approach_step_mm", "max_approach_mm"):
        other = design.grip.model_copy(update={key: 0.9 * getattr(design.grip, key)})
        found = rig.with_grip(other).calibration()
        assert found is not own
        again = Rig(half_plane, "both", other).calibration()
        assert np.array_equal(found.normal.readings, again.normal.readings)
    noisy = with_values(design, {"grip.hardware.gage_noise_microstrain": 1.0}).grip
    loud = rig.with_grip(noisy)
    assert loud.with_grip(noisy.model_copy(update={"seed": 1})).calibration() is not (
        loud.calibration()
    )


def test_by_default_it_is_the_finger_alone_and_perfect(half_plane, design):
    rig = Rig(half_plane, "both", design.grip)
    assert design.grip.hardware == Hardware()
    plain = CondensedPlant(half_plane.with_friction(0.3), "both")
    plant = rig.plant(0.3, MASS)
    for dx, dy in [(0.0, 0.05), (0.01, 0.01)]:
        one, two = plain.move(dx, dy), plant.move(dx, dy)
        assert np.array_equal(one.readings, two.readings)
    grip = design.grip
    bench = calibrate(
        lambda: CondensedPlant(half_plane.with_friction(grip.bench_friction_coefficient), "both"),
        half_plane.model.gage_x,
        Bounds.of(grip),
    )
    assert np.array_equal(bench.full_stick, rig.calibration().full_stick)


@pytest.mark.parametrize("plant", ["finger", "lift"])
def test_gages_are_read_from_left_to_right(half_plane, design, plant):
    """Pressed at its crest, rubber at 45 degrees shortens to the left and stretches to the right:
    Flamant's radial stress has that sign on either side."""
    rig = Rig(half_plane, "both", with_values(design, {"grip.plant": plant}).grip)
    readings = rig.plant(0.3, MASS).move(0.0, 0.05).readings
    away = np.abs(half_plane.model.gage_x) > 0.1
    assert (np.sign(readings) == np.sign(half_plane.model.gage_x))[away].all()


@pytest.mark.parametrize("kinetic", [1.0, 0.8])
def test_the_bench_measures_what_the_tangential_cell_feels_of_the_normal_force(
    half_plane, design, kinetic
):
    """To rounding without noise, whatever the cells' gains; nothing where there is nothing."""
    keys = {"grip.kinetic_share": kinetic, "grip.hardware.force_gain_spread": 0.01}
    for cross_talk in (0.0, 0.02):
        grip = with_values(design, {**keys, "grip.hardware.force_cross_talk": cross_talk}).grip
        rig = Rig(half_plane, "both", grip)
        bench = rig.calibration()
        normal_gain, tangential_gain = grip.hardware.force_gains()
        expected = cross_talk * tangential_gain / normal_gain
        assert bench.cross_talk == pytest.approx(expected, abs=1e-7)
        plant, clean = rig.plant(0.3, MASS), Rig(half_plane, "both", design.grip).plant(0.3, MASS)
        for move in ((0.0, 0.1), (0.005, 0.0)):
            corrected, true = bench.corrected(plant.move(*move)), clean.move(*move)
        assert corrected.tangential_force == pytest.approx(
            tangential_gain * true.tangential_force, rel=1e-6
        )


def test_every_controller_has_forces_without_cross_talk(half_plane, design):
    """A hand that grips by forces alone makes the same moves with it and without."""
    paths = []
    for cross_talk in (0.0, 0.05):
        keys = {"grip.controller": "fixed_ratio", "grip.hardware.force_cross_talk": cross_talk}
        (episode,) = run_episodes(Rig.of(half_plane, with_values(design, keys)), [0.5], MASS)
        paths.append(episode.trace)
    assert paths[0].dx == pytest.approx(paths[1].dx, rel=1e-6)


@pytest.mark.parametrize("plant", ["finger", "lift"])
def test_what_slides_has_the_kinetic_share_of_its_friction(half_plane, design, plant):
    keys = {"grip.plant": plant, "grip.kinetic_share": 0.8}
    rig = Rig(half_plane, "both", with_values(design, keys).grip)
    own = rig.plant(0.3, 5000.0)  # too heavy to lift: the support carries the rest
    own.move(0.0, 0.1)
    uses = []
    for _ in range(40):
        own.move(0.01, 0.0)
        truth = own.truth()
        uses.append(truth.tangential_force / (0.3 * truth.normal_force))
    assert truth.complete_slip
    assert 0.8 < max(uses) <= 1.0
    assert uses[-1] == pytest.approx(0.8, rel=1e-6)
    plain = Rig(half_plane, "both", design.grip).calibration()
    assert np.array_equal(rig.calibration().full_stick, plain.full_stick)  # it is the object's


def test_a_lifted_object_is_held_on_at_its_weight(half_plane, design, tmp_path):
    (episode,) = run_episodes(Rig.of(half_plane, lifting(design)), [0.4], MASS)
    result, trace = episode.result, episode.trace
    assert (result.lifted, result.gross_slip) == (True, False), episode.result.ending
    after = trace.tangential_force[trace.lift_step :]
    assert len(after) == 21
    assert (trace.rise[: trace.lift_step] == 0.0).all()
    assert (trace.rise[trace.lift_step :] > 0.0).all()
    assert "hangs" in result.ending
    assert after == pytest.approx(0.5e-3 * 9.80665 * MASS, rel=1e-6)
    assert result.safety_margin == pytest.approx(
        0.4 * trace.normal_force[trace.lift_step] / after[0], rel=1e-6
    )
    for rise, there in ((trace.rise, True), (None, False)):  # in the grip's table, too
        write_grip_csv(tmp_path / "grip.csv", replace(trace, rise=rise))
        header, *_, last = (tmp_path / "grip.csv").read_text("utf-8").splitlines()
        cells = dict(zip(header.split(","), last.split(","), strict=True))
        assert ("rise_mm" in cells) is there
        assert not there or float(cells["rise_mm"]) == rise[-1]


TUG = {"grip.tugs": [{"step_after_lift": 10, "extra_force_N": 40.0}]}


def weighs(mass):
    return {"grip.weight_changes": [{"step_after_lift": 5, "object_mass_g": mass}]}


@pytest.mark.parametrize(("values", "dropped"), [(TUG, 10), (weighs(3e3), 5), (weighs(310.0), 0)])
def test_a_tug_and_a_change_of_weight_are_carried_or_not(half_plane, design, values, dropped):
    (episode,) = run_episodes(Rig.of(half_plane, lifting(design, **values)), [0.4], MASS)
    result, trace = episode.result, episode.trace
    assert (result.lifted, result.gross_slip) == (True, bool(dropped))
    assert len(trace.dx) == trace.lift_step + 1 + (dropped or 20)
    assert (result.slip_distance_mm > 0.0) == bool(dropped)
    # The force that holds to the end, and its excess, are of the most that pulls.
    most = {10: 9.80665e-3 * MASS + 40.0, 5: 29.41995, 0: 1e-3 * 9.80665 * 310.0}[dropped]
    assert result.most_pull_N == pytest.approx(most, rel=1e-6)
    assert result.holding_force_N == pytest.approx(0.5 * most / 0.4, rel=1e-6)
    assert result.peak_ratio == result.peak_normal_force_N / result.holding_force_N
    if not dropped:
        carried = 2.0 * result.final_tangential_force_N
        assert carried == pytest.approx(1e-3 * 9.80665 * 310.0, rel=1e-6)


def test_noise_is_the_seeds_and_the_same_for_the_comparison(half_plane, design):
    noisy = {"grip.hardware.gage_noise_microstrain": 0.5, "grip.max_steps": 12}

    def readings(seed):
        own = with_values(design, {**noisy, "grip.seed": seed})
        (episode,) = run_episodes(Rig.of(half_plane, own), [0.4], MASS)
        return episode.trace.gage_readings, episode.trace.without_rule.gage_readings

    first, again, other = readings(1), readings(1), readings(2)
    assert np.array_equal(first[0], again[0])
    assert not np.array_equal(first[0], other[0])
    # With the rule and without, up to where they part.
    assert np.array_equal(first[0][:9], first[1][:9])


@pytest.mark.parametrize("delay", [0, 2, 300])
def test_the_bench_finds_the_delay_through_the_noise(half_plane, design, delay):
    hardware = {"delay_samples": delay, "force_noise_N": 0.01, "gage_noise_microstrain": 1.0}
    own = with_values(design, {f"grip.hardware.{key}": value for key, value in hardware.items()})
    bench = Rig(half_plane, own.gages.face, own.rig).calibration()
    assert bench.delay == delay
    # A contact's stiffness against shear rises with its width, as the depth does.
    assert (np.diff(bench.stiffness) > 0.0).all()
    assert bench.stiffness[0] == pytest.approx(bench.tangential_stiffness, rel=0.1)
    quiet = Rig(half_plane, design.gages.face, design.rig).calibration()
    assert bench.stiffness == pytest.approx(quiet.stiffness, rel=0.02)
    assert (np.diff(bench.approach) > 0.0).all()


def test_dead_gages_are_those_of_their_plates(half_plane, design):
    own = with_values(design, {"grip.hardware.dead_gages": [4]})
    plates = [2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12]
    plant = Rig(half_plane, "both", own.grip, plates).plant(0.3, MASS)
    readings = plant.move(0.0, 0.1).readings
    assert np.flatnonzero(readings == 0.0).tolist() == [2]


def felt_by(plant_class, moves=((0.0, 0.1), (0.01, 0.0)), **hardware):
    """Samples of a plant that always feels the same, as hardware feels them."""
    plant = ImperfectPlant(plant_class(), Hardware(**hardware), np.random.default_rng(0))
    return [plant.move(*each) for each in moves]


class Steady:
    """Readings 1, 2, 4 and 8 microstrain, 10 N and 3 N."""

    def move(self, dx, dy):
        return Sample(np.array([1.0, 2.0, 4.0, 8.0]), 10.0, 3.0)


def test_gages_and_force_cells_have_cross_talk_and_cells_gains_of_their_specimen():
    first, _ = felt_by(Steady, gage_cross_talk=0.1)
    assert first.readings == pytest.approx([1.2, 2.5, 5.0, 8.4])
    cells = {"force_gain_spread": 0.01, "force_cross_talk": 0.02}
    felt, again = felt_by(Steady, **cells)
    assert felt.normal_force == again.normal_force  # a gain is no noise
    assert felt.tangential_force == again.tangential_force
    assert 0.0 < abs(felt.normal_force / 10.0 - 1.0) < 0.05
    assert 0.0 < abs(felt.tangential_force / 3.2 - 1.0) < 0.05
    assert felt_by(Steady, **cells, specimen=1)[0].normal_force != felt.normal_force
    assert felt_by(Steady, specimen=1)[0].normal_force == 10.0


def test_what_warms_drifts_alike_toward_its_end():
    warm = {"warming_microstrain": 10.0, "warming_time_s": 0.02, "sample_rate_Hz": 100.0}
    samples = felt_by(Steady, [(0.0, 0.0)] * 40, **warm)
    shifts = np.array([each.readings for each in samples]) - [1.0, 2.0, 4.0, 8.0]
    assert np.ptp(shifts, axis=1) == pytest.approx(0.0, abs=1e-12)
    assert shifts[1, 0] == pytest.approx(10.0 * (1.0 - np.exp(-1.0)))
    assert shifts[-1, 0] == pytest.approx(10.0, rel=1e-6)


def test_a_gage_dies_during_the_grip_and_never_on_the_bench():
    dying = {"dying_gages": [2], "dying_after_s": 0.015, "sample_rate_Hz": 100.0}
    alive, dead = felt_by(Steady, **dying)
    assert alive.readings.tolist() == [1.0, 2.0, 4.0, 8.0]
    assert dead.readings.tolist() == [1.0, 2.0, 0.0, 8.0]
    rested = Hardware(**dying, warming_microstrain=5.0).at_rest()
    assert (rested.dying_gages, rested.warming_microstrain) == ((), 0.0)


# A plant that remembers: the same answers, fewer moves.

MOVES = [(0.0, 0.02), (0.0, 0.02), (0.002, 0.01), (0.004, 0.01), (0.004, 0.0)]

OTHER = [*MOVES[:3], (0.0, 0.01), (0.001, 0.01)]


@pytest.mark.parametrize(
    ("grips", "solved"),
    [
        ([MOVES, MOVES], MOVES),  # the same moves are solved once
        ([MOVES[:3], MOVES], MOVES),  # a longer grip goes on from where the shorter stood
        ([MOVES, OTHER], [*MOVES, *OTHER]),  # another move goes its own way, from the start
    ],
)
def test_remembered_moves_are_solved_once(half_plane, grips, solved):
    moved, memory = [], Memory()

    class Counting(CondensedPlant):
        def move(self, dx, dy):
            moved.append((dx, dy))
            return super().move(dx, dy)

    for moves in grips:
        plain = CondensedPlant(half_plane, "both")
        plant = RememberedPlant(lambda: Counting(half_plane, "both"), memory)
        for move in moves:
            assert np.array_equal(plant.move(*move).readings, plain.move(*move).readings)
            assert plant.truth() == plain.truth()
    assert moved == solved


# Each imperfection does what it says, and equal seeds read alike.


class Ramp:
    """Feels its own way: gage k reads (k + 1) 100 x, the forces are y and x."""

    def __init__(self, gages=4):
        self.x = self.y = 0.0
        self.factors = 100.0 * np.arange(1, gages + 1)

    def move(self, dx, dy):
        self.x += dx
        self.y += dy
        return Sample(self.factors * self.x, self.y, self.x, lifted=self.x > 0.5, torque=0.0)

    def truth(self):
        return Truth(self.y, self.x, self.y, self.x, 0.5, 0.0, False)


class Springs:
    """Shear raises both forces; gage k reads a_k F_n + b_k F_t."""

    alone, sticking = np.array([10.0, -4.0]), np.array([3.0, 7.0])

    def __init__(self):
        self.x = self.y = 0.0

    def move(self, dx, dy):
        self.x += dx
        self.y += dy
        normal, tangential = 5.0 * self.y + 2.0 * self.x, 4.0 * self.x
        return Sample(self.alone * normal + self.sticking * tangential, normal, tangential)


def test_responses_to_shear_are_without_what_the_normal_force_does():
    found = calibrate(Springs, np.array([-1.0, 1.0]), Bounds(0.2, 0.1, 1.0, 40))
    assert found.full_stick == pytest.approx(Springs.sticking)
    assert found.sticking.readings == pytest.approx(
        np.tile(Springs.sticking, (len(found.stiffness), 1))
    )
    assert found.stiffness == pytest.approx(4.0)


def test_a_finger_that_is_felt_some_steps_after_the_touch_is_calibrated_from_there_on():
    class Late(Springs):
        def __init__(self):
            super().__init__()
            self.y = -0.25

        def move(self, dx, dy):
            felt = super().move(dx, dy)
            return felt if self.y > 0.0 else Sample(0.0 * felt.readings, 0.0, 0.0)

    found = calibrate(Late, np.array([-1.0, 1.0]), Bounds(0.5, 0.1, 1.0, 40))
    assert found.normal.normal_force[0] == 0.0
    assert found.approach == pytest.approx(np.arange(2, 11) / 10.0)
    assert found.normal.normal_force[1:] == pytest.approx(5.0 * (found.approach[1:] - 0.25))
    assert found.full_stick == pytest.approx(Springs.sticking)


def test_an_estimator_in_a_grip_is_that_of_the_hardwares_noise(half_plane, design):
    noises = []

    class Recorder:
        def at_noise(self, noise):
            noises.append(noise)
            return self

    for noise in (0.0, 0.7):
        keys = {"grip.hardware.gage_noise_microstrain": noise, "grip.controller": "fixed_force"}
        run_episodes(Rig.of(half_plane, with_values(design, keys)), [], MASS, estimator=Recorder())
    assert noises == [0.7]


def imperfect(seed=0, plates=None, **hardware):
    return ImperfectPlant(Ramp(), Hardware(**hardware), np.random.default_rng(seed), plates)


def read(plant, moves=200, dx=0.0):
    return np.array([plant.move(dx, 0.01).readings for _ in range(moves)])


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


def test_at_rest_the_mean_of_many_samples_is_left():
    noisy = {"gage_noise_microstrain": 2.0, "force_noise_N": 0.5, "drift_microstrain_per_s": 1.0}
    lasting = {"gain_spread": 0.05, "backlash_mm": 0.01, "stage_step_mm": 0.001}
    hardware = Hardware(**noisy, **lasting, dead_gages=(3,), delay_samples=4, actuator_lag_s=0.1)
    rest = hardware.at_rest(100)
    assert (rest.gage_noise_microstrain, rest.force_noise_N) == pytest.approx((0.2, 0.05))
    assert rest.torque_noise_Nmm is None
    assert Hardware(torque_noise_Nmm=0.5).at_rest(100).torque_noise_Nmm == pytest.approx(0.05)
    assert (rest.drift_microstrain_per_s, rest.delay_samples) == (0.0, 0)
    assert rest.actuator_lag_s == 0.0
    assert np.array_equal(rest.gains(range(5)), hardware.gains(range(5)))
    assert (rest.stage_step_mm, rest.backlash_mm) == (0.001, 0.01)


def test_its_design_is_sound_and_says_every_key_of_the_hardware():
    design = parse_design(blocks(PAGE, "toml")[0])
    assert design.grip.plant == "lift"
    given = design.grip.hardware.model_fields_set
    assert set(type(design.grip.hardware).model_fields) - given == {"specimen"}


@pytest.mark.slow
def test_a_lift_is_recorded_and_a_hand_of_ones_own_grips(tmp_path, in_tmp_path, capsys):
    run_python(PAGE)
    lifted, carried, rise = capsys.readouterr().out.split()
    assert lifted == "True"
    assert float(carried) == pytest.approx(0.2 * 9.80665, abs=1e-3)
    assert float(rise) > 0.01
    assert len(read_trace(tmp_path / "grip.csv", 15))
    run_python(PAGE, 1)
    lifted, margin, *reason = capsys.readouterr().out.split()
    assert (lifted, float(margin)) == ("True", pytest.approx(2.4, abs=0.3))
    assert "hangs" in " ".join(reason)


@pytest.mark.parametrize(
    ("share", "controller", "caught"),
    [(1.2, "reactive", None), (1.6, "reactive", True), (2.2, "fixed_force", False)],
)
def test_a_weight_that_grows_is_carried_caught_or_dropped(
    half_plane, design, share, controller, caught
):
    """By a hand that answers, and by one that holds what it held."""
    heavier = {"step_after_lift": 100, "object_mass_g": share * MASS}
    found = lifting(
        design,
        **{
            "grip.controller": controller,
            "grip.inertia": True,
            "grip.hold_steps": 200,
            "grip.approach_step_mm": 0.01,
            "grip.weight_changes": [heavier],
            "grip.fixed_force.force_N": 4.5,
        },
    )
    (episode,) = run_episodes(Rig.of(half_plane, found), [0.6], MASS)
    result = episode.result
    assert result.lifted
    assert (result.caught, result.gross_slip) == (caught, caught is not None)
    assert (
        episode.result.outcome == {None: "lifted", True: "caught", False: "complete slip"}[caught]
    )
    assert (result.slid_mm > 0.0, result.catch_s is not None) == (caught is not None, bool(caught))
    assert (f"{result.slid_mm:.2f} mm" in episode.result.ending) == (caught is not None)
    assert 20.0 < result.swing_Hz < 500.0
    slipped = episode.trace.stick_ratio[100:] == 0.0
    assert slipped.any() == (caught is not None)
    if caught is not None:  # what is judged of warnings ends where the slip begins
        assert len(episode.to_slip.dx) == 101 + int(np.argmax(slipped))
        assert slipped[-1] == (caught is False)
    assert (result.success, result.holds_object) == (caught is None, caught is None)


def test_noise_has_its_size_and_its_seed_and_the_truth_has_none():
    plant = imperfect(gage_noise_microstrain=0.5, force_noise_N=0.02)
    samples = [plant.move(0.0, 0.0) for _ in range(2000)]
    assert np.std([s.readings for s in samples]) == pytest.approx(0.5, rel=0.05)
    assert np.std([s.normal_force for s in samples]) == pytest.approx(0.02, rel=0.1)
    assert np.std([s.tangential_force for s in samples]) == pytest.approx(0.02, rel=0.1)
    assert plant.truth().normal_force == 0.0
    assert {s.torque for s in samples} == {None}  # its cell has two axes
    cell = imperfect(torque_noise_Nmm=0.1)
    torques = [cell.move(0.0, 0.0).torque for _ in range(2000)]
    assert np.std(torques) == pytest.approx(0.1, rel=0.1)
    one, same, other, louder = (
        read(imperfect(seed, gage_noise_microstrain=level))
        for seed, level in ((3, 1.0), (3, 1.0), (4, 1.0), (3, 10.0))
    )
    assert np.array_equal(one, same)
    assert not np.array_equal(one, other)
    assert louder == pytest.approx(10.0 * one)


@pytest.mark.parametrize(
    ("hardware", "moves", "ways"),
    [
        ({"stage_step_mm": 0.01}, [0.004] * 5, [0.0, 0.01, 0.01, 0.02, 0.02]),  # forgets nothing
        # A turn loses the backlash once.
        (
            {"backlash_mm": 0.03},
            [0.1, 0.1, -0.02, -0.02, -0.1, 0.02, 0.1],
            [0.1, 0.2, 0.2, 0.19, 0.09, 0.09, 0.18],
        ),
        (
            {"actuator_lag_s": 0.03, "sample_rate_Hz": 100.0},
            [0.06, 0.0, 0.0, 0.0, 0.0],
            0.06 * -np.expm1(-np.arange(1, 6) / 3.0),
        ),
    ],
)
@pytest.mark.parametrize("along", ["shear", "approach"])
def test_the_stage_has_steps_backlash_and_lag(hardware, moves, ways, along):
    plant, found = imperfect(**hardware), []
    for each in moves:
        plant.move(*((each, 0.0) if along == "shear" else (0.0, each)))
        found.append(getattr(plant.truth(), along))
    assert found == pytest.approx(ways, abs=1e-12)
