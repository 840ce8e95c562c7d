"""Verdict, sentences and tables say what the numbers say."""

from dataclasses import replace

import pytest

from fingerdesign.analysis.page.tables import (
    assumed_values,
    design_table,
    foreseen_tables,
    grip_table,
    increment_table,
    model_table,
    points_table,
    work_table,
)
from fingerdesign.analysis.page.words import (
    finger_words,
    in_short,
    leaves_section,
    object_text,
    slip_grows_with_shear,
    verdict,
)
from fingerdesign.records.result import (
    GageRemedy,
    Measurability,
    MeasuredState,
    PointStrain,
)


def with_parts(result, name, changes):
    """The result with the studies, grips or increments of a name changed, each by its own keys."""
    parts = zip(getattr(result, name), changes, strict=False)
    return replace(result, **{name: tuple(replace(part, **keys) for part, keys in parts)})


def with_keys(result, **keys):
    return replace(result, parameters=result.parameters | keys)


FOLLOWS, LIFTS, NEEDED = range(3)  # the questions


def correlated(*values, **more):
    return "slip_studies", FOLLOWS, [{"rank_correlation": value, **more} for value in values]


def gripped(question, *changes):
    return "grips", question, changes


FELL = {"lifted": False, "safety_margin": None}
SLIPS, HELD = {"slips_without_rule": True}, {"gross_slip": False, "holds": 2}
IDLE = {"slips_without_rule": False, "holds": 0}


@pytest.mark.parametrize(
    ("changes", "answer", "words"),
    [
        (correlated(0.95, 0.8, 0.9), "yes", "0.95 at μ = 0.3"),
        (correlated(0.95, 0.79, None), "partly", "at 1 of 2"),
        (correlated(0.95, 0.9, None), "yes", "not defined at μ = 0.8"),
        (correlated(0.95, 0.9, -0.1), "partly", "at 2 of 3"),
        (correlated(0.5, -0.9, None), "no", "0.50 at μ = 0.3"),
        (correlated(None, None, None), "open", "not defined"),
        # 0.9 where the step's number alone has 0.85 is no merit of the gages.
        (correlated(*[0.9] * 3, step_correlation=0.85), "no", "0.9"),
        (correlated(*[0.9] * 3, step_correlation=0.79), "yes", "0.9"),
        (correlated(*[0.9] * 3, step_correlation=None), "yes", "0.9"),
        (gripped(LIFTS, FELL, {}, {}), "partly", "μ = 0.3, 200 g (not lifted"),
        (gripped(LIFTS, {"gross_slip": True}, {}, {}), "partly", "1.29 to 1.40"),  # of the others
        (gripped(LIFTS, FELL | {"gross_slip": True}, {}, {}), "partly", "2 of 3 grips"),
        (gripped(NEEDED, *[IDLE] * 3), "note", "0 of 3 grips"),
        (gripped(NEEDED, *[SLIPS | HELD] * 3), "note", "3 of 3 grips"),
        (gripped(NEEDED, SLIPS | HELD | {"gross_slip": True}, SLIPS, SLIPS), "note", "μ = 0.3:"),
        (gripped(NEEDED, *[SLIPS | HELD | {"gross_slip": True}] * 3), "note", "μ = 0.3, 0.5, 0.8:"),
        (gripped(NEEDED, *[SLIPS | {"holds": 0}] * 3), "note", "held in 0."),
        (gripped(NEEDED, IDLE | {"gross_slip": True}), "note", "only with the rule"),
    ],
)
def test_the_verdict_follows_the_numbers(plane_strain, changes, answer, words):
    part, question, changed = changes
    found = verdict(with_parts(plane_strain.result, part, changed))[question]
    assert found.answer == answer
    assert words in found.detail


def test_nothing_is_judged_where_plates_are_left_out(plane_strain):
    found = verdict(with_keys(plane_strain.result, **{"plates.model": "none"}))
    assert {each.answer for each in found} == {"open"}


@pytest.mark.parametrize("step", [3, None])
def test_a_rule_that_stops_a_lift_is_named(plane_strain, step):
    stopped = FELL | {"slips_without_rule": False}
    result = with_parts(plane_strain.result, "grips", [stopped, {}, {}])
    first, *others = plane_strain.grip_traces
    free = replace(first.without_rule, lift_step=step)
    found = verdict(result, (replace(first, without_rule=free), *others))[NEEDED]
    assert found.answer == "note"  # neither merit nor fault: what fails counts where lifts do
    assert ("stopped a lift" in found.detail) == (step is not None)
    assert "is not lifted with the rule" in verdict(result)[NEEDED].detail  # nobody knows more


def test_the_first_lines_are_made_of_the_record_s_numbers(plane_strain):
    good = [{"safety_margin": margin, "gross_slip": False} for margin in (1.5, 1.25, 1.4)]
    sound = with_parts(plane_strain.result, "grips", good)
    answers = [each.answer for each in in_short(sound)]
    assert answers == ["yes", "note", "note", "note"]
    _, objects, limits, change = (each.detail for each in in_short(sound))
    assert "1.25 times the least" in objects
    assert "up to 250 g there, or 200 g down to μ = 0.4." in objects
    assert "least margin of a grip is 1.25" in limits
    assert change == "Nothing has to be."


def test_a_grip_that_fails_says_what_force_and_approach_would_hold(plane_strain):
    fell = FELL | {"gross_slip": True, "peak_normal_force_N": 2.4515, "ending": "it slips"}
    result = with_parts(plane_strain.result, "grips", [fell, *[{"safety_margin": 1.3}] * 2])
    result = with_keys(result, **{"grip.max_approach_mm": 0.2})
    good, objects, limits, change = in_short(result)
    assert good.answer == "partly"
    assert "It fails with 200 g at μ = 0.3: it slips." in objects.detail
    # m g / 2 mu times 1.5; the model presses by 0.05 mm/N.
    assert "takes 4.9 N to hold" in limits.detail
    assert "grip.fixed_force.force_N = 4.9, at some 0.25 mm of approach" in change.detail
    assert "grip.max_approach_mm = 0.29 in place of 0.2" in change.detail
    assert "holds 100 g with that margin" in change.detail


def test_gages_that_answer_too_little_say_by_how_much_and_what_helps(plane_strain):
    state = MeasuredState(0.8, 4.6, 2.45, 0.8, 1.4, 1.0, 1.8)
    remedy = GageRemedy("plates.thickness_mm", 0.1, 0.02, 4.3, enough=False)
    found = Measurability(0.5, False, 0.1, (state,), (remedy,))
    grips = [{"safety_margin": 1.3, "gross_slip": False}] * 3
    result = with_parts(replace(plane_strain.result, measurability=found), "grips", grips)
    good, _, limits, change = in_short(result)
    assert good.answer == "partly"
    assert "10 times what is wanted" in limits.detail
    assert "plates.thickness_mm = 0.02 in place of 0.1, 4.3 times" in change.detail
    assert "an amplifier of 0.05 microstrain in place of 0.5" in change.detail


def test_a_grip_that_crushes_is_not_sound(plane_strain):
    """m g / 2 mu = 1.96 N would hold 200 g at 0.5; five times that is no gentle grip."""
    grips = [{"safety_margin": 1.3, "gross_slip": False}] * 3
    grips[1] = grips[1] | {"peak_normal_force_N": 5.0 * 1.9614}
    good, _, limits, change = in_short(with_parts(plane_strain.result, "grips", grips))
    assert good.answer == "partly"
    assert "At most 9.81 N with 200 g at μ = 0.5, 5 times the least that holds" in limits.detail
    assert "0.30 times the force would do at μ = 0.5" in change.detail


def test_there_are_no_first_lines_without_grips_or_of_a_failure(plane_strain, failed):
    assert in_short(failed.result) == []
    assert in_short(replace(plane_strain.result, grips=())) == []


def test_the_verdict_names_the_gages_it_reads(plane_strain):
    assert "are read" not in verdict(plane_strain.result)[0].detail
    rows = {"plates.count": 5, "plates.rows": [{"count": 3, "along": "z", "span_mm": None}]}
    result = with_keys(plane_strain.result, **rows)
    assert "Of 8 plates the 5 in the row along x are read." in verdict(result)[0].detail
    assert ("plates.rows", "count = 3, along = z", "") in design_table(result).rows


@pytest.mark.parametrize(
    ("changes", "answer", "words"),
    [
        ({"stick_nodes": 5, "slip_nodes": 0}, "yes", "At increment 1 of 1"),
        ({"stick_nodes": 5, "slip_nodes": 2}, "partly", "40%"),
        ({"stick_nodes": 0, "slip_nodes": 7}, "no", "twist moment 0 N mm"),
        ({"normal_force_N": 0.0, "gages": ()}, "open", "no plates"),
    ],
)
def test_a_scene_s_verdict_is_the_contact(plane_strain, changes, answer, words):
    bare = replace(plane_strain.result, slip_studies=(), grips=())
    keys = {"stick_ratio": 0.4, "twist_deg": 1.0} | changes
    (found,) = verdict(with_parts(bare, "increments", [keys]))
    assert found.answer == answer
    assert words in found.detail


def test_failure_comes_first_and_alone(failed):
    (found,) = verdict(failed.result)
    assert found.answer == "no"
    assert "plate 4: 62 % missing" in found.detail
    assert finger_words(failed.result.parameters) == ""


@pytest.mark.parametrize(
    ("changes", "key", "listed"),
    [
        ({}, "body.arc_radius_mm", True),
        ({"body.shape": "step"}, "body.arc_radius_mm", False),
        ({}, "body.edge", False),
        ({"body.edge_radius_mm": 1.0}, "body.edge", True),
    ],
)
def test_keys_that_do_nothing_are_not_listed(plane_strain, changes, key, listed):
    idle = {"body.edge": "round", "body.edge_radius_mm": None}
    table = design_table(with_keys(plane_strain.result, **idle | changes))
    assert (key in {row[0] for row in table.rows}) is listed


def test_noise_is_zero_and_a_column_has_one_format(plane_strain):
    noise = {"tangential_force_N": -6e-16, "normal_force_N": -4e-17}
    changes = [{"tangential_force_N": 2e-4, "peak_pressure_MPa": -0.0}, noise, {}]
    cells = increment_table(with_parts(plane_strain.result, "increments", changes)).rows
    assert [row[4] for row in cells] == ["0.000", "0.000", "1.900"]
    assert [row[3] for row in cells] == ["3.000", "0.000", "9.000"]
    assert cells[0][8] == "0.000"


def with_scene(result, **changes):
    """Strains at two points, no load at the end, and a scene's keys."""
    strain = PointStrain(1.25, -2.0, 0.0, 1e-14, -3.0, 0.5)
    rows = [{"points": (strain, strain)} for _ in result.increments]
    rows[-1]["normal_force_N"] = 1e-15
    scene = {
        "scene.object.friction_coefficient": 0.5,
        "scene.path.increments_mm": [[0.1, 0.0], [0.1, 0.1]],
        "scene.readout.points_mm": [[-4.0, 6.0, 0.0], [0.0, 6.25, 0.0]],
    }
    return with_keys(with_parts(result, "increments", rows), **scene | changes)


CYLINDER = {
    **{"scene.object.shape": "cylinder", "scene.object.radius_mm": 2.0, "scene.object.axis": "x"},
    **{"scene.object.turn_deg": 30.0, "scene.path.control": "force"},
}
BACK = [[0.1, 0.02], [0.1, 0.1], [0.05, 0.1]]
TURNS = [[0.1, 0.0], [0.1, 0.06], [0.1, 0.06, 0.02], [0.1, 0.06, 0.02, 0.5]]


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        (CYLINDER, "cylinder of radius 2 mm along x, turned by 30 degrees about y"),
        (CYLINDER, "normal force to 0.1 N, tangential force to 0.1 N"),
        ({"scene.path.increments_mm": TURNS}, "shear along z to 0.02 mm, twist to 0.5 degr"),
        ({"scene.path.increments_mm": BACK}, "with shear to 0.02 mm, shear to 0.1 mm, approach to"),
        ({"scene.path.increments_mm": [[0.1, 0.1], [0.1, -0.1]] * 4}, "shear from -0.1 to 0.1 mm"),
        ({"scene.path.substeps": 3}, "each row in 3 equal increments"),
    ],
)
def test_the_object_and_its_way_in_words(plane_strain, changes, words):
    assert words in object_text(with_scene(plane_strain.result, **changes))


@pytest.mark.parametrize(
    ("pairs", "more", "grows"),
    [
        (((0.9, 0.0), (1.0, 0.1), (0.5, 0.5), (0.0, 0.9)), {}, True),
        (((0.9, 0.0), (1.0, 0.1)), {}, False),
        (((1.0, 0.9), (0.5, 0.5)), {}, False),
        (((1.0, 0.1), (0.5, 0.5)), {"twist_deg": 0.5}, False),
        ((), {}, False),
    ],
)
def test_slip_is_said_to_grow_with_shear_only_where_it_does(plane_strain, pairs, more, grows):
    row = plane_strain.result.increments[0]
    path = [replace(row, stick_ratio=r, tangential_force_N=f, **more) for r, f in pairs]
    assert slip_grows_with_shear(path) == grows


def test_what_leaves_the_section_has_columns_of_its_own(plane_strain):
    result = plane_strain.result
    row = result.increments[-1]
    assert not leaves_section([replace(row, force_z_N=1e-3 * row.normal_force_N)])  # the mesh's
    assert leaves_section([replace(row, force_z_N=0.1 * row.normal_force_N)])
    assert "twist (degrees)" not in increment_table(result).columns
    table = increment_table(with_parts(result, "increments", [{"twist_deg": 0.5}] * 8))
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


def test_tables_have_a_cell_for_every_column_and_a_dash_for_no_value(plane_strain, solid):
    result = plane_strain.result
    work = work_table(result, "1.00 s", "8.00 s")
    for table in (
        work,
        *(make(result) for make in (increment_table, grip_table, model_table, design_table)),
    ):
        assert table.rows
        assert {len(row) for row in table.rows} == {len(table.columns)}
    assert model_table(solid.result).rows[0] == ("dimension", "3-D")
    assert model_table(result).rows[0] == ("dimension", "2-D, plane strain")
    assert ("this page", "1.00 s") in work.rows
    changed = with_parts(result, "increments", [{"stick_ratio": None}])
    changed = with_parts(changed, "grips", [{"safety_margin": None, "slips_without_rule": None}])
    assert increment_table(changed).rows[0][6] == "–"
    assert grip_table(changed).rows[0][6:8] == ("not tried", "–")


def test_what_was_said_of_slip_stands_beside_the_grips_with_cases_and_intervals(plane_strain):
    assert foreseen_tables(plane_strain.result) == ()
    told = {"alarms": 3, "false_alarms": 1, "samples": 50, "stick_error_samples": 40}
    slip = {"slip_warning": "standing", "lead_s": 0.05, "lead_force_share": 0.9}
    grips = [told | slip | {"stick_error": 0.1}, told | {"stick_error": 0.2}, {}]
    each, every = foreseen_tables(with_parts(plane_strain.result, "grips", grips))
    assert each.rows[0][3:] == ("warned of", "0.050", "90", "3", "1", "50", "0.100", "40")
    assert each.rows[2][3:] == ("–", "–", "–", "–", "–", "0", "–", "0")
    rows = {row[0]: row[1:] for row in every.rows}
    assert rows["complete slips warned of (%)"] == ("100.0", "20.7 to 100.0", "1")
    assert rows["lead (s), median"] == ("0.050", "–", "1")
    assert rows["grips with a false alarm (%)"] == ("100.0", "34.2 to 100.0", "2")
    assert rows["false alarms per 100 steps"][::2] == ("2.00", "100")
    value, interval, cases = rows["error of stick ratio, RMS"]
    assert (value, cases) == ("0.158", "2 grips, 80 samples")
    assert " to " in interval
    assert {len(row) for table in (each, every) for row in table.rows} == {11, 4}


def test_assumed_keys_show_their_values(plane_strain):
    assumed = ("plates.cover_mm", "materials.silicone", "grip")
    result = replace(plane_strain.result, assumed=assumed)
    assert assumed_values(result) == [
        ("plates.cover_mm", "2"),
        ("materials.silicone", "youngs_modulus_MPa = 4.96, poissons_ratio = 0.49"),
        ("grip", "see the design"),
    ]
    marked = [row[0] for row in design_table(result).rows if row[2] == "assumed"]
    assert marked == ["plates.cover_mm"]
