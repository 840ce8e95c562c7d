"""One frame for the subcommands of ``fingerdesign bench``: options, progress, files, exit code."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import as_json, print_json, print_table, progress, quiet

if TYPE_CHECKING:
    from fingerdesign_bench.check import Shown

Option = Callable[[Any], Any]
# Filled by ``subcommand``: the commands, and the functions that do their work by name.
COMMANDS: list[click.Command] = []
PARTS: dict[str, Callable[..., Shown]] = {}
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


def subcommand(
    short: str, *options: Option, quick: str = ""
) -> Callable[[Callable[..., Shown]], click.Command]:
    """Make a subcommand of a function that measures.

    The function is called with the folder, a report of progress, and the values of ``options``.
    quick: the help of ``--quick``, where there is one.
    """

    def made(function: Callable[..., Shown]) -> click.Command:
        name = function.__name__.replace("_", "-")

        def work(folder: Path, **given: Any) -> int:
            with progress(f"bench {name}", not as_json()) as report:
                found = function(folder, report, **given)
            return show(found, folder, function.__name__)

        chosen = [click.option("--quick", is_flag=True, help=quick)] if quick else []
        work.__doc__ = function.__doc__
        for option in (output_options, *reversed([*chosen, *options, folder_option(name)])):
            option(work)
        PARTS[name] = function
        COMMANDS.append(click.command(name, short_help=short)(work))
        return COMMANDS[-1]

    return made
