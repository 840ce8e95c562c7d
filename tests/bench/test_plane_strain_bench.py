"""The plane-strain study as a bench: rules and certainty from made-up records, and its files."""

import json

import numpy as np
import pytest
from click.testing import CliRunner
from fingerdesign_bench.cli.bench import command
from fingerdesign_bench.studies.plane_strain_bench import (
    FINER,
    judged,
    mesh_errors,
    uncertainty,
    write_plane_strain,
)
from fingerdesign_bench.studies.plane_strain_chart import sampled
from fingerdesign_bench.studies.plane_strain_rule import Rule, fitted

from fingerdesign.validate.plane_strain import QUANTITIES, map_of

RULE = Rule("normal_force", 0.0, 3.0, 1.2, 0.3, 0.9, 0.0, 0.0)


def model(poisson, span, depth, name="", more=1.0):
    """A model whose every error follows RULE, times ``more``."""
    rows = []
    for width in (0.06, 0.12, 0.3):
        error = more * float(RULE.error(poisson, depth, width))
        rows.append({"half_width_over_height": width} | dict.fromkeys(QUANTITIES, error))
    return {
        "name": name,
        "poissons_ratio": poisson,
        "span_over_depth": span,
        "depth_over_height": depth,
        "radius_over_height": 1.6,
        "width_over_height": 1.6,
        "dofs": 1,
        "rows": rows,
    }


@pytest.fixture
def table():
    grid = [
        model(nu, span, depth)
        for nu in (0.3, 0.45, 0.49)
        for span in (0.0, 1.0)
        for depth in (0.4, 0.8, 1.6, 3.2)
    ]
    also = [
        model(0.49, 1.0, 0.8, FINER, 1.05),
        *(model(0.49, 1.0, 0.8, f"other {k}", 1.0 + 0.1 * k) for k in range(5)),
    ]
    return {"points": grid, "also": also}


def test_the_fit_finds_the_rule_that_made_the_errors(table):
    found = fitted(map_of(table), "normal_force", 0.0)
    assert found.factor == pytest.approx(3.0, rel=0.05)
    assert found.poisson == pytest.approx(1.2, abs=0.02)
    assert found.width == pytest.approx(0.3, abs=0.01)
    assert found.depth == pytest.approx(0.9, rel=0.05)
    assert found.typical < found.off < 2e-3


def test_how_sure_a_look_up_is_comes_from_the_one_off_models(table):
    chart = map_of(table)
    largest = float(RULE.error(0.49, 0.8, 0.3))
    assert mesh_errors(chart)["normal_force"] == pytest.approx(0.05 * largest, rel=1e-6)
    found = uncertainty(chart)["gage_face"]
    assert found["absolute"] == pytest.approx(max(0.01, 0.05 * largest), rel=0.01)
    assert 0.2 < found["relative"] < 0.4  # nine of ten, the meshes' part taken off


def test_the_chart_is_sampled_over_what_was_computed(table):
    across, depth, values = sampled(map_of(table), "normal_force", 0.0, 0.49)
    assert across.shape == depth.shape == values.shape
    assert np.allclose(depth / across, (depth / across)[0])
    assert depth.min() == pytest.approx(0.4)
    assert np.isfinite(values).all()


def test_everything_is_written(table, tmp_path):
    found = judged(table, tmp_path / "plane_strain.jsonl")
    paths = write_plane_strain(found, tmp_path / "out")
    written = json.loads((tmp_path / "out" / "plane_strain.json").read_text("utf-8"))
    assert set(written) == {"points", "also", "rules", "uncertainty"}
    assert len((tmp_path / "out" / "plane_strain.csv").read_text("utf-8").splitlines()) == 91
    assert (tmp_path / "out" / "plane_strain.png").read_bytes()[:4] == b"\x89PNG"
    assert paths[-1].name == "plane_strain.jsonl"
    names = [check.name for check in found.checks]
    assert any("finer" in name for name in names)
    assert any("no plates" in name for name in names)


def test_a_study_file_with_a_fault_is_refused_before_any_work(tmp_path):
    study = tmp_path / "study.toml"
    study.write_text('[study]\nname = "x"\nbase = "maeno2000"\n', encoding="utf-8")
    run = CliRunner().invoke(
        command, ["plane-strain", "--study", str(study), "--out", str(tmp_path / "out")]
    )
    assert run.exit_code != 0
    assert "parameters" in str(run.exception)
    assert not (tmp_path / "out").exists()
