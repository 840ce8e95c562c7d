"""``fingerdesign view``: a result in the terminal, and where its report is."""

from __future__ import annotations

import re
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.analysis.page.tables import grip_table, increment_table, model_table
from fingerdesign.analysis.page.words import verdict
from fingerdesign.checks import starter
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.folder import RESULT_FILE, read_result
from fingerdesign_cli.terminal import print_json, print_table

if TYPE_CHECKING:
    from fingerdesign.records.result import Result
    from fingerdesign.report.table import Table


# ``fingerdesign new``: a commented starter design or scene.


def _toml(file: Path) -> Path:
    return file.with_suffix(".toml") if file.name else Path("finger.toml")


def new(file: Path, source: str | None, scene: bool, force: bool, quiet: bool) -> None:
    """Write a commented starter design to FILE.toml, its name taken from FILE; or a scene."""
    if file.suffix != ".toml":
        raise click.UsageError(f"FILE = {file}: must end in .toml; try {_toml(file)}")
    if file.exists() and not file.is_file():
        raise click.UsageError(f"FILE = {file}: must be a regular file; choose another name")
    if file.exists() and not force:
        raise click.UsageError(f"FILE = {file}: must not exist; choose another name or --force")
    if scene:
        text, schema_file = starter.starter_scene_text(source), starter.SCENE_SCHEMA_FILE
    else:
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-")[:64] or "finger"
        text, schema_file = starter.starter_text(name, source), starter.SCHEMA_FILE
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text(text, encoding="utf-8")
    schema = file.parent / schema_file
    if force or not schema.exists():
        schema.write_text(starter.schema_json(schema_file), encoding="utf-8")
    if not quiet:
        design = "DESIGN --scene " if scene else ""
        click.echo(f"{file} written; next: fingerdesign check {design}{shlex.quote(str(file))}")


def view(folder: Path, open_browser: bool, quiet: bool, as_json: bool) -> None:
    """Show the result in DIR, or each result in the folders of DIR, and where its report is."""
    places = _places(folder)
    results = [read_result(place) for place in places]
    if as_json:
        print_json([_summary(*pair) for pair in zip(places, results, strict=True)])
    elif not quiet:
        for place, result in zip(places, results, strict=True):
            _show(place, result)
    if open_browser:
        for place in places:
            if (place / "report.html").is_file():
                click.launch((place / "report.html").absolute().as_uri())


def _places(folder: Path) -> list[Path]:
    """DIR itself, or the folders right inside that hold a result."""
    if (folder / RESULT_FILE).is_file():
        return [folder]
    inside = sorted(path.parent for path in folder.glob(f"*/{RESULT_FILE}"))
    inside = [place for place in inside if not place.name.startswith(".")]
    if not inside:
        _refuse_validation(folder)
        bound = f"a folder with a {RESULT_FILE}, or with folders that have one"
        raise DesignError([Fault("DIR", folder, bound, "give what analyse got as --out")])
    return inside


def _refuse_validation(folder: Path) -> None:
    """A fault that names what there is to look at where the folder holds what validate writes."""
    record = "validate.json"  # validate.record.RECORD_FILE
    places = [folder] if (folder / record).is_file() else []
    places += sorted(path.parent for path in folder.glob(f"*/{record}"))
    places = [place for place in places if not place.name.startswith(".")]
    if places:
        page, numbers = places[0] / "validate.html", places[0] / record
        remedy = f"validate wrote this one: open {page}, or read {numbers}"
        bound = "a folder that analyse wrote"
        raise DesignError([Fault("DIR", folder, bound, remedy)])


def _summary(place: Path, result: Result) -> dict[str, object]:
    report = place / "report.html"
    facts = ("design", "scene", "fidelity", "status", "failure")
    return {
        "folder": str(place),
        "report": str(report) if report.is_file() else None,
        **{key: getattr(result, key) for key in facts},
        "warnings": list(result.warnings),
        "findings": [
            {key: getattr(item, key) for key in ("question", "answer", "detail")}
            for item in verdict(result)
        ],
    }


def _show(place: Path, result: Result) -> None:
    click.secho(f"{result.design} ({result.scene}, {result.fidelity})", bold=True)
    for item in verdict(result):
        click.echo(f"  {item.answer.upper():6} {item.question} {item.detail}")
    for warning in result.warnings:
        click.echo(f"  warning: {warning}")
    _print(model_table(result))
    _print(increment_table(result))
    _print(grip_table(result))
    report = place / "report.html"
    where = str(report) if report.is_file() else f"none in {place}"
    click.echo(f"report: {where}")


def _print(table: Table) -> None:
    if table.rows:
        print_table(table.caption, table.columns, table.rows)
