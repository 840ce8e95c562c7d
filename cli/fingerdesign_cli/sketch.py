"""``fingerdesign sketch``: a dimensioned drawing of a design, again whenever its file changes."""

import time
from pathlib import Path

import click

from fingerdesign.analysis.page.sketch import draw_sketch, facts
from fingerdesign.errors import DesignError, printable
from fingerdesign.report import style
from fingerdesign.runtime.files import write_whole
from fingerdesign_cli.inputs import read_case
from fingerdesign_cli.terminal import open_page, print_json

_LOOK_S = 0.3  # between two looks at the file: a save is seen at once, and a core has nothing to do


def sketch(design_file: Path, out: Path, watch: bool, quiet: bool, as_json: bool) -> int:
    """Draw DESIGN with its dimensions."""
    if watch and not design_file.is_file():
        raise click.UsageError(f"--watch needs a file of yours, not {design_file}")
    files = _draw(design_file, out, quiet, as_json)
    open_page(files[0])
    seen = _stamp(design_file) if watch else 0
    while watch:  # until it is interrupted
        time.sleep(_LOOK_S)
        if (now := _stamp(design_file)) != seen:
            seen = now
            try:
                _draw(design_file, out, quiet, as_json)
            except DesignError as error:  # in the middle of a change: the old drawing stays
                click.echo(printable(str(error)), err=True)
    return 0


def _stamp(path: Path) -> int:
    """When the file was changed; 0 while an editor has put it away."""
    try:
        return path.stat().st_mtime_ns
    except OSError:
        return 0


def _draw(design_file: Path, out: Path, quiet: bool, as_json: bool) -> list[Path]:
    design, _ = read_case(design_file)
    name = design.design.name
    words = facts(design)
    with style.house_style():
        drawing = draw_sketch(design)
        png = style.to_png(drawing)
        svg = style.to_svg(drawing, "sketch", f"{name}, a dimensioned drawing: {'; '.join(words)}")
    out.mkdir(parents=True, exist_ok=True)
    files = [out / f"{name}.svg", out / f"{name}.png"]
    write_whole(files[0], svg)
    write_whole(files[1], png)
    if as_json:
        print_json({"design": name, "facts": words, "files": [str(path) for path in files]})
    elif not quiet:
        click.echo(f"drawn: {files[0]} and {files[1].name}")
    return files
