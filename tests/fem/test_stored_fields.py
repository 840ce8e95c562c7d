"""Fields that are stored with a body's answers, and taken for another modulus."""

import numpy as np
import pytest

from fingerdesign.fem.answers import load_fields, store_fields


@pytest.mark.usefixtures("own_cache")
def test_fields_of_all_stores_scale_with_the_modulus():
    """Displacements by given forces go with one over all moduli, those stored before as well."""
    rng = np.random.default_rng(0)
    forces, fields = rng.standard_normal((2, 1, 6)), rng.standard_normal((2, 1, 30))
    assert store_fields("a" * 64, 1.0, forces[0], fields[0])
    assert store_fields("a" * 64, 2.0, forces[1], fields[1])
    for modulus in (1.0, 2.0, 5.0):
        for given, stored, own in zip(forces, fields, (1.0, 2.0), strict=True):
            found = load_fields("a" * 64, modulus, given)
            assert found == pytest.approx(stored * own / modulus)
    assert load_fields("a" * 64, 1.0, rng.standard_normal((1, 6))) is None
