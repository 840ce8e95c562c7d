"""Progress of long work: one line of plain text at a time, with the fraction that is done."""

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import Protocol

Report = Callable[[str], None]


class Progress(Protocol):
    """Shows how far long work has come."""

    def __call__(
        self, message: str, fraction: float | None = None, left_s: float | None = None
    ) -> None:
        """Show the current action; ``fraction`` in [0, 1] of the whole and the seconds left, None
        if unknown."""


@dataclass(frozen=True)
class ForecastProgress:
    """Adds to a message the fraction of the forecast time that is over, and the seconds left.
    forecast: seconds by stage; done: stages that have ended, filled while the work goes on."""

    show: Progress
    forecast: Mapping[str, float]
    done: Mapping[str, float]

    def __call__(self, message: str) -> None:
        total = sum(self.forecast.values())
        left = sum(each for stage, each in self.forecast.items() if stage not in self.done)
        self.show(message, 1.0 - left / total if total else None, left)


def silent(message: str, fraction: float | None = None, left_s: float | None = None) -> None:
    """A progress that shows nothing."""


_listener: ContextVar[Report | None] = ContextVar("listener", default=None)


@contextmanager
def listening(report: Report) -> Iterator[None]:
    """Show what deeper functions of the block announce."""
    token = _listener.set(report)
    try:
        yield
    finally:
        _listener.reset(token)


def announce(message: str) -> None:
    """Show a message of a function that has no report of its own, where somebody listens."""
    if (report := _listener.get()) is not None:
        report(message)
