"""Options that commands share, and how a command calls its work: light, so that --help is.

A command's options and words stand in commands/; what it does is the function of its name in a
module beside this one, which imports what it needs at its top and is loaded when the command runs.
"""

from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar

import click

from fingerdesign.runtime.registry import CONTROLLERS

_Command = TypeVar("_Command", bound=Callable[..., Any])

FILE = click.Path(path_type=Path)


def command(module: str, short: str) -> Callable[[Callable[[], None]], click.Command]:
    """Make a command of a function that holds options and words; its work is the function of the
    same name in ``module``. short: its line in the list of commands."""

    def made(function: Callable[[], None]) -> click.Command:
        def work(**given: Any) -> int | None:
            found = getattr(import_module(f"fingerdesign_cli.{module}"), function.__name__)
            code: int | None = found(**given)
            return code

        found = click.command(function.__name__.replace("_", "-"), short_help=short)(function)
        found.callback = work
        return found

    return made


def output_folder(_context: click.Context, parameter: click.Parameter, value: Path) -> Path:
    """Refuse an option's folder that cannot become one: it or a folder above it is a file."""
    for path in (value, *value.parents):
        if path.exists() and not path.is_dir():
            above = "" if path == value else f"; {path} is a file"
            wrong = f"{parameter.opts[0]} = {value}: must be a folder, not a file{above}"
            raise click.UsageError(f"{wrong}; choose another")
    return value


def out_option(about: str) -> Callable[[_Command], _Command]:
    """``--out`` (``out``): a folder, or what can become one."""
    return click.option("--out", required=True, type=FILE, callback=output_folder, help=about)


def design_and_out(about: str) -> Callable[[_Command], _Command]:
    """The argument DESIGN (``design_file``) and ``--out`` (``out``)."""

    def given(function: _Command) -> _Command:
        function = out_option(about)(function)
        return click.argument("design_file", metavar="DESIGN", type=FILE)(function)

    return given


def estimator_option(about: str) -> Callable[[_Command], _Command]:
    """``--estimator`` (``estimator_file``): what ``fingerdesign teach`` wrote."""
    return click.option("--estimator", "estimator_file", metavar="FILE", type=FILE, help=about)


def scene_option(about: str) -> Callable[[_Command], _Command]:
    """``--scene`` (``scene_file``): a scene's file, or a shipped one's name."""
    return click.option("--scene", "scene_file", metavar="SCENE", type=FILE, help=about)


def numbers_option(
    option: str, name: str, metavar: str, about: str, **more: Any
) -> Callable[[_Command], _Command]:
    """An option that takes a number and may be given again."""
    kept: dict[str, Any] = {"metavar": metavar, "type": float, "multiple": True}
    return click.option(option, name, **kept, **more, help=about)


model_option = click.option(
    "--fidelity",
    type=click.Choice(["plane-strain", "3d"]),
    default="plane-strain",
    show_default=True,
    help="Of the model that grips are run on; 3d takes three to four times as long.",
)
workers_option = click.option(
    "--workers",
    type=click.IntRange(1, 256),
    help="Processes; without it as many as there are cores.",
)
two_workers_option = click.option(
    "--workers", type=click.IntRange(1, 64), default=2, show_default=True, help="Processes."
)


def output_options(function: _Command) -> _Command:
    """Give a command the flags ``--quiet`` (``quiet``) and ``--json`` (``as_json``)."""
    function = click.option("--json", "as_json", is_flag=True, help="Print JSON on stdout.")(
        function
    )
    return click.option("--quiet", "-q", is_flag=True, help="Print only failures.")(function)


def result_options(function: _Command) -> _Command:
    """Give a command ``--page`` (``page``), ``--cad`` (``cad``) and ``--fresh`` (``fresh``)."""
    when = "  [default: except in plane strain; view makes it later]"
    for option in (
        click.option(
            "--fresh", is_flag=True, help="Work anew what this machine has kept the answer of."
        ),
        click.option("--cad/--no-cad", default=None, help=f"Write STEP and STL files.{when}"),
        click.option("--page/--no-page", default=None, help=f"Draw report.html.{when}"),
    ):
        function = option(function)
    return function


go_on_option = click.option(
    "--go-on", is_flag=True, help="Even where the forecast exceeds the memory that is free."
)
CONTROLLER_NAMES = CONTROLLERS.shipped_names()
controllers_option = click.option(
    "--controller",
    "controllers",
    metavar="NAME",
    multiple=True,
    help="This controller alone; may be given again. "
    f"One of: {', '.join(CONTROLLER_NAMES)}; or a plug-in's.",
)


def trial_options(seed_of: str) -> Callable[[_Command], _Command]:
    """What commands that try controllers share: ``--seed``, estimator, workers and model."""

    def given(function: _Command) -> _Command:
        for option in (
            output_options,
            model_option,
            workers_option,
            estimator_option(
                "For the regulator: what `fingerdesign teach` wrote for DESIGN. Without it one is "
                "taught first (minutes), or taken from the cache."
            ),
            click.option("--seed", type=int, default=0, show_default=True, help=f"Of {seed_of}."),
        ):
            function = option(function)
        return function

    return given


def scheduler_options(function: _Command) -> _Command:
    """Give a command ``--workers`` (``workers``) and ``--scheduler`` (``scheduler``)."""
    function = click.option(
        "--scheduler",
        metavar="ADDRESS",
        callback=_alone,
        help="Run on the workers of this Dask scheduler: tcp://host:8786 for one, or its file.",
    )(function)
    return click.option(
        "--workers",
        type=click.IntRange(1, 1024),
        is_eager=True,
        help="Processes on this machine; without it as many as there are cores.",
    )(function)


def _alone(context: click.Context, _parameter: click.Parameter, value: str | None) -> str | None:
    if value is not None and context.params.get("workers") is not None:
        raise click.UsageError("--workers and --scheduler: give one; a cluster has its own workers")
    if value is not None and not value.strip():
        remedy = "give one like tcp://host:8786, its file, or leave --scheduler out"
        raise click.UsageError(f"--scheduler = {value!r}: must be an address; {remedy}")
    return value
