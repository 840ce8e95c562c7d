"""A dome under a plane by the product's own road, tetwild mesh and all."""

import numpy as np
import pytest
from fingerdesign_bench.accuracy.verification_product import dome_errors


@pytest.mark.slow
def test_hertz_and_cattaneo_mindlin_on_a_dome(monkeypatch, tmp_path):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    errors = dome_errors()
    assert np.abs(errors.peak).max() < 1e-2
    assert np.abs(errors.width).max() < 4e-2  # 0.010 to 0.028 from mesh to mesh
    assert np.abs(errors.stick).max() < 4e-2
