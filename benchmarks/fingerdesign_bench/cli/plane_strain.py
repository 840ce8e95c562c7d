"""``fingerdesign bench plane-strain``: where plane strain holds, as a study."""

from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import print_table, progress

from fingerdesign_bench.cli.charts import show_checks


@click.command(
    "plane-strain", short_help="Where does plane strain hold? The map (20 min; --quick 1)."
)
@folder_option("plane-strain")
@click.option(
    "--study",
    type=click.Path(dir_okay=False, path_type=Path),
    help="A study file of your own instead of the shipped designs/studies/plane_strain.toml.",
)
@click.option("--quick", is_flag=True, help="The first two values of each parameter, no more.")
@output_options
def plane_strain(folder: Path, study: Path | None, quick: bool, quiet: bool, as_json: bool) -> int:
    """Plane strain against 3-D over depth, contact width, Poisson's ratio and the plates' span.

    Errors of forces at equal motion, and of contact width, stick ratio and gage strains at equal
    motion and at equal force; the map with its contours; rules fitted to it. An interrupted run
    goes on where it stopped: the same DIR again. Exit code 1 where a number falls short of what
    was asked.
    """
    from fingerdesign_bench.studies.plane_strain_bench import (
        measure_plane_strain,
        write_plane_strain,
    )

    with progress("bench plane-strain", quiet or as_json) as report:
        found = measure_plane_strain(folder, report, quick, study)
    paths = write_plane_strain(found, folder)
    if not quiet:
        for note in found.notes:
            click.echo(f"note: {note}", err=True)
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


COMMANDS = (plane_strain,)
