"""``fingerdesign grip``: options over the design's table, the record it leaves, exit codes."""

import json

import pytest

DESIGN = """
[design]
name = "coarse"
[plates]
length_mm = 1.0
cover_mm = 1.2
[gages]
length_mm = 0.6
[mesh.section]
contact_size_mm = 0.1
plate_size_mm = 0.3
plate_end_size_mm = 0.1
[grip]
max_steps = 12
"""


@pytest.fixture
def design(tmp_path):
    path = tmp_path / "coarse.toml"
    path.write_text(DESIGN)
    return path


def test_each_friction_is_lifted_once_and_recorded(design, tmp_path, said):
    options = ["--friction", "0.3", "--friction", "0.7", "--mass-g", "30"]
    printed = json.loads(said("grip", design, "--out", tmp_path / "out", *options, "--json").out)
    record = json.loads((tmp_path / "out/coarse/result.json").read_text())
    assert record["fidelity"] == "plane-strain"
    assert record["grips"] == printed["grips"]
    assert [grip["friction_coefficient"] for grip in record["grips"]] == [0.3, 0.7]
    for grip in record["grips"]:
        assert grip["object_mass_g"] == 30.0
        assert grip["lifted"]
        # mg < 2 F_t of each finger.
        assert grip["final_tangential_force_N"] > 0.5 * 0.030 * 9.80665
    assert (tmp_path / "out/coarse/report.html").is_file()


def test_a_finger_that_feels_nothing_cannot_grip(tmp_path, said):
    path = tmp_path / "plain.toml"
    path.write_text('design.name = "plain"\nplates.count = 0\n')
    assert "plates.count" in said("grip", path, "--out", tmp_path / "out", code=2).err


def test_a_faulty_option_is_one_fault_that_names_it(design, tmp_path, said):
    options = ["--friction", "0", "--mass-g", "-3", "--controller", "magic"]
    shown = said("grip", design, "--out", tmp_path / "out", *options, code=2).err.splitlines()
    assert len(shown) == 3
    magic, first, second = sorted(shown)
    assert magic.startswith("--controller (grip.controller) = 'magic': ")
    assert not (tmp_path / "out").exists()
    assert first.startswith("--friction (grip.friction_coefficients[0]) = 0.0: must be more than 0")
    assert second.startswith("--mass-g (grip.object_mass_g) = -3.0: must be more than 0")
