"""A finger as a functional mock-up unit: the engine's forces and gages, errors, its regulator."""

import zipfile
from xml.etree import ElementTree

import numpy as np
import pytest

from fingerdesign import load_design
from fingerdesign.checks.load import with_values
from fingerdesign.contact.problem import contact_problem
from fingerdesign.control.features import FingerCurves
from fingerdesign.control.fmi import plant, regulator
from fingerdesign.control.plants.plant import CondensedPlant, press
from fingerdesign.errors import DesignError
from fingerdesign.sensing.model import grip_problem
from fingerdesign.shapes.objects import Plane
from tests.control.test_c_code import COMPILER, GAGES, GRIP, estimator
from tests.support.reduced import bump
from tests.support.singles import SingleRegulator
from tests.support.units import WITHOUT, Running

FRICTION = 0.5
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler: a unit has no library")


@pytest.fixture(scope="module")
def finger():
    design = load_design("sensitive")
    return design, grip_problem(design)


@pytest.fixture(scope="module")
def unit(tmp_path_factory, finger):
    path = tmp_path_factory.mktemp("plant") / plant.FILE
    path.write_bytes(plant.plant_fmu(finger[1], finger[0]))
    return path


def moves(steps, deepest, seed=0):
    """Legs of random direction: pressing, shearing to and fro, sliding as a whole, leaving."""
    rng, approach, found = np.random.default_rng(seed), 0.0, []
    while len(found) < steps:
        way = deepest * np.array([0.05, 0.005]) * rng.normal(size=2) * rng.choice([0.2, 1.0, 3.0])
        for _ in range(rng.integers(5, 40)):
            if not -0.1 * deepest < approach + way[1] < deepest:
                way[1] *= -1.0
            found.append(way.copy())
            approach += way[1]
    return found[:steps]


def errors(running, problem, face, steps, deepest):
    """The largest errors of readings and of forces over the largest of that step, and counts of
    steps that were free, that stuck and slid in parts, and that slid as a whole."""
    engine, worst, kinds = CondensedPlant(problem, face), np.zeros(2), np.zeros(3, dtype=int)
    names = [f"reading[{k + 1}]" for k in range(len(problem.model.gage_x))]
    for dx, dy in moves(steps, deepest):
        sample = engine.move(dx, dy)
        running.step(dx=dx, dy=dy)
        found = np.array(running.get(*names, "normal_force", "tangential_force"))
        exact = np.array([*sample.readings, sample.normal_force, sample.tangential_force])
        touching, sticking = running.get("touching", "sticking")
        kinds += [not touching, 0 < sticking < touching, bool(touching) and not sticking]
        if sample.normal_force == 0.0:
            assert not found.any()
            continue
        for part, rows in enumerate((slice(-2), slice(-2, None))):
            scale = np.abs(exact[rows]).max(initial=0.0)
            off = np.abs(found - exact)[rows].max(initial=0.0)
            worst[part] = max(worst[part], off / scale if scale else 0.0)
    return worst, kinds


@pytest.mark.slow
def test_a_unit_holds_sources_and_the_model_and_fmpy_finds_no_fault(unit, finger):
    with zipfile.ZipFile(unit) as archive:
        names = set(archive.namelist())
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    sources = {f"sources/{name}.c" for name in ("plant", "dense", "fmi2", "kernel")}
    assert sources | {"resources/model.bin"} < names
    assert len(root.findall("ModelVariables/ScalarVariable")) == len(finger[1].model.gage_x) + 11
    assert unit.stat().st_size < plant.MOST_BYTES
    pytest.importorskip("fmpy", reason=WITHOUT)
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(unit)) == []


@pytest.mark.slow
def test_thousands_of_moves_are_the_engines(unit, finger, tmp_path):
    """Forces and gages to 1e-9 of each step's largest, along one path with all kinds of contact."""
    design, problem = finger
    running = Running(unit, tmp_path, friction=FRICTION)
    at_friction = problem.with_friction(FRICTION)
    worst, kinds = errors(running, at_friction, design.gages.face, 3_000, 0.3)
    assert worst.max() < 1e-9
    assert kinds.min() > 30


@pytest.mark.slow
def test_moves_in_space_are_the_engines(tmp_path):
    model = bump(9)
    readout = np.random.default_rng(1).normal(size=(4, model.compliance.shape[0]))
    changed = {"gage_readout": 1e-6 * readout, "gage_x": np.arange(2.0)}
    problem = contact_problem(type(model)(**{**vars(model), **changed}), Plane(0.0), 0.4)
    path = tmp_path / plant.FILE
    path.write_bytes(plant.plant_fmu(problem, load_design("sensitive")))
    running = Running(path, tmp_path / "unit", friction=0.4)
    worst, kinds = errors(running, problem, load_design("sensitive").gages.face, 600, 0.012)
    assert worst.max() < 1e-9
    assert kinds.min() > 5


@pytest.mark.slow
def test_a_move_without_an_answer_is_an_error_and_changes_nothing(unit, tmp_path):
    running = Running(unit, tmp_path, friction=FRICTION)
    running.step(dx=0.0, dy=0.05)
    running.step(dx=0.01, dy=0.02)
    names = "normal_force", "tangential_force", "approach", "shear"
    before = running.get(*names)
    for wrong, words in ((2.0, "candidate zone"), (np.nan, "finite")):
        with pytest.raises(Exception, match="fmi2DoStep"):
            running.step(dx=0.0, dy=wrong)
        assert words in running.log[-1]
        assert running.get(*names) == before
    running.step(dx=0.0, dy=0.0)
    assert running.get(*names) == pytest.approx(before, rel=1e-9)
    with pytest.raises(Exception, match="fmi2ExitInitializationMode"):
        Running(unit, tmp_path / "slippery", friction=0.0)


@pytest.mark.slow
def test_a_state_is_set_back(unit, tmp_path):
    running, names = (
        Running(unit, tmp_path, friction=FRICTION),
        ("normal_force", "tangential_force"),
    )
    running.step(dx=0.0, dy=0.1)
    state = running.slave.getFMUState()
    path = [(0.02, 0.01), (-0.05, 0.0), (0.01, -0.2), (0.0, 0.15)]
    found = []
    for _ in range(2):
        for dx, dy in path:
            running.step(dx=dx, dy=dy)
        found.append(running.get(*names))
        running.slave.setFMUState(state)
    assert found[0] == pytest.approx(found[1], rel=1e-9)
    assert np.abs(found[0]).min() > 0.0


def test_what_the_unit_does_not_know_is_refused_before_any_work(tmp_path, terminal):
    file = tmp_path / "sliding.toml"
    file.write_text('design.name = "sliding"\n[plates]\ncount = 1\n[grip]\nkinetic_share = 0.8\n')
    err = terminal("export", "--to", "fmu-plant", file, "--out", tmp_path, code=2).err
    starts = [each.partition(":")[0] for each in err.splitlines()]
    assert starts == ["grip.kinetic_share = 0.8", "plates.count = 1"]


def test_what_does_not_fit_is_refused(finger):
    design, problem = finger
    with pytest.raises(DesignError, match=r"grip\.kinetic_share = 0\.8: must be 1"):
        plant.plant_fmu(problem, with_values(design, {"grip.kinetic_share": 0.8}))
    large = contact_problem(bump(16), Plane(0.0), 0.4)  # 256 nodes in space
    noise = np.random.default_rng(0).normal(size=large.compliance.shape)
    large.compliance[:] = noise + noise.T  # doubles of a finger have no pattern, a bump's have
    with pytest.raises(DesignError, match="256 contact nodes in 3-D: must be 1000 kB"):
        plant.plant_fmu(large, design)


@pytest.mark.slow
def test_a_regulator_grips_the_plant_unit_by_unit(half_plane, bench, tmp_path):
    """Both units, connected by names, against both in Python: the same moves and forces."""
    trained = estimator(FingerCurves.of(bench), (24, 12))
    hand, finger = tmp_path / regulator.FILE, tmp_path / plant.FILE
    hand.write_bytes(regulator.fmu(trained, GRIP))
    finger.write_bytes(plant.plant_fmu(half_plane, load_design("sensitive")))
    stiffness = float(np.float32(bench.tangential_stiffness))
    hand = Running(hand, tmp_path / "hand", delay=0, stiffness=stiffness)
    finger = Running(finger, tmp_path / "finger", friction=FRICTION)
    engine = CondensedPlant(half_plane.with_friction(FRICTION), "both")
    single = SingleRegulator(trained, GRIP, bench)
    *_, sample = press(engine, 0.04, 0.01)
    for _ in range(4):
        finger.step(dx=0.0, dy=0.01)
    signals = [f"reading[{k + 1}]" for k in range(GAGES)] + ["normal_force", "tangential_force"]
    for _ in range(60):
        hand.step(**dict(zip(signals, finger.get(*signals), strict=True)), lifted=0)
        dx, dy = hand.get("dx", "dy")
        answer = single.step(sample.readings, sample.normal_force, sample.tangential_force, False)
        assert (dx, dy) == pytest.approx(answer[:2], rel=1e-4, abs=1e-9)  # single precision
        finger.step(dx=dx, dy=dy)
        sample = engine.move(dx, dy)
    assert finger.get("normal_force")[0] == pytest.approx(sample.normal_force, rel=1e-9)
    assert finger.get("shear")[0] > 0.01
