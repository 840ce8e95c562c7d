"""The subcommands of ``fingerdesign bench``: each measures, writes, and returns what is printed.

Their modules are imported when they run, so that ``--help`` is fast.
"""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import click
from fingerdesign_cli.options import fidelity_option, workers_option

from fingerdesign.runtime.progress import Report
from fingerdesign_bench.cli.frame import COMMANDS, PARTS, Shown, subcommand

__all__ = ["COMMANDS", "PARTS"]
HALF_A_MINUTE = "Coarser and fewer: about half a minute or less."
_PEER_TITLES = {
    "condensed": "Condensed: Siconos and ours, an increment",
    "full": "Full: GetFEM and ours, on one mesh",
}


@subcommand(
    "Cases with known answers (4 min; --quick seconds).",
    click.option(
        "--problems", is_flag=True, help="Also write the contact problems, for other solvers."
    ),
    quick="The few that cost seconds.",
)
def suite(folder: Path, report: Report, quick: bool, problems: bool) -> Shown:
    """Analytic solutions, other codes' answers and our own, each with its source and tolerances.

    Hertz, Cattaneo-Mindlin, Spence, Lubkin, Carter, layers, patch tests, published cases, and rates
    in the size and in the increment: a page with pictures. Exit code 1 where one is missed, or is
    no longer what it was; misses that are known and explained are none.
    """
    from fingerdesign_bench.known.case import load_cases
    from fingerdesign_bench.known.run import HEADINGS, row, run_cases, write_suite

    found = run_cases([case for case in load_cases() if case.quick or not quick], report)
    return Shown(
        write_suite(found, folder, problems),
        tables=[("Cases with known answers", HEADINGS, [row(each) for each in found.outcomes])],
        record=[each.as_dict() for each in found.outcomes],
        fails=found.fails,
    )


@subcommand(
    "Is --fidelity auto within its tolerance? (20 min).",
    workers_option,
    click.option(
        "--references",
        "again",
        is_flag=True,
        help="Compute the references, into DIR, instead of taking shipped ones (hours).",
    ),
)
def fidelity(folder: Path, report: Report, workers: int | None, again: bool) -> Shown:
    """Thirty seeded fingers and scenes with tolerances of 1 to 10 %: true errors and costs.

    Every rung of each is solved once; the ladder climbs on these, and each rung is also taken as
    the one model for all. True errors are against much finer models in space. Rungs are stored in
    DIR when they are solved; an interrupted run goes on. Exit code 1 where a number misses its
    target.
    """
    from fingerdesign_bench.fidelity import fidelity as bench

    found = bench.measure_fidelity(folder, report, workers or 1, again=again)
    models = [
        [each.name, f"{each.seconds:.0f}", f"{100 * each.within:.1f}", f"{each.meets}"]
        for each in found.fixed
    ]
    tables = [
        ("The ladder, pair by pair", bench.HEADINGS, bench.rows(found)),
        ("One model for all", ["model", "s", "readings within %", "pairs"], models),
    ]
    paths = bench.write_fidelity(found, folder)
    return Shown(paths, "Fidelity", found.checks(), tables, machine=found.machine)


@subcommand(
    "Predicted and real dofs, memory, time (15 min).", quick="Three small ones: half a minute."
)
def forecast(folder: Path, report: Report, quick: bool) -> Shown:
    """Forecasts of `check` (dofs, memory, time) against whole analyses.

    An interrupted run goes on where it stopped: run it again with the same --out.

    Each analysis runs in a process of its own, with an empty mesh cache. Its forecast is for the
    machine's speed as measured right before and after it, so that other work counts on both sides.
    Exit code 1 where a forecast is off by more than a factor of 2.
    """
    from fingerdesign_bench.any_finger import forecast as bench

    found = bench.measure_forecasts(folder, report, quick)
    tables = [("Forecast / measured", bench.HEADINGS, bench.rows(found.records))]
    paths = bench.write_forecasts(found, folder)
    return Shown(paths, "Forecasts", found.checks(), tables, machine=found.machine)


@subcommand(
    "Molds of shipped and of 100 random designs (20 min).",
    click.option(
        "--seeds",
        default=100,
        show_default=True,
        type=click.IntRange(0, 10_000),
        help="How many random designs, besides the shipped ones.",
    ),
    workers_option,
)
def molds(folder: Path, report: Report, seeds: int, workers: int | None) -> Shown:
    """Make molds of every shipped design and of random ones of every kind.

    Each in a process of its own; the mold is deleted, its checks are stored. An interrupted run
    goes on where it stopped: the same DIR again. Exit code 1 where a number misses its target.
    """
    from fingerdesign.runtime.machine import usable_cores
    from fingerdesign_bench.any_finger import molds as bench

    found = bench.measure_molds(folder, report, seeds, workers or usable_cores())
    rows = [
        [kind, str(count), str(made), str(refused), f"{seconds:.1f}", f"{error:.1e}"]
        for kind, count, made, refused, seconds, error in bench.by_kind(found.records)
    ]
    headings = ["kind", "designs", "made", "refused", "median s", "volume error"]
    return Shown(
        bench.write_molds(found, folder),
        "Molds",
        found.checks(),
        [("Molds by kind", headings, rows)],
        [bench.words(each) for each in found.records if each["status"] != bench.MADE],
        machine=found.machine,
    )


@subcommand(
    "Where is plane strain right? The map (20 min).",
    click.option(
        "--study",
        type=click.Path(dir_okay=False, path_type=Path),
        help="A study file of your own instead of the shipped designs/studies/plane_strain.toml.",
    ),
    quick="The first two values of each parameter (1 min).",
)
def plane_strain(folder: Path, report: Report, quick: bool, study: Path | None) -> Shown:
    """Plane strain against 3-D over depth, contact width, Poisson's ratio and the plates' span.

    Errors of forces at equal motion, and of contact width, stick ratio and gage strains at equal
    motion and at equal force; the map with its contours; rules fitted to it. An interrupted run
    goes on where it stopped: the same DIR again. Exit code 1 where a number misses its target.
    """
    from fingerdesign_bench.plane_strain import judge as bench

    found = bench.measure_plane_strain(folder, report, quick, study)
    headings = ["error of", "span/depth", "rule", "off", "at worst"]
    rows = [rule.row() for rule in found.rules]
    tables = [("Rules fitted to the map; x = nu^2 / (1 - nu^2)", headings, rows)]
    return Shown(bench.write_plane_strain(found, folder), "Plane strain", found.checks, tables)


@subcommand("Errors against seconds, a line a method (15 min; --quick 3 min).", quick=HALF_A_MINUTE)
def precision(folder: Path, report: Report, quick: bool) -> Shown:
    """Errors against seconds, a line a method.

    Forces, stick ratio and gage strain. Four shipped fingers: tetrahedra by fTetWild, swept
    tetrahedra, prisms, plane strain. One small finger: P1, P2 and mixed elements; solid plates,
    sheets and none.
    """
    from fingerdesign_bench.speed import precision as bench
    from fingerdesign_bench.speed.precision_points import HEADINGS

    found = bench.measure_precision(report, quick)
    rows = [point.row() for point in found.points]
    return Shown(
        bench.write_precision(found, folder),
        tables=[("Errors against references of another kind", HEADINGS, rows)],
        notes=[remark for remarks in found.remarks.values() for remark in remarks],
        machine=found.machine,
        record=[asdict(point) for point in found.points],
    )


@subcommand("Seconds, memory, growth, against targets (4 min; --quick 20 s).", quick=HALF_A_MINUTE)
def speed(folder: Path, report: Report, quick: bool) -> Shown:
    """Seconds, memory and their growth, against targets; the cost of condensation."""
    from fingerdesign_bench.speed import speed as bench

    found = bench.measure_speed(report, quick)
    laws = [
        f"{law.kind}: {law.quantity} grows with {law.against}: power {law.exponent:.2f}"
        for law in found.laws
    ]
    paths = bench.write_speed(found, folder)
    return Shown(paths, "Speed", found.checks, after=laws, machine=found.machine)


@subcommand("A whole `analyse` from cold caches (1.5 min).", fidelity_option(None, unset="both"))
def whole(folder: Path, report: Report, fidelity: str | None) -> Shown:
    """Seconds, memory and dofs of `analyse`, from cold caches."""
    from fingerdesign_bench.files import write_json
    from fingerdesign_bench.machine import machine
    from fingerdesign_bench.speed.whole import whole_checks

    checks = []
    for each in (fidelity,) if fidelity else ("plane-strain", "3d"):
        report(each)
        found, stages = whole_checks(each)
        checks += found
        report(f"{each}: " + ", ".join(f"{name} {s:.1f} s" for name, s in stages.items() if s))
    record = {"machine": machine(), "checks": [check.as_dict() for check in checks]}
    path = write_json(folder / "whole.json", record)
    return Shown([path], "A whole analysis, in a process of its own", checks)


@subcommand("Hard cases through every method (3.5 min; --quick 5 s).", quick=HALF_A_MINUTE)
def stability(folder: Path, report: Report, quick: bool) -> Shown:
    """Hard cases through every method, judged and mapped."""
    from fingerdesign_bench.stability import stability as bench

    found = bench.measure_stability(report, quick)
    return Shown(bench.write_stability(found, folder), "Stability", found.checks())


@subcommand(
    "Siconos and GetFEM in the same run (20 min; --quick 1.5).",
    quick="Plane strain alone, fewer repeats.",
)
def peers(folder: Path, report: Report, quick: bool) -> Shown:
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
        return Shown(record={}, fails=True)
    begun = machine()
    rows = dict(zip(_PEER_TITLES, bench.measure_peers(installed, report, quick), strict=True))
    record = {"machine": begun, "installed": installed, **rows}
    tables = []
    for name, own in rows.items():
        headings = list(dict.fromkeys(key for row in own for key in row))
        cells = [[bench.cell(row.get(heading)) for heading in headings] for row in own]
        tables.append((_PEER_TITLES[name], headings, cells))
    paths = [write_json(folder / "peers.json", record)]
    return Shown(paths, tables=tables, machine=begun, record=record)
