"""``fingerdesign bench compare``: the comparison page of 500 designs in a real browser."""

from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import progress

from fingerdesign_bench.cli.charts import say_busy, show_checks


@click.command("compare", short_help="The page of 500 designs: size, opening, sorting (1 min).")
@folder_option("compare")
@click.option("--quick", is_flag=True, help="50 designs, opened once: seconds.")
@output_options
def compare(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """How large the comparison page of 500 made-up designs is, how fast it opens and sorts.

    In headless Chromium, which must be installed, five fresh browsers a page. Times by the clock,
    and in processor time of the page's main thread, which a busy machine leaves as it is. Exit code
    1 where a number falls short of what was asked.
    """
    from fingerdesign_bench.any_finger.comparison import measure_comparison, write_comparison

    with progress("bench compare", quiet or as_json) as report:
        found = measure_comparison(report, quick)
    say_busy(found.machine, quiet)
    paths = write_comparison(found, folder)
    return show_checks("The comparison page", found.checks(), paths, quiet, as_json)


COMMANDS = (compare,)
