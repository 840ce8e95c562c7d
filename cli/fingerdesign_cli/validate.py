"""``fingerdesign validate``: what each modelling assumption costs for this finger, and saves."""

from dataclasses import dataclass
from pathlib import Path

import click

from fingerdesign.analysis.fidelity.readings import QUANTITIES
from fingerdesign.records.verdict import SIGNS
from fingerdesign.runtime.machine import usable_cores
from fingerdesign.validate.advice import NONE, spread_cell
from fingerdesign.validate.gages.record import FOLDER as GAGE_STUDY
from fingerdesign.validate.gages.record import Observability, write_observability
from fingerdesign.validate.gages.study import observe, refuse
from fingerdesign.validate.record import Row, Validation
from fingerdesign_cli.inputs import read_case, recorded
from fingerdesign_cli.options import Options
from fingerdesign_cli.terminal import WIDTH, number, print_table, say_marked, say_result


@dataclass(frozen=True)
class Assumptions(Options):
    """The assumptions to judge: all without ``keys``; deep: at finite strain in 3-D too."""

    deep: bool
    keys: tuple[str, ...]


@dataclass(frozen=True)
class Gages(Options):
    """The study of the gages; gages: it is requested. noise: microstrain; grips: to learn from."""

    gages: bool
    noise: float | None
    grips: int | None
    workers: int | None


def validate(
    design_file: Path,
    out: Path,
    scene_file: Path | None,
    assumptions: Assumptions,
    gages: Gages,
    fidelity: str,
) -> int:
    """Report what each modelling assumption costs for DESIGN in a scene, and what it saves."""
    if gages.gages:
        if scene_file is not None or assumptions.deep or assumptions.keys:
            raise click.UsageError("--gages takes no --scene, --deep and --only")
        return _validate_gages(design_file, out, gages, fidelity)
    if gages.noise is not None or gages.grips is not None:
        raise click.UsageError("--noise and --grips are for --gages alone")
    finger, scene = read_case(design_file, scene_file)
    from fingerdesign.validate.run import FOLDER, validate, write_validation

    target, stem = out / finger.design.name, "" if scene_file is None else scene_file.stem
    deep, keys = assumptions.deep, assumptions.keys
    with recorded(FOLDER, target) as (folder, show):
        found = validate(finger, scene, deep=deep, scene_name=stem, keys=keys, report=show)
        show("writing the report", 1.0)
        write_validation(found, folder)
    say_result(found.data, lambda: _show(found, target), target / "validate.html")
    if found.failure is not None:
        click.echo(f"{target.name}: {found.failure}", err=True)
    return 0 if found.status == "ok" else 1


def _show(found: Validation, folder: Path) -> None:
    if rows := [cells for row in found.assumptions if row.tested for cells in _cells(row)]:
        columns = ["assumption: at equal", "F_n %", "F_t %", "width %", "stick ratio", "gages %"]
        title = f"{found.design}, scene {found.scene}: greatest error over the path (median)"
        print_table(title, [*columns, "s", "better s", "saves"], rows, WIDTH)
    for row in found.assumptions:
        say_marked(SIGNS["note"], f"{row.title}: {row.advice}")
    click.echo(f"{found.seconds:.0f} s; report: {folder / 'validate.html'}")


def _cells(row: Row) -> list[list[str]]:
    found = []
    for name in ("equal_motion", "equal_force"):
        side = getattr(row, name)
        reported = [spread_cell(q, side.spread(q)) if side else NONE for q in QUANTITIES]
        title, costs = f"  {name.removeprefix('equal_')}", ["", "", ""]
        if name == "equal_motion":
            title = f"{row.title}: motion"
            values = ((row.seconds, 2), (row.better_seconds, 2), (row.saving, 1))
            costs = [number(value, digits, none=NONE) for value, digits in values]
        found.append([title, *reported, *costs])
    return found


def _validate_gages(design_file: Path, out: Path, options: Gages, fidelity: str) -> int:
    """Report how well DESIGN's gages determine the stick ratio, how few suffice and where."""
    noise = 0.5 if options.noise is None else options.noise
    grips = 600 if options.grips is None else options.grips
    design, _ = read_case(design_file)
    refuse(design, noise, grips)
    target = out / design.design.name
    with recorded(GAGE_STUDY, target) as (folder, show):
        workers = options.workers or usable_cores()
        found = observe(design, noise, grips, show, workers, fidelity)
        show("writing", 1.0)
        write_observability(found, folder)
    page = target / "observability.png"
    return say_result(found.data, lambda: _show_gages(found, target), page)


def _show_gages(found: Observability, folder: Path) -> None:
    rows = [
        [
            str(len(each.chosen)) if each.chosen else "0 (forces and moves)",
            f"{each.stick_error:.3f} ± {each.stick_std:.3f}",
            f"{each.friction_utilisation_error:.3f}",
            (", ".join(f"{x:g}" for x in found.places(each)) or "–")
            + (f" ({layout})" if (layout := found.layout(each)) else ""),
        ]
        for each in found.confirmed
    ]
    what = "errors (RMS) on other grips of the same finger"
    title = f"{found.design} at {found.noise:g} microstrain: {what}"
    print_table(title, ["gages", "stick ratio", "friction utilisation", "at x, mm"], rows, WIDTH)
    rows = [
        [
            f"{each.x_mm:g}",
            f"{each.response_microstrain_per_N:.3g}",
            str(each.rank),
            f"{each.unnoticed_stick_cost:+.3f}",
            f"{each.known_stick_cost:+.3f}",
        ]
        for each in sorted(found.gages, key=lambda gage: gage.x_mm)
    ]
    columns = ["gage at x, mm", "microstrain/N", "rank", "dead, unnoticed", "dead, known"]
    title = "each gage: rank 1 is removed last; the cost of its failure"
    print_table(title, columns, rows, WIDTH)
    for sentence in (*found.limits, *found.sentences):
        say_marked("", sentence)
    click.echo(f"{found.seconds:.0f} s; chart: {folder / 'observability.png'}")
