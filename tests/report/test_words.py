"""Verdict and tables say what the numbers say."""

import dataclasses

import pytest

from fingerdesign.analysis.page.tables import (
    assumed_values,
    design_table,
    grip_table,
    increment_table,
    model_table,
    points_table,
    scene_table,
    work_table,
)
from fingerdesign.analysis.page.words import (
    findings,
    leaves_section,
    object_text,
    slip_grows_with_shear,
)
from fingerdesign.records.result import PointStrain


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
        ((0.95, 0.79, None), "partly", "at 1 of 2 friction coefficients where it is defined"),
        ((0.95, 0.9, None), "yes", "every friction coefficient that was tried where it"),
        ((0.95, 0.9, -0.1), "partly", "at 2 of 3"),
        ((0.5, -0.9, None), "no", "not at any"),
    ],
)
def test_gage_area_verdict(plane_strain, values, answer, words):
    found = findings(with_correlations(plane_strain.result, *values))[0]
    assert found.answer == answer
    assert words in found.detail
    assert f"{values[0]:.2f} at μ = 0.3" in found.detail
    assert ("not defined at μ = 0.8" in found.detail) == (None in values)
    assert "with the stick area" in found.detail
    assert "over 9 microstrain/N, half of this finger's largest" in found.detail


def test_nothing_defined_is_an_open_question(plane_strain):
    found = findings(with_correlations(plane_strain.result, None, None, None))[0]
    assert found.answer == "open"
    assert "not defined at any friction" in found.detail


def test_not_studied_and_no_plates_are_open_questions(plane_strain):
    bare = dataclasses.replace(plane_strain.result, slip_studies=(), grips=())
    (found,) = findings(bare)
    assert found.question == "Does the contact hold at the end of the path?"
    assert "without --scene" in found.detail
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
def test_a_grip_that_fails_is_named(plane_strain, changes, words):
    grips = plane_strain.result.grips
    result = dataclasses.replace(
        plane_strain.result, grips=(dataclasses.replace(grips[0], **changes), *grips[1:])
    )
    found = findings(result)[1]
    assert found.answer == "partly"
    assert "2 of 3 grips lift it" in found.detail
    assert words in found.detail
    assert "1.29 to 1.40" in found.detail, "the margin is that of the grips that lift"


def test_a_rule_that_was_not_needed_is_said(plane_strain):
    grips = tuple(
        dataclasses.replace(grip, slips_without_rule=False, holds=0)
        for grip in plane_strain.result.grips
    )
    found = findings(dataclasses.replace(plane_strain.result, grips=grips))[2]
    assert (found.answer, found.question) == ("no", "Was the rule needed?")
    assert "0 of 3 grips slip completely; the rule held in 0." in found.detail


@pytest.mark.parametrize(
    ("slips_with", "holds", "answer", "words"),
    [
        ((False, False, False), 2, "yes", "3 of 3 grips slip completely"),
        ((True, False, False), 2, "partly", "The rule did not help at μ = 0.3:"),
        ((True, True, True), 2, "no", "The rule did not help at μ = 0.3, 0.5, 0.8:"),
        ((False, False, False), 0, "no", "the rule held in 0."),
    ],
)
def test_a_rule_that_did_not_help_was_not_needed(plane_strain, slips_with, holds, answer, words):
    grips = tuple(
        dataclasses.replace(grip, slips_without_rule=True, gross_slip=slips, holds=holds)
        for grip, slips in zip(plane_strain.result.grips, slips_with, strict=True)
    )
    found = findings(dataclasses.replace(plane_strain.result, grips=grips))[2]
    assert found.answer == answer
    assert words in found.detail


def test_a_rule_that_does_harm_is_said(plane_strain):
    grips = tuple(
        dataclasses.replace(grip, slips_without_rule=False, gross_slip=True)
        for grip in plane_strain.result.grips[:1]
    )
    found = findings(dataclasses.replace(plane_strain.result, grips=grips))[2]
    assert found.answer == "no"
    assert "At μ = 0.3 the grip slips completely only with the rule." in found.detail


def test_nothing_is_judged_where_plates_are_left_out(plane_strain):
    keys = plane_strain.result.parameters | {"plates.model": "none"}
    found = findings(dataclasses.replace(plane_strain.result, parameters=keys))
    assert {each.answer for each in found} == {"open"}
    assert all(each.detail.startswith("Not judged: plates are left out") for each in found)


def test_a_rule_that_stops_a_lift_is_no_yes(plane_strain):
    grips, traces = plane_strain.result.grips, plane_strain.grip_traces
    stopped = dataclasses.replace(
        grips[0], lifted=False, slips_without_rule=False, safety_margin=None
    )
    result = dataclasses.replace(plane_strain.result, grips=(stopped, *grips[1:]))
    free = dataclasses.replace(traces[0].without_rule, lift_step=3)
    lifts = (dataclasses.replace(traces[0], without_rule=free), *traces[1:])
    found = findings(result, lifts)[2]
    assert found.answer == "partly"
    assert "At μ = 0.3 the rule stopped a lift that succeeds without it." in found.detail
    unlifted = dataclasses.replace(free, lift_step=None)
    never = (dataclasses.replace(traces[0], without_rule=unlifted), *traces[1:])
    assert findings(result, never)[2].answer == "yes"
    untold = findings(result)[2]
    assert untold.answer == "partly"
    assert "At μ = 0.3 the object is not lifted with the rule, though" in untold.detail


def test_the_verdict_names_the_gages_it_reads(plane_strain):
    assert "are read" not in findings(plane_strain.result)[0].detail
    rows = {"plates.count": 5, "plates.rows": [{"count": 3, "along": "z", "span_mm": None}]}
    keys = plane_strain.result.parameters | rows
    result = dataclasses.replace(plane_strain.result, parameters=keys)
    words = "Of 8 plates the 5 in the row along x are read."
    assert words in findings(result)[0].detail
    assert ("plates.rows", "count = 3, along = z", "") in design_table(result).rows


def test_keys_that_do_nothing_are_not_listed(plane_strain):
    keys = plane_strain.result.parameters | {"body.edge": "round", "body.edge_radius_mm": None}

    def listed(**more):
        changed = keys | {key.replace("__", "."): value for key, value in more.items()}
        table = design_table(dataclasses.replace(plane_strain.result, parameters=changed))
        return {row[0] for row in table.rows}

    assert "body.arc_radius_mm" in listed()
    assert "body.arc_radius_mm" not in listed(body__shape="step")
    assert "body.edge" not in listed()
    assert "body.edge" in listed(body__edge_radius_mm=1.0)


def test_noise_is_zero_and_a_column_has_one_format(plane_strain):
    rows = plane_strain.result.increments
    noisy = (
        dataclasses.replace(rows[0], tangential_force_N=2e-4, peak_pressure_MPa=-0.0),
        dataclasses.replace(rows[1], tangential_force_N=-6e-16, normal_force_N=-4e-17),
        rows[2],
    )
    cells = increment_table(dataclasses.replace(plane_strain.result, increments=noisy)).rows
    assert [row[4] for row in cells] == ["0.000", "0.000", "1.900"]
    assert [row[3] for row in cells] == ["3.000", "0.000", "9.000"]
    assert cells[0][8] == "0.000"


def with_scene(result, **changes):
    strain = PointStrain(1.25, -2.0, 0.0, 1e-14, -3.0, 0.5)
    rows = tuple(dataclasses.replace(row, points=(strain, strain)) for row in result.increments)
    gone = dataclasses.replace(rows[-1], normal_force_N=1e-15, points=(strain, strain))
    scene = {
        "scene.object.friction_coefficient": 0.5,
        "scene.path.increments_mm": [[0.1, 0.0], [0.1, 0.1]],
        "scene.readout.points_mm": [[-4.0, 6.0, 0.0], [0.0, 6.25, 0.0]],
    }
    return dataclasses.replace(
        result,
        increments=(*rows[:-1], gone),
        parameters=result.parameters | scene | changes,
    )


def test_scene_has_a_table_of_its_own(plane_strain):
    result = with_scene(plane_strain.result)
    assert design_table(result).rows == design_table(plane_strain.result).rows
    assert scene_table(plane_strain.result).rows == ()
    assert ("object.friction_coefficient", "0.5") in scene_table(result).rows
    assert object_text(result) == (
        "The object is a plane; friction coefficient μ = 0.5. Its motion is prescribed: approach "
        "to 0.1 mm, shear to 0.1 mm. The model is one section of the finger; forces are those over "
        "its whole depth."
    )
    assert object_text(plane_strain.result) == ""


def test_the_object_in_words(plane_strain):
    changes = {
        "scene.object.shape": "cylinder",
        "scene.object.radius_mm": 2.0,
        "scene.object.axis": "x",
        "scene.object.turn_deg": 30.0,
        "scene.path.control": "force",
    }
    words = object_text(with_scene(plane_strain.result, **changes))
    assert words == (
        "The object is a cylinder of radius 2 mm along x, turned by 30 degrees about y; friction "
        "coefficient μ = 0.5. Its forces are prescribed: normal force to 0.1 N, tangential force "
        "to 0.1 N; the motions were found. The model is one section of the finger; forces are "
        "those over its whole depth."
    )


@pytest.mark.parametrize(
    ("rows", "words"),
    [
        (
            [
                [0.05, 0.0, 0.0, 0.0],
                [0.1, 0.0],
                [0.1, 0.06],
                [0.1, 0.06, 0.02],
                [0.1, 0.06, 0.02, 0.5],
            ],
            "approach to 0.1 mm, shear to 0.06 mm, shear along z to 0.02 mm, twist to 0.5 degrees",
        ),
        (
            [[0.1, 0.02], [0.1, 0.1], [0.05, 0.1]],
            "approach to 0.1 mm with shear to 0.02 mm, shear to 0.1 mm, approach to 0.05 mm",
        ),
        (
            [[0.1, 0.1 * (-1) ** n] for n in range(9)],
            "approach from 0.1 to 0.1 mm, shear from -0.1 to 0.1 mm",
        ),
    ],
)
def test_the_motion_in_words(plane_strain, rows, words):
    changes = {"scene.path.increments_mm": rows, "scene.path.substeps": 3}
    said = object_text(with_scene(plane_strain.result, **changes))
    assert f" Its motion is prescribed: {words}, each row in 3 equal increments. " in said


def test_the_model_is_whole_or_half(solid):
    for symmetry, words in ((False, "The model is the whole finger."), (True, "the half z ≥ 0")):
        model = dataclasses.replace(solid.result.model, symmetry=symmetry)
        assert words in object_text(with_scene(dataclasses.replace(solid.result, model=model)))


def test_slip_is_said_to_grow_with_shear_only_where_it_does(plane_strain):
    row = plane_strain.result.increments[0]

    def path(*pairs, **more):
        return [
            dataclasses.replace(row, stick_ratio=ratio, tangential_force_N=force, **more)
            for ratio, force in pairs
        ]

    assert slip_grows_with_shear(path((0.9, 0.0), (1.0, 0.1), (0.5, 0.5), (0.0, 0.9)))
    assert not slip_grows_with_shear(path((0.9, 0.0), (1.0, 0.1)))
    assert not slip_grows_with_shear(path((1.0, 0.9), (0.5, 0.5)))
    assert not slip_grows_with_shear(path((1.0, 0.1), (0.5, 0.5), twist_deg=0.5))
    assert not slip_grows_with_shear([])


def test_a_mesh_s_asymmetry_does_not_leave_the_section(plane_strain):
    row = plane_strain.result.increments[-1]
    assert not leaves_section([dataclasses.replace(row, force_z_N=1e-3 * row.normal_force_N)])
    assert leaves_section([dataclasses.replace(row, force_z_N=0.1 * row.normal_force_N)])


@pytest.mark.parametrize(
    ("stick", "slip", "answer", "words"),
    [
        (5, 0, "yes", "all of the contact sticks"),
        (5, 2, "partly", "40% of the contact area sticks, the rest slips"),
        (0, 7, "no", "the contact slips completely"),
    ],
)
def test_a_scene_s_verdict_begins_with_the_contact(plane_strain, stick, slip, answer, words):
    bare = dataclasses.replace(plane_strain.result, slip_studies=(), grips=())
    last = dataclasses.replace(
        bare.increments[-1], stick_nodes=stick, slip_nodes=slip, stick_ratio=0.4, twist_deg=1.0
    )
    (found,) = findings(dataclasses.replace(bare, increments=(last,)))
    assert found.answer == answer
    assert f"At increment 1 of 1, {words}: F_n = " in found.detail
    assert "twist moment 0 N mm" in found.detail
    off = dataclasses.replace(last, normal_force_N=0.0)
    (found,) = findings(dataclasses.replace(bare, increments=(off,)))
    assert (found.answer, "never presses" in found.detail) == ("open", True)


def test_what_leaves_the_section_has_columns_of_its_own(plane_strain):
    result = plane_strain.result
    assert "twist (degrees)" not in increment_table(result).columns
    rows = tuple(dataclasses.replace(row, twist_deg=0.5) for row in result.increments)
    table = increment_table(dataclasses.replace(result, increments=rows))
    assert table.columns[-3] == "twist (degrees)"
    assert all(len(row) == len(table.columns) for row in table.rows)


def test_strain_at_points_is_that_under_load(plane_strain):
    assert points_table(plane_strain.result).rows == ()
    table = points_table(with_scene(plane_strain.result))
    assert "at increment 7 (the last under load)" in table.caption
    where = ("2", "0.000", "6.250", "0.000")
    assert table.rows[1] == (*where, "1.2", "-2.0", "0.0", "0.0", "-3.0", "0.5")
    unknown = points_table(with_scene(plane_strain.result, **{"scene.readout.points_mm": None}))
    assert unknown.rows[0][:4] == ("1", "–", "–", "–")


def test_dimension_is_said_once(plane_strain, solid):
    assert model_table(solid.result).rows[0] == ("dimension", "3-D")
    assert model_table(plane_strain.result).rows[0] == ("dimension", "2-D, plane strain")
    assert any("without making this page" in row[0] for row in work_table(solid.result).rows)


def test_failure_comes_first_and_alone(failed):
    (found,) = findings(failed.result)
    assert found.answer == "no"
    assert "plate 4: 62 % missing" in found.detail


def test_tables_have_a_cell_for_every_column(plane_strain):
    result = plane_strain.result
    for make in (increment_table, grip_table, model_table, work_table, design_table):
        table = make(result)
        assert table.rows
        assert {len(row) for row in table.rows} == {len(table.columns)}


def test_missing_values_are_dashes_not_numbers(plane_strain):
    result = plane_strain.result
    row = dataclasses.replace(result.increments[0], stick_ratio=None)
    grip = dataclasses.replace(result.grips[0], safety_margin=None, slips_without_rule=None)
    changed = dataclasses.replace(result, increments=(row,), grips=(grip,))
    assert increment_table(changed).rows[0][6] == "–"
    assert grip_table(changed).rows[0][6:8] == ("not tried", "–")


def test_assumed_keys_show_their_values(plane_strain):
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
