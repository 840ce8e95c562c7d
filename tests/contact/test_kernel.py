"""The compiled kernel against numpy, its judge; and a machine without a compiler."""

from dataclasses import fields

import numpy as np
import pytest

from fingerdesign.contact.increment import Workspace
from fingerdesign.contact.outcome import Answer, outcome
from fingerdesign.contact.problem import Motion
from fingerdesign.contact.solver import kernel
from fingerdesign.contact.solver.tracking import Tracker
from fingerdesign.runtime import native
from tests.contact.conftest import SCALED
from tests.support.reduced import followed


@pytest.fixture
def library():
    found = kernel.kernel()
    if found is None:
        pytest.skip("no C compiler on this machine")
    return found


@pytest.mark.parametrize("shape", ["strip", "patch"])
@pytest.mark.parametrize("friction", [0.3, *SCALED.values()], ids=["coefficient", *SCALED])
@pytest.mark.parametrize("spoilt", ["", "force", "motion", "nothing", "not a number", "all open"])
def test_the_kernel_judges_an_answer_as_numpy_does(shape, friction, spoilt, request, library):
    """Right or wrong, finite or not: the same certificate and the same state."""
    problem = request.getfixturevalue(shape).with_friction(friction)
    rows = [Motion(0.02, 0.0), Motion(0.021, 0.004), Motion(0.021, 0.009)]
    *_, before, last = followed(problem, rows)
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
    start = 0.9 * found.yielded

    class Started(kernel.CompiledTracker):
        """A tracker that measures the motion from ``start``."""

        def _before(self, slip, answer):
            return start

    tracker = Started(library, problem.compliance, problem.self_compliance, problem.friction)
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


@pytest.fixture
def no_compiler(monkeypatch, own_cache):
    """A machine on whose PATH there is no compiler."""
    caches = native._compiled, kernel.kernel
    monkeypatch.setenv("PATH", "")
    for each in caches:
        each.cache_clear()
    yield
    for each in caches:
        each.cache_clear()


def test_without_a_compiler_numpy_does_it(patch, no_compiler):
    assert kernel.kernel() is None
    assert type(Workspace().tracker(patch)) is Tracker


def test_a_library_is_made_once_and_cached_by_content(tmp_path, library, own_cache, request):
    source = tmp_path / "answer.c"
    source.write_text("int answer(void) { return 42; }\n")
    assert native.compiled(source).answer() == 42
    request.getfixturevalue("no_compiler")
    assert native.compiled(source).answer() == 42
    source.write_text("this is not C\n")
    assert native._compiled.__wrapped__(source) is None


def test_a_user_can_refuse_compiled_code(tmp_path, monkeypatch):
    monkeypatch.setenv("FINGERDESIGN_NATIVE", "0")
    source = tmp_path / "answer.c"
    source.write_text("int answer(void) { return 42; }\n")
    assert native.compiled(source) is None
