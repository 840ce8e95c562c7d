"""``fingerdesign study-control``: controllers over friction x weight x noise, on one design."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.trials.grid import ControlGrid
from fingerdesign.trials.page import findings
from fingerdesign_cli.common import (
    CONTROLLER_NAMES,
    controllers_option,
    cores,
    estimator_for,
    output_folder,
    output_options,
    print_json,
    print_table,
    progress,
    read_case,
    refuse_foreign,
)

if TYPE_CHECKING:
    from fingerdesign.control.metrics import Summary
    from fingerdesign.trials.grid import ControlGrid
    from fingerdesign.trials.record import ControlStudy

_FILE = click.Path(path_type=Path)


@click.command("study-control")
@click.argument("design_file", metavar="DESIGN", type=_FILE)
@click.option(
    "--out",
    required=True,
    type=_FILE,
    callback=output_folder,
    help="The record goes to OUT/NAME of the design.",
)
@controllers_option
@click.option(
    "--friction",
    "frictions",
    metavar="MU",
    type=float,
    multiple=True,
    help="Friction coefficient; may be given again. Without it ten from 0.2 to 0.8.",
)
@click.option(
    "--mass-g",
    "masses",
    metavar="G",
    type=float,
    multiple=True,
    help="The object's mass; may be given again. Without it ten from 100 to 1000 g.",
)
@click.option(
    "--noise",
    "noises",
    metavar="E",
    type=float,
    multiple=True,
    help="Standard deviation of a gage's sample, microstrain; may be given again. Without it 0, "
    "0.5, 1, 2, 5 and 10.",
)
@click.option("--quick", is_flag=True, help="4 frictions, 4 masses, 3 noises: seconds.")
@click.option("--no-tug", is_flag=True, help="Leave out the grips whose lifted object is tugged.")
@click.option("--seed", type=int, default=0, show_default=True, help="Of all noise.")
@click.option(
    "--estimator",
    "estimator_file",
    metavar="FILE",
    type=_FILE,
    help="For the regulator: what `fingerdesign teach` wrote for DESIGN. Without it one is taught "
    "first (minutes), or taken from the cache.",
)
@click.option(
    "--workers",
    type=click.IntRange(1, 256),
    help="Processes; without it as many as there are cores.",
)
@output_options
def command(
    design_file: Path,
    out: Path,
    controllers: tuple[str, ...],
    frictions: tuple[float, ...],
    masses: tuple[float, ...],
    noises: tuple[float, ...],
    quick: bool,
    no_tug: bool,
    seed: int,
    estimator_file: Path | None,
    workers: int | None,
    quiet: bool,
    as_json: bool,
) -> int:
    """Judge controllers on DESIGN over friction, weight and gage noise; in plane strain.

    Each lifts every object at every noise and, once, holds it against a tug. OUT/NAME then holds
    control.html (findings, tables, figures), control.json, grips.csv (every grip), control.png and
    path_*.csv (the grips that are drawn).

    What is done stands in OUT/NAME.unfinished.jsonl until the folder is there: an interrupted study
    goes on where it stopped. Exit code 0 also where objects are dropped or crushed: that is a
    finding.
    """
    design, _ = read_case(design_file)
    from fingerdesign.trials.run import (
        FOLDER,
        journal_beside,
        study_control,
        write_study,
    )

    name = design.design.name
    target = out / name
    grid = _grid(frictions, masses, noises, quick, no_tug, seed)
    grid.refuse()
    refuse_foreign(FOLDER, target)
    estimator = estimator_for(design, estimator_file)
    journal = journal_beside(target.absolute())
    with FOLDER.written(target) as folder, progress(name, quiet) as show:
        found = study_control(
            design,
            controllers or CONTROLLER_NAMES,
            grid,
            journal,
            estimator=estimator,
            workers=workers or cores(),
            tell=lambda message, fraction: show(message, fraction),
        )
        show("writing the report", 1.0)
        write_study(found, folder)
    journal.unlink(missing_ok=True)
    if as_json:
        print_json(found.data())
    elif not quiet:
        _show(found, target)
    return 0


def _grid(
    frictions: tuple[float, ...],
    masses: tuple[float, ...],
    noises: tuple[float, ...],
    quick: bool,
    no_tug: bool,
    seed: int,
) -> ControlGrid:
    from dataclasses import replace

    grid = ControlGrid.quick() if quick else ControlGrid()
    return replace(
        grid,
        frictions=frictions or grid.frictions,
        masses_g=masses or grid.masses_g,
        noises=noises or grid.noises,
        seed=seed,
        tug=None if no_tug else grid.tug,
    )


def _show(found: ControlStudy, folder: Path) -> None:
    noise, grid = found.trace_noise, found.grid
    summaries = {name: found.summary(name, noise) for name in found.controllers}
    grips = len(grid.frictions) * len(grid.masses_g)
    print_table(
        f"{found.design} at {noise:g} microstrain: grips: {grips}; success and held in %",
        ["controller", "success", "95 %", "held", "dropped", "crushed", "unlifted"],
        [_shares(name, told) for name, told in summaries.items()],
    )
    print_table(
        "medians; margin and peak: force over the least that holds",
        ["controller", "margin", "peak", "least stick", "slip, mm", "steps"],
        [_medians(name, told) for name, told in summaries.items()],
    )
    if grid.tug is not None:
        rate = found.hardware["sample_rate_Hz"]
        print_table(
            f"tugged with {100 * grid.tug.share:g} % of the weight: reactions in ms",
            ["controller", "held %", "answered", "median", "slowest"],
            [_answers(name, found.summary(name, tugged=True), rate) for name in found.controllers],
        )
    for each in findings(found.data()):
        click.echo(f"{each.question} {each.answer}: {each.words}")
    for warning in found.warnings:
        click.echo(f"mind: {warning}")
    click.echo(f"{found.seconds['whole']:.0f} s; report: {folder / 'control.html'}")


def _shares(name: str, told: Summary) -> list[str]:
    low, high = told.success.interval or (0.0, 1.0)
    return [
        name,
        _number(told.success.rate, 1, 100.0),
        f"{100 * low:.1f}–{100 * high:.1f}",
        _number(told.held.rate, 1, 100.0),
        *(str(count) for count in (told.dropped, told.crushed, told.not_lifted)),
    ]


def _medians(name: str, told: Summary) -> list[str]:
    spreads = (
        (told.margin_at_lift, 2),
        (told.peak_ratio, 2),
        (told.minimum_stick_ratio, 2),
        (told.slip_distance_mm, 3),
        (told.steps, 0),
    )
    return [name, *(_number(None if s is None else s.median, digits) for s, digits in spreads)]


def _answers(name: str, told: Summary, rate_hz: float) -> list[str]:
    reaction = told.reaction_steps
    times = (None, None) if reaction is None else (reaction.median, reaction.most)
    return [
        name,
        _number(told.held.rate, 1, 100.0),
        f"{told.answered.count} of {told.answered.of}",
        *(_number(each, 0, 1000.0 / rate_hz) for each in times),
    ]


def _number(value: float | None, decimals: int, factor: float = 1.0) -> str:
    return "–" if value is None else f"{factor * value:.{decimals}f}"
