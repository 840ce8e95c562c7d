"""The names of cached estimators and sensitivities: each thing that decides them changes it."""

from dataclasses import fields, replace

import numpy as np
import pytest

from fingerdesign import parse_design, with_values
from fingerdesign.sensing.identify.bench import FINE, BenchModel, protocol
from fingerdesign.sensing.identify.latents import Latent
from fingerdesign.sensing.identify.sensitivities import sensitivities_key
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


PHASES = protocol(DESIGN)
LATENTS = [Latent("lean"), Latent("gain", 0)]


def name_of(
    design=DESIGN, phases=PHASES, fidelity="plane-strain", latents=LATENTS, lean=0.0, mesh=FINE
):
    return sensitivities_key(BenchModel(design, phases, fidelity, mesh), latents, lean)


@pytest.mark.parametrize("field", ["kind", "friction_coefficient", "tilt_deg", "points"])
@pytest.mark.parametrize("number", [0, len(PHASES) - 1])
def test_each_move_of_the_bench_is_part_of_the_key(field, number):
    phase = PHASES[number]
    other = {"kind": "slide" if phase.kind != "slide" else "press"}.get(field)
    others = [getattr(phase, field) + 0.01] if field[0] in "ft" else [other]
    if field == "points":
        others = [
            replace(phase.points, **{each: np.array(getattr(phase.points, each)) + 0.001})
            for each in ("approach", "shear")
        ]
    for value in others:
        moved = [*PHASES]
        moved[number] = replace(phase, **{field: value})
        assert name_of(phases=tuple(moved)) != name_of()
    assert name_of(phases=PHASES[:-1]) != name_of()


@pytest.mark.parametrize("field", fields(FINE), ids=lambda each: each.name)
def test_each_size_of_the_mesh_is_part_of_the_key(field):
    other = replace(FINE, **{field.name: 2.0})
    assert name_of(fidelity="3d", mesh=other) != name_of(fidelity="3d")


def test_model_hidden_values_and_lean_are_part_of_the_key():
    others = [
        *(name_of(fidelity="3d"), name_of(lean=0.1), name_of(latents=LATENTS[:1])),
        name_of(latents=[Latent("lean"), Latent("gain", 1)]),
        name_of(with_values(DESIGN, {"gages.length_mm": 0.51})),
        name_of(with_values(DESIGN, {"materials.polyimide.youngs_modulus_MPa": 2600.0})),
    ]
    assert len({name_of(), *others}) == len(others) + 1


def test_a_meshs_file_counts_by_its_content_in_every_key(tmp_path):
    found = set()
    for name, content in (("a.msh", "one"), ("b.msh", "two"), ("a.msh", "three")):
        (tmp_path / name).write_text(content)
        data = {"mesh.mesher": "file", "mesh.file": str(tmp_path / name)}
        design = with_values(DESIGN, data)
        found.add((training_key(design, SETTINGS, "3d"), name_of(design)))
        (tmp_path / "elsewhere.msh").write_text(content)
        moved = with_values(DESIGN, data | {"mesh.file": str(tmp_path / "elsewhere.msh")})
        assert (training_key(moved, SETTINGS, "3d"), name_of(moved)) in found
    assert [len(set(each)) for each in zip(*found, strict=True)] == [3, 3]
