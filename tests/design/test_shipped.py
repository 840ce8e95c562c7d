"""What is shipped: designs, scenes, schemas, the starter; and the numbers stated of a design."""

import json
import re
import tomllib
from pathlib import Path

import jsonschema
import numpy as np
import pytest

from fingerdesign.checks.load import load_design, parse_design
from fingerdesign.checks.scene import scene_faults
from fingerdesign.design import schema as json_schema
from fingerdesign.design.shipped import load_scene, shipped_text
from fingerdesign.design.starter import starter_text
from fingerdesign.errors import DesignError
from fingerdesign.layout.zone import contact_half_width

DESIGNS = Path(__file__).parents[2] / "designs"


def toml(path):
    return tomllib.loads(path.read_text("utf-8"))


def shipped(folder):
    return sorted((DESIGNS / folder).glob("*.toml"))


@pytest.mark.parametrize("path", shipped("."), ids=lambda path: path.stem)
def test_designs_are_sound_and_say_why_they_exist(path):
    design = load_design(path)
    assert design.design.name == path.stem
    reason = path.read_text("utf-8").splitlines()[0]
    assert re.match(r"# \w", reason)
    assert len(reason) > 40
    jsonschema.validate(toml(path), json_schema.json_schema("design"))
    for scene in shipped("scenes"):
        if scene.stem != "reference_plane_strain":
            assert scene_faults(load_scene(scene), design) == []


def test_the_paper_finger_has_the_papers_values_and_lists_the_others():
    design = load_design(DESIGNS / "maeno2000.toml")
    assert (design.plates.count, design.plates.thickness_mm) == (15, 0.1)
    assert design.plates.angle_deg == 45.0
    assert design.material_of("body").youngs_modulus_MPa == 4.96
    assert design.material_of("plates").youngs_modulus_MPa == 1.35e5
    given = {"plates.count", "plates.thickness_mm", "plates.angle_deg"}
    assert not given & set(design.assumed)
    for table in ("body", "plates", "gages"):
        for key in type(getattr(design, table)).model_fields:
            if key in ("offset_mm", "span_offset_mm", "stagger_mm", "hole_pitch_mm"):
                continue  # one row of whole plates: nothing is chosen here
            choice = key.endswith("_mm") and getattr(getattr(design, table), key) is not None
            name = f"{table}.{key}"
            assert (name in design.assumed) is (choice and name not in given) or key == "face"


def test_schemas_are_current_and_refuse_what_the_program_refuses():
    data = Path(json_schema.__file__).parents[1] / "data"
    schema = json_schema.json_schema("design")
    for name in ("design", "scene"):
        shipped_copy = (data / f"{name}.schema.json").read_text("utf-8")
        remedy = "run python -m fingerdesign.design.schema"
        assert shipped_copy == json_schema.schema_text(name), remedy
    jsonschema.Draft202012Validator.check_schema(schema)
    unknown = {"design": {"name": "a"}, "body": {"widht_mm": 3}}
    for bad in ({}, unknown, {"design": {"name": "a/b"}}):
        with pytest.raises(jsonschema.ValidationError):
            jsonschema.validate(bad, schema)
    assert '"null"' not in json.dumps(schema)


def test_starter_holds_every_key_with_its_default_and_rows_and_holes_that_are_sound():
    text = starter_text("mine")
    assert parse_design(text) == parse_design('design.name = "mine"')
    keys = ("width_mm", "dome_radius_mm", "placement", "plate_end_size_mm", "seed", "assumed")
    for key in (*keys, "plate_fixture", "wall_mm", "sheet_mm"):
        assert re.search(rf"(?m)^(# )?{key} = ", text), key
    assert text.startswith("#:schema ./design.schema.json")
    for key in ("rows", "hole_diameter_mm", "edge_radius_mm"):
        text = re.sub(rf"(?m)^# ({key} = )", r"\1", text)
    plates = parse_design(text).plates
    assert plates.number == 20
    assert plates.all_rows[1].along == "z"


def test_starter_from_a_shipped_design_keeps_its_comments():
    text = starter_text("mine", "narrow")
    first, *rest = text.splitlines()
    assert first.startswith("# A copy of narrow.")
    assert rest[0] == shipped_text("narrow").splitlines()[0]
    started, original = parse_design(text), parse_design(shipped_text("narrow"))
    assert started.design.name == "mine"
    assert started.body == original.body
    assert "#:schema ./design.schema.json" in text


def test_designs_and_scenes_are_found_by_file_or_by_name(tmp_path, in_tmp_path):
    path = DESIGNS / "scenes/fundamental.toml"
    assert load_scene(path) == load_scene("fundamental") == load_scene(path)
    for find, name, near in (
        (load_scene, "fundamentel", "readable TOML file"),
        (lambda name: shipped_text(name, "scene"), "fundamentel", "did you mean fundamental"),
        (lambda name: starter_text("mine", name), "narow", "did you mean narrow"),
        (load_design, "meano2000.toml", "did you mean maeno2000"),
    ):
        with pytest.raises(DesignError, match=near):
            find(name)
    (tmp_path / "narrow").mkdir()  # a result's folder
    assert load_design("narrow").design.name == "narrow"
    (tmp_path / "wide").write_text('design.name = "mine"')
    assert load_design("wide").design.name == "mine"


def test_contact_forecast_is_near_the_reference():
    """Half-widths at nu = 0.3 from the two-code table: 1.09 at 0.1 mm, 2.50 at 0.4 mm."""
    text = 'design.name = "a"\nplates.count = 0\nmaterials.silicone.poissons_ratio = 0.3'
    design = parse_design(text)
    assert np.isclose(contact_half_width(design, 0.1), 1.09, rtol=0.15)
    assert np.isclose(contact_half_width(design, 0.4), 2.50, rtol=0.15)
    # The wide side: a zone of candidates chosen by it must hold the contact.
    assert contact_half_width(design, 0.4) > 2.50
    assert contact_half_width(design, 0.0) == 0.0
    widths = [contact_half_width(design, approach) for approach in np.linspace(0.0, 6.0, 30)]
    assert (np.diff(widths) >= 0).all()
    assert max(widths) <= 10.0


@pytest.mark.parametrize("path", shipped("scenes"), ids=lambda path: path.stem)
def test_scenes_are_sound_and_say_why_they_exist(path):
    rows = np.array(load_scene(path).path.rows)
    assert re.match(r"# \w", path.read_text("utf-8"))
    jsonschema.validate(toml(path), json_schema.json_schema("scene"))
    if path.stem == "fundamental":
        assert len(rows) == 8
        assert (np.diff(rows[:, 0]) >= 0).all()
        assert (np.diff(rows[:, 1]) > 0).all()
