"""The regulator in C: nearly what it does in doubles, whatever happens to gages and samples."""

import ctypes
import re
import shutil
import subprocess
from collections import deque
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from fingerdesign.control.c_code import c_files
from fingerdesign.control.controllers.regulator import Regulator, RegulatorTable
from fingerdesign.control.estimator import (
    Band,
    FingerCurves,
    GripEstimator,
    Layer,
    feature_count,
)
from fingerdesign.control.plants.plant import CondensedPlant, press
from fingerdesign.control.roster import Object
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import Grip

COMPILER = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-fno-fast-math", "-Wall", "-Wextra", "-Werror"]
PAGE = Path(__file__).parents[2] / "docs/how_to/control.md"
GAGES, CROSS_TALK = 11, 0.02
GRIP = Grip(approach_step_mm=0.002)
S = np.float32


def estimator(curves, hidden=(24, 12), seed=0):
    """One that takes F_t / F_n for half the friction in use, and hears more in the rest."""
    rng = np.random.default_rng(seed)
    widths = [feature_count(curves.pressed.shape[1]), *hidden, 3]
    layers = [
        Layer(0.3 * rng.standard_normal(size) / size[0] ** 0.5, 0.1 * rng.standard_normal(size[1]))
        for size in pairwise(widths)
    ]
    ratio = curves.pressed.shape[1] + 1
    layers[0].weight[:, 0] *= 0.1
    layers[0].weight[ratio, 0], layers[1].weight[0, 0] = 0.2, 1.0
    layers[0].bias[0] = layers[1].bias[0] = 0.0
    layers[-1].weight[0], layers[-1].bias[:] = (-1.0, 2.0, 1.0), (0.9, 0.0, 0.0)
    spread = np.array([[0.3, 0.2], [0.7, 0.1], [1.0, 0.05]])
    center, scale = 0.1 * rng.standard_normal(widths[0]), rng.uniform(0.5, 2.0, widths[0])
    center[ratio], scale[ratio] = 0.0, 0.2
    return GripEstimator("digest", curves, 0.5, (Band(1.0, center, scale, tuple(layers), spread),))


NAMES = "normal_force", "pressed", "sticking", "approach", "stiffness"


class Curves(ctypes.Structure):
    _fields_ = (
        ("points", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in NAMES),
        ("cross_talk", ctypes.c_float),
    )


class Compiled:
    """The shared library of a C file; ``status`` of the last call."""

    def __init__(self, folder, estimator):
        for name, text in c_files(estimator, GRIP).items():
            (folder / name).write_text(text)
        library = folder / "regulator.so"
        made = [COMPILER, *FLAGS, "-shared", "-fPIC", folder / "regulator.c", "-o", library, "-lm"]
        subprocess.run(made, check=True)
        self._library = ctypes.CDLL(str(library))
        self._state = ctypes.create_string_buffer(1 << 16)

    def init(self, curves, delay, stiffness, cross_talk=CROSS_TALK):
        self._kept = [np.ascontiguousarray(getattr(curves, name), dtype=S) for name in NAMES]
        table = Curves(len(curves.approach), *(each.ctypes.data for each in self._kept), cross_talk)
        given = ctypes.byref(table), delay, ctypes.c_float(stiffness)
        return self._library.regulator_init(self._state, *given)

    def step(self, readings, normal, tangential, lifted):
        felt, answer = S(readings), np.full(6, np.nan, dtype=S)
        forces = ctypes.c_float(normal), ctypes.c_float(tangential)
        at, to = (ctypes.c_void_p(each.ctypes.data) for each in (felt, answer))
        self.status = self._library.regulator_step(self._state, at, *forces, int(lifted), to)
        answer[5] = answer.view(np.int32)[5]
        return answer


@pytest.fixture(scope="module")
def compiled(tmp_path_factory, bench):
    if COMPILER is None:
        pytest.skip("no C compiler here (cc, gcc or clang): the C file was not run")
    return Compiled(tmp_path_factory.mktemp("c"), estimator(FingerCurves.of(bench)))


def missed(double):
    """The sample of a move is passed over: that move counts with the next one's, and none follows.

    Without a delay the move waits for the next sample.
    """
    if len(double._pending) > 1:
        (x, y), (x1, y1), *rest = double._pending
        double._pending = deque([(x1 + x, y1 + y), *rest, (0.0, 0.0)])


@pytest.mark.parametrize(("delay", "dead"), [(0, None), (3, None), (0, 5), (3, 0)])
def test_a_grip_goes_the_same_way(half_plane, compiled, bench, delay, dead):
    """To 1e-3 in doubles that remember the same moves; a gage may die, and a sample be missed."""
    curves, rng = FingerCurves.of(bench), np.random.default_rng(1)
    assert compiled.init(curves, delay, bench.tangential_stiffness) == 0
    double = Regulator(GRIP, RegulatorTable(), Object(estimator=estimator(curves)))
    calibration = replace(bench, delay=delay, cross_talk=CROSS_TALK)
    plant = CondensedPlant(half_plane, "both")
    *_, sample = press(plant, 0.04, 0.01)
    double.start(calibration, calibration.corrected(sample))
    late, moved, most = [sample] * delay, [], 0.0
    for k in range(130):
        noisy = sample.readings + 0.5 * rng.standard_normal(GAGES)
        if dead is not None and k > 60:
            noisy[dead] = 0.0
        pull = sample.tangential_force * (1.3 if k > 110 else 1.0)
        felt = Sample(S(noisy).astype(float), sample.normal_force, pull, k > 100)
        given = felt.normal_force, felt.tangential_force, felt.lifted
        if k == 70:  # A cable has come off: nothing is measured, and nothing moves.
            assert not compiled.step(np.full(GAGES, np.nan), *given)[:2].any()
            assert compiled.status == 1
            missed(double)
            late.append(plant.move(0.0, 0.0))
            sample = late.pop(0)
            continue
        found, command = (
            compiled.step(felt.readings, *given),
            double.command(calibration.corrected(felt)),
        )
        assert compiled.status == 0
        reported = double.estimator.estimate(double._history)
        expected = [reported.stick_ratio, reported.friction_utilisation]
        assert found[2:4] == pytest.approx(expected, abs=1e-3)
        assert found[4] == pytest.approx(double.friction or 0.0, rel=1e-3)
        assert found[5] == command.unsure
        most = max(most, abs(found[0] - command.dx), abs(found[1] - command.dy))
        moved.append((command.dx > 0.0, command.dy > 0.0))
        dx, dy = found[:2].tolist()
        if k >= delay:
            double._pending[-1] = dx, dy
        late.append(plant.move(dx, dy))
        sample = late.pop(0)
    assert most < 1e-3 * GRIP.shear_step_mm
    assert {(False, True), (True, False), (True, True), (False, False)} == set(moved)


def test_what_cannot_be_is_refused(compiled, bench):
    curves = FingerCurves.of(bench)
    falling = FingerCurves(curves.normal_force[::-1], *list(vars(curves).values())[1:])
    for wrong in [(curves, -1, 1.0), (curves, 121, 1.0), (curves, 0, 0.0), (falling, 0, 1.0)]:
        assert compiled.init(*wrong) == 1
    for name in NAMES:
        broken = {**vars(curves), name: np.where(vars(curves)[name] > 0.0, np.inf, 0.0)}
        assert compiled.init(FingerCurves(**broken), 0, 1.0) == 1
    assert compiled.init(curves, 0, np.inf) == 1


def test_it_fits_into_64_kB_and_the_page_calls_it(tmp_path):
    """15 gages, 99 features, hidden layers of 128 and 64: 21,000 weights."""
    if COMPILER is None:
        pytest.skip("no C compiler here (cc, gcc or clang): the C file was not measured")
    ones = np.ones((2, 15))
    curves = FingerCurves(ones[:, 0], ones, ones, ones[:, 0], ones[:, 0])
    for name, text in c_files(estimator(curves, (128, 64)), GRIP).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "hand.c").write_text(re.search("```c\n(.*?)```", PAGE.read_text(), re.S)[1])
    for name in ("regulator", "hand"):
        subprocess.run([COMPILER, *FLAGS, "-Os", "-c", f"{name}.c"], cwd=tmp_path, check=True)
    # With the object file's own headers; text and data are less.
    assert (tmp_path / "regulator.o").stat().st_size < 64_000
    includes = re.findall("#include (.*)", (tmp_path / "regulator.c").read_text())
    assert sorted(includes) == ['"regulator.h"', "<math.h>", "<stdint.h>", "<string.h>"]
