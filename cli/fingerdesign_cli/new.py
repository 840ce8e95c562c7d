"""``fingerdesign new``: a commented starter design, scene or study."""

import re
import shlex
from dataclasses import dataclass
from pathlib import Path

import click

from fingerdesign.design import starter
from fingerdesign.design.schema import schema_text
from fingerdesign.runtime.files import why_no_place, write_whole
from fingerdesign_cli.options import Options
from fingerdesign_cli.terminal import quiet

FLAGSHIP = "film_tees"  # Plain `new` copies it: it passes all verdicts, and its keys are few.


@dataclass(frozen=True)
class Kind(Options):
    """Kind of file that is written; whole, short: of a design all keys, or the first fifteen."""

    scene: bool
    study: bool
    whole: bool
    short: bool


def new(file: Path, source: str | None, form: Kind, force: bool) -> None:
    """Write a commented starter design to FILE.toml, its name taken from FILE; or another file."""
    given = (form.scene, form.study, form.whole, form.short)
    if sum(given) > 1 or (source is not None and (form.whole or form.short)):
        words = "give one of --scene, --study, --all, --short; the last two go without --from"
        raise click.UsageError(words)
    _refuse(file, force)
    name = re.sub(r"[^A-Za-z0-9_-]+", "-", file.stem).strip("-")[:64] or "finger"
    scene, study = form.scene, form.study
    kind = "scene" if scene else "study" if study else "design"
    file.parent.mkdir(parents=True, exist_ok=True)
    write_whole(file, _text(kind, name, source, form))
    schema = file.parent / f"{kind}.schema.json"
    if not study and (force or not schema.exists()):
        write_whole(schema, schema_text(kind))
    if not quiet():
        design = "DESIGN --scene " if scene else ""
        click.echo(f"{file} written; next: fingerdesign check {design}{shlex.quote(str(file))}")


def _refuse(file: Path, force: bool) -> None:
    """Raise a usage error for a file that cannot or must not be written."""
    if file.suffix != ".toml":
        other = file.with_suffix(".toml") if file.name else Path("finger.toml")
        raise click.UsageError(f"FILE = {file}: must end in .toml; try {other}")
    if file.exists() and not file.is_file():
        raise click.UsageError(f"FILE = {file}: must be a regular file; choose another name")
    if file.exists() and not force:
        raise click.UsageError(f"FILE = {file}: must not exist; choose another name or --force")
    if why := why_no_place(file.parent):
        wrong = f"must be in a folder that can be written into, and {why}"
        raise click.UsageError(f"FILE = {file}: {wrong}; choose another")


def _text(kind: str, name: str, source: str | None, flags: Kind) -> str:
    """Return the starter's text."""
    if kind == "scene":
        return starter.starter_scene_text(source)
    if kind == "study":
        return starter.starter_study_text(name, source)
    if flags.short:
        return starter.starter_short_text(name)
    return starter.starter_text(name, None if flags.whole else source or FLAGSHIP)
