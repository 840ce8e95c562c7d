"""Options that commands share, and how a command calls its work: light, so that --help is.

A command's options and words stand in commands/; what it does is the function of its name in a
module next to commands/, which imports what it needs at its top and is loaded when the command
runs. Options that concern the terminal alone (--quiet, --json, --details, --open) are left in the
command's context, from which terminal.py reads them.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass, fields
from difflib import get_close_matches
from functools import partial
from importlib import import_module
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

import click
from click.shell_completion import CompletionItem

from fingerdesign.runtime.files import why_no_place
from fingerdesign.runtime.limits import limited
from fingerdesign.runtime.registry import CONTROLLERS, code_allowed, is_reference

_Command = TypeVar("_Command", bound=Callable[..., Any])

# The names of --open, --details, --quiet and --json in a command's context.
OPEN, DETAILS = "fingerdesign.open", "fingerdesign.details"
QUIET, JSON = "fingerdesign.quiet", "fingerdesign.json"
COMMON = "Also: --time-limit, --memory-limit, --allow-code (see `fingerdesign --help`)."
OUT = Path("out")  # The folder of commands that are given no other.
# Names of former versions, which work until December 2027: the words that now stand for each.
RENAMED = {
    "teach": ("train",),
    "calibrate": ("identify", "--bench"),
    "study-control": ("study",),
    "study-unlike": ("study", "--perturbed"),
    "tune": ("study", "--tune", "--quick"),
    "export-c": ("export", "--to", "c"),
    "sketch": ("view",),
    "gages": ("validate", "--gages"),
}
SHELVES = ("designs", "scenes", "studies", "materials", "metrics", "controllers", "gages", "atlas")
FIDELITIES = {
    "plane-strain": "the section alone, in seconds",
    "3d": "the finger in space, ten to thirty times as long; `check` forecasts it",
    "finite": "in space, the path at finite strain: each row a few factorisations",
    "auto": "the cheapest model whose estimated error is under the tolerance",
}
CONTROLLER_NAMES = CONTROLLERS.shipped_names()
_WHEN = "  [default: except in plane strain; view makes it later]"


class Place(click.Path):
    """A path. An empty one, as of a shell's variable that is not set, would be this folder."""

    def __init__(self, dir_okay: bool = True) -> None:
        super().__init__(path_type=Path, dir_okay=dir_okay)

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """The path. UsageError where it is empty."""
        if str(value) == "" and not isinstance(value, Path):
            name = "the path" if param is None else param.human_readable_name
            name = param.opts[0] if isinstance(param, click.Option) else name
            wrong = f"{name} = '': must be a path that is not empty"
            raise click.UsageError(f"{wrong}; give one (. is this folder), or leave it out", ctx)
        return super().convert(value, param, ctx)


class ShippedOrFile(Place):
    """A file, or the name of what is shipped; shells complete both. kinds: of which."""

    def __init__(self, *kinds: str) -> None:
        super().__init__()
        self.kinds = kinds

    def shell_complete(
        self, ctx: click.Context, param: click.Parameter, incomplete: str
    ) -> list[CompletionItem]:
        """Shipped names that begin alike, then the shell's own files."""
        from fingerdesign.design.shipped import shipped_names

        names = [name for kind in self.kinds for name in shipped_names(kind)]
        found = [CompletionItem(name) for name in names if name.startswith(incomplete)]
        return found + super().shell_complete(ctx, param, incomplete)


class Masses(click.ParamType[Any]):
    """A mass in g, or a range of masses: 500, 500g, 50..500, 50..500g."""

    name = "G"

    def convert(
        self, value: Any, param: click.Parameter | None, ctx: click.Context | None
    ) -> float | list[float]:
        """The number or list of two of :func:`masses_of`; their bounds are the design's."""
        found = masses_of(str(value))
        if found is None:
            self.fail(f"{value!r} must be grams, such as 500 or 50..500", param, ctx)
        return found


class FiniteRange(click.FloatRange):
    """A range of numbers that no option's ``nan`` or ``inf`` gets past."""

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> Any:
        """Return the number; see click."""
        found = super().convert(value, param, ctx)
        if not math.isfinite(found):
            self.fail(f"{value} is not a finite number", param, ctx)
        return found


def masses_of(text: str) -> float | list[float] | None:
    """A mass in g or a range of two as a design writes it; None of other text.

    >>> masses_of("500g"), masses_of("50..500"), masses_of("0.01...500")
    (500.0, [50.0, 500.0], None)
    """
    if "..." in text:
        return None
    try:
        ends = [float(part) for part in text.strip().removesuffix("g").split("..")]
    except ValueError:
        return None
    return ends[0] if len(ends) == 1 else ends if len(ends) == 2 else None


MASSES = Masses()
FILE = Place()
DESIGN, SCENE, STUDY = (ShippedOrFile(kind) for kind in ("design", "scene", "study"))


class Group(click.Group):
    """A group that lists its commands under headings, in the order in which they were added; it
    accepts former names and suggests the nearest one."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.headings: dict[str, list[str]] = {}

    def add_under(self, heading: str, *commands: click.Command) -> None:
        """Add commands, and list them under the heading."""
        for each in commands:
            self.add_command(each)
            self.headings.setdefault(heading, []).append(each.name or "")

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Take this group's own options from anywhere in front of ``--``: every command has them.
        ``--version`` and ``--help`` stay where they are."""
        end = args.index("--") if "--" in args else len(args)
        own = {
            name: 1 if option.is_flag else 2
            for option in self.params
            if isinstance(option, click.Option) and not option.is_eager
            for name in option.opts
        }
        first, rest, place = list[str](), list[str](), 0
        while place < end:
            name, equals, _ = args[place].partition("=")
            size = 1 if equals else own.get(name, 1)
            (first if name in own else rest).extend(args[place : min(place + size, end)])
            place += size
        return super().parse_args(ctx, [*first, *rest, *args[end:]])

    def list_commands(self, ctx: click.Context) -> list[str]:
        """List the names in the order of the work, not of the alphabet."""
        return list(self.commands)

    def format_commands(self, ctx: click.Context, formatter: click.HelpFormatter) -> None:
        """Write a section of ``--help`` for each heading."""
        if not self.headings:
            super().format_commands(ctx, formatter)
            return
        width = formatter.width - 6 - max(map(len, self.commands))
        for heading, names in self.headings.items():
            with formatter.section(heading.capitalize()):
                rows = [(name, self.commands[name].get_short_help_str(width)) for name in names]
                formatter.write_dl(rows, col_max=max(map(len, self.commands)))

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command. A former name is replaced, and the new one reported on stderr; the
        UsageError for an unknown name suggests the nearest: "optimize" is optimise."""
        words = RENAMED.get(args[0], ())
        if args[0] not in self.commands and words and words[0] in self.commands:
            click.echo(f"`{args[0]}` is now `fingerdesign {' '.join(words)}`", err=True)
            args = [*words, *args[1:]]
        try:
            return super().resolve_command(ctx, args)
        except click.UsageError as error:
            near = get_close_matches(args[0].lower(), self.list_commands(ctx), 1, 0.5)
            if near and not getattr(error, "possibilities", None):  # newer clicks name it
                message = f"{error.message} Did you mean '{near[0]}'?"
                raise click.UsageError(message, ctx) from error
            raise


class Command(click.Command):
    """A command whose error for wrong values of options and arguments names all of them."""

    def parse_args(self, ctx: click.Context, args: list[str]) -> list[str]:
        """Parse as usual. UsageError with every fault where there is more than one."""
        try:
            return super().parse_args(ctx, list(args))
        except click.BadParameter as first:
            given, _, _ = self.make_parser(ctx).parse_args(list(args))
            wrong = list[str]()
            for each in self.params:
                try:
                    each.handle_parse_result(ctx, given, [])
                except click.UsageError as error:
                    wrong.append(error.format_message())
            if len(wrong) < 2:
                raise
            raise click.UsageError("\n".join(wrong), ctx) from first


@dataclass(frozen=True)
class Options:
    """Base of dataclasses of options that travel together: a function that does a command's work
    and has a parameter of such a type is given the options of its fields as one object."""


def command(module: str, short: str) -> Callable[[Callable[[], None]], click.Command]:
    """Make a command of a function that holds options and words; its work is the function of the
    same name in ``module``. short: its line in the list of commands."""

    def made(function: Callable[[], None]) -> click.Command:
        def work(**given: Any) -> int | None:
            found = getattr(import_module(f"fingerdesign_cli.{module}"), function.__name__)
            for name, kind in get_type_hints(found).items():
                if isinstance(kind, type) and issubclass(kind, Options):
                    given[name] = kind(**{e.name: given.pop(e.name) for e in fields(kind)})
            code: int | None = found(**given)
            return code

        name = function.__name__.strip("_").replace("_", "-")
        found = click.command(name, Command, short_help=short)(function)
        found.callback = work
        found.epilog = COMMON
        return found

    return made


def limit_option(name: str, metavar: str, least: float, about: str) -> Callable[[Any], Any]:
    """A limit of the command's time or memory (runtime/limits.py)."""

    def limit(context: click.Context, parameter: click.Parameter, value: float | None) -> None:
        if value is not None:
            seconds = name == "--time-limit"
            context.with_resource(limited(value) if seconds else limited(memory_MB=value))

    kind, shown = FiniteRange(least, 1e7), f"{about}."
    return click.option(
        name, metavar=metavar, type=kind, expose_value=False, callback=limit, help=shown
    )


def permit(context: click.Context, _parameter: click.Parameter, value: bool) -> None:
    """Let files run the code that they name, while this command runs."""
    if value:
        context.with_resource(code_allowed())


def output_folder(
    _context: click.Context, parameter: click.Parameter, value: Path | None
) -> Path | None:
    """Refuse an option's folder that cannot become one, before any work: it or a folder above it is
    a file, or nothing can be written there."""
    if value is not None and (why := why_no_place(value)):
        wrong = f"{parameter.opts[0]} = {value}: must be a folder that can be written into"
        raise click.UsageError(f"{wrong}, and {why}; choose another")
    return value


def together(*options: Callable[[Any], Any]) -> Callable[[_Command], _Command]:
    """Give a command several options, which its help shows in this order."""

    def given(function: _Command) -> _Command:
        for option in reversed(options):
            function = option(function)
        return function

    return given


def out_option(folder: str = "") -> Callable[[_Command], _Command]:
    """``--out`` (``out``): the folder that holds the folder of the design or study.

    folder: of commands whose results would meet those of ``analyse`` under the design's name; they
    write into OUT/folder where no other is given.
    """
    return click.option(
        "--out",
        metavar="DIR",
        type=FILE,
        default=OUT / folder,
        show_default=True,
        callback=output_folder,
        help="Where to write: DIR/NAME, the name that of the design or study.",
    )


def design_and_out(folder: str = "") -> Callable[[_Command], _Command]:
    """The argument DESIGN (``design_file``) and :func:`out_option`."""
    argument = click.argument("design_file", metavar="DESIGN", type=DESIGN)
    return together(argument, out_option(folder))


def folder_option(name: str = "") -> Callable[[_Command], _Command]:
    """``--out`` (``folder``): the very folder that is written into, without it OUT/name. name:
    empty where it is the design's; ``folder`` is then None unless it is given."""
    return click.option(
        "--out",
        "folder",
        metavar="DIR",
        type=FILE,
        default=OUT / name if name else None,
        show_default=True if name else str(OUT / "mesh" / "NAME"),
        callback=output_folder,
        help="Where to write: into this very folder.",
    )


def estimator_option(about: str) -> Callable[[_Command], _Command]:
    """``--estimator`` (``estimator_file``): what ``fingerdesign train`` wrote."""
    return click.option("--estimator", "estimator_file", metavar="FILE", type=FILE, help=about)


def scene_option(
    about: str = "In this scene (a file, or a shipped scene's name); without it, the fundamental "
    "case.",
) -> Callable[[_Command], _Command]:
    """``--scene`` (``scene_file``): a scene's file, or a shipped one's name."""
    return click.option("--scene", "scene_file", metavar="SCENE", type=SCENE, help=about)


def numbers_option(
    option: str, name: str, metavar: str, about: str
) -> Callable[[_Command], _Command]:
    """An option that takes a number and may be given again."""
    return click.option(option, name, metavar=metavar, type=float, multiple=True, help=about)


def fidelity_option(
    default: str | None,
    *,
    auto: bool = False,
    finite: bool = False,
    unset: str = "",
    purpose: str = "Which",
) -> Callable[[_Command], _Command]:
    """``--fidelity`` (``fidelity``): which model. unset: what holds where ``default`` is None;
    purpose: words before "model"."""
    offered = {"auto": auto, "finite": finite}
    models = [each for each in FIDELITIES if offered.get(each, True)]
    return click.option(
        "--fidelity",
        type=click.Choice(models),
        default=default,
        show_default=unset or True,
        help=f"{purpose} model. {'; '.join(f'{each}: {FIDELITIES[each]}' for each in models)}.",
    )


model_option = fidelity_option("plane-strain")  # of commands that run hundreds of grips
workers_option = click.option(
    "--workers",
    type=click.IntRange(1, 1024),
    show_default="as many as there are cores; 1 where seconds are measured",
    is_eager=True,
    help="Processes on this machine.",
)


def _context_flag(key: str, about: str, *names: str) -> Callable[[_Command], _Command]:
    """A flag that the terminal reads from the command's context; no function passes it on."""

    def store(context: click.Context, _parameter: click.Parameter, value: bool) -> None:
        context.meta[key] = value

    return click.option(*names, is_flag=True, expose_value=False, callback=store, help=about)


json_option = _context_flag(JSON, "Print JSON on stdout.", "--json", "as_json")
quiet_option = _context_flag(QUIET, "Print only failures.", "--quiet", "-q")
output_options = together(quiet_option, json_option)
open_option = _context_flag(OPEN, "Open what was made in the browser.", "--open")
page_options = together(open_option, output_options)
details_option = _context_flag(DETAILS, "Print every finding, warning and table.", "--details")
result_options = together(
    click.option("--page/--no-page", default=None, help=f"Draw report.html.{_WHEN}"),
    click.option("--cad/--no-cad", default=None, help=f"Write STEP and STL files.{_WHEN}"),
    click.option("--fresh", is_flag=True, help="Compute again what is in this machine's cache."),
)
go_on_option = click.option(
    "--go-on", is_flag=True, help="Even where the forecast exceeds the memory that is free."
)


def complete_controller(
    _context: click.Context, _parameter: click.Parameter, incomplete: str
) -> list[str]:
    """Controllers that are shipped and begin alike, for shells."""
    return [name for name in CONTROLLER_NAMES if name.startswith(incomplete)]


def _imported(
    context: click.Context, _parameter: click.Parameter, value: str | tuple[str, ...] | None
) -> str | tuple[str, ...] | None:
    """Import the classes that the user named before a file is read: it may hold their tables."""
    for name in [value] if isinstance(value, str) else value or ():
        if is_reference(name):
            context.with_resource(code_allowed(name))
            CONTROLLERS.find(name, "--controller")
    return value


_controller = partial(
    click.option,
    "--controller",
    metavar="NAME",
    callback=_imported,
    shell_complete=complete_controller,
)
controller_option = _controller(
    help="Instead of grip.controller; package.module:Class is one of yours."
)
controllers_option = _controller(
    "controllers",
    multiple=True,
    help="This controller alone; may be given again. "
    f"One of: {', '.join(CONTROLLER_NAMES)}; a plug-in's; or package.module:Class of yours.",
)


def _alone(context: click.Context, _parameter: click.Parameter, value: str | None) -> str | None:
    if value is not None and context.params.get("workers") is not None:
        raise click.UsageError("--workers and --scheduler: give one; a cluster has its own workers")
    if value is not None and not value.strip():
        remedy = "give one like tcp://host:8786, its file, or leave --scheduler out"
        raise click.UsageError(f"--scheduler = {value!r}: must be an address; {remedy}")
    return value


# ``--workers`` (``workers``) and ``--scheduler`` (``scheduler``).
scheduler_options = together(
    workers_option,
    click.option(
        "--scheduler",
        metavar="ADDRESS",
        callback=_alone,
        help="Run on the workers of this Dask scheduler: tcp://host:8786 or tls://host:8786 "
        "for one, or its file.",
    ),
)
