"""The button *make it pass*: the search of ``fingerdesign optimise DESIGN`` in another process.

Its process writes the best finger so far into a file; the page looks at it. Killed at any time, it
leaves the best so far.
"""

import pickle
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path

from fingerdesign.analysis.case import Case
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, FingerDesignError, SolverError
from fingerdesign.records.result import Result
from fingerdesign.records.verdict import VerdictView
from fingerdesign.runtime.files import scratch, write_whole
from fingerdesign.runtime.isolate import Worker
from fingerdesign.search.passing.found import Candidate, unready
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.passing import Callbacks, evaluated_by, most_trials, search_passing
from fingerdesign.search.passing.space import space_of
from fingerdesign.search.run.cluster import Cluster

_FILE = "progress.pkl"  # A pickle knows which keys the design states; JSON would state all.


@dataclass(frozen=True)
class Progress:
    """The state of a search: its step in words; the best finger so far and its verdicts.

    confirmed: the verdicts are those of the whole finger, else of a trial. conflict: why no finger
    passes, once the search has ended.
    """

    message: str = "starting"
    best: Design | None = None
    view: VerdictView | None = None
    confirmed: bool = False
    conflict: str = ""


def default_trials(design: Design) -> int:
    """Trials that the command takes by default; 1 where it refuses the design."""
    try:
        return most_trials(space_of(design, Freedom()))
    except DesignError:
        return 1


def search(design: Design, folder: Path, most: int) -> Progress:
    """Search from the design; the progress is in the folder all the while.

    Raises DesignError where nothing can vary, and errors of the work.
    """
    from fingerdesign.pipeline import analyse_into  # It loads the solvers.

    now = Progress()

    def show(**news: object) -> None:
        nonlocal now
        now = replace(now, **news)  # type: ignore[arg-type]
        write_whole(folder / _FILE, pickle.dumps(now))

    def report(message: str) -> None:
        show(message=message)

    def improved(best: Candidate) -> None:
        show(best=best.design, view=best.view, confirmed=best.result is not None)

    def confirm(found: Design) -> Result:
        return analyse_into(Case(found, mesh_error=True), folder, page=False, cad=False)

    with Cluster() as cluster:
        calls = Callbacks(evaluated_by(cluster), confirm, report, improved, unready)
        found = search_passing(design, Freedom(), folder / "trials.sqlite", calls, most)
    if found.best is not None:
        improved(found.best)
    words = filter(None, (f"{len(found.tried)} trials", found.given_up, found.note))
    show(message=". ".join(words), conflict=found.conflict)
    return now


class PassingSearch:
    """One search: run by one thread, looked at and stopped from any other."""

    def __init__(self) -> None:
        self._worker, self._folder = Worker(), Path()
        self.last = Progress()
        self.stopped = self._ended = False

    def run(self, design: Design, most: int) -> None:
        """Search to the end, which is ``last`` then; also where it fails or was stopped.

        Raises FingerDesignError where it fails.
        """
        with scratch("studio") as self._folder, self._worker as worker:
            try:
                found = worker.call(search, design, self._folder, most, time_s=None)
                self._ended, self.last = True, found
            except FingerDesignError as error:
                message = "stopped" if self.stopped else "failed"
                found = replace(self.progress(), message=f"{message}; the best so far stays")
                self._ended, self.last = True, found
                if not self.stopped:
                    raise SolverError(f"the search failed: {error}") from error

    def progress(self) -> Progress:
        """The present state."""
        if not self._ended:
            with suppress(OSError):
                self.last = pickle.loads((self._folder / _FILE).read_bytes())
        return self.last

    def stop(self) -> None:
        """End it; the best finger so far stays."""
        self.stopped = True
        self._worker.kill()
