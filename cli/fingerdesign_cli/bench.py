"""``fingerdesign bench``: what the numbers of this project rest on, one subcommand each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign_cli.common import output_options, print_json, print_table, progress

if TYPE_CHECKING:
    from fingerdesign.bench.check import Check

_FOLDER = click.Path(file_okay=False, path_type=Path)


@click.group("bench")
def command() -> None:
    """Compare with known answers; measure speed and accuracy; repeat the searches."""


@command.command("paper-finger")
@click.option("--out", "folder", metavar="DIR", type=_FOLDER, required=True, help="Written here.")
@click.option("--count", default=384, show_default=True, type=click.IntRange(1, 100_000))
@click.option("--seed", default=2000, show_default=True, type=click.IntRange(0))
@click.option("--workers", default=2, show_default=True, type=click.IntRange(1, 64))
@output_options
def paper_finger(
    folder: Path, count: int, seed: int, workers: int, quiet: bool, as_json: bool
) -> None:
    """Search the dimensions that the paper does not give (minutes).

    On the finger that is kept, the gage area follows the stick area best, whatever the friction.
    Writes every candidate (CSV), a chart, and the winner with its scene (TOML): with the default
    --count and --seed the shipped designs/maeno2000.toml and designs/scenes/fundamental.toml.
    """
    from fingerdesign.bench.paper_finger import search, write
    from fingerdesign.study.paper_finger import FRICTIONS, Finding

    with progress("bench paper-finger", quiet or as_json) as tell:
        found = search(count, seed, workers, tell)
    paths = write(found, folder)

    def numbers(values: tuple[float, ...]) -> str:
        return " ".join(f"{value:.2f}" for value in values)

    def row(finding: Finding) -> list[str]:
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


@command.command("reference")
@click.option("--tetwild/--no-tetwild", default=True, show_default=True, help="Also by pytetwild.")
@output_options
def reference(tetwild: bool, quiet: bool, as_json: bool) -> int:
    """The cases whose answers two other finite-element codes agree on."""
    from fingerdesign.bench.reference import one_plate_checks, plane_strain_checks, three_d_checks

    with progress("bench reference", quiet or as_json) as tell:
        tell("plane strain")
        checks = [*plane_strain_checks(), *one_plate_checks()]
        for mesher in ("extrude", "tetwild") if tetwild else ("extrude",):
            tell(f"3-D, {mesher}")
            checks += three_d_checks(mesher)
    return _show("Against two other codes", checks, quiet, as_json)


@command.command("condensation")
@output_options
def condensation(quiet: bool, as_json: bool) -> int:
    """Condensed against full, and the price of condensing over factoring alone."""
    from fingerdesign.bench.condensation import condensation_checks

    with progress("bench condensation", quiet or as_json) as tell:
        tell("condensing")
        checks = condensation_checks()
    return _show("Condensation", checks, quiet, as_json)


@command.command("whole")
@click.option(
    "--fidelity",
    type=click.Choice(["plane-strain", "3d"]),
    multiple=True,
    default=("plane-strain", "3d"),
    show_default=True,
)
@output_options
def whole(fidelity: tuple[str, ...], quiet: bool, as_json: bool) -> int:
    """Seconds, memory and dofs of `analyse` on the reference finger, from cold caches."""
    from fingerdesign.bench.whole import whole_checks

    checks = []
    with progress("bench whole", quiet or as_json) as tell:
        for each in fidelity:
            tell(each)
            found, stages = whole_checks(each)
            checks += found
            tell(f"{each}: " + ", ".join(f"{name} {s:.1f} s" for name, s in stages.items() if s))
    return _show("A whole analysis, in a process of its own", checks, quiet, as_json)


def _show(title: str, checks: list[Check], quiet: bool, as_json: bool) -> int:
    if as_json:
        print_json([check.as_dict() for check in checks])
    elif not quiet:
        headings = ["number", "asked at most", "measured", ""]
        print_table(title, headings, [check.row() for check in checks])
    return 0 if all(check.holds for check in checks) else 1


@command.command("precision")
@click.option("--out", "folder", metavar="DIR", type=_FOLDER, required=True, help="Written here.")
@output_options
def precision(folder: Path, quiet: bool, as_json: bool) -> None:
    """Speed against accuracy: errors against seconds, plane strain and 3-D (minutes)."""
    from dataclasses import asdict

    from fingerdesign.bench.precision import measure_precision, write_precision

    with progress("bench precision", quiet or as_json) as tell:
        points = measure_precision(tell)
    paths = write_precision(points, folder)
    if as_json:
        print_json([asdict(point) for point in points])
    elif not quiet:
        headings = ["method", "facets mm", "dofs", "s", "F_n", "F_t", "stick", "gages"]
        rows = [
            [
                point.method,
                f"{point.size_mm:g}",
                str(point.dofs),
                f"{point.seconds:.2f}",
                f"{point.normal_force_error:.1e}",
                f"{point.tangential_force_error:.1e}",
                f"{point.stick_ratio_error:.1e}",
                f"{point.gage_error:.1e}",
            ]
            for point in points
        ]
        print_table("Errors against the finest mesh of the kind", headings, rows)
        for path in paths:
            click.echo(str(path))
