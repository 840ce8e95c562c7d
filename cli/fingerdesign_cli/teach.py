"""``fingerdesign teach``: an estimator of the stick ratio for a design's gages, for a rig too."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.records.folder import RecordFolder
from fingerdesign_cli.common import (
    output_folder,
    output_options,
    print_json,
    print_table,
    progress,
    read_case,
    refuse_foreign,
)

if TYPE_CHECKING:
    from fingerdesign.sensing.teach import Lesson

_FILE = click.Path(path_type=Path)


def _finite(_context: click.Context, parameter: click.Parameter, value: float) -> float:
    """NaN passes any range of click's."""
    if not math.isfinite(value):
        raise click.BadParameter(f"{value} is not a finite number", param=parameter)
    return value


@click.command("teach")
@click.argument("design_file", metavar="DESIGN", type=_FILE)
@click.option(
    "--out",
    required=True,
    type=_FILE,
    callback=output_folder,
    help="Files go to OUT/NAME of the design.",
)
@click.option(
    "--noise",
    type=click.FloatRange(0.0, 1e3),
    callback=_finite,
    default=0.5,
    show_default=True,
    help="Of a sample of your gages, microstrain: written into the file.",
)
@click.option(
    "--workers", type=click.IntRange(1, 64), default=2, show_default=True, help="Processes."
)
@output_options
def command(
    design_file: Path, out: Path, noise: float, workers: int, quiet: bool, as_json: bool
) -> int:
    """Teach the estimator that the regulator grips by, on DESIGN's own model.

    OUT/NAME/estimator.json runs on a rig with numpy alone (fingerdesign.control.estimator);
    lesson.json tells its errors on grips that it was not taught on. Minutes the first time; what
    has been taught is kept, and changes of the [grip] table's controllers teach nothing anew.
    """
    design, _ = read_case(design_file)
    from fingerdesign.sensing.lessons import at_noise, lesson_for, lesson_text

    name = design.design.name
    kind = RecordFolder("lesson", "lesson.json", ("lesson.json", "estimator.json"))
    refuse_foreign(kind, out / name)
    with kind.written(out / name) as folder, progress(name, quiet) as show:
        lesson = lesson_for(design, tell=lambda told: show(told, 0.0), workers=workers)
        lesson = at_noise(lesson, noise)
        record = {k: v for k, v in json.loads(lesson_text(lesson)).items() if k != "estimator"}
        (folder / "estimator.json").write_text(lesson.estimator.to_json(), encoding="utf-8")
        (folder / "lesson.json").write_text(json.dumps(record, indent=1) + "\n", encoding="utf-8")
        show("writing", 1.0)
    if as_json:
        print_json({"design": name, **record})
    elif not quiet:
        _show(lesson, name, out / name)
    return 0


def _show(lesson: Lesson, name: str, folder: Path) -> None:
    rows = [
        [f"{noise:g}", f"{stick:.3f}", f"{used:.3f}"]
        for noise, stick, used in zip(
            lesson.noises, lesson.stick_errors, lesson.used_errors, strict=True
        )
    ]
    columns = ["noise, microstrain", "stick ratio", "friction in use"]
    print_table(f"{name}: errors (RMS) on grips that were not taught", columns, rows)
    click.echo(f"{lesson.samples} samples were taught; {folder / 'estimator.json'} is for a rig")
