"""``fingerdesign identify DESIGN BENCH``: a bench's files, a finger's curves and hidden values."""

import json
import re
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest
from fingerdesign_cli.main import main

from fingerdesign import load_design, parse_design
from fingerdesign.checks.load import with_values
from fingerdesign.control.bench_curves import Phase, Points, bench_curves, points_of
from fingerdesign.control.bench_table import read_bench
from fingerdesign.control.calibration import Bounds, calibrate
from fingerdesign.control.completion import Relations
from fingerdesign.control.estimator import Band, GripEstimator, Layer
from fingerdesign.control.features import FingerCurves, feature_count
from fingerdesign.control.plants.hardware import ImperfectPlant
from fingerdesign.control.plants.plant import CondensedPlant
from fingerdesign.control.signals import Sample
from fingerdesign.control.trace import Trace, trace_of
from fingerdesign.errors import SolverError
from fingerdesign.layout.rows import plate_frames
from fingerdesign.sensing.identify import bench_fit
from fingerdesign.sensing.identify.bench import (
    COARSE,
    FINE,
    LEAN_STEP,
    BenchModel,
    bench_finger,
    protocol,
    simulated_bench,
)
from fingerdesign.sensing.identify.bench_fit import Measured, Noise, fit_latents
from fingerdesign.sensing.identify.bench_report import write_measured
from fingerdesign.sensing.identify.latents import Latent, with_latents
from fingerdesign.sensing.identify.sensitivities import differences
from fingerdesign.sensing.train.result import finger_key
from tests.sensing.conftest import FINGER
from tests.support.pages import DOCS, blocks, run_python

HARDWARE = """
[grip.hardware]
gage_noise_microstrain = 0.5
force_noise_N = 0.005
"""
# Bench and fit share their mesh: it may be coarse.
SIZES = "[mesh.section]\ncontact_size_mm = 0.4\nplate_size_mm = 0.5\nfar_size_mm = 3.0\n"
SOFT = FINGER[: FINGER.index("[mesh.section]")] + f"preload_mm = 0.02{HARDWARE}{SIZES}"
GAGES = 4
ALONE, STUCK = np.array([10.0, -4.0]), np.array([3.0, -7.0])  # readings by F_n and by F_t


def played(kind, rows, tilt=0.0, cross_talk=0.0, slid=0.0):
    """A phase of points (approach, shear, F_n, F_t); the cell of F_t feels F_n too."""
    approach, shear, normal, pull = np.array(rows).T
    readings = np.outer(normal, ALONE) + np.outer(pull, STUCK + slid)
    measured = pull + cross_talk * normal
    points = Points(approach, shear, normal, measured, readings, np.ones(len(rows)))
    return Phase(kind, kind, 0.5, tilt, points)


def test_curves_of_a_bench_are_those_of_its_phases():
    """Shears of another F_n, deeper ones first, and slides to either side, -x first."""
    press = [(0.1, 0, 2, 0), (0.2, 0, 1.5, 0), (0.3, 0, 6, 0), (0.2, 0, 7, 0), (0.5, 0, 10, 0)]
    phases = (
        played("press", press),
        played("shear", [(0.4, 0, 8, 0), (0.4, 0.02, 8.5, 0.3)]),
        played("shear", [(0.1, 0, 1, 0), (0.2, 0, 4, 0), (0.2, 0.01, 5, 0.1)]),
        played("slide", [(0.2, 0, 4, 0), (0.2, -0.1, 5, -2.5)], cross_talk=0.02, slid=1.0),
        played("slide", [(0.2, 0, 4, 0), (0.2, 0.05, 4, 1), (0.2, 0.1, 4, 2)], cross_talk=0.02),
        played("tilt", [(0.1, 0, 3, 0)], tilt=-2.0),
    )
    found = bench_curves(phases, np.arange(2.0))
    own = found.calibration
    # Points with less force, or less deep, than an earlier one are left out.
    assert own.normal.normal_force.tolist() == [0.0, 2.0, 6.0, 10.0]
    assert own.approach.tolist() == [0.0, 0.1, 0.3, 0.5]
    assert own.sticking.normal_force.tolist() == [4.0, 8.0]
    assert own.sticking.readings == pytest.approx(np.array([STUCK, STUCK]))
    assert own.stiffness == pytest.approx([10.0, 15.0])
    assert (own.tangential_stiffness, own.delay) == (pytest.approx(10.0), 0)
    assert own.full_stick == pytest.approx(np.abs(STUCK))
    assert (own.cross_talk, found.slid) == (pytest.approx(0.02), pytest.approx(0.5))
    right, left = found.slides
    assert right.tangential_force == pytest.approx([1.0, 2.0])
    assert right.responses == pytest.approx(np.outer([0.5, 1.0], STUCK))  # over F_t at the end
    assert left.responses == pytest.approx((STUCK + 1.0)[None])
    assert [tilt for tilt, _ in found.tilted] == [-2.0]
    assert bench_curves(phases[:4], np.arange(2.0)).calibration.cross_talk == 0.0
    # A quick press after three samples at rest, felt two samples late.
    felt = [Sample(np.zeros(2), 6.0 * (k >= 5), 0.0) for k in range(20)]
    trace = trace_of(felt, [(0.0, 0.3 * (k == 3)) for k in range(20)], 100.0)
    quick = replace(phases[0], kind="quick", trace=trace)
    assert bench_curves((*phases, quick), np.arange(2.0)).calibration.delay == 2


@pytest.fixture(scope="module")
def design():
    return parse_design(SOFT)


@pytest.fixture(scope="module")
def measured(design, tmp_path_factory):
    """The folder that a bench has left of a finger whose plate 2 lies 0.15 mm off along x."""
    folder = tmp_path_factory.mktemp("bench")
    (folder / "mine.toml").write_text(SOFT)
    bench = simulated_bench(moved(design, 2, 0.15), ["gains"], 1)
    write_measured(bench, folder)
    return folder


def moved(design, plate, way):
    rows = [[*each.centre, each.angle_deg] for each in plate_frames(design)]
    rows[plate][0] += way
    return with_values(design, {"plates.placement": [[float(v) for v in row] for row in rows]})


def estimator_file(design, folder):
    """Write an estimator without training: its numbers have no meaning."""
    forces, ones = np.array([0.0, 5.0]), np.ones((2, GAGES))
    curves = FingerCurves(forces, 0.0 * ones, ones, 0.01 * forces, np.full(2, 10.0), np.zeros(2))
    count = feature_count(GAGES)
    layer = Layer(np.zeros((count, 3)), np.array([0.7, 0.4, 0.1]))
    relations = Relations.of_neighbours(GAGES)
    numbers = np.zeros(count), np.ones(count), relations, (layer,), np.array([[1.0, 0.1]])
    band = Band(10.0, *numbers)
    key = finger_key(design)
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "estimator.json").write_text(GripEstimator(key, curves, 0.5, (band,)).to_json())
    return folder / "estimator.json"


def test_traces_give_the_calibration_that_the_rig_makes_of_the_same_plant(design, tmp_path):
    quiet = with_values(
        design,
        {
            "grip.hardware.gage_noise_microstrain": 0.0,
            "grip.hardware.force_noise_N": 0.0,
            "grip.hardware.delay_samples": 3,
            "grip.hardware.force_cross_talk": 0.01,
        },
    )
    bench = simulated_bench(quiet, [], 0)
    write_measured(bench, tmp_path)
    problem = bench_finger(quiet, protocol(quiet), "plane-strain").model()[1]
    x = problem.model.gage_x
    hardware = quiet.grip.hardware
    own = bench_curves(read_bench(tmp_path, GAGES), x)

    def plant():
        rng = np.random.default_rng(0)
        return ImperfectPlant(CondensedPlant(problem, "upper"), hardware.at_rest(), rng)

    rig = calibrate(plant, x, Bounds.of(quiet.grip))
    assert own.calibration.delay == 3
    for name in ("normal", "sticking"):
        found, known = getattr(own.calibration, name), getattr(rig, name)
        assert found.normal_force == pytest.approx(known.normal_force, rel=1e-5)
        assert found.readings == pytest.approx(known.readings, rel=1e-3, abs=1e-3)
    assert own.calibration.stiffness == pytest.approx(rig.stiffness, rel=1e-5)
    assert own.calibration.cross_talk == pytest.approx(0.01, rel=1e-3)
    assert rig.cross_talk == pytest.approx(0.01, rel=1e-3)
    assert own.slid == pytest.approx(quiet.grip.bench_friction_coefficient, rel=1e-3)
    assert [tilt for tilt, _ in own.tilted] == [2.0]


def test_points_are_means_at_rest_without_what_is_stale():
    """A zero of 1 before touch; then two moves, each followed by rest, measured one sample late."""
    dy = np.array([0.0, 0.0, 0.1, 0.0, 0.0, 0.1, 0.0, 0.0])
    values = np.array([1.0, 1.0, 1.0, 3.0, 3.0, 3.0, 6.0, 6.0])
    time, none = np.arange(1.0, 9.0), np.zeros(8)
    trace = Trace(time, none, dy, values, none, values[:, None], np.arange(2, 10))
    points = points_of(trace, samples=10.0, delay=1)
    assert points.normal_force == pytest.approx([2.0, 5.0])
    assert points.readings[:, 0] == pytest.approx([2.0, 5.0])
    assert points.approach == pytest.approx([0.1, 0.2])
    assert points.samples.tolist() == [20.0, 20.0]
    # Of a rest as short as the delay the last row alone counts.
    points = points_of(trace, delay=3)
    assert points.normal_force == pytest.approx([2.0, 5.0])
    assert points.samples.tolist() == [1.0, 1.0]


class Springs:
    """F_n = 5 N/mm of the closing, F_t = 2 N/mm of the shear; a gage reads the former."""

    x = y = 0.0

    def move(self, dx, dy):
        self.x, self.y = self.x + dx, self.y + dy
        return Sample(np.array([5.0 * self.y]), 5.0 * self.y, 2.0 * self.x)


def test_a_phase_played_on_another_plant_makes_the_same_moves_from_touch_on():
    approach, shear, none = np.array([0.1, 0.3, 0.3]), np.array([0.0, 0.0, 0.2]), np.zeros(3)
    points = Points(approach, shear, none, none, none[:, None], none)
    played = Phase("a shear", "shear", 0.5, 0.0, points).played(Springs()).points
    assert played.normal_force == pytest.approx(5.0 * approach)
    assert played.tangential_force == pytest.approx(2.0 * shear)
    assert played.readings[:, 0] == pytest.approx(5.0 * approach)
    assert np.isinf(played.samples).all()


@pytest.mark.slow
def test_sensitivities_are_differences_of_the_models_own_curves(design):
    """A wrong one hardly spoils a fit, which corrects it, but its stated deviations."""
    plan = protocol(design, (2.0,))
    model = BenchModel(design, (*plan[:3], plan[-1]))  # pressed, sheared twice, pressed at a tilt
    latents = [Latent("x", 2), Latent("lean"), Latent("angle", 1), Latent("modulus")]
    found = differences(model, design, latents, 0.5, lambda message: None)
    for latent, slope in zip(latents, found, strict=True):
        if latent.kind == "lean":
            step = LEAN_STEP["plane-strain"]
            low, high = (model.curves(design, 0.5 + side * step) for side in (-1.0, 1.0))
        else:
            step = latent.step
            ends = [np.array([side * step]) for side in (-1.0, 1.0)]
            low, high = (model.curves(with_latents(design, [latent], end), 0.5) for end in ends)
        for take in (
            lambda each: each.calibration.normal.readings,
            lambda each: each.calibration.normal.normal_force,
            lambda each: each.tilted[0][1].readings,
        ):
            own = (take(high) - take(low)) / (2.0 * step)
            derived = (take(slope.high) - take(slope.low)) / slope.apart
            assert derived == pytest.approx(own, abs=0.05 * np.abs(own).max())


def test_only_a_finger_that_is_swept_has_meshes_of_its_own():
    """Facets as fine along both ways would take a tetrahedral mesh of millions."""
    plan = protocol(load_design("sensitive"))
    swept, dome = (BenchModel(load_design(name), plan, "3d") for name in ("sensitive", "domed"))
    assert dome.lean_step > 2.0 * swept.lean_step
    sizes = [
        {
            bench_finger(load_design(name), plan, "3d", mesh=mesh).design.mesh.contact_size_mm
            for mesh in (FINE, COARSE)
        }
        for name in ("sensitive", "domed")
    ]
    assert [len(each) for each in sizes] == [2, 1]


@pytest.mark.slow
def test_a_coarse_mesh_with_the_designs_fine_contact_reads_what_a_fine_one_does():
    """Readings of a softer finger, whose plates are off. Its coarse mesh alone is off by 1 %."""
    values = {"plates.count": 3, "plates.thickness_mm": 0.2, "grip.max_approach_mm": 0.2}
    values["mesh.contact_size_mm"] = 0.8
    design = with_values(load_design("maeno2000"), values)
    finger = with_latents(
        design,
        [Latent("x", 1), Latent("y", 1), Latent("angle", 2), Latent("modulus")],
        np.array([0.06, -0.06, 0.8, -0.1]),
    )
    model = BenchModel(design, protocol(design)[:3], "3d")
    own = model.curves(finger).calibration.normal
    fine, coarse = (
        model.played_on(bench_finger(finger, model.phases, "3d", design, mesh).model()[1], finger)(
            0.0
        )
        for mesh in (FINE, COARSE)
    )
    true, alone = (each.calibration.normal for each in (fine, coarse))
    forces = np.linspace(0.3, 1.0, 6) * true.normal_force[-1]
    most = np.abs(true.readings).max()
    off, missed = (
        max(np.abs(each.at(f) - true.at(f)).max() for f in forces) / most for each in (own, alone)
    )
    assert off < 0.005
    assert missed > 3.0 * off
    assert own.normal_force == pytest.approx(true.normal_force, rel=3e-3)


@pytest.mark.slow
def test_slopes_by_moduli_and_gains_are_those_of_other_fingers(design):
    """The rubber's takes no model of its own: forces scale with all moduli."""
    bench = simulated_bench(design, [], 1)
    model = BenchModel(design, bench.phases)
    curves = bench_curves(bench.phases, model.curves().calibration.gage_x)
    measured = Measured(design, bench.phases, curves, Noise(0.5, 0.005))
    data = bench_fit._Data(measured, np.ones(GAGES, bool))
    latents = [Latent(kind) for kind in ("modulus", "plate_modulus")]
    latents += [Latent("gain", number) for number in range(1, GAGES + 1)]
    problem = bench_fit._Problem(model, data, latents)
    x = np.array([0.3, -0.2, *np.full(GAGES, 4.0)])  # Slopes pass through gains of 1.12.
    problem.derive(x, model, roughly=False, report=lambda message: None)
    slopes = problem.jacobian(x)
    for k, step in enumerate((0.2, 0.2, 0.1)):
        ends = [problem.residual(x + step * side * np.eye(len(x))[k]) for side in (-1.0, 1.0)]
        own = (ends[1] - ends[0]) / (2.0 * step)
        assert slopes[:, k] == pytest.approx(own, abs=0.05 * np.abs(own).max())


def test_gains_and_touch_are_fitted_without_another_finger(design, calls_of):
    bench = simulated_bench(design, ["gains"], 1)
    model = BenchModel(design, bench.phases)
    curves = bench_curves(bench.phases, model.curves().calibration.gage_x)
    measured = Measured(design, bench.phases, curves, Noise(0.5, 0.005))
    data = bench_fit._Data(measured, np.ones(GAGES, bool))
    # A response is a reading over a pull: so is its deviation.
    pulls, _ = bench_fit.small_pulls(bench.phases, len(data.where.sheared))
    mesh = bench_fit.MESH["plane-strain"]
    own = np.hypot(2.0**0.5 * measured.mean_noise.gage, bench_fit._SMALL * mesh[0]) / pulls
    rows = data.strain_deviation[data.where.readings :][: len(pulls), 0]
    assert rows == pytest.approx(np.hypot(own, mesh[1]))
    latents = [Latent("poisson"), Latent("touch")]
    latents += [Latent("gain", number) for number in range(1, GAGES + 1)]
    problem = bench_fit._Problem(model, data, latents)
    x = np.zeros(len(latents))
    before = problem.residual(x)
    condensed = calls_of(BenchModel, "bench")
    found = problem.settled(x)
    after = problem.residual(found)
    assert not condensed
    assert found[0] == 0.0
    assert after @ after < 0.2 * (before @ before)
    true = np.array(bench.design.grip.hardware.gains(range(GAGES))) - 1.0
    assert problem.values(found, "gain") == pytest.approx(true, abs=0.01)


@pytest.mark.slow
def test_gains_are_as_certain_as_stated_where_plates_are_in_place(design):
    """Errors in stated deviations, 4 gages of 4 fingers: if those are right, the root mean square
    of 16 is under 1.4 but once in 80 times."""
    x = np.array(bench_finger(design, protocol(design), "plane-strain").model()[1].model.gage_x)
    errors = []
    for seed in range(1, 5):
        bench = simulated_bench(design, ["gains"], seed)
        noise = Noise(0.5, 0.005)
        fit = fit_latents(Measured(design, bench.phases, bench_curves(bench.phases, x), noise))
        values, deviations = fit.of("gain")
        true = np.array(bench.design.grip.hardware.gains(range(GAGES))) - 1.0
        errors.append((values - true) / deviations)
    assert np.sqrt(np.mean(np.square(errors))) < 1.4


@pytest.mark.slow
def test_a_plate_that_lies_off_is_found_and_the_estimator_is_this_fingers(
    design, measured, tmp_path, terminal
):
    trained = estimator_file(design, tmp_path / "trained")
    given = (measured / "mine.toml", measured, "--out", tmp_path / "out")
    record = json.loads(terminal("identify", *given, "--estimator", trained, "--json").out)
    assert record == json.loads((tmp_path / "out/mine/calibration.json").read_text())
    by_name = {each["name"]: each for each in record["latents"]}
    off = by_name["plate_2.x"]
    assert off["value"] == pytest.approx(0.15, abs=3.0 * off["deviation"])
    assert off["determined"]
    assert off["deviation"] < 0.4 * off["deviation_before"]
    # The row as a whole is all but one with the bench's lean; plates among each other are not.
    others = [v["value"] for k, v in by_name.items() if k.endswith(".x") and k != off["name"]]
    assert off["value"] - np.mean(others) == pytest.approx(0.15, abs=0.015)
    assert np.ptp(others) < 0.03
    assert record["fit"]["after_microstrain"] < 0.2 * record["fit"]["before_microstrain"]
    fitted = load_design(tmp_path / "out/mine/fitted.toml")
    assert plate_frames(fitted)[2].x == pytest.approx(plate_frames(design)[2].x + off["value"])
    # The estimator is what was trained, with this finger's curves; a rig loads it.
    own = GripEstimator.from_json((tmp_path / "out/mine/estimator.json").read_text())
    assert own.design == finger_key(design)
    curves = np.array(record["curves"]["pressed_microstrain"])
    assert own.curves.pressed == pytest.approx(curves, rel=1e-4, abs=1e-4)
    exported = (tmp_path / "out/mine/estimator.json", measured / "mine.toml", "--out", tmp_path)
    terminal("export", "--to", "c", *exported)
    former = (measured / "mine.toml", "--measured", measured / "phases.csv")
    shown = terminal("calibrate", *former, "--out", tmp_path / "out").out
    assert "plates along x, mm" in shown
    assert "fitted.toml is this finger" in shown


@pytest.mark.slow
def test_a_dead_gage_is_named(design, measured):
    phases = read_bench(measured, GAGES)
    x = [each.x for each in plate_frames(design)]
    dead = []
    for each in phases:
        readings = each.points.readings.copy()
        readings[:, 1] = 0.0
        dead.append(replace(each, points=replace(each.points, readings=readings)))
    fit = fit_latents(Measured(design, dead, bench_curves(dead, np.array(x)), Noise(0.5, 0.005)))
    assert fit.dead == (2,)
    values, deviations = fit.of("gain")
    assert (values[1], deviations[1]) == pytest.approx((0.0, 0.03))
    moved_by, deviation = (each[2] for each in fit.of("x"))
    assert 0.07 < moved_by < 0.15 + 2.0 * deviation < 0.22


@pytest.mark.slow
def test_a_fit_that_does_not_converge_is_an_error(design, measured):
    phases = read_bench(measured, GAGES)
    curves = bench_curves(phases, np.array([each.x for each in plate_frames(design)]))
    # Without a halving no step is taken: the plate that lies off remains to be found.
    with (
        patch.object(bench_fit, "_HALVINGS", 0),
        pytest.raises(SolverError, match="did not converge"),
    ):
        fit_latents(Measured(design, phases, curves, Noise(0.5, 0.005)))


@pytest.mark.slow
def test_another_fingers_bench_is_an_error(design, measured, tmp_path):
    """Forces in kN: so soft is no finger near the design."""
    for each in measured.glob("*.csv"):
        text = each.read_text()
        for name in ("normal_force_N", "tangential_force_N") if each.stem != "phases" else ():
            text = column(name, lambda force, last: 0.001 * force)(text)
        (tmp_path / each.name).write_text(text)
    phases = read_bench(tmp_path, GAGES)
    curves = bench_curves(phases, np.array([each.x for each in plate_frames(design)]))
    with pytest.raises(SolverError, match="forces in N"):
        fit_latents(Measured(design, phases, curves, Noise(0.5, 0.005)))


def column(name, change=None):
    """A change of a table's text: of each number of a column, or the loss of the column."""

    def changed(text):
        rows = [line.split(",") for line in text.splitlines()]
        k = rows[0].index(name)
        for row in rows:
            if change is None:
                del row[k]
            elif row is not rows[0]:
                row[k] = f"{change(float(row[k]), row is rows[-1]):.9g}"
        return "\n".join(map(",".join, rows)) + "\n"

    return changed


@pytest.mark.parametrize(
    ("file", "change", "named"),
    [
        (
            "slide.csv",
            column("normal_force_N", lambda n, last: (3.0 if last else 1.0) * n),
            "slide.csv: tangential_force",
        ),
        ("phases.csv", column("friction_coefficient"), "friction_coefficient"),
        ("phases.csv", lambda t: t.replace("press,0.5", "press,"), "column friction_coefficient"),
        (
            "phases.csv",
            lambda t: t.replace("slide,0.5", "slide,0.9"),
            "slide.csv: tangential_force",
        ),
        ("phases.csv", lambda t: t.replace(",tilt,0.5,2,", ",tilt,0.5,,"), "column tilt_deg"),
        ("phases.csv", lambda t: t.replace("press.csv,press", "press.csv,pres"), "one of press"),
        ("phases.csv", lambda t: t.replace("quick.csv", "quik.csv"), "quik.csv"),
        ("phases.csv", lambda t: f"{t.rstrip()}\n{t.split()[-1]}\n", "at most one row"),
        ("phases.csv", lambda t: t.replace("quick.csv", "qui\0ck.csv"), "column trace"),
        ("phases.csv", lambda t: t.replace("quick.csv", "."), "Is a directory"),
        ("phases.csv", lambda t: t.replace("quick.csv", "/dev/zero"), "column trace"),
        ("phases.csv", lambda t: t.replace("quick.csv", "../press.csv"), "column trace"),
        ("phases.csv", lambda t: t.replace(",100", ",1e300"), "must be 1 to 1e+06"),
        ("press.csv", column("dy_mm", lambda dy, last: -dy), "closing positive"),
        (
            "tilt_1.csv",
            column("dy_mm", lambda dy, last: 0.0),
            "tilt_1.csv: normal_force_N = 0 points",
        ),
        ("quick.csv", lambda t: t.replace(",0,0.02,", ",0,0.2,"), "quick.csv, the quick press"),
        ("press.csv", column("gage_3"), "gage"),
        ("press.csv", lambda t: re.sub(r",[^,\n]*$", ",nan", t), "column gage_4 = nan"),
        ("press.csv", lambda t: "\n".join(t.splitlines()[:6]), "at least 8 points"),
        ("press.csv", lambda t: t.replace(",0,0.0", ",0,0.01"), "0.25"),
        ("shear_1.csv", lambda t: "\n".join(t.splitlines()[:-1]), "shear_1.csv: dx_mm"),
    ],
)
def test_bad_measurements_are_refused_before_any_work(
    measured, tmp_path, terminal, file, change, named
):
    folder = tmp_path / "bench"
    folder.mkdir()
    for each in measured.glob("*.csv"):
        (folder / each.name).write_text(each.read_text())
    (folder / file).write_text(change((folder / file).read_text()))
    given = (measured / "mine.toml", folder, "--out", tmp_path / "out")
    assert named in terminal("identify", *given, code=2).err
    assert not (tmp_path / "out").exists()


def test_wrong_options_and_foreign_estimators_are_refused(design, measured, tmp_path, terminal):
    out = ("--out", tmp_path / "out")
    other = estimator_file(with_values(design, {"body.depth_mm": 9.0}), tmp_path / "other")
    own = measured / "mine.toml"
    for given, named in (
        ((), "or --simulate"),
        ((measured, "--simulate"), "either"),
        ((measured, "--fault", "gains"), "--fault"),
        ((measured, "--terms", "1"), "--terms"),
        (("--simulate", "--bench", "--fault", "radius"), "one of modulus"),
        (("--simulate", "--bench", "--fault", "magic"), "magic"),
        (("--bench", tmp_path / "none"), "a folder with phases.csv"),
        ((measured, "--estimator", other), "on this design"),
    ):
        assert named in terminal("identify", own, *out, *given, code=2).err
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_the_pages_commands_run(design, tmp_path, in_tmp_path, capsys):
    page = "how_to/identify.md"
    (tmp_path / "mine.toml").write_text(SOFT)
    estimator_file(design, tmp_path / "trained/mine")
    for line in "".join(blocks(page, "sh")).splitlines():
        assert main(line.partition("#")[0].split()[1:]) == 0, capsys.readouterr()
    capsys.readouterr()
    run_python(page)
    assert "plate_" in capsys.readouterr().out
    shown = re.search(r"```\n(trace,phase,.*?)```", (DOCS / page).read_text("utf-8"), re.DOTALL)
    assert (tmp_path / "bench/mine/phases.csv").read_text() == shown[1]
    run_python(page, 1)
