"""``fingerdesign validate``: what each modelling assumption costs for this finger, and saves."""

from pathlib import Path

import click

from fingerdesign.analysis.fidelity.readings import QUANTITIES
from fingerdesign.validate.advice import NONE, spread_cell
from fingerdesign.validate.record import Row, Validation
from fingerdesign_cli.inputs import read_case, recorded
from fingerdesign_cli.terminal import number, open_page, print_json, print_table


def validate(
    design_file: Path,
    out: Path,
    scene_file: Path | None,
    deep: bool,
    keys: tuple[str, ...],
    quiet: bool,
    as_json: bool,
) -> int:
    """Tell what each modelling assumption costs for DESIGN in a scene, and what it saves."""
    finger, scene = read_case(design_file, scene_file)
    from fingerdesign.validate.run import FOLDER, validate, write_validation

    name = finger.design.name
    with recorded(FOLDER, out / name, quiet) as (folder, show):
        found = validate(
            finger,
            scene,
            deep=deep,
            scene_name=scene_file.stem if scene_file is not None else "",
            keys=keys,
            report=show,
        )
        show("writing the report", 1.0)
        write_validation(found, folder)
    if as_json:
        print_json(found.data())
    elif not quiet:
        _show(found, out / name)
    open_page(out / name / "validate.html")
    if found.failure is not None:
        click.echo(f"{name}: {found.failure}", err=True)
    return 0 if found.status == "ok" else 1


def _show(found: Validation, folder: Path) -> None:
    columns = ["assumption", "at equal", "F_n %", "F_t %", "width %", "stick ratio", "gages %"]
    columns += ["s", "better s", "saves"]
    rows = [cells for row in found.assumptions if row.tested for cells in _cells(row)]
    if rows:
        title = f"{found.design}, scene {found.scene}: greatest error over the path (median)"
        print_table(title, columns, rows)
    for row in found.assumptions:
        click.echo(f"{row.title}: {row.advice}")
    click.echo(f"{found.seconds:.0f} s; report: {folder / 'validate.html'}")


def _cells(row: Row) -> list[list[str]]:
    found = []
    for name in ("equal_motion", "equal_force"):
        side = getattr(row, name)
        reported = [spread_cell(q, side.spread(q)) if side else NONE for q in QUANTITIES]
        values = ((row.seconds, 2), (row.better_seconds, 2), (row.saving, 1))
        costs = [number(value, digits, none=NONE) for value, digits in values]
        first = name == "equal_motion"
        title = row.title if first else ""
        at = name.removeprefix("equal_")
        found.append([title, at, *reported, *(costs if first else [""] * len(costs))])
    return found
