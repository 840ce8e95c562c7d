"""The compiled kernel against numpy, its judge; and a machine without a compiler."""

from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest

from fingerdesign.contact.increment import TRACKED, ContactState, Workspace, solve_increment
from fingerdesign.contact.outcome import Answer, outcome
from fingerdesign.contact.problem import Motion
from fingerdesign.contact.solver import kernel
from fingerdesign.contact.solver.tracking import Tracker
from fingerdesign.runtime import native
from tests.contact.test_tracking import walk

SAME = 1e-9  # of the largest force, and of the length that it makes


@pytest.fixture
def library():
    found = kernel.kernel()
    if found is None:
        pytest.skip("no C compiler on this machine")
    return found


def increments(problem, motions):
    state, workspace = ContactState.untouched(problem), Workspace()
    for motion in motions:
        found = solve_increment(problem, state, motion, workspace)
        yield found
        state = found.state


@pytest.mark.parametrize("friction", [0.0, 0.2, 0.7])
@pytest.mark.parametrize("shape", ["strip", "patch"])
def test_the_kernel_follows_a_path_as_numpy_does(shape, friction, request, library, monkeypatch):
    problem = request.getfixturevalue(shape).with_friction(friction)
    motions = [*walk(30), Motion(-0.01, 0.0), Motion(0.02, 0.01), *walk(10, seed=1)]
    compiled = list(increments(problem, motions))
    monkeypatch.setattr("fingerdesign.contact.increment.tracker_of", Tracker)
    force = max(float(each.multiplier.max()) for each in compiled)
    length = force * problem.typical_compliance
    for one, other in zip(compiled, increments(problem, motions), strict=True):
        for mine, theirs, scale in (
            (one.multiplier, other.multiplier, force),
            (one.force, other.force, force),
            (one.gap, other.gap, length),
            (one.slip_increment, other.slip_increment, length),
            (one.state.slip, other.state.slip, length),
            (one.state.travelled, other.state.travelled, length),
        ):
            np.testing.assert_allclose(mine, theirs, rtol=0.0, atol=SAME * scale)
        np.testing.assert_array_equal(one.status, other.status)
    assert np.mean([each.method == TRACKED for each in compiled]) > 0.8


@pytest.mark.parametrize("shape", ["strip", "patch"])
@pytest.mark.parametrize("spoilt", ["", "force", "motion", "nothing", "not a number", "all open"])
def test_the_kernel_judges_an_answer_as_numpy_does(shape, spoilt, request, library, monkeypatch):
    """Right or wrong, finite or not: the same certificate and the same state."""
    problem = request.getfixturevalue(shape).with_friction(0.3)
    rows = [Motion(0.02, 0.0), Motion(0.021, 0.004), Motion(0.021, 0.009)]
    *_, before, last = increments(problem, rows)
    motion = np.column_stack([last.gap, last.slip_increment])
    multiplier, rng = last.multiplier.copy(), np.random.default_rng(0)
    if spoilt == "force":
        multiplier += 1e-3 * multiplier.max() * rng.normal(size=multiplier.shape)
    elif spoilt == "motion":
        motion += 1e-3 * np.abs(motion).max() * rng.normal(size=motion.shape)
    elif spoilt == "nothing":
        multiplier[:] = 0.0
    elif spoilt == "not a number":
        motion[3, 1] = np.nan
    elif spoilt == "all open":
        multiplier[:], motion[:, 0] = 0.0, np.abs(motion[:, 0]) + 1e-3
    found = Answer(multiplier, motion - 0.01, motion, 0.0, 1)
    tracker = kernel.CompiledTracker(
        library, problem.compliance, problem.self_compliance, problem.friction_coefficient
    )
    start = 0.9 * found.yielded
    monkeypatch.setattr(tracker, "_before", lambda slip, answer: start)
    mine = tracker.outcome(problem, before.state, found)
    theirs = outcome(problem, before.state, found, start)
    for law in fields(theirs.certificate):
        one, other = (getattr(each.certificate, law.name) for each in (mine, theirs))
        assert one == pytest.approx(other, rel=1e-9, abs=1e-14), law.name
    if spoilt == "not a number":
        return  # nothing else of it is read
    for name in ("force", "status", "touching", "ahead", "slip", "travelled", "sliding"):
        one, other = getattr(mine, name), getattr(theirs, name)
        np.testing.assert_allclose(one, other, rtol=1e-12, atol=1e-15, err_msg=name)
    assert mine.at_rim == theirs.at_rim
    assert mine.largest == theirs.largest


def test_without_a_compiler_numpy_does_it(patch, monkeypatch, own_cache):
    monkeypatch.setattr(native, "_COMPILERS", ("no-such-compiler",))
    found = native._compiled.__wrapped__(Path(kernel.__file__).with_name("kernel.c"))
    assert found is None
    monkeypatch.setattr(kernel, "kernel", lambda: None)
    assert type(Workspace().tracker(patch)) is Tracker


def test_a_library_is_made_once_and_cached_by_content(tmp_path, monkeypatch, library):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path / "cache"))
    source = tmp_path / "answer.c"
    source.write_text("int answer(void) { return 42; }\n")
    assert native.compiled(source).answer() == 42
    monkeypatch.setattr(native, "_COMPILERS", ("no-such-compiler",))
    assert native._compiled.__wrapped__(source).answer() == 42
    source.write_text("this is not C\n")
    assert native._compiled.__wrapped__(source) is None
    monkeypatch.setenv("FINGERDESIGN_NATIVE", "0")
    assert native._compiled.__wrapped__(source) is None
