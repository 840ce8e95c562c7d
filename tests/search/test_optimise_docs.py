"""docs/optimise.md: what it shows exists, and says what the shipped study and README say."""

import re
from pathlib import Path

from fingerdesign.search.optimise.optimise import RANDOM_TRIALS
from fingerdesign.search.study.file import read_study

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "docs/optimise.md").read_text("utf-8")
STUDY = read_study("better_maeno")


def test_links_and_pictures_exist():
    targets = re.findall(r"\]\(([^)#]+)\)", TEXT)
    assert targets
    for target in targets:
        assert (ROOT / "docs" / target).exists(), target


def test_the_example_is_the_shipped_study():
    assert len(STUDY.parameters) == 5
    assert f"Of {STUDY.optimise.trials} trials" in TEXT
    assert len(re.findall(r"^\| trial \d+ \|", TEXT, re.MULTILINE)) == STUDY.optimise.confirm
    for objective in STUDY.objectives:
        assert f"`{objective.metric}`" in TEXT
    assert RANDOM_TRIALS == 20  # "the first twenty"


def test_readme_says_the_same_numbers():
    readme = " ".join((ROOT / "README.md").read_text("utf-8").split())
    reported = re.search(
        r"an error of ([\d.]+) where the paper's finger has ([\d.]+), and it grips with "
        r"([\d.]+) times the least force that holds \(median\) where that takes ([\d.]+)",
        " ".join(TEXT.split()),
    )
    assert reported is not None
    own, paper, force, least = reported.groups()
    assert f"an error of {own} instead of {paper}" in readme
    assert f"{force} times the least force instead of {least}." in readme
    assert float(own) < float(paper)
    assert float(force) < float(least)
