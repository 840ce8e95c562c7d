"""The pages on studies and optimising, designs/studies: what they show exists and runs."""

import itertools
import re
from pathlib import Path

import pytest

from fingerdesign.search.study.file import parse_study, read_study
from fingerdesign.search.study.metrics import METRICS
from fingerdesign.search.study.variants import base_design, variants

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs/how_to/studies.md").read_text("utf-8")
PAGE = (ROOT / "docs/how_to/optimise.md").read_text("utf-8")
BETTER = read_study("better_maeno")
STUDIES = sorted(path.stem for path in (ROOT / "designs/studies").glob("*.toml"))


def blocks(kind):
    return re.findall(rf"```{kind}\n(.*?)```", TEXT, flags=re.DOTALL)


def test_the_pages_study_has_sound_variants_and_its_python_runs(capsys):
    study = parse_study(blocks("toml")[0])
    found = list(variants(study, base_design(study)))
    assert len(found) == study.study.count == 32
    assert sum(variant.design is not None for variant in found) >= 16
    spans = {v.design.plates.span_mm / v.design.body.depth_mm for v in found if v.design}
    assert 0.5 <= min(spans) < max(spans) <= 1.0
    exec(compile(blocks("python")[0], "studies.md", "exec"), {})
    first, *faults = capsys.readouterr().out.splitlines()
    total, valid = map(int, first.split())
    assert total == 200
    assert len({line.split()[0] for line in faults}) == total - valid


def test_the_page_lists_every_metric():
    table = TEXT.split("## Metrics\n")[1].split("\n## ")[0]
    rows = [line.strip("| ").split(" | ") for line in table.splitlines() if line.startswith("| `")]
    better = {"min": "less", "max": "more", None: "-"}
    assert rows == [
        [f"`{each.name}`", each.unit or "-", better[each.better], each.words]
        for each in METRICS.values()
    ]


@pytest.mark.parametrize("name", [name for name in STUDIES if not name.startswith("plane_strain")])
def test_shipped_studies_say_why_and_have_variants(name):
    assert (ROOT / f"designs/studies/{name}.toml").read_text("utf-8").startswith("# ")
    study = read_study(name)
    assert study.name == name
    assert study.objectives
    found = list(itertools.islice(variants(study, base_design(study)), 32))
    assert sum(variant.design is not None for variant in found) >= 0.8 * len(found)
