"""Which rows are compared at equal force, and how."""

import numpy as np
import pytest

from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.checks.load import parse_scene
from fingerdesign.contact.problem import Motion
from fingerdesign.errors import SolverError
from fingerdesign.validate.comparison import Answer, compare, side_of, usable_rows

ROWS = "[[0.0, 0.0], [0.1, 0.0], [0.2, 0.05], [0.2, 0.5], [0.2, 0.2]]"
NORMAL = np.array([0.0, 1.0, 3.0, 3.0, 3.0])
PULL = np.array([0.0, 0.01, 0.5, 1.49, 0.2])


def scene(rows=ROWS):
    return parse_scene(f"object.friction_coefficient = 0.5\npath.increments_mm = {rows}\n")


def readings(normal=NORMAL, pull=PULL, factor=1.0):
    rows = len(normal)
    stick = np.where(pull < 1.4, 0.8, 0.0)
    return Readings(factor * normal, pull, np.ones(rows), stick, np.zeros((rows, 0, 2)))


def answer(along=None, **changed):
    found = readings(**changed)
    motions = tuple(Motion(0.1, 0.0) for _ in range(found.rows))
    return Answer("a model", found, motions, 1.0, 10, 3, along)


def test_rows_before_touch_and_from_complete_slip_on_are_left_out():
    first, last, note = usable_rows(answer(), scene())
    assert (first, last) == (1, 3)
    assert "1 row before it presses" in note
    assert "2 rows from complete slip" in note


def test_the_better_models_forces_are_followed():
    requested = []

    def along(other):
        requested.append(other)
        return readings(NORMAL[1:3], PULL[1:3])

    found = compare("x", answer(along, factor=1.3), answer(), scene())
    assert requested[0].path.control == "force"
    assert requested[0].path.increments_N == ((1.0, 0.01), (3.0, 0.5))
    assert found.force.rows == 2
    assert found.force.rows_left_out == 3
    assert found.force.errors["normal_force"] is None  # prescribed
    assert found.force.errors["tangential_force"] is None
    assert found.force.errors["contact_width"].greatest == 0.0
    assert found.motion.errors["normal_force"].greatest == pytest.approx(0.3)


def test_forces_that_a_model_cannot_carry_are_left_out_and_counted():
    def along(other):
        if len(other.path.rows) > 1:
            raise SolverError("no equilibrium")
        return readings(NORMAL[1:2], PULL[1:2])

    found = compare("x", answer(along), answer(), scene()).force
    assert (found.rows, found.rows_left_out) == (1, 4)
    assert "no equilibrium" in found.note


def test_a_model_that_can_carry_none_is_missing_with_its_reason():
    def along(other):
        raise SolverError("no equilibrium")

    found = compare("x", answer(along), answer(), scene())
    assert found.force is None
    assert found.motion is not None
    assert "cannot follow even the first row: no equilibrium" in found.missing[0]


def test_paths_out_of_the_plane_have_no_equal_force():
    rows = "[[0.1, 0.0, 0.0], [0.2, 0.0, 0.1]]"
    two = {"normal": NORMAL[1:3], "pull": PULL[1:3]}
    found = compare("x", answer(**two), answer(**two), scene(rows))
    assert found.force is None
    assert "shear_z" in found.missing[0]


def test_rounding_of_a_pull_that_is_not_there_is_no_error():
    found = side_of(readings(pull=1e-6 * np.ones(5)), readings(pull=-1e-6 * np.ones(5)))
    assert found.errors["tangential_force"] is None
    assert found.errors["normal_force"].greatest == 0.0
