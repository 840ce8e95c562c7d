"""One frame for the subcommands of ``fingerdesign bench``: options, progress, files, exit code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import as_json, print_json, print_table, progress, quiet

from fingerdesign.runtime.child import resolved

if TYPE_CHECKING:
    from fingerdesign_bench.check import Shown

Option = Callable[[Any], Any]
WORK: dict[str, str] = {}  # filled by ``subcommand``: what does the work of each
CHECKED = ("number", "target at most", "measured", "")


def show(found: Shown, folder: Path, name: str) -> int:
    """Write a result into the folder, print it, and return its exit code."""
    from fingerdesign_bench.machine import busy

    paths = found.write(folder, name)
    warning = busy(dict(found.machine))
    if warning and not quiet():
        click.echo(warning, err=True)
    if as_json():
        checks = [check.as_dict() for check in found.checks]
        print_json(checks if found.listed is None else found.listed)
    elif not quiet():
        for title, headings, cells in found.tables:
            if cells:
                print_table(title, headings, cells)
        for note in found.notes:
            click.echo(note)
        if found.title:
            print_table(found.title, CHECKED, [check.row() for check in found.checks])
        for line in (*paths, *found.after):
            click.echo(str(line))
    return found.code


def work_of(name: str) -> Callable[..., Shown]:
    """The function that does the work of a subcommand."""
    return resolved(f"fingerdesign_bench.{WORK[name]}")


def subcommand(
    work: str, short: str, *options: Option, quick: str = ""
) -> Callable[[Callable[[], None]], click.Command]:
    """Make a subcommand of a function that holds its name and help.

    work: MODULE:FUNCTION of this package, imported when it runs, so that ``--help`` is fast. It is
    called with the folder, a report of progress, and the values of ``options``, and returns what
    is shown. quick: the help of ``--quick``, where there is one.
    """

    def made(function: Callable[[], None]) -> click.Command:
        key = function.__name__
        name = key.replace("_", "-")

        def run(folder: Path, **given: Any) -> int:
            with progress(f"bench {name}", not as_json()) as report:
                found = work_of(key)(folder, report, **given)
            return show(found, folder, key)

        chosen = [click.option("--quick", is_flag=True, help=quick)] if quick else []
        for option in (output_options, *reversed([*chosen, *options, folder_option(name)])):
            option(run)
        WORK[key] = work
        return click.command(name, short_help=short, help=function.__doc__)(run)

    return made
