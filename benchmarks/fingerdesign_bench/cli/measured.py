"""The parts of ``fingerdesign bench`` that measure speed and accuracy."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click
from fingerdesign_cli.options import fidelity_option, folder_option, output_options
from fingerdesign_cli.terminal import print_json, print_table, progress

from fingerdesign_bench.cli.shared import name_files, quick_option, show_checks, warn_busy


@click.command(
    "precision", short_help="Errors against seconds, a line a method (6 min; --quick 35 s)."
)
@folder_option("precision")
@quick_option
@output_options
def precision(folder: Path, quick: bool, quiet: bool, as_json: bool) -> None:
    """Errors against seconds, a line a method.

    Forces, stick ratio and gage strain of one finger: P1, P2 and mixed elements; plane strain and
    3-D; extruded and by fTetWild; condensed and solved in full; solid plates, sheets and none.
    """
    from fingerdesign_bench.speed.precision import measure_precision, write_precision
    from fingerdesign_bench.speed.precision_points import HEADINGS

    with progress("bench precision", quiet or as_json) as report:
        found = measure_precision(report, quick)
    warn_busy(found.machine, quiet)
    paths = write_precision(found, folder)
    if as_json:
        print_json([asdict(point) for point in found.points])
    elif not quiet:
        rows = [point.row() for point in found.points]
        print_table("Errors against references of another kind", HEADINGS, rows)
        for remarks in found.remarks.values():
            for remark in remarks:
                click.echo(remark)
        name_files(paths)


@click.command(
    "speed", short_help="Seconds, memory, growth, against targets (4 min; --quick 20 s)."
)
@folder_option("speed")
@quick_option
@output_options
def speed(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """Seconds, memory and their growth, against targets; the cost of condensation."""
    from fingerdesign_bench.speed.speed import measure_speed, write_speed

    with progress("bench speed", quiet or as_json) as report:
        found = measure_speed(report, quick)
    warn_busy(found.machine, quiet)
    paths = write_speed(found, folder)
    code = show_checks("Speed", found.checks, paths, quiet, as_json)
    if not (quiet or as_json):
        for law in found.laws:
            grows = f"{law.kind}: {law.quantity} grows with {law.against}"
            click.echo(f"{grows}: power {law.exponent:.2f}")
    return code


@click.command("whole", short_help="A whole `analyse` from cold caches (1.5 min).")
@fidelity_option(None, unset="both")
@folder_option("whole")
@output_options
def whole(fidelity: str | None, folder: Path, quiet: bool, as_json: bool) -> int:
    """Seconds, memory and dofs of `analyse`, from cold caches."""
    from fingerdesign_bench.files import write_json
    from fingerdesign_bench.machine import machine
    from fingerdesign_bench.speed.whole import whole_checks

    checks = []
    with progress("bench whole", quiet or as_json) as report:
        for each in (fidelity,) if fidelity else ("plane-strain", "3d"):
            report(each)
            found, stages = whole_checks(each)
            checks += found
            report(f"{each}: " + ", ".join(f"{name} {s:.1f} s" for name, s in stages.items() if s))
    record = {"machine": machine(), "checks": [check.as_dict() for check in checks]}
    path = write_json(folder / "whole.json", record)
    title = "A whole analysis, in a process of its own"
    return show_checks(title, checks, [path], quiet, as_json)


@click.command("stability", short_help="Hard cases through every method (3.5 min; --quick 5 s).")
@folder_option("stability")
@quick_option
@output_options
def stability(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """Hard cases through every method, judged and mapped."""
    from fingerdesign_bench.stability.stability import measure_stability, write_stability

    with progress("bench stability", quiet or as_json) as report:
        found = measure_stability(report, quick)
    paths = write_stability(found, folder)
    return show_checks("Stability", found.checks(), paths, quiet, as_json)


_PEER_TITLES = {
    "condensed": "Condensed: Siconos and ours, an increment",
    "full": "Full: GetFEM and ours, on one mesh",
}


@click.command("peers", short_help="Siconos and GetFEM in the same run (20 min; --quick 1.5).")
@folder_option("peers")
@click.option("--quick", is_flag=True, help="Plane strain alone, fewer repeats.")
@output_options
def peers(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """Siconos on our condensed problems, GetFEM on our meshes: times, ratios, differences.

    They must be installed for /usr/bin/python3 (Debian: python3-siconos, python3-getfem); what is
    missing is named and left out. Exit code 1 where neither is there.
    """
    from fingerdesign_bench.files import write_json
    from fingerdesign_bench.machine import machine
    from fingerdesign_bench.speed import peers as bench

    installed = bench.installed()
    for line in bench.missing(installed):
        click.echo(line, err=True)
    if not installed:
        return 1
    begun = machine()
    with progress("bench peers", quiet or as_json) as report:
        condensed, full = bench.measure_peers(installed, report, quick)
    warn_busy(begun, quiet)
    tables = {"condensed": condensed, "full": full}
    record = {"machine": begun, "installed": installed, **tables}
    if as_json:
        print_json(record)
    for name, rows in tables.items():
        if rows and not (quiet or as_json):
            headings = list(dict.fromkeys(key for row in rows for key in row))
            cells = [[_cell(row.get(heading)) for heading in headings] for row in rows]
            print_table(_PEER_TITLES[name], headings, cells)
    path = write_json(folder / "peers.json", record)
    if not (quiet or as_json):
        click.echo(str(path))
    return 0


def _cell(value: float | str | None) -> str:
    return value if isinstance(value, str) else "-" if value is None else f"{value:.3g}"


COMMANDS = (precision, speed, whole, stability, peers)
