"""``fingerdesign paper``: the figures of Maeno, Hiromitsu and Kawai 2000, remade."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.paper.remade import write_paper
from fingerdesign_cli.inputs import read_case
from fingerdesign_cli.terminal import print_json, print_table, progress

if TYPE_CHECKING:
    from fingerdesign.paper.claims import Remade


def paper(out: Path, design_file: Path, quiet: bool, as_json: bool) -> int:
    """Remake the paper's Figs 2, 3, 6, 7, 8, 10 and 12, and judge its words by them."""
    design, _ = read_case(design_file)
    with progress("paper", quiet) as show:
        from fingerdesign.paper.remade import remake

        found = remake(design, show)
        show("drawing", 0.93)
        files = write_paper(found, out)
    _report(found, files, quiet, as_json)
    return 0


def _report(found: Remade, files: list[Path], quiet: bool, as_json: bool) -> None:
    if as_json:
        from dataclasses import asdict

        print_json(
            {
                "design": found.design.design.name,
                "claims": [asdict(claim) for claim in found.claims],
                "files": [str(path) for path in files],
            }
        )
    elif not quiet:
        rows = [[claim.title, claim.where, claim.verdict] for claim in found.claims]
        name = found.design.design.name
        print_table(f"{name}: does the paper's word hold?", ["claim", "paper", "holds"], rows)
        click.echo(f"{found.seconds:.0f} s; page: {files[-1]}")
