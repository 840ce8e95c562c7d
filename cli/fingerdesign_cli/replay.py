"""``fingerdesign replay``: a grip recorded on a rig, put before a controller."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.control.roster import needs_training
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.folder import RecordFolder
from fingerdesign.trials.replay import replay_trace
from fingerdesign_cli.common import (
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
    from fingerdesign.trials.replay import Replay

_FILE = click.Path(path_type=Path)


@click.command("replay")
@click.argument("design_file", metavar="DESIGN", type=_FILE)
@click.argument("trace_file", metavar="TRACE", type=_FILE)
@click.option(
    "--out",
    required=True,
    type=_FILE,
    callback=output_folder,
    help="Files go to OUT/NAME of the design.",
)
@click.option("--controller", metavar="NAME", help="Instead of grip.controller.")
@click.option(
    "--estimator",
    "estimator_file",
    type=_FILE,
    help="An estimator taught on DESIGN (JSON): tells the stick ratio; the regulator needs it.",
)
@output_options
def command(
    design_file: Path,
    trace_file: Path,
    out: Path,
    controller: str | None,
    estimator_file: Path | None,
    quiet: bool,
    as_json: bool,
) -> int:
    """Ask a controller along a grip recorded on a rig with the finger DESIGN.

    TRACE is a CSV file: time_s, dx_mm, dy_mm, normal_force_N, tangential_force_N, gage_1, ... (in
    microstrain), and lifted (0 or 1) if the hand sees it; a row a sample. OUT/NAME/replay.csv tells
    what the controller asks for at each. A trace with gaps, NaN, other units or too few gages is
    refused by row and column.
    """
    design, _ = read_case(design_file)
    name = design.design.name
    kind = RecordFolder("replay", "replay.json", ("replay.json", "replay.csv"))
    refuse_foreign(kind, out / name)
    estimator = estimator_for(design, estimator_file)
    chosen = controller or design.grip.controller
    if estimator is None and needs_training(chosen):
        _refuse_untaught(chosen, design_file)
    with kind.written(out / name) as folder, progress(name, quiet) as show:
        found = replay_trace(design, trace_file, chosen, estimator, show)
        record = json.dumps(found.record(), indent=1, allow_nan=False) + "\n"
        (folder / "replay.json").write_text(record, encoding="utf-8")
        (folder / "replay.csv").write_text(found.table(), encoding="utf-8")
    if as_json:
        print_json(found.record())
    elif not quiet:
        _show(found, out / name)
    return 0


def _refuse_untaught(name: str, design_file: Path) -> None:
    bound = "a controller that needs no estimator, where none is given"
    remedy = f"give --estimator FILE (fingerdesign teach {design_file})"
    raise DesignError([Fault("--controller", name, bound, remedy)])


def _show(found: Replay, folder: Path) -> None:
    record = found.record()

    def number(key: str) -> str:
        return "-" if record[key] is None else f"{record[key]:.3g}"

    rows = [
        ["closing, mm", number("closed_mm"), number("asked_closing_mm")],
        ["shear, mm", number("sheared_mm"), number("asked_shear_mm")],
    ]
    title = f"{found.design}, rows {record['first_row']} to {record['last_row']} of {found.trace}"
    print_table(title, ["", "the rig", found.controller], rows)
    click.echo(f"holds: {found.holds}")
    if record["least_stick_ratio_told"] is not None:
        least, most = number("least_stick_ratio_told"), number("most_friction_used_told")
        click.echo(f"told: stick ratio down to {least}, friction used up to {most}")
    click.echo(f"row by row: {folder / 'replay.csv'}")
