"""Our assembly against scikit-fem's own: the same matrix."""

import pytest
from fingerdesign_bench.speed.assembly import compared


@pytest.mark.parametrize(("dimension", "count"), [(2, 5), (3, 3)])
def test_the_stiffness_is_that_of_scikit_fem(dimension, count):
    ours, theirs, difference, dofs = compared(dimension, count)
    assert dofs == dimension * (2 * count + 1) ** dimension
    assert difference < 1e-13
    assert ours > 0.0
    assert theirs > 0.0
