"""``fingerdesign tune``: every controller tuned alike, on grips that are not those of the study."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import click

from fingerdesign.records.folder import RecordFolder
from fingerdesign.trials.tuning_record import RECORD_FILE
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

_FILE = click.Path(path_type=Path)


@click.command("tune")
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
    "--noise",
    "noises",
    metavar="E",
    type=float,
    multiple=True,
    default=(0.5,),
    show_default=True,
    help="Standard deviation of a gage's sample in the tuning grips, microstrain; may be given "
    "again.",
)
@click.option("--seed", type=int, default=0, show_default=True, help="Of trials, grips and noise.")
@click.option(
    "--estimator",
    "estimator_file",
    metavar="FILE",
    type=_FILE,
    help="For the regulator: what `fingerdesign teach` wrote for DESIGN. Without it one is taught "
    "or taken from the cache.",
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
    noises: tuple[float, ...],
    seed: int,
    estimator_file: Path | None,
    workers: int | None,
    quiet: bool,
    as_json: bool,
) -> int:
    """Tune the controllers of DESIGN, each by the same procedure and the same number of grips.

    The grips have other frictions, masses and noise than those of study-control. OUT/NAME then
    holds tuning.json (every trial) and tuned.toml: DESIGN with the best values in its [grip] table,
    for `fingerdesign study-control`, whose grid gives other success rates than the grips tuned on.
    One to six minutes a controller.

    What is done stands in OUT/NAME.unfinished.jsonl until the folder is there: an interrupted run
    goes on in the middle of a round.
    """
    design, _ = read_case(design_file)
    from fingerdesign.trials.tune import DESIGN_FILE, tune_controllers, write_tuning

    name = design.design.name
    target = out / name
    journal = target.absolute().with_name(f"{name}.unfinished.jsonl")
    kind = RecordFolder("tuning", RECORD_FILE, (RECORD_FILE, DESIGN_FILE))
    refuse_foreign(kind, target)
    estimator = estimator_for(design, estimator_file)
    with kind.written(target) as folder, progress(name, quiet) as show:
        record = tune_controllers(
            design,
            controllers or CONTROLLER_NAMES,
            journal,
            estimator=estimator,
            noises=noises,
            seed=seed,
            workers=workers or cores(),
            tell=lambda message, fraction: show(message, fraction),
        )
        write_tuning(record, design, folder)
    journal.unlink(missing_ok=True)
    if as_json:
        print_json(record.data())
    elif not quiet:
        headings = ["controller", "success % (before)", "held %", "dropped", "crushed"]
        headings += ["not lifted", "peak (before)", "takes"]
        rows = [_row(name, found) for name, found in record.controllers.items()]
        print_table(f"{record.design}: tuned on {len(record.cells)} grips", headings, rows)
        click.echo("rates on other grips differ: judge the tuned design with study-control")
        click.echo(f"{record.seconds:.0f} s; tuned design: {target / DESIGN_FILE}")
    return 0


def _row(name: str, found: dict[str, Any]) -> list[str]:
    best, default = found["best"], found["default"]
    takes = (f"{key.removeprefix('grip.')} {value:g}" for key, value in best["values"].items())
    return [
        name,
        f"{100 * best['success_rate']:.1f} ({100 * default['success_rate']:.1f})",
        f"{100 * best['held_rate']:.1f}",
        *(f"{best[key]}" for key in ("dropped", "crushed", "not_lifted")),
        f"{_ratio(best['mean_peak_ratio'])} ({_ratio(default['mean_peak_ratio'])})",
        ", ".join(takes),
    ]


def _ratio(value: float | None) -> str:
    return "-" if value is None else f"{value:.2f}"
