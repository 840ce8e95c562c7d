"""``fingerdesign bench molds``: molds of every shipped design and of random ones."""

from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options, workers_option
from fingerdesign_cli.terminal import print_table, progress

from fingerdesign_bench.cli.charts import say_busy, show_checks


@click.command("molds", short_help="Molds of shipped and of 100 random designs (20 min).")
@folder_option("molds")
@click.option(
    "--seeds",
    default=100,
    show_default=True,
    type=click.IntRange(0, 10_000),
    help="How many random designs, beside the shipped ones.",
)
@workers_option
@output_options
def molds(folder: Path, seeds: int, workers: int | None, quiet: bool, as_json: bool) -> int:
    """Make molds of every shipped design and of random ones of every kind.

    Each in a process of its own; what is made is thrown away, what was checked is
    kept. An interrupted run goes on where it stopped: the same DIR again. Exit code 1 where a
    number falls short of what was asked.
    """
    from fingerdesign.runtime.machine import usable_cores
    from fingerdesign_bench.any_finger.molds import MADE, by_kind, measure_molds, words, write_molds

    with progress("bench molds", quiet or as_json) as report:
        found = measure_molds(folder, report, seeds, workers or usable_cores())
    say_busy(found.machine, quiet)
    paths = write_molds(found, folder)
    if not (quiet or as_json):
        rows = [
            [kind, str(all_), str(made), str(refused), f"{seconds:.1f}", f"{error:.1e}"]
            for kind, all_, made, refused, seconds, error in by_kind(found.records)
        ]
        headings = ["kind", "designs", "made", "refused", "median s", "volume error"]
        print_table("Molds by kind", headings, rows)
        for each in found.records:
            if each["status"] != MADE:
                click.echo(words(each))
    return show_checks("Molds", found.checks(), paths, quiet, as_json)


COMMANDS = (molds,)
