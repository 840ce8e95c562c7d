"""How a row is cut into increments: what depends on it, and what must not."""

import numpy as np
import pytest

from fingerdesign.contact.force_control import Forces
from fingerdesign.contact.path import _pieces, follow, row_ends
from fingerdesign.contact.problem import Motion

# Pressed and pulled at once, then pulled: nodes close while the object moves aside.
ROWS = [Motion(0.04, 0.006), Motion(0.06, 0.012), Motion(0.06, 0.02), Motion(0.06, 0.028)]
FORCES = [Forces(0.6, 0.05), Forces(1.0, 0.15), Forces(1.0, 0.3)]


def measured(problem, rows, substeps):
    return [step.measures for step in follow(problem, rows, substeps)]


@pytest.mark.parametrize("rows", [ROWS, FORCES])
def test_by_default_a_path_is_near_that_of_short_increments(strip, rows):
    found, fine = measured(strip, rows, None), measured(strip, rows, 64)
    for one, other in zip(found, fine, strict=True):
        assert one.normal_force == pytest.approx(other.normal_force, rel=0.001)
        assert one.tangential_force == pytest.approx(other.tangential_force, rel=0.01)
        assert one.stick_ratio == pytest.approx(other.stick_ratio, abs=0.012)


def test_one_increment_a_row_is_not(strip):
    one, fine = measured(strip, ROWS, 1)[0], measured(strip, ROWS, 64)[0]
    assert one.tangential_force > 1.05 * fine.tangential_force
    assert one.stick_ratio < fine.stick_ratio - 0.05


def test_the_stick_ratio_does_not_follow_the_length_of_the_last_increment(patch):
    """Pulled without turning back, the answer is one: by the slip of the last increment alone the
    stick ratio would rise from 0.71 to 0.86."""
    rows = [Motion(0.02, 0.0), Motion(0.02, 0.003), Motion(0.02, 0.006)]
    one, cut = ([m.stick_ratio for m in measured(patch, rows, n)] for n in (1, 64))
    assert 0.3 < one[-1] < one[1] < 0.8
    assert cut == pytest.approx(one, abs=1e-6)


def test_a_slip_of_the_row_is_that_of_its_increments(strip):
    """Nodes that slide through the whole last row: their slip is the change of it."""
    rows = [Motion(0.06, 0.0), Motion(0.06, 0.05), Motion(0.06, 0.2)]
    _, before, last = (step.increment.state for step in follow(strip, rows, 4))
    slid = np.abs(last.slip - before.slip)[:, 0]
    touching = (last.multiplier[:, 0] > 0.0) & (before.multiplier[:, 0] > 0.0)
    np.testing.assert_allclose(last.sliding[touching], slid[touching], rtol=1e-6)


@pytest.mark.parametrize("coarser", [1, 2, 4])
@pytest.mark.parametrize("touching", [True, False])
def test_cuts_end_with_the_row_and_grow_toward_it(touching, coarser):
    ends = row_ends(None, touching, coarser)
    assert ends[-1] == 1.0
    assert (np.diff([0.0, *ends]) > 0.0).all()
    assert len(row_ends(None, touching)) == coarser * len(ends)


def test_pieces_of_a_row_go_evenly_from_what_is_carried_and_where_it_stands(strip):
    *_, step = follow(strip, [Forces(1.0, 0.2)])
    state, ends = step.increment.state, np.array([0.25, 1.0])
    first, last = _pieces(strip, state, row := Forces(2.0, -0.2), ends)
    assert last is row
    assert (first.normal, first.tangential) == pytest.approx((1.25, 0.1), abs=1e-8)
    assert first.held.amplitudes == pytest.approx(0.75 * state.motion.amplitudes)
    first, _ = _pieces(strip, state, Motion(0.0, 0.0), ends)
    assert first.amplitudes == pytest.approx(0.75 * state.motion.amplitudes)
