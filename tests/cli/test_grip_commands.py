"""``fingerdesign grip``: options over the design's table, the record it leaves, exit codes."""

import csv
import json
import re

import numpy as np
import pytest

from fingerdesign import load_design
from fingerdesign.control.c_code import c_files
from fingerdesign.control.completion import Relations
from fingerdesign.control.estimator import Band, GripEstimator, Layer
from fingerdesign.control.features import FingerCurves, feature_count
from fingerdesign.sensing.model import grip_problem
from fingerdesign.sensing.train.result import finger_key
from fingerdesign.tolerance import spread
from fingerdesign.tolerance.cast import Draws
from tests.support.fingers import COARSE


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two designs' files."""
    folder = tmp_path_factory.mktemp("replay")
    (folder / "coarse.toml").write_text(COARSE)
    fine = COARSE.replace("contact_size_mm = 0.3", "contact_size_mm = 0.1")
    (folder / "fine.toml").write_text(f"{fine}max_steps = 12\n")
    return folder


@pytest.fixture
def estimator(tmp_path):
    """``estimator(key)``: the file of one that was taught nothing: its numbers mean nothing."""
    gages, rng = 5, np.random.default_rng(0)
    forces, ones = np.array([0.0, 5.0]), np.full((2, gages), 1.0)
    curves = FingerCurves(
        forces, np.zeros((2, gages)), ones, 0.01 * forces, np.full(2, 10.0), np.zeros(2)
    )
    count = feature_count(gages)
    layer = Layer(0.003 * rng.standard_normal((count, 3)), np.array([0.7, 0.4, 0.1]))
    relations = Relations.of_neighbours(gages)
    numbers = np.zeros(count), np.ones(count), relations, (layer,), np.array([[1.0, 0.1]])
    band = Band(10.0, *numbers)

    def write(key):
        path = tmp_path / "estimator.json"
        path.write_text(GripEstimator(key, curves, 0.5, (band,)).to_json())
        return path

    return write


def test_an_estimator_taught_on_another_is_refused(folder, tmp_path, estimator, terminal):
    path, out, own = estimator("another"), tmp_path / "out", folder / "coarse.toml"
    given = ["--out", out, "--estimator", path]
    for command in (["study", own, *given], ["export", "--to", "c", path, own, "--out", out]):
        reported = terminal(*command, code=2).err
        assert re.search(r"on another: must be one \w+ on this design", reported)
    design = load_design(own)
    estimator(finger_key(design))
    solid = ["grip", own, "--controller", "regulator", "--fidelity", "3d"]
    refused = terminal(*solid, *given, code=2).err
    assert "in plane-strain: must be one trained in 3d" in refused
    unknown = terminal("grip", own, "--estimator", "maeno2000", "--out", out, code=2).err
    assert "or a design with one: film_tees, sensitive" in " ".join(unknown.split())
    assert not out.exists()


def test_an_estimator_is_exported(folder, tmp_path, estimator, terminal):
    design = load_design(folder / "coarse.toml")
    path = estimator(finger_key(design))
    louder = GripEstimator.from_json(path.read_text()).at_noise(2.0)
    given = [path, folder / "coarse.toml", "--noise", 2.0, "--out"]
    weights = 3 * feature_count(5)
    assert (
        f"5 gages, {weights} weights" in terminal("export", "--to", "c", *given, tmp_path / "c").out
    )
    loud = [*given[:3], 900.0, "--out", tmp_path / "loud"]
    warned = terminal("export", "--to", "c", *loud).err
    assert "warning: the estimator was trained for a noise of up to 10 microstrain" in warned
    written = {file.name: file.read_text() for file in (tmp_path / "c/coarse").iterdir()}
    assert written == c_files(louder, design.grip)


@pytest.mark.parametrize("command", ["train", "validate", "study"])
def test_a_folder_of_something_else_is_left_alone(command, folder, tmp_path, terminal):
    (tmp_path / "coarse").mkdir()
    (tmp_path / "coarse/mine.txt").write_text("mine")
    more = {"study": ["--quick"]}
    given = [folder / "coarse.toml", *more.get(command, []), "--out", tmp_path]
    assert "mine.txt" in terminal(command, *given, code=2).err
    assert [path.name for path in (tmp_path / "coarse").iterdir()] == ["mine.txt"]


@pytest.mark.slow
def test_each_friction_is_lifted_once_and_recorded(folder, tmp_path, terminal):
    options = ["--friction", "0.3", "--friction", "0.7", "--mass-g", "30"]
    arguments = ["grip", folder / "fine.toml", "--out", tmp_path / "out", *options]
    printed = json.loads(terminal(*arguments, "--json").out)
    record = json.loads((tmp_path / "out/coarse/result.json").read_text())
    assert record["fidelity"] == "plane-strain"
    assert record["grips"] == printed["grips"]
    assert [grip["friction_coefficient"] for grip in record["grips"]] == [0.3, 0.7]
    for grip in record["grips"]:
        assert grip["object_mass_g"] == 30.0
        assert grip["lifted"]
        # mg < 2 F_t of each finger.
        assert grip["final_tangential_force_N"] > 0.5 * 0.030 * 9.80665


SOLID = """
[mesh]
contact_size_mm = 0.7
plate_size_mm = 1.0
far_size_mm = 3.0
layers = 2
"""

LIMITS = "max_approach_mm = 0.2\nmax_steps = 20\n"  # of the design's last table, [grip]


@pytest.mark.slow
def test_every_decision_on_grips_can_be_taken_in_3d(tmp_path, terminal):
    """On a short finger swept through two layers: another model, named so, and taken by each."""
    short = COARSE.replace("[plates]", "[body]\ndepth_mm = 4.0\n[plates]\nspan_mm = 4.0")
    path = tmp_path / "short.toml"
    path.write_text(short.replace("[mesh.section]", f"{SOLID}[mesh.section]") + LIMITS)
    study = ["study", path, "--controller", "fixed_ratio", "--quiet", "--friction", "0.6"]
    study += ["--mass-g", "30", "--noise", "0", "--workers", "1", "--no-tug"]
    peaks, design = [], load_design(path)
    for fidelity in ("plane-strain", "3d"):
        terminal(*study, "--fidelity", fidelity, "--out", tmp_path / fidelity)
        record = json.loads((tmp_path / fidelity / "coarse/control.json").read_text())
        assert record["model"]["fidelity"] == fidelity
        with (tmp_path / fidelity / "coarse/grips.csv").open() as file:
            (grip,) = csv.DictReader(file)
        peaks.append(float(grip["peak_normal_force_N"]))
    flat, solid = peaks
    assert 0.6 * flat < solid != flat
    assert grip_problem(design, "3d").model.dimension == 3
    keys = {finger_key(design, each) for each in ("plane-strain", "3d")}
    assert len(keys) == 2


@pytest.mark.slow
def test_a_fix_keeps_the_controller_of_the_option(folder, importable, tmp_path, terminal):
    (tmp_path / "idle.py").write_text(
        "from fingerdesign.control.command import Command\n"
        'class Hand:\n    name = "idle"\n'
        "    def __init__(self, *given): ...\n"
        "    def start(self, *given): ...\n"
        "    def command(self, *given): return Command(0.0, 0.0, False)\n"
    )
    given = ["--controller", "idle:Hand", "--friction", "0.5", "--out", tmp_path / "out"]
    shown = terminal("grip", folder / "coarse.toml", *given).out
    (file,) = re.findall(r"fingerdesign optimise (\S+) --allow-code", shown)
    assert load_design(file, allow_code=True).grip.controller == "idle:Hand"


def test_a_finger_that_feels_nothing_cannot_grip(tmp_path, terminal):
    path = tmp_path / "plain.toml"
    path.write_text('design.name = "plain"\nplates.count = 0\n')
    assert "plates.count" in terminal("grip", path, "--out", tmp_path / "out", code=2).err


def test_grips_take_a_level_planes_friction_and_no_other(folder, tmp_path, terminal):
    scene, out = tmp_path / "scene.toml", tmp_path / "out"
    scene.write_text("object.tilt_deg = 3.0\npath.increments_mm = [[0.1, 0.0]]\n")
    own = ["grip", folder / "fine.toml", "--out", out, "--scene", scene]
    assert "level plane" in terminal(*own, code=2).err
    scene.write_text(
        "object = {friction_law = 'shear_strength', shear_strength_MPa = 0.1}\n"
        "path.increments_mm = [[0.1, 0.0]]\n"
    )
    relaxing = tmp_path / "relaxing.toml"
    text = (folder / "fine.toml").read_text()
    relaxing.write_text(f'{text}plant = "lift"\nrelaxation_per_minute = 0.1\n')
    given = ["grip", relaxing, "--out", out, "--scene", scene]
    assert "grip.relaxation_per_minute = 0.1" in terminal(*given, code=2).err
    assert "leave one" in terminal(*own, "--friction", "0.3", code=2).err
    assert not out.exists()


def test_a_faulty_option_is_one_fault_that_names_it(folder, tmp_path, terminal):
    options = ["--friction", "0", "--mass-g", "-3", "--controller", "magic"]
    out = tmp_path / "out"
    faults = sorted(
        terminal("grip", folder / "fine.toml", "--out", out, *options, code=2).err.splitlines()
    )
    assert [fault.split(": must be ")[0] for fault in faults[1:]] == [
        "--friction (grip.friction_coefficients[0]) = 0.0",
        "--mass-g (grip.object_mass_g) = -3.0",
    ]
    assert faults[0].startswith("--controller (grip.controller) = 'magic': ")
    assert not out.exists()


@pytest.mark.parametrize(
    ("command", "named"),
    [
        ("grip pin --controller magic --scene nosuch", ("'magic'", "nosuch")),
        ("study pin --controller magic --friction nan --noise -1", ("magic", "nan", "-1")),
        ("grip pin --fidelity 4d --mass-g x", ("'4d'", "'x'")),
        ("optimise pin --trials -1 --scheduler tcp://h:1 --workers x", ("-1", "'x'")),
    ],
)
def test_faults_of_several_options_come_together(terminal, command, named):
    refused = terminal(*command.split(), code=2).err
    assert [each for each in named if each not in refused] == []


@pytest.mark.parametrize(
    "arguments",
    [
        ("tolerance", "maeno2000", "--yield-within"),
        ("study", "sensitive", "--noise"),
        ("check", "sensitive", "--time-limit"),
    ],
)
@pytest.mark.parametrize("value", ["nan", "inf", "-1"])
def test_a_number_that_is_none_is_refused(terminal, arguments, value):
    shown = terminal(*arguments, value, code=2)
    assert arguments[-1] in shown.err
    assert value in shown.err


def test_a_foreign_folder_is_refused_before_work(terminal, tmp_path):
    (tmp_path / "maeno2000").mkdir()
    (tmp_path / "maeno2000" / "notes.txt").touch()
    refused = terminal("grip", "maeno2000", "--out", tmp_path, code=2).err
    assert "notes.txt" in refused
    assert "meshing" not in refused


def test_points_of_a_yield_are_hundredths(tmp_path, terminal, calls_of):
    """Refused for want of gages, after the option was read."""
    called = calls_of(spread, "tolerance")
    given = ("--yield-within", "5", "--workers", "2", "--out", tmp_path / "out")
    terminal("tolerance", "homogeneous", *given, code=2)
    assert [given[-1] for given, _ in called] == [Draws(0.05, 2)]
