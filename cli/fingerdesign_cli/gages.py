"""``fingerdesign gages``: what a design's gages tell of the stick ratio, and how few suffice."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.sensing.observability import observe, refuse
from fingerdesign.sensing.page import FOLDER, write_observability
from fingerdesign.sensing.record import plain
from fingerdesign_cli.common import (
    output_folder,
    output_options,
    print_json,
    print_table,
    progress,
    read_case,
    refuse_foreign,
)

if TYPE_CHECKING:
    from fingerdesign.sensing.record import Observability

_FILE = click.Path(path_type=Path)


@click.command("gages")
@click.argument("design_file", metavar="DESIGN", type=_FILE)
@click.option(
    "--out",
    required=True,
    type=_FILE,
    callback=output_folder,
    help="The record goes to OUT/NAME of the design.",
)
@click.option(
    "--noise",
    type=float,
    default=0.5,
    show_default=True,
    help="Standard deviation of a gage's sample, microstrain.",
)
@click.option(
    "--grips",
    type=int,
    default=600,
    show_default=True,
    help="Grips to learn from; more tell finer differences.",
)
@click.option(
    "--workers", type=click.IntRange(1, 64), default=2, show_default=True, help="Processes."
)
@output_options
def command(
    design_file: Path,
    out: Path,
    noise: float,
    grips: int,
    workers: int,
    quiet: bool,
    as_json: bool,
) -> int:
    """Tell how well DESIGN's gages determine the stick ratio, how few suffice and where.

    OUT/NAME then holds observability.json (all numbers), counts.csv (error by number of gages),
    gages.csv (each gage: its rank, and what it costs dead) and observability.png. Errors are of
    learners on grips in plane strain that they were not taught on. A minute or two.
    """
    design, _ = read_case(design_file)
    refuse(design, noise, grips)
    name = design.design.name
    refuse_foreign(FOLDER, out / name)
    with FOLDER.written(out / name) as folder, progress(name, quiet) as show:
        found = observe(design, noise, grips, lambda message: show(message), workers)
        show("writing", 1.0)
        write_observability(found, folder)
    if as_json:
        print_json(found.data())
    elif not quiet:
        _show(found, out / name)
    return 0


def _show(found: Observability, folder: Path) -> None:
    rows = [
        [
            str(len(each.kept)) if each.kept else "0 (forces and moves)",
            f"{each.stick_error:.3f} ± {each.stick_spread:.3f}",
            f"{each.used_error:.3f}",
            ", ".join(f"{x:g}" for x in found.places(each)) or "–",
        ]
        for each in found.confirmed
    ]
    title = f"{found.design} at {found.noise:g} microstrain: errors (RMS) on grips not taught"
    print_table(title, ["gages", "stick ratio", "friction in use", "at x, mm"], rows)
    rows = [
        [
            f"{each.x_mm:g}",
            f"{each.response_microstrain_per_N:.3g}",
            str(each.rank),
            f"{each.untold_stick_cost:+.3f}",
            f"{each.told_stick_cost:+.3f}",
        ]
        for each in sorted(found.gages, key=lambda gage: gage.x_mm)
    ]
    columns = ["gage at x, mm", "microstrain/N", "rank", "dead, untold", "dead, told"]
    print_table("each gage: 1 is missed most; what its silence adds to the error", columns, rows)
    for each in found.floors:
        click.echo(
            f"at {each.normal_force_N:.3g} N no unbiased estimate from the gages knows the stick "
            f"ratio better than {plain(each.one_sample_stick_error)} from one sample, "
            f"{plain(each.window_stick_error)} from the estimator's whole window"
        )
    for sentence in found.sentences:
        click.echo(sentence)
    click.echo(f"{found.seconds:.0f} s; chart: {folder / 'observability.png'}")
