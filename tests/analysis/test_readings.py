"""Readings and their errors: each relative to what the contract says."""

import numpy as np
import pytest

from fingerdesign.analysis.fidelity.ladder import ORDERS, difference, discretisation, of_most
from fingerdesign.analysis.fidelity.readings import Readings, errors


def path(normal=(1.0, 2.0), tangential=(0.0, 1.0), stick=(1.0, 0.5), gages=None, face="both"):
    both = np.array([[[10.0, -10.0], [4.0, 6.0]], [[20.0, 0.0], [1.0, 1.0]]])
    return Readings(
        np.array(normal),
        np.array(tangential),
        np.array([1.0, 2.0]),
        np.array(stick),
        both if gages is None else np.array(gages),
        face,
    )


def test_what_a_gage_reads_is_of_its_face():
    np.testing.assert_allclose(path().reading, [[0.0, 5.0], [10.0, 1.0]])
    np.testing.assert_allclose(path(face="upper").reading, [[10.0, 4.0], [20.0, 1.0]])
    np.testing.assert_allclose(path(face="lower").reading, [[-10.0, 6.0], [0.0, 1.0]])


def test_errors_are_relative_to_what_the_contract_says():
    found = path(normal=(1.1, 2.1), tangential=(0.01, 1.02), stick=(0.9, 0.52))
    off = errors(found, path())
    np.testing.assert_allclose(off.normal_force, [0.1, 0.05])
    np.testing.assert_allclose(off.tangential_force, [0.01, 0.02])  # of the path's largest
    np.testing.assert_allclose(off.stick_ratio, [0.1, 0.02])  # absolute
    np.testing.assert_allclose(off.gage, 0.0)
    gages = path().gages + np.array([1.0, 1.0])
    np.testing.assert_allclose(errors(path(gages=gages), path()).gage, [[0.2, 0.2], [0.1, 0.1]])


def test_paths_of_other_lengths_are_not_compared():
    with pytest.raises(ValueError, match="2 and 1 rows"):
        errors(path(), path().part(slice(1)))


def test_a_finger_without_gages_has_no_gage_error():
    bare = path(gages=np.empty((2, 0, 2)))
    assert errors(bare, bare).worst()["gage"] == 0.0
    assert difference(bare, bare).worst == 0.0


def test_richardson_finds_the_error_of_a_power_law():
    exact = path()
    coarse = path(normal=(1.0 + 2.0 ** ORDERS["normal_force"] * 0.01, 2.0))
    fine = path(normal=(1.01, 2.0))
    estimate = discretisation(fine, coarse, 2.0).by_quantity["normal_force"]
    truth = difference(fine, exact).by_quantity["normal_force"]
    assert estimate == pytest.approx(truth, rel=0.02)  # relative to the fine answer, not the exact
    with pytest.raises(ValueError, match="ratio"):
        discretisation(fine, coarse, 1.0)


def test_an_error_is_that_of_most_readings():
    values = np.r_[np.zeros(99), 1.0]
    assert of_most(values) == 0.0
    assert of_most(np.empty(0)) == 0.0
    assert of_most(np.linspace(0.0, 1.0, 101)) == pytest.approx(0.95)
