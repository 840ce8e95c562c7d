"""``fingerdesign bench fidelity``: the ladder of --fidelity auto against one model for all."""

from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options, workers_option
from fingerdesign_cli.terminal import print_table, progress

from fingerdesign_bench.cli.charts import say_busy, show_checks


@click.command("fidelity", short_help="Does --fidelity auto keep its tolerance? (20 min).")
@folder_option("fidelity")
@workers_option
@click.option(
    "--references",
    "anew",
    is_flag=True,
    help="Compute the references, into DIR, instead of taking shipped ones (hours).",
)
@output_options
def fidelity(folder: Path, workers: int | None, anew: bool, quiet: bool, as_json: bool) -> int:
    """Thirty seeded fingers and scenes with tolerances of 1 to 10 %: true errors and costs.

    Every rung of each is solved once; the ladder climbs on these, and each rung is also taken as
    the one model for all. True errors are against much finer models in space. Rungs are kept in DIR
    as they are solved; an interrupted run goes on. Exit code 1 where a number falls short of what
    was asked.
    """
    from fingerdesign_bench.fidelity.fidelity import measure_fidelity, rows, write_fidelity

    with progress("bench fidelity", quiet or as_json) as report:
        found = measure_fidelity(folder, report, workers or 1, anew=anew)
    say_busy(found.machine, quiet)
    paths = write_fidelity(found, folder)
    if not (quiet or as_json):
        headings = ["pair", "depth", "plates", "asked %", "chosen", "stated %", "true %"]
        headings += ["within %", "plane strain %", "s"]
        print_table("The ladder, pair by pair", headings, rows(found))
        each_model = [
            [each.name, f"{each.seconds:.0f}", f"{100 * each.within:.1f}", f"{each.meets}"]
            for each in found.fixed
        ]
        print_table("One model for all", ["model", "s", "readings within %", "pairs"], each_model)
    return show_checks("Fidelity", found.checks(), paths, quiet, as_json)


COMMANDS = (fidelity,)
