"""The names of cached estimators: each thing that decides them changes it; meshes of grips."""

from dataclasses import fields, replace

import pytest

from fingerdesign import parse_design, with_values
from fingerdesign.sensing.model import EVEN_LAYERS, layers_for_many, meshed_for_grips
from fingerdesign.sensing.train import family
from fingerdesign.sensing.train.paths import Settings
from fingerdesign.sensing.train.result import settings_of, training_key
from tests.sensing.conftest import FINGER

DESIGN = parse_design(FINGER)
SETTINGS = replace(settings_of(DESIGN), torque_noise=0.05)


@pytest.mark.parametrize("field", [each.name for each in fields(Settings)])
def test_each_setting_is_part_of_the_key(field):
    value = getattr(SETTINGS, field)
    if field == "bounds":
        others = [replace(value, **{k: v + 1}) for k, v in vars(value).items()]
    else:
        others = ["lower" if field == "face" else value + 1]
    keys = {training_key(DESIGN, replace(SETTINGS, **{field: other})) for other in others}
    assert len(keys) == len(others)
    assert training_key(DESIGN, SETTINGS) not in keys


@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("grip.bench_friction_coefficient", 0.77),
        ("body.depth_mm", 8.1),
        ("plates.cover_mm", 0.91),
        ("gages.length_mm", 0.51),
        ("materials.polyimide.youngs_modulus_MPa", 2600.0),
        ("mesh.section.plate_size_mm", 0.31),
    ],
)
def test_each_part_of_the_design_is_part_of_the_key(key, value):
    other = with_values(DESIGN, {key: value})
    assert training_key(other, SETTINGS) != training_key(DESIGN, SETTINGS)


def test_the_fidelity_is_part_of_the_key_and_names_are_not():
    assert training_key(DESIGN, SETTINGS, "3d") != training_key(DESIGN, SETTINGS)
    named = with_values(DESIGN, {"design.name": "other"})
    assert training_key(named, SETTINGS) == training_key(DESIGN, SETTINGS)


def test_a_meshs_file_counts_by_its_content(tmp_path):
    found = set()
    for name, content in (("a.msh", "one"), ("b.msh", "two"), ("a.msh", "three")):
        (tmp_path / name).write_text(content)
        data = {"mesh.mesher": "file", "mesh.file": str(tmp_path / name)}
        design = with_values(DESIGN, data)
        found.add(training_key(design, SETTINGS, "3d"))
        (tmp_path / "elsewhere.msh").write_text(content)
        moved = with_values(DESIGN, data | {"mesh.file": str(tmp_path / "elsewhere.msh")})
        assert training_key(moved, SETTINGS, "3d") in found
    assert len(found) == 3


def test_grips_are_meshed_coarsely_and_no_finer_than_the_file_asks():
    def meshed(values, *fixed):
        mesh = meshed_for_grips(with_values(DESIGN, values), "3d", fixed_keys=fixed).mesh
        return mesh.layers, mesh.contact_size_mm, mesh.section.gradation, mesh.mesher

    fine = {"mesh.contact_size_mm": 0.2, "mesh.layers": 9, "mesh.mesher": "tetwild"}
    assert meshed(fine) == (4, 0.4, 0.4, "auto")
    assert meshed(fine, "mesh.layers", "mesh.mesher") == (9, 0.4, 0.4, "tetwild")
    coarse = {"mesh.contact_size_mm": 0.6, "mesh.layers": 2, "mesh.section.gradation": 0.5}
    assert meshed(coarse)[:3] == (2, 0.6, 0.5)
    assert meshed({"body.depth_mm": 22.0})[0] == 7  # 0.6 in a mm of half the depth


def test_where_many_fingers_are_condensed_three_layers_are_enough_for_both_faces(calls_of):
    both = with_values(DESIGN, {"gages.face": "both"})
    one = with_values(DESIGN, {"gages.face": "upper"})
    assert layers_for_many(both) == (3, 0.45, 1.3)
    assert layers_for_many(one) == EVEN_LAYERS
    made = calls_of(family, "BenchFinger")
    settings = replace(settings_of(both), grips=2, fingers=2)
    assert family._made(family.Family(both, settings, "3d", "key"), 1, None)
    assert [each.layered for _, each in made] == [(3, 0.45, 1.3)]
