"""The study file of the plane-strain question, its models, and the run that can be stopped."""

import json

import pytest
from fingerdesign_bench.studies import plane_strain
from fingerdesign_bench.studies.plane_strain import (
    compare,
    key_of,
    known_records,
    models_of,
    run_study,
)
from fingerdesign_bench.studies.plane_strain_file import (
    StudyMesh,
    parse_study,
    points_of,
    read_study,
    shipped_study,
)
from fingerdesign_bench.studies.plane_strain_table import half_width, row_errors

from fingerdesign.errors import DesignError
from fingerdesign.layout.gaps import layered

SMALL = """
[study]
name = "small"
base = "maeno2000"
[fixed]
"body.width_mm" = 20.0
"body.base_height_mm" = 10.0
"body.arc_radius_mm" = 20.0
"plates.count" = 1
"plates.length_mm" = 2.0
"plates.cover_mm" = 2.0
"gages.length_mm" = 1.0
[parameters]
"body.depth_mm" = [10.0, 40.0]
"plates.span_mm / body.depth_mm" = [0.0, 1.0]
[scene]
approach_mm = [0.4]
[mesh]
contact_size_mm = 0.6
plate_size_mm = 1.0
far_size_mm = 4.0
gradation = 0.6
end_layer_mm = 1.0
[[also]]
name = "rough"
"scene.friction_coefficient" = 1.0
"mesh.contact_size_mm" = 0.7
"body.base_height_mm" = 12.0
"""


def test_the_shipped_study_is_a_grid_of_sound_designs():
    study = read_study(shipped_study())
    points = list(points_of(study))
    grid = [point for point in points if not point.name]
    lists = [len(values) for values in study.parameters.values()]
    assert len(grid) == lists[0] * lists[1] * lists[2] >= 48
    assert len({key_of(point) for point in points}) == len(points)
    assert {"finer", "twice the radius", "half the base height"} <= {p.name for p in points}
    assert len(list(points_of(study, quick=True))) == 8
    for point in grid:
        plates, depth = point.design.plates, point.design.body.depth_mm
        share = point.values["plates.span_mm / body.depth_mm"]
        assert plates.model == ("none" if share == 0.0 else "solid")
        assert plates.span_mm == pytest.approx(depth * (share or 1.0))
        assert layered(point.design)


def test_layers_follow_the_depth_and_both_models_have_one_section():
    shallow, *_, deep, _ = points_of(parse_study(SMALL))
    assert shallow.design.body.depth_mm == 10.0
    assert 3 <= shallow.layers < deep.layers
    flat, solid = models_of(deep)
    assert flat.sizes == solid.sizes
    assert flat.element == solid.element == "mixed"
    assert solid.layers == deep.layers


def test_one_off_models_change_what_they_name():
    *_, rough = points_of(parse_study(SMALL))
    assert rough.name == "rough"
    assert rough.scene.friction_coefficient == 1.0
    assert rough.mesh.contact_size_mm == 0.7
    assert rough.design.body.base_height_mm == 12.0


@pytest.mark.parametrize(
    ("old", "new", "key"),
    [
        ('name = "small"', 'name = ""', "study.name"),
        ("approach_mm = [0.4]", "approach_mm = [-1.0]", "scene.approach_mm"),
        ("gradation = 0.6", "gradient = 0.6", "mesh.gradient"),
        ('base = "maeno2000"', 'base = "maeno2000"\nsampling = "sobol"', "study.sampling"),
        ("[study]", "[study", "file"),
    ],
)
def test_faults_name_their_keys(old, new, key):
    with pytest.raises(DesignError) as caught:
        parse_study(SMALL.replace(old, new), "small.toml")
    assert any(fault.key.startswith(key) for fault in caught.value.faults)


def test_a_combination_that_is_no_finger_is_refused_by_its_key():
    study = parse_study(SMALL.replace('"plates.cover_mm" = 2.0', '"plates.cover_mm" = 0.1'))
    with pytest.raises(DesignError, match=r"plates\.cover_mm"):
        list(points_of(study))


def _record(point):
    """What compare gives of a model, made up."""
    readings = {
        "normal_force": [0.0, 1.0, 1.0, 1.0],
        "tangential_force": [0.0, 0.0, 0.1, 0.2],
        "contact_width": [1.0, 2.0, 2.0, 2.0],
        "stick_ratio": [1.0, 1.0, 0.9, 0.8],
        "gages": [[]] * 4,
    }
    row = {"space": readings, "motion": readings, "force": None, "why": "made up"}
    sizes = ("radius_mm", "depth_mm", "width_mm", "height_mm", "poissons_ratio", "span_share")
    own = dict.fromkeys(sizes, 1.0) | {"dofs": 1, "seconds": 60.0, "rows": [row]}
    return own | {"name": point.name, "values": point.values}


@pytest.mark.parametrize(
    "line",
    [b'{"foo": 1}', b"[1]", b"7", b"\xff\xfe\x00\x80", b'{"key": "a", "rows": []}', b"[" * 9999],
)
def test_damaged_lines_are_left_out_and_said(line, tmp_path, monkeypatch):
    points = list(points_of(parse_study(SMALL)))[:2]
    monkeypatch.setattr(plane_strain, "compare", _record)
    lines = tmp_path / "records.jsonl"
    run_study(points[:1], lines)
    lines.write_bytes(line + b"\n" + lines.read_bytes() + line)
    said, reported = [], []
    assert len(run_study(points, lines, reported.append, said.append)) == 2
    (note,) = said
    assert "2 lines are no records, left out" in note
    assert reported[0] == "1 of 2 models to solve, about 1 min"
    said.clear()
    run_study(points, lines, note=said.append)
    assert set(known_records(lines)[0]) == {key_of(point) for point in points}


def test_records_of_another_study_are_left_out_and_said(tmp_path, monkeypatch):
    monkeypatch.setattr(plane_strain, "compare", _record)
    lines, said = tmp_path / "records.jsonl", []
    run_study(list(points_of(parse_study(SMALL)))[:2], lines, note=said.append)
    assert not said
    other = list(points_of(parse_study(SMALL.replace("gradation = 0.6", "gradation = 0.7"))))[:1]
    assert len(run_study(other, lines, note=said.append)) == 1
    assert "2 of 2 records are of models that this study does not ask for" in said[0]


def test_too_many_models_are_refused_at_once():
    values = ", ".join(f"{10.0 + 0.01 * k:g}" for k in range(3000))
    study = parse_study(SMALL.replace("[10.0, 40.0]", f"[{values}]"))
    with pytest.raises(DesignError) as caught:
        next(points_of(study))
    assert str(caught.value).startswith(
        "parameters = 3000 x 2 + 1 models: must be at most 2000 models in all (6001 would take "
    )
    assert len(list(points_of(study, quick=True))) == 4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("[10.0, 40.0]", "[]", 'parameters."body.depth_mm" = []: must be an array of at least 1;'),
        ("[10.0, 40.0]", "[inf]", 'parameters."body.depth_mm"[0] = inf: must be a finite number;'),
        ("[10.0, 40.0]", "3.0", 'parameters."body.depth_mm" = 3.0: must be an array;'),
        ("[0.4]", "[]", "scene.approach_mm = []: must be an array of at least 1; add to it"),
        ('_mm" = 0.7', '_mm" = -1.0', "also rough: mesh.contact_size_mm = -1.0: must be at least"),
        ("[10.0, 40.0]", "[9.0, 9.0]", '"body.depth_mm" = [9.0, 9.0]: must be values that differ;'),
        ('name = "rough"', "", "also.name = (absent): must be text in quotes; add one"),
        ("s.span_mm / b", "s.span_mm / B", 'parameters = "... / Body.depth_mm": must be a key'),
    ],
)
def test_faults_are_in_our_words(old, new, words):
    with pytest.raises(DesignError) as caught:
        list(points_of(parse_study(SMALL.replace(old, new))))
    assert words in str(caught.value)
    assert "nput should" not in str(caught.value)


def test_a_stopped_run_goes_on_where_it_stopped(tmp_path, monkeypatch):
    points = list(points_of(parse_study(SMALL)))
    made = []

    def stand_in(point):
        made.append(point)
        return _record(point)

    monkeypatch.setattr(plane_strain, "compare", stand_in)
    lines = tmp_path / "deep" / "records.jsonl"
    run_study(points[:2], lines)
    with lines.open("a") as file:
        file.write('{"key": "cut sho')
    found = run_study(points, lines)
    assert len(made) == len(points) == len(found)
    assert [record["values"] for record in found] == [point.values for point in points]
    assert set(known_records(lines)[0]) == {key_of(point) for point in points}
    other = points[0].mesh.model_copy(update={"gradation": 0.7})
    assert isinstance(other, StudyMesh)
    changed = type(points[0])(points[0].design, points[0].scene, other, points[0].values)
    assert key_of(changed) != key_of(points[0])


def test_plane_strain_overstates_by_what_was_known():
    """R = 20, nu = 0.49, approach 0.4, depth 10, no plates: 31 %; a coarse mesh does for it."""
    point = next(iter(points_of(parse_study(SMALL))))
    record = compare(point)
    line = json.dumps(record | {"key": key_of(point)}, allow_nan=False)
    assert plane_strain._record(line.encode()) is not None
    (row,) = record["rows"]
    found = row_errors(row)
    assert found["normal_force"] == pytest.approx(0.31, abs=0.02)
    assert 0.05 < found["tangential_force"] < 0.2
    assert abs(found["force_contact_width"]) < 0.5 * found["contact_width"]
    assert half_width(row) == pytest.approx(2.45, abs=0.15)
    assert record["height_mm"] == pytest.approx(12.68, abs=0.01)
    assert record["span_share"] == 0.0


@pytest.mark.slow
def test_plane_strain_is_nearer_where_the_finger_is_deep():
    """Depth 40: 12 % without plates; plates of full span halve that."""
    _, _, bare, plated, _ = points_of(parse_study(SMALL))
    assert bare.design.body.depth_mm == plated.design.body.depth_mm == 40.0
    errors = [row_errors(compare(point)["rows"][0]) for point in (bare, plated)]
    assert errors[0]["normal_force"] == pytest.approx(0.12, abs=0.02)
    assert errors[1]["normal_force"] < errors[0]["normal_force"]
