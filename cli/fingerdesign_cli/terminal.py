"""What commands show: progress, tables and JSON, on a terminal or elsewhere."""

from __future__ import annotations

import json
import shlex
import sys
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import click

from fingerdesign.errors import printable

if TYPE_CHECKING:
    from fingerdesign.analysis.page.words import Question


class Progress(Protocol):
    """Tells the user where long work stands."""

    def __call__(self, message: str, fraction: float | None = None) -> None:
        """Say what is being done now; ``fraction`` in [0, 1] of the whole, None if unknown."""


@contextmanager
def progress(title: str, quiet: bool = False) -> Iterator[Progress]:
    """Show progress on stderr: a bar on a terminal, plain lines elsewhere, nothing if ``quiet``.

    stdout stays free for results. A plain line is written when the message changes.
    """
    if quiet:
        yield lambda message, fraction=None: None
    elif sys.stderr.isatty():
        with _bar(title) as show:
            yield show
    else:
        yield _plain_lines(title)


def _plain_lines(title: str) -> Progress:
    last = ""

    def show(message: str, fraction: float | None = None) -> None:
        nonlocal last
        if message != last:
            last = message
            click.echo(printable(f"{title}: {message}"), err=True)

    return show


@contextmanager
def _bar(title: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (
        SpinnerColumn(),
        TextColumn("{task.fields[title]}", markup=False),
        BarColumn(bar_width=24),
        TimeElapsedColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None, title=title)

        def show(message: str, fraction: float | None = None) -> None:
            message = printable(message)
            if fraction is None:
                bar.update(task, description=message)
            else:
                bar.update(task, description=message, completed=fraction, total=1.0)

        yield show


def say(text: str, **style: Any) -> None:
    """A line on stdout that the terminal obeys in nothing; further lines in it are indented."""
    click.secho(printable(text).replace("\n", "\n      "), **style)


def say_verdict(findings: Sequence[Question]) -> None:
    """The questions of a report and their answers, a line each."""
    for item in findings:
        say(f"  {item.answer.upper():6} {item.question} {item.detail}")


def where_report(folder: Path) -> str:
    """Where a result's page is, or how to get it."""
    page = folder / "report.html"
    if page.is_file():
        return f"report: {page}"
    return f"{folder} written; its report: fingerdesign view {shlex.quote(str(folder))} --open"


def number(value: float | None, digits: int = 2, factor: float = 1.0, none: str = "-") -> str:
    """A number in a table's cell, so many digits after the point."""
    return none if value is None else f"{factor * value:.{digits}f}"


def print_table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table on stdout, as wide as it needs where stdout is not a terminal."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(printable(title)), title_justify="left")
    for index, heading in enumerate(headings):
        table.add_column(Text(printable(heading)), justify="left" if index == 0 else "right")
    for row in rows:
        table.add_row(*(Text(printable(cell)) for cell in row))
    console = Console(file=sys.stdout)
    if not console.is_terminal:
        console.width = 200
    console.print(table)


def print_json(value: object) -> None:
    """Print ``value`` as JSON on stdout; NaN is refused, not written."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))
