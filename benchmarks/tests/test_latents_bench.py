"""Errors of fitted latents against what was drawn, as checks."""

import numpy as np
import pytest
from fingerdesign_bench.studies.latents import _of_case


def test_errors_are_counted_by_the_deviations_that_were_stated():
    rows = np.array([[0.01, 0.01], [-0.03, 0.01], [0.0, 0.01], [0.01, 0.01]])
    rms, said, outside = _of_case("at rest", {"x": [rows[:2], rows[2:]]})
    assert rms.measured == pytest.approx(np.sqrt(0.0011 / 4))
    assert said.measured == pytest.approx(np.sqrt(11 / 4))
    assert outside.measured == 0.25
    assert (rms.unit, rms.name) == ("mm", "at rest: x, RMS error (0.058 before)")
    assert not outside.holds
