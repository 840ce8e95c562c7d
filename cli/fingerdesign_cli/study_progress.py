"""What commands on studies share: where they run, progress with time left and failures."""

from __future__ import annotations

import json
import re
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import click

from fingerdesign_cli.common import Progress

if TYPE_CHECKING:
    from fingerdesign.search.run.cluster import Cluster
    from fingerdesign.search.run.run import Standing

_NUMBER = re.compile(r"-(\d{4,6})(?:-3d|-auto)?$")
_Command = TypeVar("_Command", bound=Callable[..., Any])
_PLAIN_S = 8.0  # between plain lines, where stderr is no terminal; looks are 2 s apart


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
    return value


class StudyProgress:
    """Shows where a study stands, on a bar, in plain lines, or a JSON line an outcome.

    cluster: set it once it is there; its dashboard's address is told when it has started.
    """

    def __init__(self, show: Progress, quiet: bool, as_json: bool) -> None:
        self._show, self._quiet, self._as_json = show, quiet, as_json
        self._said_dashboard = False
        self._next, self._waited = 0.0, False
        self._start, self._said = time.monotonic(), ""
        self.cluster: Cluster | None = None
        self.last: Standing | None = None

    def __call__(self, standing: Standing) -> None:
        """Show a standing."""
        self.last = standing
        if (standing.threads or standing.waiting) and not self._said_dashboard:
            self._said_dashboard = True
            self._dashboard()
        if self._as_json and standing.outcome is not None:
            line(told(standing))
        now = time.monotonic()
        news = standing.number == standing.of or standing.waiting != self._waited
        if news or sys.stderr.isatty() or now >= self._next:
            self._next, self._waited = now + _PLAIN_S, standing.waiting
            said = words(standing)
            if said == self._said and not sys.stderr.isatty():  # nothing new: it is alive
                said += f", {now - self._start:.0f} s so far"
            else:
                self._said = said
            self._show(said, standing.number / max(standing.of, 1))

    def _dashboard(self) -> None:
        address = None if self.cluster is None else self.cluster.dashboard
        if self._as_json:
            line({"dashboard": address})
        elif not self._quiet:
            click.echo(f"Dask dashboard: {address or 'none (it needs bokeh)'}", err=True)


def words(standing: Standing) -> str:
    """As "12 of 200, 1 failed, 3 min left"."""
    said = [f"{standing.number} of {standing.of}"]
    if standing.failures:
        said.append(f"{standing.failures} failed")
    if standing.waiting:
        said.append("waiting for workers")
    elif standing.left is not None and standing.number < standing.of:
        said.append(f"{duration(standing.left)} left")
    return ", ".join(said)


def duration(seconds: float) -> str:
    """In words.

    >>> duration(4.2), duration(200.0), duration(9000.0)
    ('4 s', '3 min', '2.5 h')
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def told(standing: Standing) -> dict[str, Any]:
    """A standing with an outcome, for scripts.

    done, of: outcomes at hand, and of how many; number: the variant's, None for the reference.
    """
    outcome = standing.outcome
    assert outcome is not None
    failure = outcome.failure
    return {
        "done": standing.number,
        "of": standing.of,
        "number": variant_number(outcome.name),
        "name": outcome.name,
        "scene": outcome.scene,
        "status": outcome.status,
        "failure": None if failure is None else {"kind": failure.kind, "cause": failure.sentence},
        "from_store": standing.from_store,
        "failures": standing.failures,
        "seconds": round(standing.seconds, 3),
        "seconds_left": None if standing.left is None else round(standing.left, 1),
    }


def variant_number(name: str) -> int | None:
    """The number in the name of a variant's outcome; None for one of no variant.

    >>> variant_number("fingers-0007"), variant_number("fingers-0007-3d")
    (7, 7)
    >>> variant_number("reference-maeno2000") is None
    True
    """
    found = None if name.startswith("reference-") else _NUMBER.search(name)
    return None if found is None else int(found[1])


def say_failures(failures: int, of: int, causes: Path) -> None:
    """One line on stderr, of variants that failed; nothing where none did."""
    if failures:
        click.echo(f"{failures} of {of} failed: causes in {causes}", err=True)


def line(value: dict[str, Any]) -> None:
    """One line of JSON on stdout, at once."""
    click.echo(json.dumps(value, allow_nan=False))
    sys.stdout.flush()
