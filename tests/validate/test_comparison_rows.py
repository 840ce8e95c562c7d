"""Which rows are compared at equal force, and how."""

from dataclasses import replace

import numpy as np
import pytest

from fingerdesign.analysis.fidelity.readings import Readings
from fingerdesign.analysis.path import PathStopped
from fingerdesign.contact.problem import Motion
from fingerdesign.design.io import parse_scene
from fingerdesign.errors import SolverError
from fingerdesign.validate.advice import advise, worst_of
from fingerdesign.validate.comparison import Answer, compare, side_of, usable_rows
from fingerdesign.validate.record import ComparisonData

ROWS = "[[0.0, 0.0], [0.1, 0.0], [0.2, 0.05], [0.2, 0.5], [0.2, 0.2]]"
NORMAL = np.array([0.0, 1.0, 3.0, 3.0, 3.0])
FORCED = parse_scene('path.control = "force"\npath.increments_N = [[1.0, 0.0]]\n')
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
    assert found.equal_force.rows == 2
    assert found.equal_force.rows_left_out == 3
    assert found.equal_force.errors["normal_force"] is None  # prescribed
    assert found.equal_force.errors["tangential_force"] is None
    assert found.equal_force.errors["contact_width"].greatest == 0.0
    assert found.equal_motion.errors["normal_force"].greatest == pytest.approx(0.3)


@pytest.mark.parametrize("carried", [1, 0])
def test_forces_that_a_model_cannot_carry_are_counted_or_the_reason(carried):
    def along(other):
        if len(other.path.rows) > carried:
            raise SolverError("no equilibrium")
        return readings(NORMAL[1:2], PULL[1:2])

    found = compare("x", answer(along), answer(), scene())
    assert found.equal_motion is not None
    if carried:
        assert (found.equal_force.rows, found.equal_force.rows_left_out) == (1, 4)
        assert "no equilibrium" in found.equal_force.note
    else:
        assert found.equal_force is None
        assert "cannot follow even the first row: no equilibrium" in found.missing[0]


def test_paths_out_of_the_plane_have_no_equal_force():
    rows = "[[0.1, 0.0, 0.0], [0.2, 0.0, 0.1]]"
    two = {"normal": NORMAL[1:3], "pull": PULL[1:3]}
    found = compare("x", answer(**two), answer(**two), scene(rows))
    assert found.equal_force is None
    assert "shear_z" in found.missing[0]


def test_rounding_of_a_pull_that_is_not_there_is_no_error():
    found = side_of(readings(pull=0.02 * np.ones(5)), readings(pull=-0.02 * np.ones(5)))
    assert found.errors["tangential_force"] is None
    assert found.errors["normal_force"].greatest == 0.0


def answer_off(forces=1.0, stick=0.0, gages=1.0, seconds=1.0):
    base, strains = np.array([1.0, 2.0]), np.array([[[10.0, 10.0]], [[20.0, 20.0]]])
    ratio = np.array([0.9, 0.5]) + stick
    readings = Readings(forces * base, 0.1 * forces * base, base, ratio, gages * strains)
    return Answer("a model", readings, (), seconds, 100, 3)


def compared(seconds=1.0, better_seconds=12.0, **off):
    found, truth = answer_off(seconds=seconds, **off), answer_off(seconds=better_seconds)
    side = side_of(found.readings, truth.readings)
    return ComparisonData("test", found.data(), truth.data(), side, side, ())


@pytest.mark.parametrize(
    ("kind", "changes", "verdict", "words"),
    [
        ("model", {"forces": 1.003}, "keep", ("0.3 %", "a factor 12")),
        ("model", {}, "keep", ("below 0.01 %",)),
        ("model", {"forces": 1.5, "stick": 0.3, "gages": 2.0}, "drop", ("F_n 50 %", "n 100 %")),
        ("model", {"stick": 0.05, "gages": 1.4}, "limited", ("ratio 5 %", "drop it for gages (")),
        ("model", {"better_seconds": 1.1}, "keep", ("saves nothing",)),
        ("value", {"forces": 1.2}, "measure", ("F_n 20 %",)),
        ("value", {"forces": 1.001}, "keep", ()),
        ("reading", {"gages": 1.01, "forces": 9.0}, "keep", ("up to 1 %",)),
        ("reading", {"gages": 1.06}, "limited", ("up to 6 %",)),
        ("reading", {"gages": 0.5}, "drop", ("up to 50 %",)),
    ],
)
def test_advice_follows_the_numbers(kind, changes, verdict, words):
    found, sentence = advise(kind, [compared(**changes)])
    assert found == verdict
    assert all(each in sentence for each in words), sentence
    assert kind != "reading" or "F_n" not in sentence


def test_the_worst_of_several_comparisons_counts_and_nothing_compared_is_no_advice():
    worst = {each.group: each for each in worst_of([compared(), compared(gages=3.0)])}
    assert worst["gages"].error == pytest.approx(2.0)
    assert worst["forces"].error == 0.0
    given = replace(compared(gages=1.3), equal_force=compared().equal_force)
    assert "it hardly moves the gages" in advise("value", [given])[1]  # at a given force
    with pytest.raises(ValueError, match="nothing was compared"):
        advise("model", [])


def test_a_path_of_forces_is_followed_at_the_better_models_motions():
    asked = []
    truth = replace(answer(), motions=tuple(Motion(0.1 * row, 0.01 * row) for row in range(5)))
    along = answer(lambda other: asked.append(other.path) or readings(), factor=1.3)
    found = compare("x", along, truth, FORCED)
    assert asked[0].increments_mm == tuple((each.approach, each.shear) for each in truth.motions)
    assert found.equal_motion.errors["normal_force"].greatest == 0.0  # as it answers there
    assert (found.equal_force.errors["normal_force"], len(asked)) == (None, 1)


def test_near_slip_counts_on_a_level_object_of_coulomb_friction_alone():
    near = replace(answer(), readings=replace(readings(), stick_ratio=np.full(5, 0.5)))
    tilted = parse_scene(f"object.tilt_deg = 3.0\npath.increments_mm = {ROWS}\n")
    assert [usable_rows(near, each)[:2] for each in (scene(), tilted)] == [(1, 3), (1, 5)]


def test_a_path_that_stops_is_cut_where_it_stopped_at_once():
    asked = []

    def along(other):
        asked.append(len(other.path.rows))
        if asked[-1] > 2:
            raise PathStopped("no equilibrium", (None, None))
        return readings(NORMAL[:2], PULL[:2])

    found = compare("x", answer(along), answer(), FORCED).equal_motion
    assert (asked, found.rows, found.rows_left_out) == ([5, 2], 2, 3)
