"""Verdict and tables say what the numbers say."""

import dataclasses

import pytest

from fingerdesign.report.tables import (
    assumed_values,
    design_table,
    grip_table,
    increment_table,
    model_table,
    work_table,
)
from fingerdesign.report.verdict import findings


def with_correlations(result, *values):
    studies = tuple(
        dataclasses.replace(study, rank_correlation=value)
        for study, value in zip(result.slip_studies, values, strict=True)
    )
    return dataclasses.replace(result, slip_studies=studies)


@pytest.mark.parametrize(
    ("values", "answer", "words"),
    [
        ((0.95, 0.8, 0.9), "yes", "every friction coefficient"),
        ((0.95, 0.79, None), "partly", "at 1 of 3"),
        ((0.5, -0.9, None), "no", "not at any"),
    ],
)
def test_gage_area_verdict(plane_strain, values, answer, words) -> None:
    found = findings(with_correlations(plane_strain.result, *values))[0]
    assert found.answer == answer
    assert words in found.detail
    assert f"{values[0]:.2f} at μ = 0.3" in found.detail
    assert ("undefined" in found.detail) == (None in values)


def test_not_studied_and_no_plates_are_open_questions(plane_strain) -> None:
    bare = dataclasses.replace(plane_strain.result, slip_studies=(), grips=())
    assert [item.answer for item in findings(bare)] == ["open", "open"]
    no_gages = tuple(dataclasses.replace(row, gages=()) for row in bare.increments)
    assert "no plates" in findings(dataclasses.replace(bare, increments=no_gages))[0].detail


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"lifted": False, "safety_margin": None}, "μ = 0.3, 200 g (not lifted; 102 steps)"),
        ({"gross_slip": True}, "slips completely though lifted"),
        ({"gross_slip": True, "lifted": False, "safety_margin": None}, "(slips completely;"),
    ],
)
def test_a_grip_that_fails_is_named(plane_strain, changes, words) -> None:
    grips = plane_strain.result.grips
    result = dataclasses.replace(
        plane_strain.result, grips=(dataclasses.replace(grips[0], **changes), *grips[1:])
    )
    found = findings(result)[1]
    assert found.answer == "partly"
    assert "2 of 3 grips lift it" in found.detail
    assert words in found.detail
    assert "1.29 to 1.40" in found.detail, "the margin is that of the grips that lift"


def test_a_rule_that_was_not_needed_is_said(plane_strain) -> None:
    grips = tuple(
        dataclasses.replace(grip, slips_without_rule=False, holds=0)
        for grip in plane_strain.result.grips
    )
    found = findings(dataclasses.replace(plane_strain.result, grips=grips))[2]
    assert (found.answer, found.question) == ("no", "Was the rule needed?")
    assert "0 of 3 grips slip completely; the rule held in 0." in found.detail


def test_failure_comes_first_and_alone(failed) -> None:
    (found,) = findings(failed.result)
    assert found.answer == "no"
    assert "plate 4: 62 % missing" in found.detail


def test_tables_have_a_cell_for_every_column(plane_strain) -> None:
    result = plane_strain.result
    for make in (increment_table, grip_table, model_table, work_table, design_table):
        table = make(result)
        assert table.rows
        assert {len(row) for row in table.rows} == {len(table.columns)}


def test_missing_values_are_dashes_not_numbers(plane_strain) -> None:
    result = plane_strain.result
    row = dataclasses.replace(result.increments[0], stick_ratio=None)
    grip = dataclasses.replace(result.grips[0], safety_margin=None, slips_without_rule=None)
    changed = dataclasses.replace(result, increments=(row,), grips=(grip,))
    assert increment_table(changed).rows[0][6] == "–"
    assert grip_table(changed).rows[0][6:8] == ("not tried", "–")


def test_assumed_keys_show_their_values(plane_strain) -> None:
    result = dataclasses.replace(
        plane_strain.result, assumed=("plates.cover_mm", "materials.silicone", "grip")
    )
    assert assumed_values(result) == [
        ("plates.cover_mm", "2"),
        ("materials.silicone", "youngs_modulus_MPa = 4.96, poissons_ratio = 0.49"),
        ("grip", "see the design"),
    ]
    marked = [row[0] for row in design_table(result).rows if row[2] == "assumed"]
    assert marked == ["plates.cover_mm"]
