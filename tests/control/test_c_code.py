"""The regulator in C: numpy in singles gives the same bits, the controller nearly the same."""

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

from fingerdesign.control.c_code import c_files, in_16_bits
from fingerdesign.control.completion import Relations
from fingerdesign.control.controllers.regulator import Regulator, RegulatorTable
from fingerdesign.control.estimator import Band, GripEstimator, Layer
from fingerdesign.control.features import FingerCurves, feature_count
from fingerdesign.control.plants.plant import CondensedPlant, press
from fingerdesign.control.roster import Object
from fingerdesign.control.signals import Sample
from fingerdesign.design.grip import Grip
from fingerdesign.sensing.train import network
from tests.support.singles import CURVES, RADIUS, SingleRegulator

COMPILER = next(filter(None, map(shutil.which, ("cc", "gcc", "clang"))), None)
FLAGS = ["-std=c99", "-O2", "-ffp-contract=off", "-fno-fast-math", "-Wall", "-Wextra", "-Werror"]
PAGE = Path(__file__).parents[2] / "docs/how_to/control.md"
GAGES, CROSS_TALK = 11, 0.02
GRIP = Grip(approach_step_mm=0.002)
S = np.float32
TABLES = *CURVES, RADIUS


def of_rig(bench):
    """The curves of a rig, with a turn radius that grows with the depth."""
    curves = FingerCurves.of(bench)
    return replace(curves, turn_radius=np.linspace(2.0, 3.0, len(curves.approach)))


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
    common = rng.standard_normal((400, 4)) @ rng.standard_normal((4, widths[0]))
    rows = common + rng.standard_normal(common.shape)
    relations = Relations.of(rows / rows.std(axis=0))
    band = Band(1.0, center, scale, relations, tuple(layers), spread)
    return GripEstimator("digest", curves, 0.5, (band,))


class Curves(ctypes.Structure):
    _fields_ = (
        ("points", ctypes.c_int),
        *((name, ctypes.c_void_p) for name in CURVES),
        ("cross_talk", ctypes.c_float),
        (RADIUS, ctypes.c_void_p),
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
        self._held = [np.ascontiguousarray(getattr(curves, name), dtype=S) for name in TABLES]
        *tables, radius = (each.ctypes.data for each in self._held)
        table = Curves(len(curves.approach), *tables, cross_talk, radius)
        given = ctypes.byref(table), delay, ctypes.c_float(stiffness)
        return self._library.regulator_init(self._state, *given)

    def step(self, readings, normal, tangential, lifted, torque=0.0):
        self._library.regulator_torque(self._state, ctypes.c_float(torque))
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
    return Compiled(tmp_path_factory.mktemp("c"), estimator(of_rig(bench)))


@pytest.mark.parametrize("delay", [0, 3])
def test_a_grip_goes_the_same_way(half_plane, compiled, bench, delay):
    plant, rng = CondensedPlant(half_plane, "both"), np.random.default_rng(1)
    *_, sample = press(plant, 0.04, 0.01)
    late, moved = [sample] * delay, set()
    for k in range(130):
        noisy = sample.readings + 0.5 * rng.standard_normal(GAGES)
        pull = sample.tangential_force * (1.3 if k > 110 else 1.0)
        torque = float(S(1.5 * pull + 0.05 * rng.standard_normal()))  # an arm of 1.5 mm
        felt = Sample(S(noisy).astype(float), sample.normal_force, pull, k > 100, torque)
        if k == 0:
            pair = Pair(compiled, bench, delay, felt)
        command, found = pair.step(felt)
        moved.add((command.dx > 0.0, command.dy > 0.0))
        late.append(plant.move(*found[:2].tolist()))
        sample = late.pop(0)
    assert {(False, True), (True, False), (True, True), (False, False)} == moved


def test_whatever_is_felt_the_answers_are_the_same(compiled, bench):
    rng, most = np.random.default_rng(0), bench.normal.normal_force[-1]
    normal, answers = 1.0, []
    for step in range(400):
        k = step % 50  # a grip
        normal = abs(normal + 0.1 * most * rng.standard_normal()) % (1.5 * most) if k != 20 else 0.0
        readings = S(10.0 ** rng.uniform(-3, 3) * rng.standard_normal(GAGES)).astype(float)
        torque = float(S(rng.standard_normal()))
        felt = Sample(readings, normal, normal * rng.uniform(-0.1, 0.8), k > 40, torque)
        if k == 0:
            pair = Pair(compiled, bench, step // 50, felt)
        if k == 30:  # a cable has come off: nothing is felt, and nothing moves
            nothing = np.full(GAGES, np.nan), normal, felt.tangential_force, felt.lifted
            assert not compiled.step(*nothing)[:2].any()
            assert compiled.status == 1
            pair.miss()
        if k == 31:
            assert not compiled.step(readings, normal, 0.0, felt.lifted, np.nan)[:2].any()
            assert compiled.status == 1
            pair.miss()
        answers.append(pair.step(felt)[1])
    assert (np.ptp(answers, axis=0) > 0.0).all()


def test_a_friction_that_is_hardly_known_counts_for_half_at_least(tmp_path, bench):
    """Of a hanging object: pressed harder above 0.82 of a half, not above 0.82 of a fifth."""
    if COMPILER is None:
        pytest.skip("no C compiler here (cc, gcc or clang): the C file was not run")
    curves = FingerCurves.of(bench)
    found = estimator(curves)
    unsure = replace(found, bands=(replace(found.band, spread=np.array([[1.0, 0.5]])),))
    compiled = Compiled(tmp_path, unsure)
    assert compiled.init(curves, 0, bench.tangential_stiffness) == 0
    single = SingleRegulator(unsure, GRIP, replace(bench, delay=0, cross_talk=CROSS_TALK))
    normal, friction, closed = 2.0, 0.0, []
    for used, lifted in [*[(None, False)] * 3, (0.35, True), (0.45, True)]:
        ratio = 0.2 if used is None else used * friction
        given = np.zeros(GAGES), normal, (ratio + CROSS_TALK) * normal, lifted
        answer = compiled.step(*given)
        assert answer.tobytes() == S(single.step(*given)).tobytes()
        friction = float(answer[4])
        closed.append(bool(answer[1] > 0.0))
    assert 1.0 - 1.0 / float(single.weight) ** 0.5 < 0.3
    assert closed[-2:] == [False, True]


def test_what_cannot_be_is_refused(compiled, bench):
    curves = of_rig(bench)
    falling = FingerCurves(curves.normal_force[::-1], *list(vars(curves).values())[1:])
    for wrong in [(curves, -1, 1.0), (curves, 121, 1.0), (curves, 0, 0.0), (falling, 0, 1.0)]:
        assert compiled.init(*wrong) == 1
    for name in TABLES:
        broken = {**vars(curves), name: np.where(vars(curves)[name] > 0.0, np.inf, 0.0)}
        assert compiled.init(FingerCurves(**broken), 0, 1.0) == 1
    assert compiled.init(curves, 0, np.inf) == 1


def test_it_fits_into_64_kB_and_the_page_calls_it(tmp_path):
    """15 gages, 123 features, hidden layers of 96 and 32: 15,000 weights, 7,500 relations."""
    if COMPILER is None:
        pytest.skip("no C compiler here (cc, gcc or clang): the C file was not measured")
    ones = np.ones((2, 15))
    curves = FingerCurves(ones[:, 0], ones, ones, *[ones[:, 0]] * 3)
    for name, text in c_files(estimator(curves, network._HIDDEN), GRIP).items():
        (tmp_path / name).write_text(text)
    (tmp_path / "hand.c").write_text(re.search("```c\n(.*?)```", PAGE.read_text(), re.S)[1])
    for name in ("regulator", "hand"):
        subprocess.run([COMPILER, *FLAGS, "-Os", "-c", f"{name}.c"], cwd=tmp_path, check=True)
    # With the object file's own headers; text and data are less.
    assert (tmp_path / "regulator.o").stat().st_size < 64_000
    includes = re.findall("#include (.*)", (tmp_path / "regulator.c").read_text())
    assert sorted(includes) == ['"regulator.h"', "<math.h>", "<stdint.h>", "<string.h>"]


def in_singles(estimator):
    """The estimator with the weights that the C file has."""
    layers = []
    for each in estimator.band.layers:
        weight, scale = in_16_bits(each.weight)
        layers.append(Layer(weight * scale.astype(float), each.bias))
    return replace(estimator, bands=(replace(estimator.band, layers=tuple(layers)),))


class Pair:
    """The same grip in C and by the controller, which makes the moves of the C file."""

    def __init__(self, compiled, bench, delay, first):
        curves = of_rig(bench)
        assert compiled.init(curves, delay, bench.tangential_stiffness) == 0
        self.compiled, self.delay = compiled, delay
        self.calibration = replace(bench, delay=delay, cross_talk=CROSS_TALK)
        trained = Object(estimator=in_singles(estimator(curves)))
        self.hand = Regulator(GRIP, RegulatorTable(), trained)
        self.hand.start(self.calibration, self.calibration.corrected(first))
        self.single = SingleRegulator(estimator(curves), GRIP, self.calibration)

    def step(self, felt):
        """The command of the controller and the answer of the C file: of equal bits in singles."""
        given = felt.readings, felt.normal_force, felt.tangential_force, felt.lifted, felt.torque
        settling = self.hand._settling > 0
        found = self.compiled.step(*given)
        command = self.hand.command(self.calibration.corrected(felt))
        known = self.hand.estimator.estimate(self.hand._history)
        assert self.compiled.status == 0
        assert found.tobytes() == S(self.single.step(*given)).tobytes()
        # The errors of single precision were up to 1.5e-5, 4e-7, 1.1e-6 and 0.
        expected = [known.stick_ratio, known.friction_utilisation]
        assert found[2:4] == pytest.approx(expected, abs=1e-4)
        assert found[4] == pytest.approx(self.hand.friction or 0.0, rel=1e-5)
        assert found[5] == command.unsure
        assert found[0] == pytest.approx(command.dx, abs=1e-5 * GRIP.shear_step_mm)
        assert found[1] == pytest.approx(command.dy, abs=1e-5 * GRIP.approach_step_mm)
        if not settling:
            self.hand._pending[-1] = tuple(found[:2].tolist())
        return command, found

    def miss(self):
        """A sample passed over: its move counts with the next one's, and none follows."""
        self.single.miss()
        if self.hand._settling > 0:
            self.hand._settling -= 1
        elif self.delay > 0:
            (x, y), (x1, y1), *rest = self.hand._pending
            self.hand._pending = deque([(x1 + x, y1 + y), *rest, (0.0, 0.0)])
