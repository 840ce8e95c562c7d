"""Keys, types and bounds of a design, one by one."""

import pytest
from pydantic import ValidationError

from fingerdesign.checks.load import dump_design, parse_design, with_values
from fingerdesign.errors import DesignError
from fingerdesign.layout.frames import mirrors_in_z
from fingerdesign.layout.gaps import layered


def faults(text):
    with pytest.raises(DesignError) as caught:
        parse_design(text)
    return {fault.key: fault for fault in caught.value.faults}


NAME = 'design.name = "a"\n'


@pytest.mark.parametrize(
    ("line", "key"),
    [
        ("body.width_mm = true", "body.width_mm"),
        ('body.width_mm = "20"', "body.width_mm"),
        ("body.width_mm = nan", "body.width_mm"),
        ("body.width_mm = 1e300", "body.width_mm"),
        (f"body.width_mm = 1{'0' * 400}", "body.width_mm"),
        ("plates.count = 15.0", "plates.count"),
        ("plates.count = 100000", "plates.count"),
        ("plates.placement = [[0, 10]]", "plates.placement[0]"),
        ("plates.placement = [[0, nan, 1]]", "plates.placement[0][1]"),
        ('gages.face = "uper"', "gages.face"),
        ("materials.silicone.poissons_ratio = 0.5", "materials.silicone.poissons_ratio"),
        ("materials.silicone.youngs_modulus_MPa = 0", "materials.silicone.youngs_modulus_MPa"),
        ("materials.silicone = 3", "materials.silicone"),
        ('body.material = "silicon"', "body.material"),
        ("grip.friction_coefficients = []", "grip.friction_coefficients"),
        ("grip.friction_coefficients = [0.3, 0]", "grip.friction_coefficients[1]"),
        ('mesh.mesher = "gmsh"', "mesh.mesher"),
        ("assumed = [3]", "assumed[0]"),
    ],
)
def test_wrong_values_are_refused_by_key(line, key):
    assert key in faults(NAME + line)


@pytest.mark.parametrize("name", ["", ".a", "a/b", "a\\b", "..", "a b", "é", "x" * 65, "a."])
def test_names_that_are_no_folder_are_refused(name):
    fault = faults(f"design.name = {name!r}")["design.name"]
    assert "letters" in fault.bound


def test_a_mold_is_requested_for_in_a_table_of_its_own():
    assert parse_design(NAME).mold.process == "sla"
    assert parse_design(NAME + "mold.limits.slot_mm = 0.4").mold.limits.slot_mm == 0.4
    assert "mold.wall_mm" in faults(NAME + "mold.wal_mm = 2")["mold.wal_mm"].remedy


@pytest.mark.parametrize(
    ("lines", "key"),
    [
        ('body.shape = "block"\nbody.arc_radius_mm = 30', "body.arc_radius_mm"),
        ('body.shape = "revolved"\nbody.depth_mm = 30', "body.depth_mm"),
        ('body.shape = "step"', "body.step.file"),
        ('body.step.file = "a.step"', "body.step.file"),
        ('body.edge = "chamfer"', "body.edge"),
        ("plates.hole_pitch_mm = 3", "plates.hole_pitch_mm"),
        ("plates.placement = [[0, 8, 0]]\nplates.rows = [{}]", "plates.rows"),
        ("plates.count = 400\nplates.rows = [{count = 101}]", "plates.rows"),
        ("plates.placement = [[0, 8, 0], [501, 8, 0]]", "plates.placement[1]"),
        ("plates.placement = [[0, 8, 180.5]]", "plates.placement[0]"),
        ("plates.placement = [[0, 8, 0, -501]]", "plates.placement[0]"),
        ('plates.placement = [[0, 8, 0]]\nplates.follow = "bent"', "plates.follow"),
        ("plates.placement = [[0, 8, 0]]\nplates.offset_mm = 1", "plates.offset_mm"),
        ('body.core.material = "oak"', "body.core.material"),
    ],
)
def test_keys_that_change_nothing_are_refused(lines, key):
    assert set(faults(NAME + lines)) == {key}


def test_a_revolved_body_is_as_deep_as_wide():
    design = parse_design(NAME + 'body.shape = "revolved"\nplates.count = 0\nbody.width_mm = 12')
    assert design.body.depth_mm == 12.0
    assert with_values(design, {"body.shape": "arc"}).body.depth_mm == 12.0
    assert parse_design(dump_design(design)) == design


def test_rows_take_what_they_do_not_say_from_the_table():
    text = "plates.rows = [{ cover_mm = 5.0 }, { along = 'z', count = 3, cover_mm = 8 }]"
    plates = parse_design(NAME + text).plates
    assert plates.number == 15 + 15 + 3
    first, second, third = plates.all_rows
    assert (first.cover_mm, second.cover_mm, third.cover_mm) == (2.0, 5.0, 8.0)
    assert (second.pitch_mm, third.along, second.along) == (1.0, "z", "x")


def test_dome_needs_its_radius_and_an_arc_has_none():
    assert faults(NAME + 'body.shape = "dome"')["body.dome_radius_mm"].value == "(absent)"
    assert "body.dome_radius_mm" in faults(NAME + "body.dome_radius_mm = 25")
    sound = parse_design(NAME + 'body.shape = "dome"\nbody.dome_radius_mm = 25')
    assert not sound.extruded
    assert mirrors_in_z(sound)


def test_known_material_is_completed_and_its_source_dropped_when_changed():
    design = parse_design(NAME + "materials.silicone.poissons_ratio = 0.3")
    material = design.material_of("body")
    assert (material.youngs_modulus_MPa, material.poissons_ratio) == (4.96, 0.3)
    assert "Maeno" not in material.source
    same = parse_design(NAME + "materials.silicone.poissons_ratio = 0.49")
    assert same == parse_design(NAME)


def test_new_material():
    text = NAME + 'body.material = "mine"\n[materials.mine]\nyoungs_modulus_MPa = 1\n'
    design = parse_design(text + "poissons_ratio = 0.45")
    assert design.material_of("body").youngs_modulus_MPa == 1.0
    assert "silicone" not in design.materials


@pytest.mark.parametrize(
    ("lines", "extruded", "in_layers"),
    [
        ("", True, True),
        ("plates.span_mm = 10.0", True, True),
        ("plates.span_mm = 8.0", False, True),
        ("plates.span_mm = 8.0\nplates.count = 0", True, True),
        ("plates.span_mm = 5.0\nplates.stagger_mm = 2.0", False, True),
        ("plates.hole_diameter_mm = 0.5", False, False),
        ('body.shape = "dome"\nbody.dome_radius_mm = 25', False, False),
        ("body.core = { height_mm = 2.0, depth_mm = 6.0 }", False, True),
    ],
)
def test_extruded_and_layered(lines, extruded, in_layers):
    """One section tells all; or, swept through layers, it can at least be meshed so."""
    design = parse_design(NAME + lines)
    assert (design.extruded, layered(design)) == (extruded, in_layers)


def test_designs_hash_by_content():
    assert len({parse_design(NAME), parse_design(NAME + "body.width_mm = 20")}) == 1


def test_frozen():
    with pytest.raises(ValidationError):
        parse_design(NAME).body.width_mm = 3.0


def test_name_is_required():
    assert faults("body.width_mm = 20")["design.name"].bound == "given"
