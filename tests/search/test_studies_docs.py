"""The page on studies, designs/studies: what they show exists and runs."""

import itertools
from pathlib import Path

import pytest

from fingerdesign.search.study.file import parse_study, read_study
from fingerdesign.search.study.metrics import METRICS
from fingerdesign.search.study.variants import base_design, variants
from tests.support.pages import DOCS, blocks, run_python

PAGE = "how_to/studies.md"
STUDIES = sorted((Path(__file__).parents[2] / "designs/studies").glob("*.toml"))


def test_the_pages_study_has_sound_variants_and_its_python_runs(capsys):
    study = parse_study(blocks(PAGE, "toml")[0])
    found = [each.design for each in variants(study, base_design(study))]
    assert len(found) == study.study.count == 32
    spans = [each.plates.span_mm / each.body.depth_mm for each in found if each]
    assert len(spans) >= 16
    assert 0.5 <= min(spans) < max(spans) <= 1.0
    run_python(PAGE)
    first, *faults = capsys.readouterr().out.splitlines()
    total, valid = map(int, first.split())
    assert total == 200
    assert len({line.split()[0] for line in faults}) == total - valid


def test_the_page_lists_every_metric():
    table = (DOCS / PAGE).read_text("utf-8").split("## Metrics\n")[1].split("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line.startswith("| `")]
    better = {"min": "less", "max": "more", None: "-"}
    assert rows == [
        [f"`{each.name}`", each.unit or "-", better[each.better], each.words]
        for each in METRICS.values()
    ]


@pytest.mark.parametrize(
    "path",
    [path for path in STUDIES if not path.stem.startswith("plane_strain")],
    ids=lambda path: path.stem,
)
def test_shipped_studies_say_why_and_have_variants(path):
    assert path.read_text("utf-8").startswith("# ")
    study = read_study(path.stem)
    assert study.name == path.stem
    assert study.objectives
    found = list(itertools.islice(variants(study, base_design(study)), 32))
    assert sum(variant.design is not None for variant in found) >= 0.8 * len(found)
