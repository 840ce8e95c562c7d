"""README and docs: length, length of sentences, and words; what is counted is stated here.

Words are those between white space of README.md and docs/**/*.md, tables and code included.
A sentence ends with . ! or ? before white space, and with its paragraph, list item or quotation.
Headings, tables, code blocks, directives and pictures have no sentences. Inline code and a link's
text count as the words that are seen, a link's target as none.
"""

import re
from pathlib import Path
from statistics import mean

import pytest

from tests.support import stated_numbers

ROOT = Path(__file__).parents[1]
PAGES = (
    ROOT / "README.md",
    *sorted(path for path in ROOT.glob("docs/**/*.md") if "generated" not in path.parts),
)
TEXTS = (*PAGES, ROOT / "CHANGELOG.md", *sorted(ROOT.glob("docs/gallery/**/*.rst")))
MOST_WORDS, MOST_WORDS_README, MOST_LINES_README = 30_000, 1_200, 130
LONGEST, MEAN = 35, 18.0
DIALECT = {
    "anew",
    "asked",
    "beside",
    "besides",
    "doubt",
    "felt",
    "heard",
    "hearing",
    "kept",
    "lesson",
    "said",
    "says",
    "stands",
    "taught",
    "teach",
    "tell",
    "tells",
    "told",
    "unlike",
    "wander",
    "wanted",
    "whoever",
}


def named(page):
    """Path of a page in the repository."""
    return page.relative_to(ROOT).as_posix()


def prose(text):
    """The paragraphs of a page without headings, tables, code, directives and pictures."""
    text = re.sub(r"^([`:]{3,}).*?^\1", "", text, flags=re.DOTALL | re.MULTILINE)
    text = re.sub(r"!\[[^\]]*\]\([^)]*\)", "", text)
    text = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", text)
    lines = [
        "" if re.match(r"#|\||    (?! *[-*] )", line) else re.sub(r"^\s*([-*>]|\d+\.) ", "\n", line)
        for line in text.splitlines()
    ]
    return [part for part in re.split(r"\n\s*\n", "\n".join(lines)) if part.strip()]


def sentences(text):
    """Lists of words."""
    found = []
    for paragraph in prose(text):
        plain = re.sub(r"`[^`]*`", "code", paragraph)
        for sentence in re.split(r"(?<=[.!?])[*_)\"]*\s+", plain):
            words = [word for word in sentence.split() if re.search(r"\w", word)]
            if words:
                found.append(words)
    return found


def test_readme_is_short():
    text = (ROOT / "README.md").read_text("utf-8")
    assert len(text.split()) <= MOST_WORDS_README
    assert len(text.splitlines()) <= MOST_LINES_README


def test_all_pages_together_are_short():
    counts = {named(page): len(page.read_text("utf-8").split()) for page in PAGES}
    assert sum(counts.values()) <= MOST_WORDS, sorted(counts.items(), key=lambda each: -each[1])


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_no_sentence_is_long(page):
    found = sentences(page.read_text("utf-8"))
    assert [" ".join(words) for words in found if len(words) > LONGEST] == []
    assert not found or mean(map(len, found)) < MEAN


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_no_word_of_the_dialect(page):
    text = " ".join(prose(page.read_text("utf-8")))
    words = re.findall(r"[a-z]+", re.sub(r"`[^`]*`", "", text).lower())
    assert sorted(set(words) & DIALECT) == []


def anchor(heading):
    """The site's and GitHub's address of a heading."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


@pytest.mark.parametrize("page", PAGES, ids=named)
def test_links_into_a_page_find_their_heading(page):
    for target, name in re.findall(r"\]\(([^)#\s]*)#([^)\s]+)\)", page.read_text("utf-8")):
        if not target.startswith("http"):
            text = (page.parent / target if target else page).read_text("utf-8")
            assert name in map(anchor, re.findall(r"^#+ (.*)$", text, re.MULTILINE)), (target, name)


def test_numbers_are_shown_by_a_command():
    """A new one needs a command next to it that prints it, or a record; else leave it out."""
    assert stated_numbers.counted() == {}


def test_the_papers_references_and_parts_are_those_that_journals_ask_for():
    paper, sources = (
        (ROOT / "docs/paper" / f"paper.{kind}").read_text("utf-8") for kind in ("md", "bib")
    )
    assert set(re.findall(r"@(\w+)\]", paper)) == set(re.findall(r"^@\w+\{(\w+),", sources, re.M))
    parts = re.findall(r"^# (.+)$", paper, re.M)
    assert parts == [
        *("Summary", "Statement of need", "State of the field", "Software design"),
        *("Research impact statement", "AI usage disclosure", "Acknowledgements", "References"),
    ]
    assert 750 < len(paper.split()) < 1750  # what the Journal of Open Source Software allows


def test_a_number_without_a_command_is_found():
    bare, shown = "# A\n\n12 % and `3 mm`, 4 of 5\n", "# B\n\n12 %\n\n    fingerdesign check x\n"
    assert stated_numbers.unshown(bare + shown) == ["12 %", "4 of 5"]
