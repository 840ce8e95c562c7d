"""The regulator as a functional mock-up unit: its content, fmpy's judgement, bits of numpy."""

import json
import zipfile
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from fingerdesign_cli import sensing

from fingerdesign.control.features import FingerCurves
from fingerdesign.control.fmi.pack import systems_of
from fingerdesign.control.fmi.regulator import FILE, fmu
from fingerdesign.runtime import native
from tests.control.test_c_code import COMPILER, CROSS_TALK, GAGES, GRIP, estimator
from tests.support.session import never_called
from tests.support.singles import SingleRegulator
from tests.support.units import Running

S = np.float32
OUTPUTS = ("dx", "dy", "stick_ratio", "used", "friction")


@pytest.fixture(scope="module")
def unit(tmp_path_factory, bench):
    """The file of a unit with so many weights as the shipped estimators have."""
    if COMPILER is None:
        pytest.skip("no C compiler here (cc, gcc or clang): the unit has no library to run")
    path = tmp_path_factory.mktemp("fmu") / FILE
    path.write_bytes(fmu(estimator(FingerCurves.of(bench), (128, 64)), GRIP))
    return path


def test_a_unit_holds_description_sources_and_library(unit):
    with zipfile.ZipFile(unit) as archive:
        names = set(archive.namelist())
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    sources = {f"sources/{name}" for name in ("fmu.c", "regulator.c", "regulator.h")}
    assert sources | {"modelDescription.xml", "resources/weights.bin"} < names
    assert len(root.findall("ModelVariables/ScalarVariable")) == GAGES + 14
    assert unit.stat().st_size < 100_000  # 23,000 weights of two bytes in it


def test_weights_that_were_cut_are_no_unit(unit, tmp_path):
    """A folder's name may need escapes in its address; a file of weights must be whole."""
    Running(unit, tmp_path / "a folder")
    cut = tmp_path / FILE
    with zipfile.ZipFile(unit) as whole, zipfile.ZipFile(cut, "w") as archive:
        for name in whole.namelist():
            archive.writestr(name, whole.read(name)[: -1 if name.endswith(".bin") else None])
    with pytest.raises(Exception, match="instantiate"):
        Running(cut, tmp_path / "cut")


def test_the_same_regulator_is_the_same_unit(unit, bench):
    again = fmu(estimator(FingerCurves.of(bench), (128, 64)), GRIP)
    assert again == unit.read_bytes()


def sampled(running, readings, normal, tangential, lifted):
    """Outputs of one step."""
    slave, place = running.slave, running.place
    at = [place[f"reading[{k + 1}]"] for k in range(GAGES)]
    slave.setReal(at, list(readings))
    running.step(normal_force=normal, tangential_force=tangential, lifted=int(lifted))
    return running.get(*OUTPUTS, "unsure", "missed")


def test_fmpy_finds_no_fault(unit, tmp_path):
    pytest.importorskip("fmpy", reason="pip install fmpy brings it")
    from fmpy.validation import validate_fmu

    assert validate_fmu(str(unit)) == []
    running = Running(unit, tmp_path)
    with pytest.raises(Exception, match="fmi2DoStep"):
        running.slave.doStep(0.0, 1.5 * running.period)
    assert f"must be one sample of the hand, {running.period} s" in running.log[-1]
    for wrong in ({"delay": 121}, {"stiffness": 0.0}, {"cross_talk": np.nan}):
        with pytest.raises(Exception, match="fmi2ExitInitializationMode"):
            Running(unit, tmp_path / next(iter(wrong)), **wrong)


def test_without_a_compiler_a_unit_says_so(monkeypatch, tmp_path, terminal):
    """It holds the sources, and both outputs report that no system has a library."""
    monkeypatch.setattr(native, "_COMPILERS", ())
    given = ["export", "sensitive", "--to", "fmu", "--out", tmp_path]
    assert json.loads(terminal(*given, "--json").out)["systems"] == []
    assert "no library, as no C compiler was found" in terminal(*given).out
    assert systems_of((tmp_path / "sensitive" / FILE).read_bytes()) == []


@pytest.mark.parametrize("target", ["c", "fmu", "fmu-plant", "mjcf", "urdf"])
def test_a_folder_of_others_is_refused_before_training(target, tmp_path, terminal):
    (tmp_path / "block").mkdir()
    (tmp_path / "block" / "mine.txt").touch()
    with never_called(sensing, "_estimator_of", "grip_problem"):
        printed = terminal("export", "block", "--to", target, "--out", tmp_path, code=2).err
    assert f"--out = {tmp_path}" in printed
    assert "choose another, for" in printed


@pytest.mark.slow
def test_two_thousand_steps_have_the_bits_of_numpy(unit, tmp_path, bench):
    """Grips of 200 samples from one state that is set back, a sample without a number in each."""
    taught, calibration = (
        estimator(FingerCurves.of(bench), (128, 64)),
        replace(bench, delay=2, cross_talk=CROSS_TALK),
    )
    stiffness = float(S(bench.tangential_stiffness))
    running = Running(unit, tmp_path, delay=2, stiffness=stiffness, cross_talk=CROSS_TALK)
    start = running.slave.getFMUState()
    rng, most, found = np.random.default_rng(0), bench.normal.normal_force[-1], []
    for _ in range(10):
        running.slave.setFMUState(start)
        single, normal = SingleRegulator(taught, GRIP, calibration), 1.0
        for step in range(200):
            normal = abs(normal + 0.1 * most * rng.standard_normal()) % (1.5 * most)
            readings = S(10.0 ** rng.uniform(-3, 3) * rng.standard_normal(GAGES)).astype(float)
            given = float(S(normal)), float(S(normal * rng.uniform(-0.1, 0.8))), step > 160
            if step == 100:
                *_, missed = sampled(running, np.full(GAGES, np.nan), *given)
                assert missed
                single.miss()
                continue
            answer = sampled(running, readings, *given)
            assert S(answer[:6]).tobytes() == S(single.step(readings, *given)).tobytes()
            found.append(answer)
    assert len(found) == 10 * 199
    assert (np.ptp(np.array(found)[:, :6], axis=0) > 0.0).all()
