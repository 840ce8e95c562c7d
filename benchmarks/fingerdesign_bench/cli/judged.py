"""The parts of ``fingerdesign bench`` that compare results with known answers and targets."""

from __future__ import annotations

from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options, workers_option
from fingerdesign_cli.terminal import print_json, print_table, progress

from fingerdesign_bench.cli.shared import name_files, show_checks, warn_busy


@click.command("suite", short_help="Cases with known answers (4 min; --quick seconds).")
@click.option("--quick", is_flag=True, help="The few that cost seconds.")
@click.option(
    "--problems", is_flag=True, help="Also write the contact problems, for other solvers."
)
@folder_option("suite")
@output_options
def suite(quick: bool, problems: bool, folder: Path, quiet: bool, as_json: bool) -> int:
    """Analytic solutions, other codes' answers and our own, each with its source and tolerances.

    Hertz, Cattaneo-Mindlin, Spence, Lubkin, Carter, layers, patch tests, published cases, and rates
    in the size and in the increment: a page with pictures. Exit code 1 where one is missed, or is
    no longer what it was; misses that are known and explained are none.
    """
    from fingerdesign_bench.known.case import load_cases
    from fingerdesign_bench.known.run import HEADINGS, row, run_cases, write_suite

    cases = [case for case in load_cases() if case.quick or not quick]
    with progress("bench suite", quiet or as_json) as report:
        found = run_cases(cases, report)
    paths = write_suite(found, folder, problems)
    if as_json:
        print_json([each.as_dict() for each in found.outcomes])
    elif not quiet:
        print_table("Cases with known answers", HEADINGS, [row(each) for each in found.outcomes])
        name_files(paths)
    return 1 if found.fails else 0


@click.command("fidelity", short_help="Is --fidelity auto within its tolerance? (20 min).")
@folder_option("fidelity")
@workers_option
@click.option(
    "--references",
    "again",
    is_flag=True,
    help="Compute the references, into DIR, instead of taking shipped ones (hours).",
)
@output_options
def fidelity(folder: Path, workers: int | None, again: bool, quiet: bool, as_json: bool) -> int:
    """Thirty seeded fingers and scenes with tolerances of 1 to 10 %: true errors and costs.

    Every rung of each is solved once; the ladder climbs on these, and each rung is also taken as
    the one model for all. True errors are against much finer models in space. Rungs are stored in
    DIR when they are solved; an interrupted run goes on. Exit code 1 where a number misses its
    target.
    """
    from fingerdesign_bench.fidelity.fidelity import measure_fidelity, rows, write_fidelity

    with progress("bench fidelity", quiet or as_json) as report:
        found = measure_fidelity(folder, report, workers or 1, again=again)
    warn_busy(found.machine, quiet)
    paths = write_fidelity(found, folder)
    if not (quiet or as_json):
        headings = ["pair", "depth", "plates", "target %", "chosen", "stated %", "true %"]
        headings += ["within %", "plane strain %", "s"]
        print_table("The ladder, pair by pair", headings, rows(found))
        each_model = [
            [each.name, f"{each.seconds:.0f}", f"{100 * each.within:.1f}", f"{each.meets}"]
            for each in found.fixed
        ]
        print_table("One model for all", ["model", "s", "readings within %", "pairs"], each_model)
    return show_checks("Fidelity", found.checks(), paths, quiet, as_json)


@click.command("forecast", short_help="Predicted and real dofs, memory, time (15 min).")
@folder_option("forecast")
@click.option("--quick", is_flag=True, help="Three small ones: half a minute.")
@output_options
def forecast(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """Forecasts of `check` (dofs, memory, time) against whole analyses.

    An interrupted run goes on where it stopped: run it again with the same --out.

    Each analysis runs in a process of its own, with an empty mesh cache. Its forecast is for the
    machine's speed as measured right before and after it, so that other work counts on both sides.
    Exit code 1 where a forecast is off by more than a factor of 2.
    """
    from fingerdesign_bench.any_finger.forecast import measure_forecasts, rows, write_forecasts

    with progress("bench forecast", quiet or as_json) as report:
        found = measure_forecasts(folder, report, quick)
    warn_busy(found.machine, quiet)
    paths = write_forecasts(found, folder)
    if not (quiet or as_json):
        headings = ["analysis", "dofs", "MB", "s", "factors", "GFLOP/s"]
        print_table("Forecast / measured", headings, rows(found.records))
    return show_checks("Forecasts", found.checks(), paths, quiet, as_json)


@click.command("molds", short_help="Molds of shipped and of 100 random designs (20 min).")
@folder_option("molds")
@click.option(
    "--seeds",
    default=100,
    show_default=True,
    type=click.IntRange(0, 10_000),
    help="How many random designs, besides the shipped ones.",
)
@workers_option
@output_options
def molds(folder: Path, seeds: int, workers: int | None, quiet: bool, as_json: bool) -> int:
    """Make molds of every shipped design and of random ones of every kind.

    Each in a process of its own; the mold is deleted, its checks are stored. An interrupted run
    goes on where it stopped: the same DIR again. Exit code 1 where a number misses its target.
    """
    from fingerdesign.runtime.machine import usable_cores
    from fingerdesign_bench.any_finger.molds import MADE, by_kind, measure_molds, words, write_molds

    with progress("bench molds", quiet or as_json) as report:
        found = measure_molds(folder, report, seeds, workers or usable_cores())
    warn_busy(found.machine, quiet)
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


@click.command("plane-strain", short_help="Where is plane strain right? The map (20 min).")
@folder_option("plane-strain")
@click.option(
    "--study",
    type=click.Path(dir_okay=False, path_type=Path),
    help="A study file of your own instead of the shipped designs/studies/plane_strain.toml.",
)
@click.option("--quick", is_flag=True, help="The first two values of each parameter (1 min).")
@output_options
def plane_strain(folder: Path, study: Path | None, quick: bool, quiet: bool, as_json: bool) -> int:
    """Plane strain against 3-D over depth, contact width, Poisson's ratio and the plates' span.

    Errors of forces at equal motion, and of contact width, stick ratio and gage strains at equal
    motion and at equal force; the map with its contours; rules fitted to it. An interrupted run
    goes on where it stopped: the same DIR again. Exit code 1 where a number misses its target.
    """
    from fingerdesign_bench.plane_strain.judge import measure_plane_strain, write_plane_strain

    with progress("bench plane-strain", quiet or as_json) as report:
        found = measure_plane_strain(folder, report, quick, study)
    paths = write_plane_strain(found, folder)
    if not (quiet or as_json):
        rows = [
            [
                rule.quantity.replace("_", " "),
                f"{rule.span:g}",
                f"{rule.factor:.3g} x^{rule.poisson:.2f} (a/H)^{rule.width:.2f} "
                f"/ (1 + {rule.depth:.2g} D/H)",
                f"{rule.typical:.1%}",
                f"{rule.off:.1%}",
            ]
            for rule in found.rules
        ]
        headings = ["error of", "span/depth", "rule", "off", "at worst"]
        print_table("Rules fitted to the map; x = nu^2 / (1 - nu^2)", headings, rows)
    return show_checks("Plane strain", found.checks, paths, quiet, as_json)


COMMANDS = (suite, fidelity, forecast, molds, plane_strain)
