"""Numbers that pages state without a command, a test or a record that shows them.

    python -m tests.support.stated_numbers

Counted are numbers with a unit in README and docs, outside code. A number is shown where its
section has a command or code that prints it.
"""

import re
from collections import Counter

from tests.support.house import ROOT

UNITS = (
    r"%|µm|mm|[kMG]Pa|N|ms|min|seconds?|minutes?|hours?|h|s|[kMG]B|k?g|Hz|K|microstrain|degrees?|°"
)
NUMBER = re.compile(rf"(?<![\w.#/`-])\d(?:[\d,.]*\d)?\s?(?:{UNITS}|times|of \d+)(?![\w`])")
SHOWN = re.compile(r"fingerdesign [a-z]|python -m |make [a-z]|^ {4}|^```", re.MULTILINE)
NOT_SAID = re.compile(r"\]\([^)]*\)|`[^`]*`|^\s*\d+\.\s|\b[23]-D\b")


def pages():
    """README and the pages, but for the paper and what is made."""
    every = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
    names = [each.relative_to(ROOT).as_posix() for each in every]
    return [name for name in names if not re.match(r"docs/(paper|examples|generated)/", name)]


def sections(text):
    """Parts of a page from heading to heading; hashes in code are no headings."""
    part, inside = [], False
    for line in text.splitlines():
        inside ^= line.startswith("```")
        if line.startswith("#") and not inside and part:
            yield "\n".join(part)
            part = []
        part.append(line)
    yield "\n".join(part)


def unshown(text):
    """Numbers with a unit in sections without a command or code."""
    bare = [each for each in sections(text) if not SHOWN.search(each)]
    lines = (NOT_SAID.sub("", line) for each in bare for line in each.splitlines())
    return [found for line in lines for found in NUMBER.findall(line)]


def counted():
    """How many each page has, those without any left out."""
    texts = {name: (ROOT / name).read_text("utf-8") for name in pages()}
    return Counter({name: len(unshown(text)) for name, text in texts.items() if unshown(text)})


if __name__ == "__main__":
    print(f"{sum(counted().values())} stated numbers without a command next to them")
    for page, number in counted().most_common():
        print(f"{page}: {number} not shown")
