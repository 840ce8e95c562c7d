"""``fingerdesign sweep``: all variants of a study, on the cores at hand or on a cluster."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import click

from fingerdesign.checks.load import read_text
from fingerdesign.search.compare.recommend import recommend
from fingerdesign.search.compare.words import summary
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.folder import FOLDER, write_study
from fingerdesign.search.run.jobs import planned, study_scenes
from fingerdesign.search.run.run import run_jobs
from fingerdesign.search.run.store import TRANSIENT, Store
from fingerdesign.search.study.file import parse_study, study_path
from fingerdesign.search.study.variants import base_design, variants
from fingerdesign_cli.common import (
    output_folder,
    output_options,
    progress,
    refuse_foreign,
)
from fingerdesign_cli.study_progress import StudyProgress, line, say_failures, scheduler_options

if TYPE_CHECKING:
    from fingerdesign.records.outcome import Outcome
    from fingerdesign.search.compare.read import Comparison
    from fingerdesign.search.run.run import Standing

_FILE = click.Path(path_type=Path)
_KINDS = {
    "invalid": "invalid",
    "refused": "refused",
    "failed": "without a result",
    "crashed": "crashed",
    "timeout": "out of time",
    "memory": "out of memory",
}


@click.command("sweep")
@click.argument("study_file", metavar="STUDY", type=_FILE)
@click.option(
    "--out",
    required=True,
    type=_FILE,
    callback=output_folder,
    help="Outcomes, tables and report.html go to OUT/NAME of the study.",
)
@scheduler_options
@click.option("--retry", is_flag=True, help="Run again what failed: for time, memory, a crash.")
@output_options
def command(
    study_file: Path,
    out: Path,
    workers: int | None,
    scheduler: str | None,
    retry: bool,
    quiet: bool,
    as_json: bool,
) -> int:
    """Analyse every variant of STUDY, a TOML file or a shipped study, and compare them.

    Each variant is analysed in a process of its own under the study's [limits]: one that crashes,
    hangs or takes too much memory is a failure with its cause, and the rest goes on. What is done
    is kept at once, by content: interrupted or run again, a study computes only what is missing,
    and two studies share what they have in common.

    With --json a line of JSON an outcome as it comes (number: the variant's; done: how many are),
    and a last one for the folder. With --quiet one line where variants failed. Exit code 1 where no
    variant at all could be analysed.
    """
    path = study_path(study_file)
    text, folder = read_text(path), path.parent
    study = parse_study(text, str(study_file))
    target = out / study.name
    refuse_foreign(FOLDER, target)
    scenes = study_scenes(study, folder)
    plan = list(planned(study, variants(study, base_design(study, folder)), scenes))
    with progress(study.name, quiet or as_json) as show:
        told = StudyProgress(show, quiet, as_json)
        with Cluster(workers, scheduler) as cluster:
            told.cluster = cluster
            outcomes = run_jobs(plan, Store(), cluster, study.limits, told, retry=retry)
        show("writing the report", 1.0)
        with FOLDER.written(target) as aside:
            found = write_study(aside, study, outcomes, text)
    if as_json:
        line({"folder": str(target), **_counts(outcomes, told.last)})
    elif not quiet:
        _show(found, outcomes, told.last, target)
    else:
        failures = sum(outcome.failure is not None for outcome in outcomes)
        say_failures(failures, len(outcomes), target / "failures.csv")
    return 0 if any(outcome.status == "ok" for outcome in outcomes) else 1


def _counts(outcomes: Sequence[Outcome], last: Standing | None) -> dict[str, object]:
    """What came of a study, for scripts."""
    kinds = Counter(outcome.failure.kind for outcome in outcomes if outcome.failure is not None)
    return {
        "variants": len(outcomes),
        "failures": sum(kinds.values()),
        "failures_by_kind": dict(sorted(kinds.items())),
        "from_store": 0 if last is None else last.stored,
        "computed": 0 if last is None else last.computed,
        "seconds": 0.0 if last is None else round(last.seconds, 3),
    }


def _show(
    found: Comparison, outcomes: Sequence[Outcome], last: Standing | None, target: Path
) -> None:
    facts = found.facts
    best = recommend(found.outcomes, facts.objectives, facts.constraints)
    said = summary(found.outcomes, facts, best)
    click.echo(said.counts)
    counts = _counts(outcomes, last)
    kinds = counts["failures_by_kind"]
    assert isinstance(kinds, dict)
    if kinds:
        told = ", ".join(f"{number} {_KINDS[kind]}" for kind, number in kinds.items())
        click.echo(f"failed: {told}; causes in {target / 'failures.csv'}")
    if set(kinds) & set(TRANSIENT):
        click.echo("--retry runs these again, with the limits that the study has now")
    if counts["computed"] == 0 and counts["from_store"]:
        click.echo("nothing was computed: every outcome was in the store")
    elif counts["from_store"]:
        click.echo(f"{counts['computed']} computed, {counts['from_store']} were in the store")
    click.echo(f"recommended: {said.recommended}. {said.why}" if said.recommended else said.why)
    click.echo(f"report: {target / 'report.html'}")
