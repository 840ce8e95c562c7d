"""``fingerdesign paper``: the figures of Maeno, Hiromitsu and Kawai 2000, remade."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click
from fingerdesign_cli.options import FILE, folder_option, open_option, output_options
from fingerdesign_cli.terminal import as_json, open_page, print_json, print_table, progress, quiet

if TYPE_CHECKING:
    from fingerdesign_bench.paper.claims import Remade


@click.command("paper", short_help="Remake every figure of the paper.")
@folder_option("paper")
@click.option(
    "--design",
    "design_file",
    metavar="DESIGN",
    type=FILE,
    default="maeno2000",
    show_default=True,
    help="With this finger: a file, or a shipped design's name.",
)
@open_option
@output_options
def command(folder: Path, design_file: Path) -> None:
    """Remake the paper's Figs 2, 3, 6, 7, 8, 10 and 12, and judge its words by them.

    OUT then holds paper.html (the paper's words next to what was measured), each figure as PNG and
    SVG with its data as CSV, and paper.json. In plane strain, under a minute. Exit code 0 also
    where a claim of the paper does not hold: that is a finding.
    """
    from fingerdesign_cli.inputs import read_case, refuse_in_the_way

    from fingerdesign_bench.paper.remade import PAGE_FILE, RECORD_FILE, remake, write_paper

    design, _ = read_case(design_file)
    refuse_in_the_way([folder / PAGE_FILE], folder / RECORD_FILE)
    with progress("paper") as show:
        found = remake(design, show)
        show("drawing", 0.93)
        files = write_paper(found, folder)
    _report(found, files)
    open_page(files[-1])


def _report(found: Remade, files: list[Path]) -> None:
    if as_json():
        from dataclasses import asdict

        print_json(
            {
                "design": found.design.design.name,
                "claims": [asdict(claim) for claim in found.claims],
                "files": [str(path) for path in files],
            }
        )
    elif not quiet():
        rows = [[claim.title, claim.where, claim.verdict] for claim in found.claims]
        name = found.design.design.name
        print_table(f"{name}: does the paper's word hold?", ["claim", "paper", "holds"], rows)
        click.echo(f"{found.seconds:.0f} s; page: {files[-1]}")
