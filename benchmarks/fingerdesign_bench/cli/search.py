"""``fingerdesign bench paper-finger``, ``grids``: gage areas that follow the stick area;
``slides``: what hands make of an object that grows heavier."""

from dataclasses import asdict
from pathlib import Path
from typing import Literal

import click
from fingerdesign_cli.options import fidelity_option, folder_option, output_options, workers_option
from fingerdesign_cli.terminal import print_json, print_table, progress


@click.command("paper-finger", short_help="Search the dimensions the paper leaves open (10 min).")
@folder_option("paper-finger")
@click.option("--count", default=384, show_default=True, type=click.IntRange(1, 100_000))
@click.option("--seed", default=2000, show_default=True, type=click.IntRange(0))
@workers_option
@output_options
def paper_finger(
    folder: Path, count: int, seed: int, workers: int | None, quiet: bool, as_json: bool
) -> None:
    """Search the dimensions that the paper does not give (minutes).

    On the finger that is kept, the gage area follows the stick area best, whatever the friction.
    Writes every candidate (CSV), a chart, and the winner with its scene (TOML). The shipped
    designs/maeno2000.toml won this search with quadratic elements; with the mixed ones of today
    its score on the fine mesh (0.946) is next to the winner's (0.948).
    """
    from fingerdesign.runtime.machine import usable_cores
    from fingerdesign_bench.studies.paper_finger import FRICTIONS, Analysed
    from fingerdesign_bench.studies.paper_finger_bench import search, write

    with progress("bench paper-finger", quiet or as_json) as report:
        found = search(count, seed, workers or usable_cores(), report)
    paths = write(found, folder)

    def numbers(values: tuple[float, ...]) -> str:
        return " ".join(f"{value:.2f}" for value in values)

    def row(finding: Analysed) -> list[str]:
        given = [f"{value:g}" for value in finding.candidate.values.values()]
        measured = [finding.signal, finding.normal_force, finding.pitches, finding.score]
        return [
            str(finding.candidate.number),
            *given,
            f"{finding.candidate.approach:g}",
            *(f"{value:.2f}" for value in measured),
            numbers(finding.fine),
            numbers(finding.steps),
            numbers(finding.growing),
        ]

    if as_json:
        print_json(
            {
                "candidates": len(found.candidates),
                "analysed": len(found.findings),
                "refused": dict(found.refusals),
                "winner": {**found.winner.candidate.values, "rows_mm": found.winner.rows},
                "score": found.winner.score,
                "files": [str(path) for path in paths],
            }
        )
    elif not quiet:
        headings = ["no.", "R", "width", "base", "plate", "cover", "pitch", "gage", "approach"]
        headings += ["signal", "F_n", "pitches", "score", "refined", "8 steps", "growing"]
        title = "The ten best on the fine mesh: lengths in mm, signal in microstrain/N, F_n in N;\n"
        title += f"rank correlations at friction {', '.join(f'{mu:g}' for mu in FRICTIONS)}"
        print_table(title, headings, [row(finding) for finding in found.finalists])
        left_out = ", ".join(f"{n} {why}" for why, n in found.refusals.most_common())
        click.echo(f"{len(found.findings)} of {count} candidates analysed; left out: {left_out}")
        for path in paths:
            click.echo(str(path))


@click.command("grids", short_help="Single gages and tees in 3-D, over 32 points (3 min).")
@click.argument("designs", nargs=-1)
@click.option(
    "--mesher",
    default="extrude",
    show_default=True,
    type=click.Choice(["extrude", "tetwild", "plane-strain"]),
    help="plane-strain: what one section says instead.",
)
@click.option("--contact-mm", default=0.4, show_default=True, type=click.FloatRange(0.05, 2.0))
@click.option("--layers", default=5, show_default=True, type=click.IntRange(1, 40))
@click.option("--pieces", default=4, show_default=True, type=click.IntRange(1, 64))
@click.option(
    "--chart",
    metavar="FILE.png",
    type=click.Path(dir_okay=False, path_type=Path),
    help="Draw the gage area beside what sticks, written here.",
)
@output_options
def grids(
    designs: tuple[str, ...],
    mesher: str,
    contact_mm: float,
    layers: int,
    pieces: int,
    chart: Path | None,
    quiet: bool,
    as_json: bool,
) -> None:
    """Rank correlation of the gage area with the stick area in 3-D, by grids of the gages.

    Over the fundamental case, each row cut into --pieces, at five friction coefficients; and the
    area in mm at full stick, as the last spot gives way, and while all slips (at those five, the
    least of the first, the greatest of the others). DESIGNS are files or shipped names; without
    them maeno2000, as it is and with shorter plates nearer to the surface.
    """
    from fingerdesign_bench.studies.grids import FRICTIONS, fingers, measure_grids
    from fingerdesign_bench.studies.grids_chart import draw_grids

    with progress("bench grids", quiet or as_json) as report:
        found = measure_grids(fingers(designs), mesher, contact_mm, layers, report, pieces)
    if chart is not None:
        draw_grids(found, chart)
    if as_json:
        print_json({"frictions": FRICTIONS, "rows": [asdict(row) for row in found]})
    elif not quiet:

        def most(areas: tuple[float | None, ...]) -> str:
            known = [area for area in areas if area is not None]
            return f"{max(known):.1f}" if len(known) == len(areas) else "-"

        headings = ["finger", "grid", *(f"mu {mu:g}" for mu in FRICTIONS), "A mm"]
        headings += ["sticks", "gives way", "slips", "dofs", "s"]
        cells = [
            [
                row.finger,
                row.grid,
                *("-" if value is None else f"{value:.2f}" for value in row.correlations),
                f"{row.least_mm:.1f}-{row.greatest_mm:.1f}",
                f"{min(row.full_stick_mm):.1f}",
                most(row.giving_way_mm),
                most(row.slipping_mm),
                str(row.dofs),
                f"{row.seconds:.0f}",
            ]
            for row in found
        ]
        title = f"Rank correlation of gage area A and stick area, {8 * pieces} points; A in mm"
        print_table(title, headings, cells)


@click.command("slides", short_help="A weight that grows: held, caught, dropped? (half a minute).")
@click.argument("design", default="sensitive")
@click.option("--controller", "controllers", multiple=True, help="Repeat it for more.")
@click.option("--friction", "frictions", multiple=True, type=click.FloatRange(0.01, 5.0))
@click.option("--share", "shares", multiple=True, type=click.FloatRange(0.0, 10.0))
@fidelity_option("plane-strain")
@output_options
def slides(
    design: str,
    controllers: tuple[str, ...],
    frictions: tuple[float, ...],
    shares: tuple[float, ...],
    fidelity: Literal["plane-strain", "3d"],
    quiet: bool,
    as_json: bool,
) -> None:
    """A hanging object's weight grows at once by a share of it; it slides, is caught, or drops.

    DESIGN is a file or a shipped name. Without options a reactive hand and one of a fixed ratio, at
    friction 0.3 and 0.6, and 30 and 60 % more weight.
    """
    from fingerdesign.checks.starter import find_design
    from fingerdesign_bench.studies.slides import CONTROLLERS, FRICTIONS, SHARES, measure_slides

    with progress("bench slides", quiet or as_json) as report:
        found = measure_slides(
            find_design(design),
            controllers or CONTROLLERS,
            frictions or FRICTIONS,
            shares or SHARES,
            fidelity,
            report,
        )
    if as_json:
        print_json({"rows": [asdict(row) for row in found]})
    elif not quiet:
        headings = ["controller", "friction", "heavier %", "margin", "outcome", "slid mm"]
        headings += ["catch ms", "swings Hz"]
        cells = [
            [
                row.controller,
                f"{row.friction_coefficient:g}",
                f"{100 * row.share:g}",
                "-" if row.safety_margin is None else f"{row.safety_margin:.2f}",
                row.outcome,
                f"{row.slid_mm:.2f}",
                "-" if row.catch_s is None else f"{1e3 * row.catch_s:.0f}",
                "-" if row.swing_Hz is None else f"{row.swing_Hz:.0f}",
            ]
            for row in found
        ]
        print_table(f"{design}: what becomes of an object that grows heavier", headings, cells)


COMMANDS = (paper_finger, grids, slides)
