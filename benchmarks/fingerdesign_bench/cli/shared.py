"""Options and output that the subcommands of ``fingerdesign bench`` share."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from fingerdesign_cli.terminal import print_json, print_table

if TYPE_CHECKING:
    from fingerdesign_bench.check import Check

quick_option = click.option(
    "--quick", is_flag=True, help="Coarser and fewer: about half a minute or less."
)


def show_checks(
    title: str, checks: Sequence[Check], paths: Sequence[Path], quiet: bool, as_json: bool
) -> int:
    """Print targets and measured values; return 1 where a value misses its target."""
    if as_json:
        print_json([check.as_dict() for check in checks])
    elif not quiet:
        headings = ["number", "target at most", "measured", ""]
        print_table(title, headings, [check.row() for check in checks])
        name_files(paths)
    return 0 if all(check.holds for check in checks) else 1


def warn_busy(machine: dict[str, Any], quiet: bool) -> None:
    """Warn on stderr where the machine was busy when measuring began."""
    from fingerdesign_bench.machine import busy

    warning = busy(machine)
    if warning and not quiet:
        click.echo(warning, err=True)


def name_files(paths: Sequence[Path]) -> None:
    for path in paths:
        click.echo(str(path))
