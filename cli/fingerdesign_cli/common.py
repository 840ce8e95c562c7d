"""What subcommands share: --quiet and --json, files or shipped names, progress, tables."""

from __future__ import annotations

import json
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol, TypeVar

import click

from fingerdesign.checks.load import judge_design, judge_scene
from fingerdesign.checks.scene import scene_faults
from fingerdesign.checks.starter import design_text, scene_text
from fingerdesign.control.estimator import EstimatorError, GripEstimator
from fingerdesign.errors import DesignError, Fault, printable
from fingerdesign.records.result import ResultError
from fingerdesign.runtime.registry import CONTROLLERS

if TYPE_CHECKING:
    from fingerdesign.checks.load import Judged
    from fingerdesign.control.estimator import GripEstimator
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.errors import DesignError
    from fingerdesign.records.folder import RecordFolder

_Command = TypeVar("_Command", bound=Callable[..., Any])


class Progress(Protocol):
    """Tells the user where long work stands."""

    def __call__(self, message: str, fraction: float | None = None) -> None:
        """Say what is being done now; ``fraction`` in [0, 1] of the whole, None if unknown."""


def output_folder(_context: click.Context, parameter: click.Parameter, value: Path) -> Path:
    """Refuse an option's folder that cannot become one: it or a folder above it is a file."""
    for path in (value, *value.parents):
        if path.exists() and not path.is_dir():
            above = "" if path == value else f"; {path} is a file"
            wrong = f"{parameter.opts[0]} = {value}: must be a folder, not a file{above}"
            raise click.UsageError(f"{wrong}; choose another")
    return value


def read_case(design_name: Path, scene_name: Path | None = None) -> tuple[Design, Scene | None]:
    """Return a design and a scene, each of a file or shipped under that name.

    Raises :class:`DesignError` with every fault of both and of the one against the other.
    """
    scene: Judged[Scene] | None = None
    errors: list[DesignError] = []
    if scene_name is not None:
        scene, error = judged_scene(scene_name)
        errors += [error] if error else []
    found, error = judged_design(design_name, scene)
    errors += [error] if error else []
    if errors or found is None or found.value is None:
        every = DesignError([fault for each in errors for fault in each.faults])
        every.args = ("\n".join(str(each) for each in errors),)
        raise every
    return found.value, scene.value if scene is not None else None


def judged_scene(name: Path) -> tuple[Judged[Scene] | None, DesignError | None]:
    """Judge a scene's file, or the shipped one; with the error that holds its faults, if any."""
    try:
        found = judge_scene(scene_text(name), str(name))
    except DesignError as error:
        return None, error
    return found, DesignError(found.faults, str(name)) if found.faults else None


def judged_design(
    name: Path, scene: Judged[Scene] | None = None
) -> tuple[Judged[Design] | None, DesignError | None]:
    """Judge a design's file, or the shipped one, and against it the scene where there is one."""
    try:
        found = judge_design(design_text(name), str(name), Path(name).parent)
    except DesignError as error:
        return None, error
    own = DesignError(found.faults, str(name))
    beside = DesignError([])
    if scene is not None and scene.value is not None and found.value is not None:
        beside = DesignError(scene_faults(scene.value, found.value), f"{name} (scene)")
    both = DesignError([*own.faults, *beside.faults])
    both.args = ("\n".join(str(error) for error in (own, beside) if error.faults),)
    return found, both if both.faults else None


def optional_folder(
    context: click.Context, parameter: click.Parameter, value: Path | None
) -> Path | None:
    """As :func:`output_folder`, where the option may be left out."""
    return None if value is None else output_folder(context, parameter, value)


def output_options(function: _Command) -> _Command:
    """Give a command the flags ``--quiet`` (``quiet``) and ``--json`` (``as_json``)."""
    function = click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout.")(
        function
    )
    return click.option("--quiet", "-q", is_flag=True, help="Print only failures.")(function)


def go_on_option(function: _Command) -> _Command:
    """Give a command the flag ``--go-on`` (``go_on``)."""
    return click.option(
        "--go-on", is_flag=True, help="Even where the forecast exceeds the memory that is free."
    )(function)


def read_estimator(path: Path) -> GripEstimator:
    """The estimator in a file that ``fingerdesign teach`` wrote; DesignError for any other."""
    try:
        return GripEstimator.from_json(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError, EstimatorError) as error:
        fault = Fault("--estimator", str(path), "an estimator's JSON file", str(error))
        raise DesignError([fault]) from error


def estimator_for(design: Design, path: Path | None) -> GripEstimator | None:
    """As :func:`read_estimator`; DesignError too for one that was taught on another design."""
    if path is None:
        return None
    from fingerdesign.sensing.lessons import estimator_faults

    estimator = read_estimator(path)
    faults = estimator_faults(design, estimator)
    if faults:
        raise DesignError(faults, str(path))
    return estimator


def refuse_foreign(kind: RecordFolder, target: Path) -> None:
    """DesignError, before any work, where ``target`` holds what is no older record of the kind."""
    try:
        kind.refuse_foreign(target)
    except ResultError as error:
        bound = f"a folder for a {kind.kind}"
        remedy = f"choose another, for {str(error).removesuffix('; choose another --out')}"
        raise DesignError([Fault("--out", str(target.parent), bound, remedy)]) from error


CONTROLLER_NAMES = CONTROLLERS.shipped_names()

controllers_option = click.option(
    "--controller",
    "controllers",
    metavar="NAME",
    multiple=True,
    help=f"This controller alone; may be given again. One of: {', '.join(CONTROLLER_NAMES)}.",
)


def cores() -> int:
    """How many cores this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


@contextmanager
def progress(title: str, quiet: bool = False) -> Iterator[Progress]:
    """Show progress on stderr: a bar on a terminal, plain lines elsewhere, nothing if ``quiet``.

    stdout stays free for results. A plain line is written when the message changes.
    """
    if quiet:
        yield lambda message, fraction=None: None
    elif sys.stderr.isatty():
        with _bar(title) as show:
            yield show
    else:
        yield _plain_lines(title)


def _plain_lines(title: str) -> Progress:
    last = ""

    def show(message: str, fraction: float | None = None) -> None:
        nonlocal last
        if message != last:
            last = message
            click.echo(printable(f"{title}: {message}"), err=True)

    return show


@contextmanager
def _bar(title: str) -> Iterator[Progress]:
    from rich.console import Console
    from rich.progress import BarColumn, SpinnerColumn, TextColumn, TimeElapsedColumn
    from rich.progress import Progress as Bar

    columns = (
        SpinnerColumn(),
        TextColumn("{task.fields[title]}", markup=False),
        BarColumn(bar_width=24),
        TimeElapsedColumn(),
        TextColumn("{task.description}", markup=False),
    )
    with Bar(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("", total=None, title=title)

        def show(message: str, fraction: float | None = None) -> None:
            message = printable(message)
            if fraction is None:
                bar.update(task, description=message)
            else:
                bar.update(task, description=message, completed=fraction, total=1.0)

        yield show


def print_table(title: str, headings: Sequence[str], rows: Sequence[Sequence[str]]) -> None:
    """Print a table on stdout, as wide as it needs where stdout is not a terminal."""
    from rich.console import Console
    from rich.table import Table
    from rich.text import Text

    table = Table(title=Text(printable(title)), title_justify="left")
    for index, heading in enumerate(headings):
        table.add_column(Text(printable(heading)), justify="left" if index == 0 else "right")
    for row in rows:
        table.add_row(*(Text(printable(cell)) for cell in row))
    console = Console(file=sys.stdout)
    if not console.is_terminal:
        console.width = 200
    console.print(table)


def print_json(value: object) -> None:
    """Print ``value`` as JSON on stdout; NaN is refused, not written."""
    click.echo(json.dumps(value, indent=2, allow_nan=False))
