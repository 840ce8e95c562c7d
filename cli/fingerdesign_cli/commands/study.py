"""Commands about many fingers: variants, studies, searches, comparisons."""

from __future__ import annotations

import click

from fingerdesign_cli.options import (
    FILE,
    command,
    out_option,
    output_options,
    scheduler_options,
    workers_option,
)

study_fidelity_option = click.option(
    "--fidelity",
    type=click.Choice(["plane-strain", "3d", "auto"]),
    help="Instead of study.fidelity: 3-D, or the cheapest model that keeps to study.tolerance.",
)


@command("generate", "Write a study's variants as files.")
@click.argument("study_file", metavar="STUDY", type=FILE)
@out_option("The variants go to OUT/NAME of the study.")
@click.option("--count", type=click.IntRange(min=1), help="Only the first COUNT variants.")
@click.option(
    "--only",
    metavar="N",
    type=click.IntRange(min=1),
    multiple=True,
    help="Only the variant of this number; may be given again.",
)
@click.option("--cad/--no-cad", default=True, show_default=True, help="Write STEP and STL too.")
@workers_option
@output_options
def generate() -> None:
    """Write the variants of STUDY, a TOML file or a shipped study: a folder each in OUT/NAME.

    It holds the variant's design as TOML, finger.step, and finger.stl (the outside), body.stl and
    plates.stl. variants.csv lists values and digests of designs; invalid.csv those that cannot
    exist, with the faults found (one that hides others is reported first). Run again, it makes what
    is missing.

    With --json a line of JSON a variant as it is done (number: the variant's; done: how many are),
    and a last one for the folder.

    Exit code 1 where the CAD of a variant fails, or no variant can exist.
    """


@command("search", "Analyse every variant of a study.")
@click.argument("study_file", metavar="STUDY", type=FILE)
@out_option("Outcomes, tables and report.html go to OUT/NAME of the study.")
@scheduler_options
@click.option("--retry", is_flag=True, help="Run again what failed: for time, memory, a crash.")
@study_fidelity_option
@output_options
def sweep() -> None:
    """Analyse every variant of STUDY, a TOML file or a shipped study, and compare them.

    Each variant is analysed in a process of its own under the study's [limits]: one that crashes,
    hangs or takes too much memory is a failure with its cause, and the rest goes on. What is done
    is kept at once, by content: interrupted or run again, a study computes only what is missing,
    and two studies share what they have in common.

    With --json a line of JSON an outcome as it comes (number: the variant's; done: how many are),
    and a last one for the folder. With --quiet one line where variants failed. Exit code 1 where no
    variant at all could be analysed.
    """


@command("search", "Search for better fingers; the best are confirmed in 3-D.")
@click.argument("study_file", metavar="STUDY", type=FILE)
@out_option("Outcomes, tables and report.html go to OUT/NAME of the study.")
@click.option(
    "--trials",
    type=click.IntRange(1, 100_000),
    help="How many trials in all; without it as many as the study's [optimise] says.",
)
@scheduler_options
@click.option("--retry", is_flag=True, help="Run again what failed for time, memory or a crash.")
@study_fidelity_option
@output_options
def optimise() -> None:
    """Search STUDY for fingers that are better in its [[objectives]], within its [constraints].

    Trials are drawn by Optuna and analysed at the study's fidelity; the best of the front, and the
    study's base as the reference, are then analysed in 3-D. OUT/NAME holds report.html (trials
    compared, what stood in 3-D, what each objective hangs on), study.json, outcomes.jsonl, tables.

    The trials stand in OUT/NAME.trials.jsonl, which stays: an interrupted search goes on there, and
    more --trials go on from those that are done. With --json a line of JSON an outcome as it comes
    (number: the trial's; done: how many are). With --quiet one line where trials failed.
    Exit code 1 where no trial at all could be analysed.
    """


@command("compare", "Which finger is better at what, on one page.")
@click.argument("results", metavar="RESULT...", nargs=-1, required=True, type=FILE)
@click.option("--out", required=True, type=FILE, help="The page, FILE.html.")
@click.option("--csv", "csv_file", metavar="FILE", type=FILE, help="Also a row a design as CSV.")
@click.option(
    "--json",
    "json_file",
    metavar="FILE",
    type=FILE,
    help="Also all outcomes, a line of JSON each; `-`: what is recommended, on stdout.",
)
@click.option(
    "--objective",
    "requested",
    metavar="METRIC[:min|max]",
    multiple=True,
    help="What a finger is wanted for, instead of the study's own; may be given again.",
)
@click.option("--name", default="", help="To head the page; without it that of the study.")
@click.option("--quiet", "-q", is_flag=True, help="Print only failures.")
def compare() -> None:
    """Compare the designs of every RESULT on one page that opens offline.

    A RESULT is what sweep or optimise wrote (OUT/NAME), a result of analyse, a folder of such
    folders, or a file of outcomes (outcomes.jsonl). The page recommends a finger and says why;
    its table sorts and filters, its chart shows the Pareto front, two designs stand side by side,
    failures are listed, and every number can be saved.

    Exit code 2 where a RESULT is none. Failed designs are shown with their causes: exit code 0.
    """
