"""Output of commands: progress, results, tables and JSON, on a terminal or elsewhere."""

from __future__ import annotations

import codecs
import json
import shlex
import sys
import textwrap
import time
import webbrowser
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from io import TextIOWrapper
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from fingerdesign.errors import printable
from fingerdesign.records.verdict import SIGNS, Fix, Verdict, VerdictView
from fingerdesign.runtime.progress import Progress, silent
from fingerdesign_cli.options import DETAILS, JSON, OPEN, QUIET

if TYPE_CHECKING:
    from rich.table import Table

    from fingerdesign.report.table import Table as ResultTable

WIDTH = 80  # Characters of a line: a terminal's usual width.
LINES = 14  # A result fits the upper half of a terminal of usual height.
SHORT = 13  # A table's cell of so many characters, as "118 / 29 / 4", stays on one line.
_ALMOST = 0.95  # The bar waits here for a stage that takes longer than its forecast.
_TELLING = 0.05  # Before this fraction the pace shows little of the time left.
# Plain characters for terminals whose encoding has no others.
_PLAIN = dict(zip("✓✗·×–°", "+x-x-o", strict=True)) | {"μ": "mu", "…": "...", "≥": ">="}


def _plain(error: UnicodeError) -> tuple[str, int]:
    if not isinstance(error, UnicodeEncodeError):
        raise error
    characters = error.object[error.start : error.end]
    return "".join(_PLAIN.get(each, ascii(each)[1:-1]) for each in characters), error.end


codecs.register_error("fingerdesign", _plain)


def degrade_signs() -> None:
    """Let stdout and stderr write plain characters for those that their encoding does not have."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, TextIOWrapper):
            stream.reconfigure(errors="fingerdesign")


@contextmanager
def progress(title: str, shown: bool = True) -> Iterator[Progress]:
    """Show progress on stderr: a bar on a terminal, plain lines elsewhere; nothing with --quiet.
    stdout stays free for results. A plain line is written when the message changes."""
    if quiet() or not shown:
        yield silent
    elif sys.stderr.isatty():
        with _bar(title) as show:
            yield show
    else:
        yield _plain_lines(title)


def part_of(show: Progress, done: int, count: int) -> Progress:
    """The progress of one of ``count`` works, after ``done`` others."""

    def part(message: str, fraction: float | None = None, left_s: float | None = None) -> None:
        show(message, (done + (fraction or 0.0)) / count, left_s if count == 1 else None)

    return part


def _plain_lines(title: str) -> Progress:
    last = ""

    def show(message: str, fraction: float | None = None, left_s: float | None = None) -> None:
        nonlocal last
        if message != last:
            last = message
            click.echo(printable(f"{title}: {message}"), err=True)

    return show


@dataclass
class _Pace:
    """The fraction of long work and the seconds left, between the moments that it reports."""

    fraction: float | None = None
    left_s: float | None = None
    shown: float = 0.0
    begun: float = field(default_factory=time.monotonic)
    reported: float = field(default_factory=time.monotonic)

    def report(self, fraction: float | None, left_s: float | None) -> None:
        if fraction is not None:
            self.fraction, self.left_s, self.reported = fraction, left_s, time.monotonic()

    def now(self) -> tuple[float | None, float | None]:
        """Fraction and seconds left; by the forecast where there is one, else by the pace so far. A
        stage that takes longer than its forecast holds the bar just before its end."""
        since = time.monotonic() - self.reported
        if self.fraction is None:
            return None, None
        if self.left_s is not None:
            part = min(since / self.left_s, _ALMOST) if self.left_s > 0.0 else 0.0
            now = self.fraction + (1.0 - self.fraction) * part
            self.shown = max(self.shown, now)  # A stage that ends late sets nothing back.
            return self.shown, max(self.left_s - since, 1.0)
        if self.fraction < _TELLING:
            return self.fraction, None
        whole = (self.reported - self.begun) / self.fraction
        return self.fraction, max(whole * (1.0 - self.fraction) - since, 1.0)


@contextmanager
def _bar(title: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, ProgressColumn, SpinnerColumn, Task, TextColumn
    from rich.progress import Progress as Bar
    from rich.progress_bar import ProgressBar
    from rich.text import Text

    pace = _Pace()

    class Fraction(BarColumn):
        def render(self, task: Task) -> ProgressBar:
            fraction, _ = pace.now()
            return ProgressBar(1.0, fraction or 0.0, width=24, pulse=fraction is None)

    class Left(ProgressColumn):
        def render(self, task: Task) -> Text:
            fraction, left = pace.now()
            percent = "" if fraction is None else f"{100.0 * fraction:.0f} %"
            spent = f"{task.elapsed or 0.0:.0f} s"
            return Text(f"{percent}, {left:.0f} s left" if left is not None else percent or spent)

    title_column = TextColumn("{task.fields[title]}", markup=False)
    description = TextColumn("{task.description}", markup=False)
    columns = (SpinnerColumn(), title_column, Fraction(), Left(), description)
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None, title=title)

        def show(message: str, fraction: float | None = None, left_s: float | None = None) -> None:
            pace.report(fraction, left_s)
            bar.update(task, description=printable(message))

        yield show


def say(text: str, **style: Any) -> None:
    """A line on stdout that the terminal obeys in nothing; further lines in it are indented."""
    click.secho(printable(text).replace("\n", "\n      "), **style)


def say_marked(mark: str, text: str) -> None:
    """A sentence behind a mark, in lines of at most 80 characters but for longer words (paths)."""
    for place, words in enumerate(_wrapped(text, WIDTH - 4)):
        click.echo(f"  {mark if place == 0 and mark else ' '} {words}".rstrip())


def say_wrapped(text: str, err: bool = False) -> None:
    """A sentence in lines of at most 80 characters but for longer words (paths)."""
    for place, words in enumerate(_wrapped(text, WIDTH - 2)):
        click.echo(f"  {words}" if place else words, err=err)


def _wrapped(text: str, width: int) -> list[str]:
    return textwrap.wrap(printable(text), width, break_long_words=False, break_on_hyphens=False)


def say_details(warnings: Sequence[str], tables: Sequence[ResultTable]) -> None:
    """Everything that a result's block leaves out: whole warnings, and tables of numbers."""
    for warning in warnings:
        say_marked(SIGNS["warning"], warning)
    for table in tables:
        if table.rows:
            print_table(table.caption, table.columns, table.rows, WIDTH)


def say_block(view: VerdictView, folder: Path) -> None:
    """A result at a glance, in at most ``LINES`` lines: verdicts, warnings, fixes, its report."""
    title = f"{view.name} · {view.fidelity} · {view.seconds:.0f} s"
    lines = [f"{title}{view.summary:>{WIDTH - len(title)}}"]
    if view.failure:
        lines += textwrap.wrap(printable(view.failure), WIDTH - 4)[: LINES - 3]
        lines[1:] = [f"  {SIGNS['fail']} {lines[1]}", *(f"    {line}" for line in lines[2:])]
    lines += _verdict_lines(view.verdicts)
    fixes = _fix_lines(view.fixes)
    room = LINES - 1 - len(lines) - len(fixes)
    lines += _warning_lines(view.warnings, max(room, 1))
    for line in [*lines, *fixes][: LINES - 1]:
        say(line)
    say(where_report(folder))


def _verdict_lines(verdicts: Sequence[Verdict]) -> list[str]:
    """A line for each verdict, its parts in columns where all of them fit."""
    judged = [each for each in verdicts if each.target]
    name = max((len(each.name) for each in verdicts), default=0)
    number = max((len(each.number) for each in judged), default=0)
    target = max((len(each.target) for each in judged), default=0)
    lines = []
    for each in verdicts:
        cells = f"{each.number:{number}}  {each.target:{target}}  {each.count}"
        line = f"  {each.sign} {each.name:{name}}  {cells}".rstrip()
        if len(line) > WIDTH:
            parts = filter(None, (each.name, each.number, each.target, each.count))
            line = f"  {each.sign} {'  '.join(parts)}"
        lines.append(shortened(line))
    return lines


def _warning_lines(warnings: Sequence[str], room: int) -> list[str]:
    """The first words of the warnings, in ``room`` lines."""
    few = warnings if len(warnings) <= room else warnings[: room - 1]
    lines = [shortened(f"  {SIGNS['warning']} {warning}") for warning in few]
    if more := len(warnings) - len(few):
        words = f"{more} {'more ' if few else ''}warning{'s' * (more > 1)}: --details"
        lines.append(f"  {SIGNS['warning']} {words}")
    return lines


def _fix_lines(fixes: Sequence[Fix]) -> list[str]:
    """The changes, each to be pasted, and their effects in a column where both fit."""
    wide = max((len(each.change) for each in fixes if len(each.change) < WIDTH // 2), default=0)
    lines: list[str] = []
    for each in fixes:
        line = f"  {'' if lines else 'fix':3}  {each.change:{wide}}  "
        effects = [text for text in (each.effect, each.brings) if len(line) + len(text) <= WIDTH]
        lines.append(f"{line}{effects[0] if effects else ''}".rstrip())
    return lines


def shortened(line: str) -> str:
    """The line, ended with three points after a whole word where a terminal is less wide."""
    line = " ".join(line.splitlines())
    if len(line) <= WIDTH:
        return line
    words = line[: WIDTH - 3].rpartition(" ")[0]
    return f"{words if len(words) > WIDTH // 2 else line[: WIDTH - 4]} ..."


def _given(key: str) -> bool:
    """True if the command that runs was given a flag."""
    context = click.get_current_context(silent=True)
    return context is not None and bool(context.meta.get(key))


opens, details = partial(_given, OPEN), partial(_given, DETAILS)
quiet, as_json = partial(_given, QUIET), partial(_given, JSON)


def say_result(
    data: Callable[[], object], show: Callable[[], None], page: Path | None = None
) -> int:
    """Report a result in the form that the command was given: as JSON, else in words, else not;
    and open its page. The exit code of work that is done, 0."""
    if as_json():
        print_json(data())
    elif not quiet():
        show()
    if page is not None:
        open_page(page)
    return 0


def say_done(facts: dict[str, Any], words: str, page: Path | None = None) -> int:
    """Report work that a line describes, as :func:`say_result` does."""
    return say_result(lambda: facts, lambda: click.echo(words), page)


def open_page(page: Path) -> None:
    """Open a page or a picture in the browser where ``--open`` wants it and it is there. Without a
    browser a line on stderr names the page."""
    if not (opens() and page.is_file()):
        return
    try:
        webbrowser.get()
    except webbrowser.Error:
        click.echo(f"no browser was found; open {page} in one", err=True)
    else:
        click.launch(page.absolute().as_uri())


def where_report(folder: Path) -> str:
    """The place of a result's page, or the command that draws it."""
    page = folder / "report.html"
    if page.is_file():
        return f"report: {page}"
    if (folder / "arrays.npz").is_file():
        return f"report: fingerdesign view {shlex.quote(str(folder))} --open"
    return f"report: none in {folder}"


def number(value: float | None, digits: int = 2, factor: float = 1.0, none: str = "-") -> str:
    """A number in a table's cell, so many digits after the point."""
    return none if value is None else f"{factor * value:.{digits}f}"


def print_table(
    title: str, headings: Sequence[str], rows: Sequence[Sequence[str]], width: int = 200
) -> None:
    """Print a table on stdout, as wide as it needs, up to ``width``, where it is no terminal.

    In ``WIDTH`` characters columns of words are aligned to the left, and columns that do not fit
    go on in another table, behind the first column again.
    """
    from rich.console import Console
    from rich.text import Text

    console = Console(file=sys.stdout)
    console.width = min(console.width, width) if console.is_terminal else width
    parts = _fitting(headings, rows) if width == WIDTH else [list(range(len(headings)))]
    for number, columns in enumerate(parts):
        shown = [headings[each] for each in columns]
        cells = [[row[each] for each in columns] for row in rows]
        table = _table(shown, cells, words=width == WIDTH)
        table.title = Text(printable(title)) if title and number == 0 else None
        console.print(table)


def _table(headings: Sequence[str], rows: Sequence[Sequence[str]], words: bool) -> Table:
    from rich.table import Table
    from rich.text import Text

    table = Table(title_justify="left")
    widths = _widths(headings, rows) if words else None
    for index, heading in enumerate(headings):
        left = index == 0 or (words and any(" " in row[index] for row in rows))
        table.add_column(Text(printable(heading)), justify="left" if left else "right")
        table.columns[-1].overflow = "fold"
        table.columns[-1].width = widths[index] if widths else None
    for row in rows:
        table.add_row(*(Text(printable(cell)) for cell in row))
    return table


def _fitting(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> list[list[int]]:
    """Columns by the table that they stand in, none narrower than ``_least`` of it."""
    columns = zip(headings, *rows, strict=True)
    least = [3 + _least(column) for column in columns]
    parts, used = [[0]], least[0]
    for column in range(1, len(headings)):
        if used + least[column] > WIDTH - 1 and len(parts[-1]) > 1:
            parts, used = [*parts, [0]], least[0]
        parts[-1].append(column)
        used += least[column]
    return parts


def _widths(headings: Sequence[str], rows: Sequence[Sequence[str]]) -> list[int]:
    """Characters of each column in a table of ``WIDTH``: no word is broken while there is room.
    What room is left goes to whatever column lacks most of being as wide as its longest cell."""
    columns = list(zip(headings, *rows, strict=True))
    longest = [max(len(cell) for cell in column) for column in columns]
    widths = [min(_least(column), WIDTH - 4) for column in columns]
    for _ in range(WIDTH - 1 - sum(width + 3 for width in widths)):
        lacking = [most - width for most, width in zip(longest, widths, strict=True)]
        if max(lacking) > 0:
            widths[lacking.index(max(lacking))] += 1
    return widths


def _least(column: Sequence[str]) -> int:
    """Characters of the longest word of a heading and its cells; a short cell is one word."""
    heading, *cells = column
    words = [word for cell in cells for word in ([cell] if len(cell) <= SHORT else cell.split())]
    return max(map(len, [*heading.split(), *words]), default=1)


def print_json(value: object) -> None:
    """Print ``value`` as JSON on stdout; NaN is refused, not written."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))
