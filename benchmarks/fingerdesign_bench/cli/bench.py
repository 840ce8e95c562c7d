"""``fingerdesign bench``: measurements of speed, accuracy and stability, one subcommand each.

Without a subcommand it measures precision, speed and stability.
"""

from pathlib import Path

import click
from click.core import ParameterSource
from fingerdesign_cli.options import Group, folder_option, output_options
from fingerdesign_cli.terminal import progress

from fingerdesign_bench.cli import judged, measured
from fingerdesign_bench.cli.shared import show_checks, warn_busy


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
def command(
    context: click.Context, folder: Path, quick: bool, quiet: bool, as_json: bool
) -> int | None:
    """Compare with known answers; measure speed, accuracy and stability.

    `fingerdesign bench` alone runs precision, speed and stability, not the other subcommands (about
    14 minutes on two quiet cores, one with --quick), and writes their charts and tables, the
    machine and the versions (bench.json). Each subcommand does its part alone. Times mean
    something on a quiet machine only; a busy one is named. Exit code 1 where a number misses its
    target.
    """
    if context.invoked_subcommand is not None:
        given = context.get_parameter_source("folder") is not ParameterSource.DEFAULT
        if given or quick or quiet or as_json:
            raise click.UsageError(
                f"options come after the subcommand: fingerdesign bench "
                f"{context.invoked_subcommand} --out DIR"
            )
        return None
    from fingerdesign_bench.suite import run_suite

    with progress("bench", quiet or as_json) as report:
        found = run_suite(folder, report, quick)
    warn_busy(found.machine, quiet)
    code = show_checks("Targets", list(found.checks), found.paths, quiet, as_json)
    for part, why in found.failures.items():
        click.echo(f"{part} failed: {why}", err=True)
    return 1 if found.failures else code


for _each in (*judged.COMMANDS, *measured.COMMANDS):
    command.add_command(_each)
