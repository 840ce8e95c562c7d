"""One frame for the subcommands of ``fingerdesign bench``: options, progress, tables, exit code."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import as_json, print_json, print_table, progress, quiet

if TYPE_CHECKING:
    from fingerdesign_bench.check import Check

Option = Callable[[Any], Any]
# A title, headings and rows of cells.
Table = tuple[str, Sequence[str], Sequence[Sequence[str]]]
# Filled by ``subcommand``: the commands, and the functions that do their work by name.
COMMANDS: list[click.Command] = []
PARTS: dict[str, Callable[..., Any]] = {}
CHECKED = ("number", "target at most", "measured", "")


@dataclass(frozen=True)
class Shown:
    """The result of a subcommand, as it is printed.

    tables and notes (lines) come before the checks, ``after`` (lines) follows the files. machine:
    as it was when measuring began. record: printed by ``--json`` instead of the checks. fails: for
    another reason than a check.
    """

    paths: Sequence[Path] = ()
    title: str = ""
    checks: Sequence[Check] = ()
    tables: Sequence[Table] = ()
    notes: Sequence[str] = ()
    after: Sequence[str] = ()
    machine: dict[str, Any] = field(default_factory=dict)
    record: object = None
    fails: bool = False

    def show(self) -> int:
        """Print all of it; return 1 where it fails or a value misses its target."""
        from fingerdesign_bench.machine import busy

        warning = busy(self.machine)
        if warning and not quiet():
            click.echo(warning, err=True)
        if as_json():
            checks = [check.as_dict() for check in self.checks]
            print_json(checks if self.record is None else self.record)
        elif not quiet():
            self._print()
        return 0 if not self.fails and all(check.holds for check in self.checks) else 1

    def _print(self) -> None:
        rows = [check.row() for check in self.checks]
        for title, headings, cells in self.tables:
            if cells:
                print_table(title, headings, cells)
        for note in self.notes:
            click.echo(note)
        if self.title:
            print_table(self.title, CHECKED, rows)
        for line in (*self.paths, *self.after):
            click.echo(str(line))


def subcommand(
    short: str, *options: Option, quick: str = ""
) -> Callable[[Callable[..., Shown]], click.Command]:
    """Make a subcommand of a function that measures and writes into a folder.

    The function is called with the folder, a report of progress, and the values of ``options``.
    quick: the help of ``--quick``, where there is one.
    """

    def made(function: Callable[..., Shown]) -> click.Command:
        name = function.__name__.replace("_", "-")

        def work(folder: Path, **given: Any) -> int:
            with progress(f"bench {name}", not as_json()) as report:
                found = function(folder, report, **given)
            return found.show()

        chosen = [click.option("--quick", is_flag=True, help=quick)] if quick else []
        work.__doc__ = function.__doc__
        for option in (output_options, *reversed([*chosen, *options, folder_option(name)])):
            option(work)
        PARTS[name] = function
        COMMANDS.append(click.command(name, short_help=short)(work))
        return COMMANDS[-1]

    return made
