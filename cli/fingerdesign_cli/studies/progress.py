"""The progress of a study or a search, while its variants run."""

import json
import re
import sys
import time
from dataclasses import replace
from typing import Any

import click

from fingerdesign.records.outcome import Failure, Outcome
from fingerdesign.runtime.progress import Progress
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.run import Standing
from fingerdesign_cli.terminal import as_json, quiet, say_wrapped

# The kinds of failures, as a user reads them.
FAILURE_WORDS = {
    "invalid": "invalid",
    "refused": "refused",
    "failed": "without a result",
    "crashed": "crashed",
    "timeout": "out of time",
    "memory": "out of memory",
}
_NUMBER = re.compile(r"-(\d{4,6})(?:-3d|-auto)?$")
_PLAIN_S = 8.0  # between plain lines, where stderr is no terminal; looks are 2 s apart
_FAILURES = 3  # are shown with their reason while a study runs; its report has all


class StudyProgress:
    """Shows the progress of a study, on a bar, in plain lines, or a JSON line an outcome; the first
    failures with their reason.

    cluster: the address of a scheduler's dashboard is reported when it has started. silent: no such
    lines.
    """

    def __init__(self, show: Progress, cluster: Cluster, silent: bool = False) -> None:
        self._show, self._cluster = show, cluster
        self._quiet, self._as_json = silent or quiet(), as_json() and not silent
        self._dashboard_shown, self._failures = False, 0
        self._next, self._waited = 0.0, False
        self._start, self._last = time.monotonic(), ""
        self.last: Standing | None = None

    def __call__(self, standing: Standing) -> None:
        """Show a standing."""
        self.last = standing
        if (standing.threads or standing.waiting) and not self._dashboard_shown:
            self._dashboard_shown = True
            self._dashboard()
        if standing.outcome is not None:
            self._came(standing, standing.outcome)
        now = time.monotonic()
        news = standing.number == standing.of or standing.waiting != self._waited
        if news or sys.stderr.isatty() or now >= self._next:
            self._next, self._waited = now + _PLAIN_S, standing.waiting
            text = words(standing)
            if text == self._last and not sys.stderr.isatty():  # nothing new: it is alive
                text += f", {now - self._start:.0f} s so far"
            else:
                self._last = text
            self._show(text, standing.number / max(standing.of, 1))

    def _dashboard(self) -> None:
        address = self._cluster.dashboard
        if self._as_json and address:
            line({"dashboard": address})
        elif address and not self._quiet:
            click.echo(f"Dask dashboard: {address}", err=True)

    def _came(self, standing: Standing, outcome: Outcome) -> None:
        if self._as_json:
            line(reported(standing))
        elif outcome.failure is not None:
            self._failed(outcome.name, outcome.failure)

    def _failed(self, name: str, failure: Failure) -> None:
        self._failures += 1
        if self._quiet or self._failures > _FAILURES:
            return
        why = " ".join(failure.sentence.split())
        more = "; the report will have the causes of further failures"
        reason = f"{name} {FAILURE_WORDS[failure.kind]}: {why}"
        say_wrapped(reason + more * (self._failures == _FAILURES), err=True)


def words(standing: Standing) -> str:
    """Progress as text: "12 of 200, 1 failed, 3 min left"."""
    parts = [f"{standing.number} of {standing.of}"]
    if standing.failures:
        parts.append(f"{standing.failures} failed")
    if standing.waiting:
        parts.append("waiting for workers")
    elif standing.left is not None and standing.number < standing.of:
        parts.append(f"{duration(standing.left)} left")
    return ", ".join(parts)


def duration(seconds: float) -> str:
    """In words.

    >>> duration(4.2), duration(200.0), duration(9000.0)
    ('4 s', '3 min', '2.5 h')
    """
    if seconds < 90.0:
        return f"{seconds:.0f} s"
    return f"{seconds / 60.0:.0f} min" if seconds < 5400.0 else f"{seconds / 3600.0:.1f} h"


def reported(standing: Standing) -> dict[str, Any]:
    """A standing with an outcome, for scripts. done, of: outcomes at hand, and of how many; number:
    the variant's, None for the reference."""
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


class SearchProgress:
    """Shows each batch's standing as one of the whole search, then that of the confirmation."""

    def __init__(self, show: StudyProgress, scenes: int) -> None:
        self._show, self._scenes = show, scenes
        self._done = self._of = self._earlier = self._failures = self._before = 0
        self._start: float | None = None
        self.searching = True  # else the search is over, and the confirmation's own numbers count

    def trials(self, done: int, of: int) -> None:
        """So many trials are done, and of how many."""
        if self._start is None:
            self._start, self._earlier = time.monotonic(), done
        self._done, self._of, self._before = done, of, self._failures

    def standing(self, now: Standing) -> None:
        """Show the progress of a batch."""
        if not self.searching:
            self._show(now)
            return
        if self._done == self._of:  # trials of an earlier run are read again, or computed
            if now.threads:
                self._show(now)
            return
        self._failures = self._before + now.failures
        number = self._done * self._scenes + now.number
        of, earlier = self._of * self._scenes, self._earlier * self._scenes
        left, seconds = None, time.monotonic() - (self._start or time.monotonic())
        if number > earlier:
            left = seconds / (number - earlier) * (of - number)
        shown: dict[str, Any] = {"number": number, "of": of, "failures": self._failures}
        self._show(replace(now, **shown, left=left, seconds=seconds))


def line(value: dict[str, Any]) -> None:
    """One line of JSON on stdout, at once."""
    click.echo(json.dumps(value, allow_nan=False))
    sys.stdout.flush()
