"""``fingerdesign bench forecast``: the forecasts of `check` against whole analyses."""

from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import print_table, progress

from fingerdesign_bench.cli.charts import say_busy, show_checks


@click.command("forecast", short_help="Predicted dofs, memory, time, and what they were (15 min).")
@folder_option("forecast")
@click.option("--quick", is_flag=True, help="Three small ones: half a minute.")
@click.option("--random", type=click.IntRange(0), default=0, help="So many random fingers instead.")
@output_options
def forecast(folder: Path, quick: bool, random: int, quiet: bool, as_json: bool) -> int:
    """What `check` foretells of dofs, memory and time, against whole analyses.

    An interrupted run goes on where it stopped: run it again with the same --out.

    Each analysis runs in a process of its own, with an empty mesh cache. Its forecast is for the
    machine's speed as measured right before and after it, so that other work counts on both sides.
    Exit code 1 where a forecast is off by more than a factor of 2; of random fingers, where more
    than a tenth are.
    """
    from fingerdesign_bench.any_finger.forecast import measure_forecasts, rows, write_forecasts

    with progress("bench forecast", quiet or as_json) as report:
        found = measure_forecasts(folder, report, quick, random)
    say_busy(found.machine, quiet)
    paths = write_forecasts(found, folder)
    if not (quiet or as_json):
        headings = ["analysis", "dofs", "MB", "s", "factors", "GFLOP/s"]
        print_table("Forecast / measured", headings, rows(found.records))
    return show_checks("Forecasts", found.checks(), paths, quiet, as_json)


COMMANDS = (forecast,)
