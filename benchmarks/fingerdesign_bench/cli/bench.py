"""``fingerdesign bench``: measurements of speed, accuracy and stability, one subcommand each.

Without a subcommand it measures precision, speed and stability.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import click
from click.core import ParameterSource
from fingerdesign_cli.options import Group, folder_option, output_options
from fingerdesign_cli.terminal import as_json, progress, quiet

from fingerdesign.errors import FingerDesignError
from fingerdesign.runtime.progress import Report
from fingerdesign_bench.cli import commands
from fingerdesign_bench.cli.frame import show, work_of

if TYPE_CHECKING:
    from fingerdesign_bench.check import Check, Shown

PARTS = ("precision", "speed", "stability")


class BenchGroup(Group):
    """A group whose options have the names of its subcommands' options."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Take options in front of the subcommand alone."""
        return click.Group.parse_args(self, ctx, args)


@click.group(
    "bench",
    cls=BenchGroup,
    short_help="Compare with known answers; speed and accuracy.",
    invoke_without_command=True,
)
@folder_option("bench")
@click.option("--quick", is_flag=True, help="Coarser and fewer: about a minute in all.")
@output_options
@click.pass_context
def command(context: click.Context, folder: Path, quick: bool) -> int | None:
    """Compare with known answers; measure speed, accuracy and stability.

    `fingerdesign bench` alone runs precision, speed and stability, not the other subcommands (about
    14 minutes on two quiet cores, one with --quick), and writes their charts and tables, the
    machine and the versions (bench.json). Each subcommand does its part alone. Times mean
    something on a quiet machine only; a busy one is named. Exit code 1 where a number misses its
    target.
    """
    if context.invoked_subcommand is not None:
        given = context.get_parameter_source("folder") is not ParameterSource.DEFAULT
        if given or quick or quiet() or as_json():
            raise click.UsageError(
                f"options come after the subcommand: fingerdesign bench "
                f"{context.invoked_subcommand} --out DIR"
            )
        return None
    with progress("bench", not as_json()) as report:
        found, failures = run_parts(folder, report, quick, {name: work_of(name) for name in PARTS})
    code = show(found, folder, "bench")
    for part, why in failures.items():
        click.echo(f"{part} failed: {why}", err=True)
    return code


def run_parts(
    folder: Path,
    report: Report,
    quick: bool,
    parts: Mapping[str, Callable[[Path, Report, bool], Shown]],
) -> tuple[Shown, dict[str, str]]:
    """Run every part; return the result of all, and why parts failed.

    A part that fails does not keep the others from running.
    """
    from fingerdesign_bench.check import Shown
    from fingerdesign_bench.machine import machine

    begun, paths, seconds = machine(), list[Path](), dict[str, float]()
    failures = dict[str, str]()
    checks: list[Check] = []
    for name, part in parts.items():
        start = time.perf_counter()
        try:
            found = part(folder, _named(report, name), quick)
            paths += found.write(folder, name)
            checks += found.checks
        except FingerDesignError as error:
            failures[name] = str(error)
        seconds[name] = round(time.perf_counter() - start, 1)
    record = {"quick": quick, "seconds": seconds, "failures": failures}
    record["files"] = [path.name for path in paths]
    return Shown("Targets", checks, begun, record, paths=paths, fails=bool(failures)), failures


def _named(report: Report, name: str) -> Report:
    return lambda message: report(f"{name}: {message}")


for _each in vars(commands).values():
    if isinstance(_each, click.Command):
        command.add_command(_each)
