"""The parts of ``fingerdesign bench`` that draw: precision, speed, stability."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click
from fingerdesign_cli.options import folder_option, output_options
from fingerdesign_cli.terminal import print_json, print_table, progress

if TYPE_CHECKING:
    from fingerdesign_bench.check import Check


quick_option = click.option(
    "--quick", is_flag=True, help="Coarser and fewer: about half a minute or less."
)


def show_checks(
    title: str, checks: Sequence[Check], paths: Sequence[Path], quiet: bool, as_json: bool
) -> int:
    """Print what was asked against what was measured; 1 where something falls short."""
    if as_json:
        print_json([check.as_dict() for check in checks])
    elif not quiet:
        headings = ["number", "asked at most", "measured", ""]
        print_table(title, headings, [check.row() for check in checks])
        name_files(paths)
    return 0 if all(check.holds for check in checks) else 1


def say_busy(machine: dict[str, Any], quiet: bool) -> None:
    """Warn on stderr where the machine was busy when measuring began."""
    from fingerdesign_bench.machine import busy

    warning = busy(machine)
    if warning and not quiet:
        click.echo(warning, err=True)


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

    with progress("bench precision", quiet or as_json) as report:
        found = measure_precision(report, quick)
    say_busy(found.machine, quiet)
    paths = write_precision(found, folder)
    if as_json:
        print_json([asdict(point) for point in found.points])
    elif not quiet:
        headings = ["chart", "method", "facets mm", "dofs", "s", "F_n", "F_t", "stick", "gages"]
        rows = [
            [
                point.chart,
                f"{point.line} ({point.group})",
                f"{point.size_mm:g}",
                str(point.dofs),
                f"{point.seconds:.2f}",
                *(
                    "failed" if error is None else f"{error:.1e}"
                    for error in (
                        point.normal_force_error,
                        point.tangential_force_error,
                        point.stick_ratio_error,
                        point.gage_error,
                    )
                ),
            ]
            for point in found.points
        ]
        print_table("Errors against references of another kind", headings, rows)
        for said in found.remarks.values():
            for remark in said:
                click.echo(remark)
        name_files(paths)


@click.command(
    "speed", short_help="Seconds, memory, growth, against what was asked (4 min; --quick 20 s)."
)
@folder_option("speed")
@quick_option
@output_options
def speed(folder: Path, quick: bool, quiet: bool, as_json: bool) -> int:
    """Seconds, memory and their growth, against what was asked."""
    from fingerdesign_bench.speed.growth import in_words
    from fingerdesign_bench.speed.speed import measure_speed, write_speed

    with progress("bench speed", quiet or as_json) as report:
        found = measure_speed(report, quick)
    say_busy(found.machine, quiet)
    paths = write_speed(found, folder)
    code = show_checks("Speed", found.checks, paths, quiet, as_json)
    if not (quiet or as_json):
        for law in found.laws:
            click.echo(f"{law.kind}: {law.quantity} grows with {law.against}: {in_words(law)}")
    return code


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


@click.command(
    "any-finger", short_help="200 random fingers meshed, 200 faults refused (30 min; --quick 1)."
)
@folder_option("any-finger")
@quick_option
@click.option("--count", type=click.IntRange(1, 10_000), help="How many of each, instead of 200.")
@output_options
def any_finger(folder: Path, quick: bool, count: int | None, quiet: bool, as_json: bool) -> int:
    """Random designs of every kind meshed by fTetWild, random faults refused.

    Two at a time, each in a process of its own. An interrupted run goes on where it stopped: the
    same DIR again. Exit code 1 where a number falls short of what was asked.
    """
    from fingerdesign_bench.any_finger.any_finger import (
        by_kind,
        measure_any_finger,
        write_any_finger,
    )

    with progress("bench any-finger", quiet or as_json) as report:
        found = measure_any_finger(folder, report, quick, count)
    paths = write_any_finger(found, folder)
    if not (quiet or as_json):
        rows = [
            [kind, str(all_), str(meshed), f"{seconds:.0f}", f"{least:.1f}"]
            for kind, all_, meshed, seconds, least in by_kind(found.records)
        ]
        headings = ["kind", "designs", "meshed", "median s", "least angle"]
        print_table("Random fingers by kind", headings, rows)
    return show_checks("Any finger", found.checks(), paths, quiet, as_json)


@click.command(
    "hexahedra", short_help="Tetrahedra or hexahedra for extruded fingers (4 min; --quick 30 s)."
)
@folder_option("hexahedra")
@quick_option
@output_options
def hexahedra(folder: Path, quick: bool, quiet: bool, as_json: bool) -> None:
    """Tetrahedra or hexahedra for extruded fingers: errors against arithmetic.

    One finger pressed and sheared, quadratic cells of both kinds, with pressures of their own and
    without.
    """
    from fingerdesign_bench.accuracy.hexahedra import measure_hexahedra, write_hexahedra

    with progress("bench hexahedra", quiet or as_json) as report:
        found = measure_hexahedra(report, quick)
    say_busy(found.machine, quiet)
    paths = write_hexahedra(found, folder)
    if as_json:
        print_json([asdict(point) for point in found.points])
    elif not quiet:
        headings = ["cells", "equations", "Gflop", "s", "forces", "stick", "gages"]
        rows = [
            [
                point.line,
                str(point.dofs),
                f"{point.gigaflop:.1f}",
                f"{point.assemble_s + point.condense_s:.1f}",
                *(f"{error:.1e}" for error in found.errors(point)),
            ]
            for point in found.points
        ]
        print_table("Errors against the finest mixed mesh of the other cell", headings, rows)
        name_files(paths)


def name_files(paths: Sequence[Path]) -> None:
    for path in paths:
        click.echo(str(path))


COMMANDS = (precision, speed, stability, any_finger, hexahedra)
