"""``fingerdesign new``: a commented starter design or scene."""

from __future__ import annotations

import re
import shlex
from pathlib import Path

import click

from fingerdesign.checks import starter


def _toml(file: Path) -> Path:
    return file.with_suffix(".toml") if file.name else Path("finger.toml")


@click.command("new")
@click.argument("file", type=click.Path(dir_okay=False, path_type=Path))
@click.option("--from", "source", metavar="NAME", help="Start from this shipped design (or scene).")
@click.option("--scene", is_flag=True, help="Write a scene instead of a design.")
@click.option("--force", is_flag=True, help="Overwrite FILE.")
@click.option("--quiet", "-q", is_flag=True, help="Print only failures.")
def command(file: Path, source: str | None, scene: bool, force: bool, quiet: bool) -> None:
    """Write a commented starter design to FILE.toml, its name taken from FILE; or a scene.

    Beside it goes design.schema.json (scene.schema.json), with which editors complete and explain
    keys. Nothing is overwritten without --force. Shipped designs: maeno2000, homogeneous, narrow,
    wide, domed, pin, block, both_ways, boned.
    """
    if file.suffix != ".toml":
        raise click.UsageError(f"FILE = {file}: must end in .toml; try {_toml(file)}")
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
