"""Every number of README.md and docs/*.md, tied to the command or test that shows it.

    python tests/support/claims.py                 what no entry covers, what disagrees
    python tests/support/claims.py write           docs/claims.md, the table of all claims
    python tests/support/claims.py run PAGE WORDS  run a claim's command again, keep what it printed

How a page's entries (docs/claims/PAGE.toml) are written stands at the top of docs/claims.md.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import subprocess
import sys
import tomllib
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from datetime import date
from functools import cache, partial
from pathlib import Path
from tempfile import TemporaryDirectory

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "docs/claims"
TABLE = ROOT / "docs/claims.md"
INTRODUCTION = FOLDER / "introduction.txt"

NUMBER = r"(?:(?<![\w)%.])[-−])?(?:\d{1,3}(?:,\d{3})+|\d+)(?:\.\d+)?(?:e[-+]?\d+)?"
# A digit within a word (P2, x86-64, GPL-3.0) or a dimension (3-D) is a name and no number.
FOUND = re.compile(rf"(?<![\w.])(?<![A-Za-z]-){NUMBER}(?!-D\b)")
ONE = rf"{NUMBER}(?: to {NUMBER})?"
SEVERAL = rf"{NUMBER}(?:(?:, | and | or | to |, and ){NUMBER})*"
# What is not measured, by its form: what was set or looked up, and what cites another text.
SETTINGS = re.compile(
    rf"\b(?:mu|nu|μ|D/H|a/H) ?(?:=|of|from) {ONE}"
    rf"|\b(?:friction|friction coefficient)(?: of| at)? {ONE}"
    rf"|\b(?:frictions|coefficients)(?: of| from)? {SEVERAL}"
    rf"|(?<![\w.])\d+(?:(?:, | and | or | to )\d+)* g\b|(?<![\w.])[\d.]+ kg\b|(?<![\w.])45 degrees"
    rf"|\b(?:[Ee]xit codes?|seeds?|Figures?|Fig\.|[Ss]ections?|sect\.|Python) {SEVERAL}"
    rf"|(?<![\w.])\d+ Hz\b"
    rf"|\((?:[A-Z]\w+[^()]*,? )?(?:19|20)\d\d\)(?: \d+)?|[A-Z]\w+ \d+, (?:19|20)\d\d"
)
CODE = re.compile(r"^```.*?^```[^\n]*$|^(?: {4,}|\t)[^\n]*$|^#[^\n]*$|^:::.*?:::$", re.M | re.S)
INLINE = re.compile(r"!\[[^\]]*\]\([^)]*\)|`[^`]*`|(?<=\])\([^)]*\)|https?://\S+")
GIVEN_OR_NOT = r"(\([^)]*\))|([^\s()]+)"
ITEM = re.compile(r"^ {0,3}(?:[-*]|\d+\.) +", re.M)


def pages() -> list[Path]:
    """The pages whose numbers need a source; docs/claims.md itself is made from their entries."""
    return [ROOT / "README.md", *sorted(set((ROOT / "docs").glob("*.md")) - {TABLE})]


def units(text: str) -> list[str]:
    """Paragraphs, list items and rows of tables, each on one line, without blocks of code."""
    found = []
    for block in re.split(r"\n\s*\n", ITEM.sub("\n\n", CODE.sub("", text))):
        lines = block.strip().splitlines()
        table = len(lines) > 1 and lines[1].startswith("|-")
        found += [f"{lines[0]} {lines[1]}", *lines[2:]] if table else [" ".join(block.split())]
    return [each for each in found if each]


def numbers(unit: str) -> list[str]:
    """The numbers of a paragraph that need an entry, as they are written."""
    return FOUND.findall(SETTINGS.sub(" ", INLINE.sub(" ", unit)))


def value(number: str) -> float:
    return float(number.replace("−", "-").replace(",", ""))


def half_digit(number: str) -> float:
    """Half of the last digit shown: 0.5 of 12, 0.005 of 1.25."""
    mantissa, _, power = number.partition("e")
    decimals = len(mantissa.partition(".")[2])
    return 0.5 * 10.0 ** (int(power or 0) - decimals) * (1 + 1e-9)


@dataclass(frozen=True)
class Entry:
    """Numbers of one paragraph: measured ones, and in brackets what was set or given."""

    page: str
    at: str
    command: str = ""
    test: str = ""
    printed: str = ""
    spread: str = ""
    why: str = ""
    scale: float = 1.0  # the text's unit in the command's: 100 where it prints shares for percent
    told: str = ""  # the day on which the text was written from the command's output
    run: str = ""  # the day on which the command was run and `printed` kept
    record: str = ""  # a file of the checkout that holds the numbers, in place of a run
    lines: tuple[str, ...] = ()  # patterns: where the measured numbers, <N>, are in the output

    def close(self, number: str, printed: str) -> bool:
        """Whether the text's number is the printed one within the spread, or the digits shown."""
        size, _, percent = self.spread.partition(" ")
        now = self.scale * value(printed)
        allowed = float(size or 0) * (0.01 * abs(now) if percent == "%" else 1.0)
        return abs(value(number) - now) <= max(allowed, half_digit(number))

    def when(self) -> str:
        if self.record:
            return f"kept in {self.record}"
        if self.run:
            return f"run on {self.run}"
        return f"as told on {self.told}, not run again" if self.told else "each time by the test"


def path_of(page: Path) -> Path:
    return FOLDER / f"{page.stem}.toml"


def entries(page: Path) -> list[Entry]:
    """What a page's file says of its numbers: its claims, then what is given."""
    if not path_of(page).is_file():
        return []
    read = tomllib.loads(path_of(page).read_text("utf-8"))
    given = read.pop("given", {})
    claims = read.pop("claim", [])
    found = [Entry(page.stem, **{**read, **claim}) for claim in claims]
    return found + [Entry(page.stem, at, printed=f"({numbers})") for at, numbers in given.items()]


def told_apart(printed: str) -> Iterator[tuple[str, bool]]:
    """Numbers of an entry in order, and whether each was measured: not what is in brackets."""
    for given, measured in re.findall(GIVEN_OR_NOT, printed):
        yield from ((number, False) for number in given.strip("()").split())
        if measured:
            yield measured, True


Covered = tuple[str, list[str], list[Entry]]


def covered(page: Path) -> tuple[list[Covered], list[str]]:
    """Each paragraph with its numbers and their entries; entries that stand in none, or in several.

    A row of a table without an entry of its own belongs to that of the table's head.
    """
    found, of, said = units(page.read_text("utf-8")), defaultdict(list), []
    for entry in entries(page):
        places = [k for k, unit in enumerate(found) if entry.at in unit]
        if len(places) == 1:
            of[places[0]].append(entry)
        else:
            said.append(f"{page.name}: '{entry.at}' stands in {len(places)} paragraphs, not in one")
    gathered: dict[int, list[str]] = {}
    head = 0
    for k, unit in enumerate(found):
        head = k if not unit.startswith("|") or "|-" in unit else head
        gathered.setdefault(k if k in of else head, []).extend(numbers(unit))
    return [(found[k], there, of.get(k, [])) for k, there in gathered.items()], said


def disagreements(page: Path) -> list[str]:
    """What is wrong between a page and its entries, a sentence each."""
    paragraphs, said = covered(page)
    for unit, there, known in paragraphs:
        said += [f"{page.name}, '{unit[:60]}': {each}" for each in _compared(there, known)]
    return said


def pairs(there: list[str], known: list[Entry]) -> list[tuple[str, Entry, str, bool]]:
    """Each number of a paragraph, its entry, what that has in its place, and if it was measured."""
    kept = [(entry, *each) for entry in known for each in told_apart(entry.printed)]
    return [(number, *each) for number, each in zip(there, kept, strict=False)]


def _compared(there: list[str], known: list[Entry]) -> Iterator[str]:
    if any(not entry.printed for entry in known):  # a test compares the paragraph itself
        return
    kept = [number for entry in known for number, _ in told_apart(entry.printed)]
    if len(there) != len(kept):
        yield f"the text has {' '.join(there)}; kept: {' '.join(kept) or 'no entry'}"
        return
    for number, entry, printed, measured in pairs(there, known):
        if not (entry.close(number, printed) if measured else value(number) == value(printed)):
            yield f"{number} in the text, {printed} printed by {entry.command or 'nothing: given'}"


def counted() -> dict[str, int]:
    """How many numbers the pages have, and how each is shown."""
    counts = dict.fromkeys(("all", "given", "told", "run", "test", "none"), 0)
    for page in pages():
        for _, there, known in covered(page)[0]:
            counts["all"] += len(there)
            for entry in known:
                way = next((each for each in ("told", "run") if getattr(entry, each)), "test")
                for _, measured in told_apart(entry.printed):
                    counts[way if measured else "given"] += 1
                counts["test"] += 0 if entry.printed else len(there)
    counts["none"] = counts["all"] - sum(counts[way] for way in ("given", "told", "run", "test"))
    return counts


def table() -> str:
    """docs/claims.md: how entries are written, then a row for each claim."""
    rows = []
    for page in pages():
        for entry in entries(page):
            if entry.command or entry.test:
                measured = [number for number, mine in told_apart(entry.printed) if mine]
                shown = " ".join(measured[:8]) + (f" … ({len(measured)})" if measured[8:] else "")
                cells = (
                    "README" if page.parent == ROOT else f"[{entry.page}]({page.name})",
                    f"{entry.at.replace('|', ' ')} …",
                    f"`{entry.command}`" if entry.command else "",
                    f"`{entry.test}`" if entry.test else "",
                    shown or "compared by the test",
                    " ".join(filter(None, (entry.spread or "digits shown", entry.why))),
                    entry.when(),
                )
                rows.append("| " + " | ".join(" ".join(cell.split()) for cell in cells) + " |")
    head = "| page | claim | command | test | printed | spread | when |\n|-|-|-|-|-|-|-|\n"
    counts = counted()
    measured = counts["told"] + counts["run"] + counts["test"]
    words = (
        f"{counts['all']} numbers: {counts['given']} are given, {measured} measured. Of these "
        f"{counts['run']} were kept when their command was run for this table, {counts['test']} "
        f"are compared by a test each time, and {counts['told']} are as told on the day named."
    )
    return f"{INTRODUCTION.read_text('utf-8')}\n{words}\n\n{head}" + "\n".join(rows) + "\n"


@cache
def output_of(page: Path, command: str) -> str:
    """What a command prints and writes as JSON, run in a folder with the page's designs."""
    arguments = shlex.split(command)
    program = {"fingerdesign": ["-m", "fingerdesign_cli.main"], "pytest": ["-m", "pytest"]}
    with TemporaryDirectory() as folder:
        for block in re.findall(r"```toml\n(.*?)```", page.read_text("utf-8"), re.S):
            for name in re.findall(r'^(?:design\.)?name = "(\w+)"', block, re.M):
                Path(folder, f"{name}.toml").write_text(block, "utf-8")
        done = subprocess.run(
            [sys.executable, *program.get(arguments[0], []), *arguments[1:]],
            cwd=folder if arguments[0] == "fingerdesign" else ROOT,
            env=os.environ | {"COLUMNS": "200", "FINGERDESIGN_CACHE": f"{folder}/kept"},
            capture_output=True,
            text=True,
            check=False,  # benchmarks answer 1 where a number falls short of what was asked
        )
        files = [json.loads(f.read_text("utf-8")) for f in sorted(Path(folder).glob("*/**/*.json"))]
    written = [json.dumps(each, ensure_ascii=False) for each in files]
    return " ".join(" ".join([done.stdout, done.stderr, *written]).split())


def printed_now(page: Path, entry: Entry) -> list[str]:
    """The numbers that a claim's lines find when its command is run now."""
    kept = (ROOT / entry.record).read_text("utf-8") if entry.record else ""
    output = " ".join(kept.split()) or output_of(page, entry.command)
    found = [re.search(each.replace("<N>", f"({NUMBER})"), output) for each in entry.lines]
    if None in found:
        raise ValueError(f"{entry.lines[found.index(None)]} is not in {output[:3000]}")
    return [number for match in found if match for number in match.groups()]


def rerun(page: Path, words: str) -> list[str]:
    """Run the commands of a page's claims, keep their numbers and the day; what was, what is."""
    claims = path_of(page).read_text("utf-8").split("[[claim]]")
    said = []
    for entry in entries(page):
        if words not in entry.at or not entry.lines or entry.record:
            continue
        measured, at = iter(printed_now(page, entry)), json.dumps(entry.at, ensure_ascii=False)
        now = re.sub(GIVEN_OR_NOT, partial(_kept, measured), entry.printed)
        for k, claim in enumerate(claims):
            if f"at = {at}\n" in claim and f'printed = "{entry.printed}"\n' in claim:
                claim = claim.replace(f'printed = "{entry.printed}"', f'printed = "{now}"')
                claims[k] = re.sub(r'(?m)^(told|run) = ".*"$', f'run = "{date.today()}"', claim)
        said.append(f"{entry.at}: {entry.printed}; now {now}")
    path_of(page).write_text("[[claim]]".join(claims), "utf-8")
    return said


def _kept(measured: Iterator[str], match: re.Match[str]) -> str:
    return match[1] or next(measured)


def main(arguments: list[str]) -> int:
    if arguments[:1] == ["run"]:
        page = next(page for page in pages() if page.stem == arguments[1])
        print(*rerun(page, " ".join(arguments[2:])), sep="\n")
    if arguments:
        TABLE.write_text(table(), "utf-8")
    said = [each for page in pages() for each in disagreements(page)]
    print(*said, counted(), sep="\n")
    return bool(said)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
