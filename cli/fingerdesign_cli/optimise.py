"""``fingerdesign optimise``: search for better fingers, and confirm the best of them."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.checks.load import read_text
from fingerdesign.search.optimise.confirm import Optimised, confirm
from fingerdesign.search.optimise.folder import FOLDER, journal_beside, write_optimised
from fingerdesign.search.optimise.optimise import BATCH, Search, refuse_aimless, searched
from fingerdesign.search.optimise.page import confirmed_table, sensitivity_tables, verdict
from fingerdesign.search.optimise.trials import Trials
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.jobs import study_scenes
from fingerdesign.search.run.run import run_jobs
from fingerdesign.search.run.store import Store
from fingerdesign.search.study.file import parse_study, study_path
from fingerdesign.search.study.variants import base_design
from fingerdesign_cli.common import (
    output_folder,
    output_options,
    print_table,
    progress,
    refuse_foreign,
)
from fingerdesign_cli.study_progress import StudyProgress, line, say_failures, scheduler_options

if TYPE_CHECKING:
    from fingerdesign.records.outcome import Outcome
    from fingerdesign.search.optimise.confirm import Optimised
    from fingerdesign.search.run.jobs import Planned
    from fingerdesign.search.run.run import Standing

_FILE = click.Path(path_type=Path)


@click.command("optimise")
@click.argument("study_file", metavar="STUDY", type=_FILE)
@click.option(
    "--out",
    required=True,
    type=_FILE,
    callback=output_folder,
    help="Outcomes, tables and report.html go to OUT/NAME of the study.",
)
@click.option(
    "--trials",
    type=click.IntRange(1, 100_000),
    help="How many trials in all; without it as many as the study's [optimise] says.",
)
@scheduler_options
@click.option("--retry", is_flag=True, help="Run again what failed for time, memory or a crash.")
@output_options
def command(
    study_file: Path,
    out: Path,
    trials: int | None,
    workers: int | None,
    scheduler: str | None,
    retry: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Search STUDY for fingers that are better in its [[objectives]], within its [constraints].

    Trials are drawn by Optuna and analysed at the study's fidelity; the best of the front, and the
    study's base as the reference, are then analysed in 3-D. OUT/NAME holds report.html (trials
    compared, what stood in 3-D, what each objective hangs on), study.json, outcomes.jsonl, tables.

    The trials stand in OUT/NAME.trials.jsonl, which stays: an interrupted search goes on there, and
    more --trials go on from those that are done. With --json a line of JSON an outcome as it comes
    (number: the trial's; done: how many are). With --quiet one line where trials failed.
    Exit code 1 where no trial at all could be analysed.
    """
    path = study_path(study_file)
    text, folder = read_text(path), path.parent
    study = parse_study(text, str(study_file))
    refuse_aimless(study)
    target = out / study.name
    refuse_foreign(FOLDER, target)
    search = Search(study, base_design(study, folder), study_scenes(study, folder))
    store = Store()
    journal = journal_beside(target.absolute())
    with (
        Trials(study, search.base, journal) as kept,  # held till the folder is written
        progress(study.name, quiet or as_json) as show,
        Cluster(workers, scheduler) as cluster,
    ):
        shown = StudyProgress(show, quiet, as_json)
        shown.cluster = cluster
        tell = _Told(shown, len(search.scenes))

        def evaluated(plan: Sequence[Planned]) -> tuple[Outcome, ...]:
            return run_jobs(plan, store, cluster, study.limits, tell.standing, retry=retry)

        tried = searched(
            search,
            kept,
            evaluated,
            trials,
            max(BATCH, workers or 0),
            tell.trials,
        )
        tell.confirming()
        confirmation = confirm(search, tried, evaluated, lambda message: show(message, None))
        show("writing the report", 1.0)
        with FOLDER.written(target) as aside:
            found = Optimised(search, tried, confirmation)
            write_optimised(aside, found, text)
    if as_json:
        line({"folder": str(target), **found.data()})
    elif not quiet:
        _show(found, target)
    else:
        every = [o for each in tried for o in each.outcomes] + list(confirmation.outcomes)
        failures = sum(o.failure is not None for o in every)
        say_failures(failures, len(every), target / "failures.csv")
    return 0 if any(o.status == "ok" for each in tried for o in each.outcomes) else 1


class _Told:
    """Shows each batch's standing as one of the whole search, then that of the confirmation."""

    def __init__(self, show: StudyProgress, scenes: int) -> None:
        self._show, self._scenes = show, scenes
        self._done = self._of = self._earlier = self._failures = self._before = 0
        self._start: float | None = None
        self._searching = True

    def trials(self, done: int, of: int) -> None:
        """So many trials are done, and of how many."""
        if self._start is None:
            self._start, self._earlier = time.monotonic(), done
        self._done, self._of, self._before = done, of, self._failures

    def confirming(self) -> None:
        """The search is over: from now on the confirmation's own numbers."""
        self._searching = False

    def standing(self, now: Standing) -> None:
        """Show where a batch stands."""
        if not self._searching:
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
        failures = self._failures
        self._show(
            replace(now, number=number, of=of, failures=failures, left=left, seconds=seconds)
        )


def _show(found: Optimised, target: Path) -> None:
    for sentence in (*found.sentences(), *verdict(found)):
        click.echo(sentence)
    for table in (confirmed_table(found), *sensitivity_tables(found)):
        if table is not None:
            print_table(table.caption, table.columns, table.rows)
    click.echo(f"report: {target / 'report.html'}")
