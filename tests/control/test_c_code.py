"""The regulator in C: bit by bit what numpy does in singles, and nearly what it does in doubles."""

import ctypes
import re
import shutil
import subprocess
from collections import deque
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from fingerdesign.control.c_code import c_files, constants, in_16_bits
from fingerdesign.control.controllers.regulator import Regulator, RegulatorTable
from fingerdesign.control.estimator import (
    LAGS,
    SILENT,
    Band,
    FingerCurves,
    GripEstimator,
    Layer,
    feature_count,
    readings_at,
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


class Single:
    """The regulator in numpy's singles, each operation in the order of the C file's."""

    def __init__(self, estimator, grip, curves, delay, stiffness):
        self.n = SimpleNamespace(**{k: S(v) for k, v in constants(estimator, grip).items()})
        self.band = estimator.band
        self.layers = [(*in_16_bits(e.weight), S(e.bias)) for e in self.band.layers]
        self.force, self.pressed, self.sticking, self.approach, self.stiff = (
            S(getattr(curves, name)) for name in NAMES
        )
        self.delay = self.settling = delay
        self.stiffness, self.history, self.pulled = S(stiffness), [], False
        self.pressing = self.weight = self.sum = self.used = self.probed = S(0.0)
        self.unfelt = deque([(S(0.0), S(0.0))] * (delay + 1))

    @staticmethod
    def log(x):
        m, power = np.frexp(x)
        if m < S(0.70710678):
            m, power = m + m, power - 1
        s = (m - S(1.0)) / (m + S(1.0))
        q = s * s
        series = S(0.14285714) + q * S(0.11111111)
        series = S(1.0) + q * (S(0.33333333) + q * (S(0.2) + q * series))
        return S(2.0) * s * series + S(0.69314718) * S(power)

    @staticmethod
    def at(x, xs, ys):
        x = min(max(x, xs[0]), xs[-1])
        k = min(max(int(np.searchsorted(xs, x)) - 1, 0), len(xs) - 2)
        return ys[k] + (x - xs[k]) / (xs[k + 1] - xs[k]) * (ys[k + 1] - ys[k])

    def changes(self, first, alone, scale, pressed):
        (readings, normal, tangential, *_), n = self.history[-1], self.n
        before = self.history[first]
        dx = dy = along = closed = S(0.0)
        for *_, x, y in self.history[first + 1 :]:
            dx, dy, along, closed = dx + x, dy + y, along + abs(x), closed + abs(y)
        way = max(along + closed, n.LEAST_MOTION)
        after = self.at(before[1], self.force, self.approach) + dy
        after = self.at(after, self.approach, self.force)
        pulling = self.at(S(0.5) * (before[1] + after), self.force, self.stiff) * dx
        rise, pull = normal - before[1], tangential - before[2]
        size = abs(pull) + n.NORMAL_SHARE * abs(rise) + n.LEAST_CHANGE
        change = readings - before[0] - (alone - self.at(before[1], self.force, self.pressed))
        of_forces = rise, pull, rise - (after - before[1]), pull - pulling
        logs = self.log(way), self.log(size / pressed)
        return [*(change / (scale * size)), *(e / size for e in of_forces), dx / way, *logs]

    def estimate(self):
        (readings, normal, tangential, dx, _), n = self.history[-1], self.n
        pressed = max(normal, n.LEAST_FORCE)
        alone = self.at(pressed, self.force, self.pressed)
        sticking = self.at(pressed, self.force, self.sticking)
        scale = max(abs(sticking).max(), n.LEAST_RESPONSE)
        present = (readings - alone) / (scale * pressed)
        most = max(S(0.0), *(e[2] / max(e[1], n.LEAST_FORCE) for e in self.history))
        found = [*present, self.log(pressed), tangential / pressed, n.LOG_NOISE, most]
        last = len(self.history) - 1
        self.pulled = self.pulled or dx != 0.0
        if not self.pulled:
            self.touch, self.start = present, last
        for first in (*(max(last - lag, 0) for lag in LAGS), self.start):
            found += self.changes(first, alone, scale, pressed)
        values = (S([*found, *self.touch]) - S(self.band.center)) / S(self.band.scale)
        values = np.clip(values, -n.OUTLIER, n.OUTLIER)
        if last + 1 >= SILENT:
            most = abs(S([each[0] for each in self.history[-SILENT:]])).max(axis=0)
            dead = np.flatnonzero((most < n.NOTHING) & (abs(alone) > n.HEARD * n.NOTHING))
            values[np.add.outer(readings_at(len(alone)), dead)] = S(0.0)
        for k, (weight, scale, bias) in enumerate(self.layers):
            sums = np.zeros(len(bias), dtype=S)
            for value, row in zip(values, S(weight), strict=True):
                sums += value * row
            values = scale * sums + bias
            values = values if k + 1 == len(self.layers) else np.maximum(values, S(0.0))
        stick, used = (min(max(value, S(0.0)), S(1.0)) for value in values[:2])
        edges, spreads = S(self.band.spread).T
        return stick, used, spreads[min(int((edges < values[2]).sum()), len(edges) - 1)]

    def learn(self, used, spread, lifted):
        (_, normal, tangential, dx, dy), n = self.history[-1], self.n
        rise, change = normal - self.history[-2][1], tangential - self.history[-2][2]
        if dy > 0.0 and rise > 0.0:
            self.pressing = rise / dy
        if dx > S(0.02) * n.SHEAR_STEP and change > 0.0:
            share = (S(1.0) - n.STIFFNESS_FADES) * change / dx
            self.stiffness = n.STIFFNESS_FADES * self.stiffness + share
        if lifted or not self.pulled or used < n.LEAST_USED or normal < S(2.0) * n.LEAST_FORCE:
            return
        friction = min(max(tangential / (normal * used), n.LEAST_FRICTION), n.MOST_FRICTION)
        sure, memory = used / max(spread, S(1e-3)), n.MEMORY
        sure = sure * sure  # not a power, which the C library may round otherwise
        if dy > 0.0:
            sure, memory = n.CLIMBING * sure, S(1.0) - n.CLIMBING * (S(1.0) - memory)
        self.weight = memory * self.weight + sure
        self.sum = memory * self.sum + sure * friction

    def surely(self, friction):
        return friction * max(S(1.0) - self.n.CAUTION / np.sqrt(self.weight), S(0.5))

    def close(self, pressed):
        if not self.pressing > 0.0:
            return S(0.5) * self.n.APPROACH_STEP
        gentle = self.n.PRESS_SHARE * pressed / self.pressing
        return min(self.n.APPROACH_STEP, max(gentle, S(0.1) * self.n.APPROACH_STEP))

    def shear(self, force):
        return min(max(force / self.stiffness, S(0.0)), self.n.SHEAR_STEP)

    def move(self, stick, used, normal, tangential, lifted):
        n, nothing, known = self.n, S(0.0), self.weight > 0.0
        pressed = max(normal, n.LEAST_FORCE)
        ratio = tangential / pressed
        friction = self.sum / self.weight if known else nothing
        believed = ratio / friction if known else nothing
        if lifted:
            in_use = ratio / (self.surely(friction) if known else n.UNKNOWN)
            return nothing, self.close(pressed) if in_use > n.MOST_HELD else nothing
        self.used += n.NEWS * (used - self.used)
        if stick < n.LEAST_STICK or max(self.used, believed) > n.MOST_USED:
            self.probed = self.probed or pressed
            return nothing, self.close(pressed)
        if pressed > n.AGAIN * self.probed > 0.0:
            self.probed = nothing
            self.weight, self.sum = n.KEPT * self.weight, n.KEPT * self.sum
        if self.probed == 0.0:
            if pressed < n.PROBE_FORCE_N:
                return nothing, self.close(pressed)
            unfelt = max(ratio - self.history[-1][2] / pressed, nothing)
            unfelt = unfelt / friction if known else nothing
            room = n.NEAR * n.TARGET - self.used - unfelt
            if room > 0.0:
                step = n.PULL_SHARE * pressed / np.sqrt(S(1 + self.delay))
                if known:
                    least, most = n.SLOWEST * step, n.OF_ROOM * room * friction * pressed
                    step = max(min(step, most), least)
                return self.shear(step), nothing
            self.probed = pressed
        if not known:
            return self.shear(n.PULL_SHARE * pressed), nothing
        dy = self.close(pressed)
        aim = n.TARGET * self.surely(friction) * (normal + max(self.pressing, nothing) * dy)
        return self.shear(aim - tangential), dy

    def step(self, readings, normal, tangential, lifted):
        pulled = S(tangential) - S(CROSS_TALK) * S(normal)
        felt, nothing = (S(readings), S(normal), pulled), S(0.0)
        settles = self.settling > 0
        if settles or not self.history:
            self.history = [(*felt, nothing, nothing)]
        if settles:
            self.settling -= 1
            return *(nothing,) * 2, *self.estimate()[:2], nothing, True
        self.history.append((*felt, *self.unfelt.popleft()))
        stick, used, spread = self.estimate()
        self.learn(used, spread, lifted)
        dx = dy = nothing
        for x, y in self.unfelt:
            dx, dy = dx + x, dy + y
        ahead = felt[1] + self.pressing * dy, felt[2] + self.stiffness * dx
        move = self.move(stick, used, *ahead, lifted)
        self.unfelt.append(move)
        friction = self.sum / self.weight if self.weight > 0.0 else nothing
        return *move, stick, used, friction, self.weight < self.n.SURE

    def miss(self):
        """A sample passed over: its move counts with the next one's, and none follows."""
        if self.settling > 0:
            self.settling -= 1
        elif self.delay > 0:
            (x, y), (x1, y1), *rest = self.unfelt
            self.unfelt = deque([(x1 + x, y1 + y), *rest, (S(0.0), S(0.0))])


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
        self._held = [np.ascontiguousarray(getattr(curves, name), dtype=S) for name in NAMES]
        table = Curves(len(curves.approach), *(each.ctypes.data for each in self._held), cross_talk)
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


def begun(compiled, bench, delay):
    """The same grip in C, in singles and in doubles."""
    curves = FingerCurves.of(bench)
    taught = estimator(curves)
    assert compiled.init(curves, delay, bench.tangential_stiffness) == 0
    single = Single(taught, GRIP, curves, delay, bench.tangential_stiffness)
    double = Regulator(GRIP, RegulatorTable(), Object(estimator=taught))
    return single, double, replace(bench, delay=delay, cross_talk=CROSS_TALK)


def same_bits(one, other):
    return np.array_equal(S(one).view(np.int32), S(other).view(np.int32))


@pytest.mark.parametrize("delay", [0, 3])
def test_a_grip_goes_the_same_way(half_plane, compiled, bench, delay):
    """Bit by bit in singles; to 1e-3 in doubles that remember the same moves."""
    single, double, calibration = begun(compiled, bench, delay)
    plant, rng = CondensedPlant(half_plane, "both"), np.random.default_rng(1)
    *_, sample = press(plant, 0.04, 0.01)
    double.start(calibration, calibration.corrected(sample))
    late, moved, most = [sample] * delay, [], 0.0
    for k in range(130):
        noisy = sample.readings + 0.5 * rng.standard_normal(GAGES)
        pull = sample.tangential_force * (1.3 if k > 110 else 1.0)
        felt = Sample(S(noisy).astype(float), sample.normal_force, pull, k > 100)
        given = felt.readings, felt.normal_force, felt.tangential_force, felt.lifted
        found, command = compiled.step(*given), double.command(calibration.corrected(felt))
        assert compiled.status == 0
        assert same_bits(found, single.step(*given)), k
        known = double.estimator.estimate(double._history)
        assert found[2:4] == pytest.approx(
            [known.stick_ratio, known.friction_utilisation], abs=1e-3
        )
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


def test_whatever_is_felt_the_bits_are_the_same(compiled, bench):
    rng, most = np.random.default_rng(0), bench.normal.normal_force[-1]
    normal, answers = 1.0, []
    for step in range(400):
        k = step % 50  # a grip; more of them, and moves unlike what is felt run out of singles
        if k == 0:
            single, _, _ = begun(compiled, bench, delay=step // 50)
        normal = abs(normal + 0.1 * most * rng.standard_normal()) % (1.5 * most) if k != 20 else 0.0
        readings = 10.0 ** rng.uniform(-3, 3) * rng.standard_normal(GAGES)
        given = readings, normal, normal * rng.uniform(-0.1, 0.8), k > 40
        if k == 30:  # a cable has come off: nothing is felt, and nothing moves
            assert not compiled.step(np.full(GAGES, np.nan), *given[1:])[:2].any()
            assert compiled.status == 1
            single.miss()
        answers.append(compiled.step(*given))
        assert same_bits(answers[-1], single.step(*given)), step
    assert (np.ptp(answers, axis=0) > 0.0).all()


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
