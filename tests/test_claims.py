"""README.md and docs/*.md: every number has its source, which exists and agrees with the text."""

import ast
import re
import shlex

import click
import pytest
from fingerdesign_bench.known.case import Outcome, load_cases
from fingerdesign_bench.known.run import row
from fingerdesign_cli.main import cli

from tests.support.claims import (
    FOLDER,
    ROOT,
    TABLE,
    covered,
    disagreements,
    entries,
    numbers,
    pages,
    pairs,
    path_of,
    printed_now,
    table,
    told_apart,
    units,
    value,
)

ENTRIES = [(page, entry) for page in pages() for entry in entries(page)]
CLAIMS = [(page, entry) for page, entry in ENTRIES if entry.command or entry.test]
AGAIN = [(page, entry) for page, entry in CLAIMS if entry.lines]


def named(each):
    page, entry = each
    return f"{page.stem}: {entry.at[:40]}"


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.stem)
def test_every_number_has_an_entry_that_agrees(page):
    assert not (said := disagreements(page)), "\n".join(said)


def test_every_file_is_of_a_page():
    assert set(FOLDER.glob("*.toml")) <= {path_of(page) for page in pages()}


def test_the_table_is_that_of_the_entries():
    assert TABLE.read_text("utf-8") == table(), "python tests/support/claims.py write"


def unknown(command):
    """What a command names that is not there: a subcommand, an option, a file of the checkout."""
    program, *rest = shlex.split(command)
    if program != "fingerdesign":
        assert program in ("python", "pytest", "ruff"), command
        files = [
            word.partition("::")[0] for word in rest if word.partition("::")[0].endswith(".py")
        ]
        return [name for name in files if not (ROOT / name).is_file()]
    found = cli
    while isinstance(found, click.Group) and rest and rest[0] in found.commands:
        found = found.commands[rest.pop(0)]
    known = {option for each in found.params for option in (*each.opts, *each.secondary_opts)}
    return [found.name] * (found is cli) + [
        word for word in rest if word.startswith("--") and word not in known
    ]


def test_every_command_is_there_with_its_options():
    assert [c for c in {entry.command for _, entry in CLAIMS} - {""} if unknown(c)] == []


def test_every_test_is_there():
    for test in {entry.test for _, entry in CLAIMS} - {""}:
        file, _, name = test.partition("::")
        tree = ast.parse((ROOT / file).read_text("utf-8"))
        assert name in {each.name for each in tree.body if isinstance(each, ast.FunctionDef)}, test


def test_every_claim_has_what_shows_it_and_a_day():
    for page, entry in CLAIMS:
        assert bool(entry.told) + bool(entry.run) + bool(entry.test or entry.record), entry
        assert not (entry.told and (entry.run or entry.record)), entry
        assert bool(entry.lines) == bool(entry.run or entry.record), entry
        assert entry.printed or entry.test, (page.name, entry.at)
    for page, entry in ENTRIES:
        if entry.command or entry.test:
            continue
        assert not any(mine for _, mine in told_apart(entry.printed)), (page.name, entry.at)


@pytest.mark.parametrize(
    "each",
    [
        pytest.param(each, id=named(each), marks=[pytest.mark.slow] * (not each[1].record))
        for each in AGAIN
    ],
)
def test_a_command_prints_or_a_record_holds_what_was_kept(each):
    page, entry = each
    ((there, known),) = ((there, known) for _, there, known in covered(page)[0] if entry in known)
    texts = [number for number, of, _, mine in pairs(there, known) if mine and of == entry]
    # Another machine's rounding leads a grip a little elsewhere: 5 % besides the entry's spread.
    for number, now in zip(texts, printed_now(page, entry), strict=True):
        near = pytest.approx(value(number), rel=0.05) == entry.scale * value(now)
        assert near or entry.close(number, now), (entry.command, number, now)


def test_the_suites_table_is_that_of_its_cases():
    """Each case's `found` is what `fingerdesign bench suite` found when its file was written."""
    text = (ROOT / "docs/suite.md").read_text("utf-8")
    for case in load_cases():
        assert "| " + " | ".join(row(Outcome(case, case.regression))) + " |\n" in text
        assert not case.known_miss or case.known_miss in text


def test_numbers_are_found_and_names_and_settings_are_not():
    text = "At mu = 0.3 P2 in 3-D lifts 500 g by 1.5 to -2.5 %, 1,250 times, `7`; Fig. 4, GPL-3.0."
    assert numbers(text) == ["1.5", "-2.5", "1,250"]
    assert re.sub(r"\s", "", units("a\n\n```\n5\n```\n| a | b |\n|-|-|\n| 1 | 2 |")[-1]) == "|1|2|"
