"""``fingerdesign compare``: which finger is better at what, and why, on one page."""

from collections.abc import Sequence
from dataclasses import astuple, dataclass
from pathlib import Path

import click

from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.outcome import Outcome, designs_csv
from fingerdesign.records.result_files import RESULT_FILE
from fingerdesign.runtime.files import why_no_place, write_whole
from fingerdesign.runtime.registry import unknown_name
from fingerdesign.search.compare.page import compare_html
from fingerdesign.search.compare.read import OUTCOMES_FILE, STUDY_FILE, Comparison, read_comparison
from fingerdesign.search.compare.recommend import (
    GOALS,
    Objective,
    Recommendation,
    recommend,
    why_not,
)
from fingerdesign.search.compare.table import design_table
from fingerdesign.search.compare.words import summary
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.evaluate import Job
from fingerdesign.search.run.run import Store, run_jobs
from fingerdesign.search.study.file import Limits
from fingerdesign.search.study.metrics import METRICS
from fingerdesign_cli import terminal
from fingerdesign_cli.inputs import GOES_ON, interrupted
from fingerdesign_cli.options import Options
from fingerdesign_cli.studies.progress import StudyProgress
from fingerdesign_cli.studies.search import say_recommended

MOST_DESIGNS = 12  # of a terminal's table; the page has all
LIMITS = Limits(time_s=1800.0, memory_MB=8000.0)  # of one in 3-D: a minute, some gigabytes


@dataclass(frozen=True)
class Files(Options):
    """The files to write: the page, and a table where it is requested."""

    out: Path
    csv_file: Path | None

    def refuse_places(self, results: Sequence[Path]) -> None:
        """A usage error where a file cannot go: folders, what is read here, one place for two."""
        read = {path.resolve() for path in results}
        taken: set[Path] = set()
        for option, given in zip(("--out", "--csv"), astuple(self), strict=True):
            if given is None:
                continue
            if why := _why_not(option, given, read, taken):
                raise click.UsageError(f"{option} = {given}: {why}; choose another")
            taken.add(given.resolve())


def compare(
    results: tuple[Path, ...], files: Files, requested: tuple[str, ...], complete: bool
) -> int:
    """Compare the designs of every RESULT on one page that opens offline."""
    files.refuse_places(results)
    shown = complete and not terminal.as_json()
    with (
        interrupted(GOES_ON if complete else ""),
        terminal.progress("missing metrics", shown) as show,
        Cluster() as cluster,
    ):

        def work(jobs: Sequence[Job]) -> tuple[Outcome, ...]:
            look = StudyProgress(show, cluster, silent=True)
            return run_jobs(list(jobs), Store(), cluster, LIMITS, look)

        given = work if complete else None
        found = read_comparison(results, _objectives(requested), given)
    _refuse_unknown(found)
    outcomes, facts = found.outcomes, found.facts
    best = recommend(outcomes, facts.objectives, facts.constraints)
    texts = {files.out: compare_html(outcomes, facts)}
    if files.csv_file is not None:
        texts[files.csv_file] = designs_csv(outcomes)
    for path, text in texts.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        write_whole(path, text)
    out = files.out
    return terminal.say_result(
        lambda: _reported(found, best, out), lambda: _show(found, best, out), out
    )


def _why_not(option: str, given: Path, read: set[Path], taken: set[Path]) -> str:
    """Explain why a file cannot be written there; "" where it can."""
    path = given.resolve()
    above = next((each for each in path.parents if each.exists()), path)
    cannot = why_no_place(path.parent)
    records = (OUTCOMES_FILE, STUDY_FILE, RESULT_FILE)
    in_result = given.is_file() and any((path.parent / name).is_file() for name in records)
    results_own = path in read or path.name in records or in_result
    is_other = given.exists() and not given.is_file()
    ends = (".html", ".htm") if option == "--out" else (".csv",)
    reasons = (
        (is_other, "must be a regular file, not a folder, a pipe or a device"),
        (not above.is_dir(), "must be a file in a folder"),
        (results_own, "must not be a result's own file"),
        (path.suffix.lower() not in ends, f"must end in {ends[0]}"),
        (path in taken, "must not be that of another option"),
        (bool(cannot), f"must be a file in a folder that can be written into, and {cannot}"),
    )
    return next((words for wrong, words in reasons if wrong), "")


def _objectives(requested: Sequence[str]) -> list[Objective]:
    found: list[Objective] = []
    for text in requested:
        metric, _, goal = text.partition(":")
        known = METRICS.get(metric)
        if known is None and not goal:
            raise DesignError([unknown_name(metric, "--objective", list(METRICS))])
        goal = goal or (known.better if known is not None and known.better else "")
        if goal not in GOALS:
            raise click.UsageError(
                f"--objective {text}: must be METRIC:min or METRIC:max; say which end is better"
            )
        if metric in [each.metric for each in found]:
            remedy = "leave the second one out"
            raise DesignError([Fault("--objective", text, "a metric once", remedy)])
        found.append(Objective(metric, "min" if goal == "min" else "max"))
    return found


def _refuse_unknown(found: Comparison) -> None:
    """DesignError for an objective that no outcome has a value of."""
    good = [outcome for outcome in found.outcomes if outcome.status == "ok"]
    names = sorted({name for outcome in good for name in outcome.metrics})
    requested = [each.metric for each in found.facts.objectives if good]
    if faults := [unknown_name(m, "--objective", names) for m in requested if m not in names]:
        raise DesignError(faults)


def _reported(found: Comparison, best: Recommendation, out: Path) -> dict[str, object]:
    outcomes, facts = found.outcomes, found.facts
    chosen = None if best.chosen is None else outcomes[best.chosen]
    return {
        "report": str(out),
        "designs": len(outcomes),
        "failed": sum(outcome.status == "failed" for outcome in outcomes),
        "feasible": len(best.feasible),
        "recommended": None if chosen is None else chosen.name,
        "values": {} if chosen is None else chosen.values,
        "no_difference_shown": [outcomes[number].name for number in best.same],
        "not_feasible": {
            outcome.name: list(causes)
            for outcome in outcomes
            if (causes := why_not(outcome, facts.objectives, facts.constraints))
        },
        "front": [outcomes[number].name for number in best.front],
        "objectives": [{"metric": each.metric, "goal": each.goal} for each in facts.objectives],
        "warnings": list(summary(outcomes, facts, best).warnings),
    }


def _show(found: Comparison, best: Recommendation, page: Path) -> None:
    head = summary(found.outcomes, found.facts, best)
    _show_designs(found, best)
    terminal.say_wrapped(head.counts)
    say_recommended(head)
    if head.table is not None:
        terminal.print_table(
            head.table.caption, head.table.columns, head.table.rows, terminal.WIDTH
        )
        if any("±" in cell for row in head.table.rows for cell in row):
            terminal.say_marked(
                "", "±: twice the deviation by chance, as of another mesh or another seed"
            )
    for sentence in head.given_up:
        terminal.say_marked("", f"better elsewhere: {sentence}")
    for sentence in head.warnings:
        terminal.say_wrapped(f"warning: {sentence}")
    click.echo(f"report: {page}")


def _show_designs(found: Comparison, best: Recommendation) -> None:
    """The best designs in a table: verdicts that fail, and the objectives."""
    table = design_table(found.outcomes, found.facts, best)
    wanted = ["failed_verdicts", *(each.metric for each in found.facts.objectives)]
    shown = [k for k, each in enumerate(table.columns) if each.path[-1] in wanted]
    headings = ["design", "standing", *(table.columns[k].heading for k in shown)]
    rows = [
        [found.outcomes[number].name, cells[0], *(cells[1 + k] for k in shown)]
        for number, _, cells in table.rows[:MOST_DESIGNS]
    ]
    if rows:
        of = f" ({len(rows)} of {len(table.rows)})" if len(table.rows) > len(rows) else ""
        terminal.print_table(f"Designs{of}", headings, rows, terminal.WIDTH)
