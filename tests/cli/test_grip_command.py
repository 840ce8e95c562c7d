"""``fingerdesign grip``: options over the design's table, the record it leaves, exit codes."""

import json

import pytest
from fingerdesign_cli.main import main

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


def test_each_friction_is_lifted_once_and_recorded(design, tmp_path, capsys):
    options = ["--friction", "0.3", "--friction", "0.7", "--mass-g", "30"]
    assert main(["grip", str(design), "--out", str(tmp_path / "out"), *options, "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
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


def test_wrong_options_are_faults_of_the_table(design, tmp_path, capsys):
    options = ["--controller", "magic", "--friction", "-1", "--mass-g", "0"]
    assert main(["grip", str(design), "--out", str(tmp_path / "out"), *options]) == 2
    reported = capsys.readouterr().err
    for key in ("grip.controller", "grip.friction_coefficients", "grip.object_mass_g"):
        assert key in reported
    assert not (tmp_path / "out").exists()


def test_a_finger_that_feels_nothing_cannot_grip(tmp_path, capsys):
    path = tmp_path / "plain.toml"
    path.write_text('design.name = "plain"\nplates.count = 0\n')
    assert main(["grip", str(path), "--out", str(tmp_path / "out")]) == 2
    assert "plates.count" in capsys.readouterr().err


def test_a_faulty_option_is_one_fault_that_names_it(design, tmp_path, capsys):
    arguments = ["grip", str(design), "--out", str(tmp_path / "out")]
    assert main([*arguments, "--friction", "0", "--mass-g", "-3"]) == 2
    first, second = capsys.readouterr().err.splitlines()
    assert first.startswith("--friction (grip.friction_coefficients[0]) = 0.0: must be more than 0")
    assert second.startswith("--mass-g (grip.object_mass_g) = -3.0: must be more than 0")


def test_out_is_no_file(design, capsys):
    assert main(["grip", str(design), "--out", str(design)]) == 2
    assert "--out" in capsys.readouterr().err
