"""A controller that is a program in any language and answers lines of JSON.

At the begin of each grip it is given, and answers with any JSON:

    {"start": {"grip": {...}, "calibration": {...}, "sample": {...}}}

then, in each control step, {"sample": {...}}, and it answers with the move in mm:

    {"dx": 0.001, "dy": 0.0, "hold": false}

and, if it likes, the other values of control/command.py's Command. A sample holds ``readings`` in
microstrain, ``normal_force`` and ``tangential_force`` in N, and ``lifted``. The same program serves
many grips. It may not know the object: what is written here is all that it is given.
"""

import json
import os
import shlex
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, fields
from functools import lru_cache
from pathlib import Path
from typing import Any, ClassVar

from fingerdesign.control.guarded import Guarded
from fingerdesign.control.roster import Command, Object
from fingerdesign.control.signals import Calibration, Sample
from fingerdesign.design.grip import Grip
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.base import plain
from fingerdesign.runtime.lines import LineProgram, ProgramError

REFERENCE = "fingerdesign.trials.program:Program"
_PROGRAM = "FINGERDESIGN_PROGRAM"  # Command and folder as JSON, for this process and its children.
_GIVEN = ("preload_mm", "approach_step_mm", "shear_step_mm", "max_approach_mm", "max_steps")
_KEYS = frozenset(each.name for each in fields(Command))


@contextmanager
def program(command: str) -> Iterator[None]:
    """Let :class:`Program` run a command line of this folder, within the block.

    DesignError where it does not start.
    """
    try:
        words = shlex.split(command)
        if not words:
            raise ValueError("it is empty")
        LineProgram(words, Path.cwd()).end()
    except (ProgramError, ValueError) as error:
        fault = Fault("--program", command, "a command that can be run", str(error))
        raise DesignError([fault]) from error
    os.environ[_PROGRAM] = json.dumps([words, str(Path.cwd())])
    try:
        yield
    finally:
        del os.environ[_PROGRAM]
        _running.cache_clear()


@lru_cache(1)
def _running(given: str) -> LineProgram:
    words, folder = json.loads(given)
    return LineProgram(words, Path(folder))


class _Piped:
    """The program as a controller; what it answers is judged by Guarded."""

    name = "program"

    def __init__(self, grip: Grip) -> None:
        if _PROGRAM not in os.environ:
            raise ProgramError("no program is given: add --program COMMAND")
        self._given = os.environ[_PROGRAM]
        self._grip: dict[str, Any] = {key: getattr(grip, key) for key in _GIVEN}
        self._grip["sample_rate_Hz"] = grip.hardware.sample_rate_Hz

    def start(self, calibration: Calibration, sample: Sample) -> None:
        begin = {"grip": self._grip, "calibration": plain(calibration), "sample": plain(sample)}
        self._ask({"start": begin})

    def command(self, sample: Sample) -> Command:
        answer = self._ask({"sample": plain(asdict(sample))})
        if not isinstance(answer, dict) or not {"dx", "dy"} <= set(answer) <= _KEYS:
            words = "dx and dy are needed, and only the values of control/command.py are known"
            raise ProgramError(f"the program answered {answer!r:.80}: {words}")
        return Command(**{"hold": False, **answer})

    def _ask(self, question: Any) -> Any:
        try:
            return _running(self._given).ask(question)
        except ProgramError:
            _running.cache_clear()  # The next grip starts it again.
            raise


class Program(Guarded):
    """The program of ``--program`` as a controller."""

    name: ClassVar[str] = "program"  # type: ignore[misc]

    def __init__(self, grip: Grip, own: Any, held: Object) -> None:
        super().__init__("program", lambda: _Piped(grip))
