"""The tables that two other finite-element codes agree on (data/two_codes.json)."""

import pytest
from fingerdesign_bench.accuracy import reference


def assert_all(checks):
    failing = [" ".join(check.row()) for check in checks if not check.holds]
    assert not failing, "\n".join(failing)


def test_plane_strain():
    assert_all(reference.plane_strain_checks())


def test_one_plate():
    assert_all(reference.one_plate_checks())


def test_three_d_extruded():
    assert_all(reference.three_d_checks("extrude"))


@pytest.mark.slow
def test_three_d_tetwild(monkeypatch, tmp_path):
    monkeypatch.setenv("FINGERDESIGN_CACHE", str(tmp_path))
    assert_all(reference.three_d_checks("tetwild"))
