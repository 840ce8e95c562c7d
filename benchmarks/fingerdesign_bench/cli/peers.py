"""``fingerdesign bench peers``: Siconos and GetFEM beside us in the same run."""

import json
from pathlib import Path

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import print_json, print_table, progress

from fingerdesign_bench.cli.charts import say_busy

_TITLES = {
    "condensed": "Condensed: Siconos beside ours, an increment",
    "full": "Full: GetFEM beside ours, on one mesh",
    "finite": "Finite strain: GetFEM beside ours, on one mesh",
}


@click.command("peers", short_help="Siconos and GetFEM beside us (20 min; --quick 1.5 min).")
@folder_option("peers")
@click.option("--quick", is_flag=True, help="Plane strain alone, fewer repeats.")
@output_options
def peers(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """Siconos on our condensed problems, GetFEM on our meshes: times, ratios, differences.

    They must be installed for /usr/bin/python3 (Debian: python3-siconos, python3-getfem); what is
    missing is named and left out. Exit code 1 where neither is there.
    """
    from fingerdesign_bench.machine import machine
    from fingerdesign_bench.speed import peers as bench
    from fingerdesign_bench.speed.peers_finite import finite_row

    installed = bench.installed()
    for line in bench.missing(installed):
        click.echo(line, err=True)
    if not installed:
        return 1
    begun = machine()
    with progress("bench peers", quiet or as_json) as report:
        condensed, full = bench.measure_peers(installed, report, quick)
        report("full, finite strain")
        finite = [finite_row()] if "getfem" in installed and not quick else []
    say_busy(begun, quiet)
    tables = {"condensed": condensed, "full": full, "finite": finite}
    record = {"machine": begun, "installed": installed, **tables}
    if as_json:
        print_json(record)
    for name, rows in tables.items():
        if rows and not (quiet or as_json):
            longest = max(rows, key=len)  # what always failed has no times
            headings = list(longest)
            cells = [[_cell(row.get(heading)) for heading in headings] for row in rows]
            print_table(_TITLES[name], headings, cells)
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "peers.json"
    path.write_text(json.dumps(record, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    if not (quiet or as_json):
        click.echo(str(path))
    return 0


def _cell(value: float | str | None) -> str:
    return value if isinstance(value, str) else "-" if value is None else f"{value:.3g}"


COMMANDS = (peers,)
