"""``fingerdesign mold``: what a finger is cast in, as files that can be made, checked;
``fingerdesign tolerance``: the spread of fingers as they are cast."""

import textwrap
from collections.abc import Collection
from dataclasses import asdict, dataclass
from pathlib import Path

import click

from fingerdesign.mold.make import FOLDER, older_passed, write_mold
from fingerdesign.mold.part import axis_name
from fingerdesign.mold.products.hours import hours_words
from fingerdesign.mold.products.notes import cautions_of
from fingerdesign.mold.profile import with_profile
from fingerdesign.mold.record import MoldData, PartData
from fingerdesign.mold.tables import made_words, words
from fingerdesign.records.base import plain
from fingerdesign.records.verdict import SIGNS
from fingerdesign.runtime.machine import usable_cores
from fingerdesign_cli import terminal
from fingerdesign_cli.inputs import folders_above, interrupted, read_case, recorded, refuse_foreign
from fingerdesign_cli.options import Options

_SHOWN = 10  # failing checks that are shown one by one


@dataclass(frozen=True)
class Instead(Options):
    """Values that replace those of the design's [mold] table."""

    process: str | None
    plate_fixture: str | None


def mold(design_file: Path, out: Path, profile: Path | None, instead: Instead) -> int:
    """Make the mold that DESIGN is cast in."""
    design, _ = read_case(design_file)
    name = design.design.name
    if profile is not None:
        design = with_profile(design, profile)
        if instead.process not in (None, design.mold.process):
            words = f"warning: --process {instead.process} with the limits of {profile}"
            click.echo(words, err=True)
    given = {key: value for key, value in asdict(instead).items() if value is not None}
    design = design.model_copy(update={"mold": design.mold.model_copy(update=given)})
    refuse_foreign(FOLDER, out / name)
    passed = older_passed(out / name)
    nothing = interrupted("nothing of the mold is stored")
    with nothing, folders_above(out / name), terminal.progress(name) as show:
        report = write_mold(design, out / name, show)
    page, general = out / name / "report.html", cautions_of(design)
    terminal.say_result(lambda: report, lambda: _show(report, out / name, general), page)
    if report["failure"] is None:
        return 0
    for line in (report["failure"], *_failed(report)):
        click.echo(f"{name}: {line}", err=True)
    if passed:
        click.echo(f"{name}: it replaces an older mold that had passed its checks", err=True)
    return 1


def tolerance(
    design_file: Path,
    out: Path,
    scene_file: Path | None,
    fidelity: str,
    within: float | None,
    workers: int | None,
) -> int:
    """Report the spread of fingers that are cast as DESIGN."""
    design, scene = read_case(design_file, scene_file)
    from fingerdesign.tolerance.cast import Draws
    from fingerdesign.tolerance.page import FOLDER, view_of, write_tolerance
    from fingerdesign.tolerance.spread import tolerance

    target = out / design.design.name
    stem = scene_file.stem if scene_file is not None else ""
    draws = None if within is None else Draws(0.01 * within, workers or usable_cores())
    with recorded(FOLDER, target) as (folder, show):
        with interrupted("nothing of the tolerances is stored"):
            found = tolerance(design, scene, fidelity, show, stem, draws)
        write_tolerance(found, folder)
    page = target / "report.html"
    return terminal.say_result(
        lambda: plain(found), lambda: terminal.say_block(view_of(found), target), page
    )


def _failed(report: MoldData) -> list[str]:
    """A sentence a failing check, the first ones."""
    checks = [check for check in report["checks"] if not check["ok"]][:_SHOWN]
    parts = [f" ({check['part']})" if check["part"] else "" for check in checks]
    return [
        f"{check['name']}{part}: {check['sentence']}"
        for check, part in zip(checks, parts, strict=True)
    ]


def _show(report: MoldData, folder: Path, general: Collection[str]) -> None:
    if report["parts"]:
        columns, made = ["part", "made", "size, mm", "cm³", "drawn"], made_words(report)
        columns += ["triangles"] if terminal.details() else []
        rows = [_cells(part, made[part["made"]]) for part in report["parts"]]
        terminal.print_table(f"{report['design']}: parts of its mold", columns, rows)
    for plate in report["plates"]:
        click.echo(
            f"{plate['name']}: {plate['count']} of {plate['thickness_mm']:g} mm "
            f"{plate['material'].replace('_', ' ')}, {plate['width_mm']:.3f} x "
            f"{plate['length_mm']:.3f} mm with legs"
        )
    _show_facts(report, general)
    terminal.say(_summary(report), bold=True)
    for line in report["sensor"]["fix"]:
        terminal.say(f"  fix  {line}")
    click.echo(f"{report['seconds']:.0f} s; report: {folder / 'report.html'}")


def _show_facts(report: MoldData, general: Collection[str]) -> None:
    """Print silicone, placement, warnings, leads and hours."""
    if report["silicone"] is not None:
        terminal.say_marked("", report["silicone"]["sentence"])
    if report["placement"] is not None:
        for sentence in report["placement"]["sentences"][:2]:  # All together, and the spread.
            terminal.say_marked("", sentence)
    for warning in report["warnings"]:
        if terminal.details() or warning not in general:
            terminal.say_marked(SIGNS["warning"], warning)
    if report["leads"] is not None and report["leads"]["reason"] is None:
        terminal.say_marked("", report["leads"]["sentences"][0])
    if report["hours"]:
        terminal.say_marked("", f"hands-on: {hours_words(report['hours'])}")


def _summary(report: MoldData) -> str:
    """Say if the finger can be cast, and if it then is a sensor; wrapped as other lines."""
    good = sum(check["ok"] for check in report["checks"])
    reasons = report["sensor"]["reasons"]
    sign = SIGNS["fail" if report["failure"] else "pass"]
    cast = f"{sign} {'castable' if not report['failure'] else 'not castable'}"
    sensor = f"{SIGNS['fail']} {'; '.join(reasons)}" if reasons else SIGNS["pass"]
    summary = f"mold {cast}, {good} of {len(report['checks'])} checks · sensor {sensor}"
    return textwrap.fill(
        summary, terminal.WIDTH - 6, break_long_words=False, break_on_hyphens=False
    )


def _cells(part: PartData, made: str) -> list[str]:
    size = " x ".join(f"{value:.1f}" for value in part["size_mm"])
    draw = "stays" if part["draw"] is None else axis_name(part["draw"])
    volume = f"{1e-3 * part['volume_mm3']:.2f}"
    triangles = [f"{part['triangles']:,}"] if terminal.details() else []
    return [words(part["name"]), made, size, volume, draw, *triangles]
