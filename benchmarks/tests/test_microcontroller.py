"""The regulator on a Cortex-M in an emulator: numpy's bits, memory, the count of a step."""

from types import SimpleNamespace

import numpy as np
import pytest
from fingerdesign_bench.microcontroller import run as bench

from fingerdesign.checks.load import load_design
from fingerdesign.sensing.train.ready import shipped_estimator
from tests.support.singles import SingleRegulator


@pytest.mark.slow
@pytest.mark.parametrize("core", bench.CORES, ids=lambda core: core.name)
def test_a_microcontroller_has_the_bits_of_numpy_within_its_limits(core):
    """Six samples after the features' history is full."""
    count = 46
    if missing := bench.missing_tools():
        pytest.skip(f"not installed: {', '.join(missing)}")
    design = load_design("film_tees")
    estimator, grip = shipped_estimator(design), design.grip
    found = bench.counted(core, estimator, grip, delay=2, count=count)
    stiff = bench.stiffness(estimator, grip)
    bench_of = SimpleNamespace(delay=2, cross_talk=0.0, tangential_stiffness=stiff)
    single = SingleRegulator(estimator, grip, bench_of)
    for (normal, pull, *readings), answer in zip(
        bench.samples(estimator, count), found.answers, strict=True
    ):
        expected = single.step(np.float32(readings), normal, pull, False)
        assert np.float32(expected[:5]).tobytes() == answer.tobytes()
    assert np.ptp(found.answers, axis=0).all()
    assert found.flash < 1024 * bench.FLASH_kB
    assert found.ram < 1024 * bench.RAM_kB
    assert found.instructions < found.cycles < 1e3 * bench.STEP_ms * bench.CLOCK_MHz


def test_cycles_of_a_step_are_those_of_the_table():
    """A branch that jumps costs its refill; a list of registers, one each; a result that waits."""
    line = "Trace 0: 0x7f [00800408/{:08x}/00000110/ff000201] {}"
    path = [(2, "regulator_step"), (4, "sqrtf"), (8, "sqrtf"), (2, "regulator_step"), (30, "main")]
    cycles = {2: (4, 1), 4: (15, 15), 8: (4, 1)}
    lines = ["Servers of hardware", *(line.format(*each) for each in path)]
    assert list(bench._steps(lines, cycles)) == [(4, 1 + 15 + 4 + 4)]
    assert bench._most("pop", " {r4, r5-r7, pc}", "") == 1 + 4 + 1 + 4
    assert bench._most("vadd.f32", " s1, s2, s3", " s4, s1, s5") == 2
    assert bench._most("vadd.f32", " s1, s2, s3", " s4, s11, s5") == 1
    assert bench._most("add", " r1, r2", " r3, r1") == 1
