"""Thousands of hostile files for the command line: it may refuse them, with a sentence, or do.

Each input is a number. Wrong are: an exit code but 0, 1 and 2; a failure without a sentence, with
the word "unexpected", a traceback, or what a terminal would obey; a warning of Python's; more than
10 s of processor time, or 60 s by the clock, to refuse; what check refuses and another command
takes; anything changed or left next to OUT, or half-written in it; a spoiled cache that changes an
answer.
"""

import contextlib
import io
import json
import os
import shutil
import signal
import tempfile
import time
import warnings
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from types import FrameType

from tests.fuzz.inputs import KINDS, chance_of, corpus, kind_of

REFUSED_S, CLOCK_S = 10.0, 60.0


class TooLong(BaseException):
    """Raised by a timer, through whatever catches errors."""


@dataclass
class Judged:
    """What one input led to. seconds: processor time of the slowest refusal."""

    number: int
    kind: str
    exits: list[int] = field(default_factory=list)
    seconds: float = 0.0
    wrong: list[str] = field(default_factory=list)


@contextlib.contextmanager
def fuzzing(folder: Path) -> Iterator[None]:
    """The environment in which inputs are judged: files of the run's own, timers."""
    names = ("FINGERDESIGN_FUZZ", "FINGERDESIGN_CACHE")
    before = {name: os.environ.get(name) for name in names}
    place, temporary_before, where = folder.absolute(), tempfile.tempdir, Path.cwd()
    os.environ |= {"FINGERDESIGN_FUZZ": str(place), "FINGERDESIGN_CACHE": str(place / "cache")}
    handlers = [(each, signal.signal(each, _ring)) for each in (signal.SIGPROF, signal.SIGALRM)]
    try:
        corpus()
        yield
    finally:
        for each, handler in handlers:
            signal.signal(each, handler)
        os.chdir(where)
        tempfile.tempdir = temporary_before
        for name, value in before.items():
            os.environ.pop(name)
            os.environ |= {} if value is None else {name: value}


def _ring(number: int, frame: FrameType | None) -> None:
    raise TooLong("processor" if number == signal.SIGPROF else "clock")


@contextlib.contextmanager
def _limited() -> Iterator[None]:
    signal.setitimer(signal.ITIMER_PROF, REFUSED_S)
    signal.setitimer(signal.ITIMER_REAL, CLOCK_S)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.setitimer(signal.ITIMER_REAL, 0.0)


def judge(number: int, kind: str = "") -> Judged:
    """Lay an input out, run its commands in this process, and say what was wrong."""
    found = Judged(number, kind or kind_of(number))
    place = Path(os.environ["FINGERDESIGN_FUZZ"]) / f"{number}"
    shutil.rmtree(place, ignore_errors=True)
    folder, out = place / "in", place / "out"
    temporary = place / "tmp"
    for each in (folder, temporary):
        each.mkdir(parents=True)
    lines = KINDS[found.kind].lay(folder, out, chance_of(number))
    tempfile.tempdir = str(temporary)
    os.chdir(folder)
    cache = os.environ["FINGERDESIGN_CACHE"]
    if found.kind == "caches":
        os.environ["FINGERDESIGN_CACHE"] = str(folder / "cache")
    before = seen(folder)
    for line in lines:
        code = _run(line, found)
        if code != 2:
            break
    os.environ["FINGERDESIGN_CACHE"] = cache
    if len(found.exits) > 1 and found.exits[-1] == 0:
        found.wrong.append(f"check refuses what {lines[-1][0]} takes")
    if found.kind == "caches":
        found.wrong += _other_answer(out) if found.exits == [0] else ["a spoiled cache fails"]
    else:
        found.wrong += [f"{each} changed" for each in sorted(before ^ seen(folder))[:3]]
    left = [each for each in (place / "tmp").iterdir() if each.name.startswith("fingerdesign")]
    found.wrong += [f"{each.name} left in the temporary folder" for each in left]
    hidden = [each.name for each in place.rglob(".*") if folder not in each.parents]
    found.wrong += [f"{name} left next to OUT" for name in hidden]
    os.chdir(place.parent)
    if not found.wrong:
        shutil.rmtree(place)
    return found


def seen(folder: Path) -> set[tuple[str, int, int]]:
    """Every file below a folder, with size and time."""
    stats = [(each, each.lstat()) for each in folder.rglob("*")]
    return {(str(each), stat.st_size, stat.st_mtime_ns) for each, stat in stats}


def _other_answer(out: Path) -> list[str]:
    own, known = (
        json.loads((folder / "result.json").read_text())["increments"]
        for folder in (out / "small", corpus() / "result")
    )
    return [] if own == known else ["a spoiled cache changes the answer"]


def _run(line: list[str], found: Judged) -> int:
    """One command line in this process; its exit code, -1 where it did not come to an end."""
    from fingerdesign_cli.main import main

    error, start = io.StringIO(), time.process_time()
    name, what = line[0], found.wrong
    try:
        with (
            warnings.catch_warnings(record=True) as warned,
            contextlib.redirect_stdout(io.StringIO()),
            contextlib.redirect_stderr(error),
        ):
            warnings.simplefilter("always")
            with _limited():
                code = main(line)
    except TooLong as limit:
        what.append(f"{name} takes too long by the {limit}")
        code = -1
    except BaseException as escaped:
        what.append(f"{name} lets {type(escaped).__name__} escape: {escaped}"[:300])
        code = -1
    seconds, written = time.process_time() - start, error.getvalue()
    found.exits.append(code)
    if code != 0:
        found.seconds = max(found.seconds, seconds)
    if code not in (-1, 0, 1, 2):
        what.append(f"{name} exits with {code}")
    if code > 0 and not written.strip():
        what.append(f"{name} fails without a sentence")
    if "unexpected " in written.partition(":")[0] or "Traceback" in written:
        what.append(f"{name}: {written.strip()[:300]}")
    if any(not (each.isprintable() or each in "\n\t") for each in written):
        what.append(f"{name} says what a terminal would obey")
    what += [f"{name} warns: {each.message}"[:300] for each in warned]
    return code
