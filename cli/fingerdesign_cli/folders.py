"""``fingerdesign view``: a result in the terminal, and where its report is."""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import click
from jinja2 import TemplateError

from fingerdesign.analysis.answers import ARRAYS, PAGE, read_arrays
from fingerdesign.analysis.page.tables import grip_table, increment_table, model_table
from fingerdesign.analysis.page.words import Question, verdict
from fingerdesign.checks import starter
from fingerdesign.design.schema import schema_text
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import ResultError
from fingerdesign.records.folder import RESULT_FILE, read_result
from fingerdesign.records.result import Result
from fingerdesign.report.table import Table
from fingerdesign.runtime.files import write_whole
from fingerdesign_cli.terminal import print_json, print_table, say, say_verdict

_VALIDATION = "validate.json"  # validate.record.RECORD_FILE
_WRONG = (ValueError, TypeError, AttributeError, LookupError, ArithmeticError, RecursionError)


# ``fingerdesign new``: a commented starter design or scene.


def new(file: Path, source: str | None, scene: bool, force: bool, quiet: bool) -> None:
    """Write a commented starter design to FILE.toml, its name taken from FILE; or a scene."""
    if file.suffix != ".toml":
        other = file.with_suffix(".toml") if file.name else Path("finger.toml")
        raise click.UsageError(f"FILE = {file}: must end in .toml; try {other}")
    if file.exists() and not file.is_file():
        raise click.UsageError(f"FILE = {file}: must be a regular file; choose another name")
    if file.exists() and not force:
        raise click.UsageError(f"FILE = {file}: must not exist; choose another name or --force")
    if scene:
        text, kind = starter.starter_scene_text(source), "scene"
    else:
        name = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-")[:64] or "finger"
        text, kind = starter.starter_text(name, source), "design"
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, text)
    schema = file.parent / f"{kind}.schema.json"
    if force or not schema.exists():
        write_whole(schema, schema_text(kind))
    if not quiet:
        design = "DESIGN --scene " if scene else ""
        click.echo(f"{file} written; next: fingerdesign check {design}{shlex.quote(str(file))}")


def view(folder: Path, open_browser: bool, cad: bool, quiet: bool, as_json: bool) -> None:
    """Show the result in DIR, or each result in the folders of DIR, and where its report is."""
    places = _places(folder)
    views = [_view(place) for place in places]
    page = open_browser or not (quiet or as_json)
    for place in places:
        _complete(place, page, cad)
    if as_json:
        print_json([_summary(each) for each in views])
    elif not quiet:
        for each in views:
            _show(each)
    if open_browser:
        for place in places:
            if (place / PAGE).is_file():
                click.launch((place / PAGE).absolute().as_uri())


def _complete(place: Path, page: bool, cad: bool) -> None:
    """Draw what is missing; a result whose arrays are not kept is shown without."""
    if (cad or page) and (place / ARRAYS).is_file():
        from fingerdesign.analysis.folder import complete

        try:
            complete(place, page, cad)
        except (*_WRONG, TemplateError, OSError) as error:
            why = f"{type(error).__name__}: {error}"[:200]
            raise ResultError(f"{place}: its report cannot be drawn: {why}") from error


def _places(folder: Path) -> list[Path]:
    """DIR itself, or the folders right inside that hold a result."""
    if (folder / RESULT_FILE).is_file():
        return [folder]
    if inside := _inside(folder, RESULT_FILE):
        return inside
    validated = [folder] if (folder / _VALIDATION).is_file() else _inside(folder, _VALIDATION)
    bound, remedy = "a folder that analyse wrote", "give what analyse got as --out"
    if validated:
        page, numbers = validated[0] / "validate.html", validated[0] / _VALIDATION
        remedy = f"validate wrote this one: open {page}, or read {numbers}"
    raise DesignError([Fault("DIR", folder, bound, remedy)])


def _inside(folder: Path, name: str) -> list[Path]:
    places = sorted(path.parent for path in folder.glob(f"*/{name}"))
    return [place for place in places if not place.name.startswith(".")]


@dataclass(frozen=True)
class _View:
    place: Path
    result: Result
    findings: list[Question]
    tables: tuple[Table, ...]

    @property
    def report(self) -> str | None:
        """Where its report is, if it is there."""
        report = self.place / PAGE
        return str(report) if report.is_file() else None


def _view(place: Path) -> _View:
    """What is shown of a result; DesignError where its values are none that can be shown."""
    makers = (model_table, increment_table, grip_table)
    result = read_result(place)
    try:
        found = verdict(result, read_arrays(place).get("grip_traces", ()))
        return _View(place, result, found, tuple(make(result) for make in makers))
    except (*_WRONG, TemplateError) as error:
        why = f"{type(error).__name__}: {error}"[:200]
        bound = "a result whose values can be shown"
        raise DesignError([Fault("RESULT", place, bound, f"{why}; run analyse again")]) from error


def _summary(view: _View) -> dict[str, object]:
    facts = ("design", "scene", "fidelity", "status", "failure")
    return {
        "folder": str(view.place),
        "report": view.report,
        **{key: getattr(view.result, key) for key in facts},
        "warnings": list(view.result.warnings),
        "findings": [
            {key: getattr(item, key) for key in ("question", "answer", "detail")}
            for item in view.findings
        ],
    }


def _show(view: _View) -> None:
    result = view.result
    say(f"{result.design} ({result.scene}, {result.fidelity})", bold=True)
    say_verdict(view.findings)
    for warning in result.warnings:
        say(f"  warning: {warning}")
    for table in view.tables:
        if table.rows:
            print_table(table.caption, table.columns, table.rows)
    say(f"report: {view.report or f'none in {view.place}'}")
