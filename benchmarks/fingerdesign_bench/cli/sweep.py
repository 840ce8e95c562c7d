"""``fingerdesign bench sweep``: a study's variants an hour on one worker and on two."""

from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import progress

from fingerdesign_bench.cli.charts import say_busy, show_checks


@click.command("sweep", short_help="200 variants on 1 worker and on 2 (6 min; --quick 40 s).")
@folder_option("sweep")
@click.option("--quick", is_flag=True, help="8 variants: starting up is most of it.")
@output_options
def sweep(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """How many plane-strain variants with grips are analysed in an hour, and what one costs.

    The shipped study of fingers on one worker process and on two, in one run, each time with an
    empty store, from the start of the workers to the last outcome. Exit code 1 where a number falls
    short of what was asked; it means something on a quiet machine with two cores only.
    """
    from fingerdesign_bench.speed.throughput import measure_throughput, write_throughput

    with progress("bench sweep", quiet or as_json) as report:
        found = measure_throughput(report, quick)
    say_busy(found.machine, quiet)
    paths = write_throughput(found, folder)
    if not quiet and not as_json:
        for run in found.runs:
            click.echo(
                f"{run.workers} at a time: {run.analysed} of {run.variants} analysed in "
                f"{run.seconds:.0f} s, {run.an_hour:.0f} an hour, "
                f"{run.mean_core_s:.2f} s of core time each"
            )
        click.echo(f"throughput: {found.ratio:.2f} times")
    return show_checks("Throughput", found.checks(), paths, quiet, as_json)


COMMANDS = (sweep,)
