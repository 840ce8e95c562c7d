"""``fingerdesign``: the group of subcommands, and how failures become exit codes.

0 done; 1 the work failed; 2 the input is wrong (one line a fault); 130 interrupted.
"""

import errno
import os
import signal
import sys
import threading
import time
import traceback
import warnings
from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from io import StringIO
from types import FrameType

import click

import fingerdesign
from fingerdesign import errors
from fingerdesign.runtime.files import is_full
from fingerdesign.runtime.limits import forget, reached
from fingerdesign_cli.commands import finger, hand
from fingerdesign_cli.options import Group, limit_option, permit
from fingerdesign_cli.terminal import degrade_signs

OK, FAILED, BAD_INPUT, INTERRUPTED = 0, 1, 2, 130

_FORMATTED = warnings.formatwarning
_end_requested: list[int] = []  # the signals that came
_ending: list[float] = []  # when the first of them was obeyed, s
_PATIENCE_S = 2.0  # a second signal within it is the first one's echo


@click.group(
    cls=Group,
    context_settings={"help_option_names": ["-h", "--help"], "max_content_width": 100},
    epilog="Exit codes: 0 done; 1 the work failed; 2 the input is wrong; 130 interrupted.",
)
@click.version_option(fingerdesign.__version__, prog_name="fingerdesign")
@click.option("--debug", is_flag=True, help="Keep the traceback of an unexpected error.")
@click.option(
    "--allow-code",
    is_flag=True,
    expose_value=False,
    callback=permit,
    help="Import the code that a design or study names (package.module:Class): if you trust it.",
)
@limit_option("--time-limit", "S", 0.1, "Stop after so many seconds")
@limit_option("--memory-limit", "MB", 1.0, "Stop when all processes together use more")
def cli(debug: bool) -> None:
    """Design, simulate and compare elastic tactile fingers that detect incipient slip.

    Start with `fingerdesign new mine.toml`, `fingerdesign view mine.toml --open` and
    `fingerdesign analyse mine.toml --open`; `fingerdesign optimise mine.toml` makes a finger pass.
    What is written goes to out/NAME, or below --out. The options below may also stand behind a
    command.
    """


cli.add_under("design", finger.new, finger.check, finger.view, finger.studio, finger.generate)
cli.add_under("design", finger.mesh)
cli.add_under("analyse", finger.analyse, hand.grip, finger.validate)
cli.add_under("choose", finger.sweep, finger.optimise, finger.compare)
cli.add_under("cast", finger.mold, finger.tolerance)
cli.add_under("control", hand.train, hand.study, hand.identify, hand.export)
cli.add_under("reference", finger.list_)
if find_spec("fingerdesign_bench") is not None:  # benchmarks/ is in a checkout, not in the wheel
    for _each in ("paper", "bench"):
        cli.add_under("reference", import_module(f"fingerdesign_bench.cli.{_each}").command)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line ``argv`` (without the program's name) and return its exit code."""
    arguments = list(sys.argv[1:] if argv is None else argv)
    warnings.formatwarning = _warned
    degrade_signs()
    forget()
    try:
        code = cli.main(args=arguments, prog_name="fingerdesign", standalone_mode=False)
        return code if isinstance(code, int) else OK
    except (Exception, KeyboardInterrupt) as error:
        return _report(error, keep="--debug" in arguments)


def _report(error: Exception | KeyboardInterrupt, keep: bool) -> int:
    """Report an error in words; its exit code. keep: the traceback of an unexpected one."""
    if isinstance(error, click.ClickException):
        text = StringIO()
        error.show(text)
        return _failure(text.getvalue().rstrip("\n").expandtabs(2), error.exit_code)
    if isinstance(error, errors.DesignError):
        return _failure(str(error), BAD_INPUT)
    if isinstance(error, BrokenPipeError):  # nobody reads our output: `fingerdesign ... | head`
        sys.stdout = None
        return FAILED
    if isinstance(error, OSError) and error.errno == errno.ENAMETOOLONG:
        name = str(error.filename)[:60]
        return _failure(f"{name}... is too long for the name of a file", BAD_INPUT)
    if isinstance(error, OSError):
        remedy = "; free space there, or write to another disk" if is_full(error) else ""
        return _failure(f"failed: {error}{remedy}")
    if _end_requested or isinstance(error, click.Abort | KeyboardInterrupt):
        # An extension that was loading makes an ImportError of a signal.
        stopped = error.__cause__ if isinstance(error, click.Abort) else error
        stored = str(stopped) if isinstance(stopped, KeyboardInterrupt) else ""
        return _interrupted(f"; {stored}" if stored else "")
    if isinstance(error, errors.FingerDesignError):
        return _failure(f"failed: {error}")
    return _unexpected(error, keep)


def _failure(text: str, code: int = FAILED) -> int:
    """Print a failure: whatever a file or an argument holds, the terminal obeys none of it. The
    exit code."""
    click.echo(errors.printable(text), err=True)
    return code


def _warned(
    message: Warning | str,
    category: type[Warning],
    filename: str,
    lineno: int,
    line: str | None = None,
) -> str:
    """A warning's text: a plug-in's sentence alone, any other as Python has it."""
    if issubclass(category, errors.PluginWarning | errors.FormerKeyWarning):
        return errors.printable(f"{message}\n")
    return _FORMATTED(message, category, filename, lineno, line)


def _interrupted(stored: str) -> int:
    """Say so; stored: what becomes of the work, where its command stores any."""
    if limit := reached():  # of memory as much is needed again, of time what is left
        more = "; raise it" if "--memory-limit" in limit else ""
        return _failure(f"stopped: {limit}{more}{stored}")
    return _failure(f"interrupted{stored}", INTERRUPTED)


def _unexpected(error: Exception, keep: bool) -> int:
    """Report a defect of the program in one line; with ``keep`` its traceback goes to a file."""
    _failure(f"unexpected {type(error).__name__}: {error}")
    if keep:
        from tempfile import NamedTemporaryFile

        with NamedTemporaryFile(
            "w", prefix="fingerdesign-", suffix=".txt", delete=False, encoding="utf-8"
        ) as file:
            traceback.print_exc(file=file)
        click.echo(f"its traceback is in {file.name}", err=True)
    else:
        click.echo("this is a defect: run `fingerdesign --debug ...` for its traceback", err=True)
    return FAILED


def entry_point() -> None:
    """Run as a console script; a signal to end interrupts it."""
    for name in ("SIGINT", "SIGTERM", "SIGHUP"):
        number = getattr(signal, name, None)
        if number is not None and signal.getsignal(number) != signal.SIG_IGN:  # as under nohup
            signal.signal(number, _interrupt)
    sys.exit(main(sys.argv[1:]))


def _interrupt(number: int, frame: FrameType | None) -> None:
    _end_requested.append(number)
    if _ending and time.monotonic() - _ending[0] < _PATIENCE_S:
        return  # A second signal at once, as of `timeout` and shells: writing goes on.
    if _ending:  # A later signal: worker processes end with this one.
        os._exit(INTERRUPTED)
    if _delays(frame):  # a moment later
        again = threading.Timer(0.05, signal.raise_signal, (number,))
        again.daemon = True
        again.start()
        return
    _ending.append(time.monotonic())
    raise KeyboardInterrupt


def _delays(frame: FrameType | None) -> bool:
    """True while compiled code runs that bears no interruption: VTK and OCP crash as they load;
    SciPy's Sobol sequence swallows it, and all its points are the same."""
    while frame is not None:
        if frame.f_code.co_filename.startswith("<frozen importlib"):
            return True
        if frame.f_globals.get("__name__") == "scipy.stats._qmc":
            return True
        frame = frame.f_back
    return False


if __name__ == "__main__":
    entry_point()
