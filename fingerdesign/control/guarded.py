"""Controllers that are not shipped, watched: what they answer is judged before anything moves.

A class of somebody's may raise, return what is no :class:`Command`, ask for a move that is no
number, write into what it is handed, print, or change numpy's settings. None of it may reach the
plant, the record, or standard output, which scripts read; the defect is named with its line.
"""

import math
import sys
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stdout
from dataclasses import replace
from numbers import Real
from typing import Any

import numpy as np

from fingerdesign.control.command import Command, Controller
from fingerdesign.control.signals import Calibration, Sample
from fingerdesign.errors import FingerDesignError

MOST_MOVE = 1000.0  # mm a step: no stage travels so far, and its square is still a sound number
_ROUNDING = 1e-6  # a network's share may pass 0 or 1 by so much


class ControllerError(FingerDesignError):
    """A controller that is not shipped raised, or answered what is no command."""


class Guarded:
    """A controller as it is, whose answers are judged. Its own attributes are seen through it."""

    def __init__(self, reference: str, make: Callable[[], Controller]) -> None:
        """Make it. reference: what it is called in messages. Raises ControllerError."""
        self._reference = reference
        with self._watched("making it"):
            self._hand = make()
            self.name = str(self._hand.name)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_"):
            raise AttributeError(name)
        return getattr(self._hand, name)

    def start(self, calibration: Calibration, sample: Sample) -> None:
        """Begin a grip. Raises ControllerError."""
        with self._watched("start"):
            self._hand.start(calibration, _read_only(sample))

    def command(self, sample: Sample) -> Command:
        """The next move, its numbers plain. Raises ControllerError."""
        with self._watched("command"):
            return self._checked(self._hand.command(_read_only(sample)))

    def _checked(self, given: Any) -> Command:
        if not isinstance(given, Command):
            what = type(given).__name__
            raise self._wrong(
                f"command returned a value of type {what}", "return Command(dx, dy, hold)"
            )
        return Command(
            dx=self._number("dx", given.dx, MOST_MOVE),
            dy=self._number("dy", given.dy, MOST_MOVE),
            hold=self._flag("hold", given.hold),
            area=None if given.area is None else self._number("area", given.area, math.inf),
            unsure=None if given.unsure is None else self._flag("unsure", given.unsure),
            stick_ratio=None if given.stick_ratio is None else self._share(given.stick_ratio),
            warns=None if given.warns is None else self._flag("warns", given.warns),
        )

    def _number(self, name: str, given: Any, most: float) -> float:
        plain = given.item() if isinstance(given, np.ndarray) and given.ndim == 0 else given
        number = float(plain) if isinstance(plain, Real) else math.nan
        if math.isfinite(number) and abs(number) <= most:
            return number
        within = "" if math.isinf(most) else f" of at most {most:g} mm either way"
        raise self._wrong(f"{name} = {given!r:.60}", f"it must be a finite number{within}")

    def _share(self, given: Any) -> float:
        share = self._number("stick_ratio", given, math.inf)
        if -_ROUNDING <= share <= 1.0 + _ROUNDING:
            return min(max(share, 0.0), 1.0)
        raise self._wrong(f"stick_ratio = {share:g}", "it must be from 0 to 1, or None")

    def _flag(self, name: str, given: Any) -> bool:
        plain = given.item() if isinstance(given, np.ndarray) and given.ndim == 0 else given
        if isinstance(plain, bool | np.bool_) or (isinstance(plain, int) and plain in (0, 1)):
            return bool(plain)
        raise self._wrong(f"{name} = {given!r:.60}", "it must be True or False")

    def _wrong(self, what: str, remedy: str) -> ControllerError:
        return ControllerError(f"the controller {self._reference}: {what}; {remedy}")

    @contextmanager
    def _watched(self, method: str) -> Iterator[None]:
        """Send prints to stderr, restore numpy's settings, name what is raised."""
        try:
            with redirect_stdout(sys.stderr), np.errstate():
                yield
        except FingerDesignError:
            raise
        except (Exception, SystemExit) as error:
            why = " ".join(f"{type(error).__name__}: {error}".split())[:300]
            remedy = f"correct it{_place(error)}"
            raise self._wrong(f"{method} raised {why}", remedy) from None


def _read_only(sample: Sample) -> Sample:
    """The sample with readings that nobody can write into."""
    readings = np.array(sample.readings)
    readings.setflags(write=False)
    return replace(sample, readings=readings)


def _place(error: BaseException) -> str:
    """The place of an error: ", FILE line N"."""
    frames = traceback.extract_tb(error.__traceback__)
    own = [each for each in frames if each.filename != __file__]
    return f", {own[-1].filename} line {own[-1].lineno}" if own else ""
