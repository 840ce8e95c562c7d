"""``fingerdesign sweep`` and ``optimise``: the variants of a study, here or on a cluster."""

import os
import re
import shlex
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import click

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import load_design
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import file_text, kind_of
from fingerdesign.errors import DesignError, Fault
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import RESULTS
from fingerdesign.runtime.extras import needs
from fingerdesign.runtime.files import write_whole
from fingerdesign.runtime.progress import silent
from fingerdesign.search.compare.folder import FOLDER, kinds_of, write_large_study, write_study
from fingerdesign.search.compare.large import COLUMNS_FILE, MANY
from fingerdesign.search.compare.read import Comparison
from fingerdesign.search.compare.recommend import recommend
from fingerdesign.search.compare.words import Summary, summary
from fingerdesign.search.optimise.confirm import confirm
from fingerdesign.search.optimise.optimise import BATCH, Search, refuse_aimless, searched
from fingerdesign.search.optimise.page import FOLDER as SEARCH_FOLDER
from fingerdesign.search.optimise.page import journal_path, tables, verdict, write_optimised
from fingerdesign.search.optimise.trials import ENDING, Trials
from fingerdesign.search.passing.found import Candidate, Found, SearchStopped, unready
from fingerdesign.search.passing.freedom import Freedom
from fingerdesign.search.passing.front import GOALS
from fingerdesign.search.passing.page import write_page
from fingerdesign.search.passing.passing import Callbacks, evaluated_by, search_passing
from fingerdesign.search.passing.space import changes_between, space_of
from fingerdesign.search.run import run
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.study.file import Study, parse_study
from fingerdesign.search.study.variants import base_design, number_of_points, variants
from fingerdesign.studio.document import edited_text
from fingerdesign_cli import terminal
from fingerdesign_cli.analyse import Products, answer_of
from fingerdesign_cli.inputs import GOES_ON, interrupted, refuse_foreign
from fingerdesign_cli.options import Options
from fingerdesign_cli.studies.progress import FAILURE_WORDS, SearchProgress, StudyProgress, line

_SHOWN = 12  # Changed keys in the terminal; the page has all.
_MADE_BY, _SCHEMA = "# Made by `fingerdesign optimise", "#:schema"
_MOST_NAME = 54  # Characters of a name that leave room for its ending.


def _say_end(kinds: Mapping[str, int], target: Path) -> None:
    """Say where the report is or, with --quiet, how many variants failed; open the report."""
    page, every = target / "report.html", sum(kinds.values())
    failures = every - kinds.get("ok", 0)
    if terminal.as_json():
        pass
    elif not terminal.quiet():
        click.echo(f"report: {page}")
    elif failures:
        terminal.say_wrapped(f"{failures} of {every} failed: causes in {_causes(target)}", err=True)
    terminal.open_page(page)


def _causes(target: Path) -> Path:
    table = target / "failures.csv"
    return table if table.is_file() else target / COLUMNS_FILE


def say_recommended(found: Summary) -> None:
    """Print the recommended design with its values, or why there is none."""
    terminal.say_wrapped(found.words)
    for key, value in found.values.items():
        click.echo(f"  {key} = {value}")


@dataclass(frozen=True)
class Setting(Options):
    """The way to run a study: so many processes, or a cluster; retry: again what failed for time,
    memory or a crash; fidelity: instead of the study's own."""

    workers: int | None
    scheduler: str | None
    retry: bool
    fidelity: str | None

    def read(self, study_file: Path) -> tuple[str, Study]:
        """A study, and its text with the fidelity of the command, where that is given."""
        text = file_text(study_file, "study")
        study = parse_study(text, str(study_file))
        if self.fidelity in (None, study.study.fidelity):
            return text, study
        import tomlkit

        document: Any = tomlkit.parse(text)
        document.setdefault("study", {})["fidelity"] = self.fidelity
        text = tomlkit.dumps(document)
        return text, parse_study(text, str(study_file))


@dataclass(frozen=True)
class FreeKeys(Options):
    """Keys that a search from a design keeps, and that it frees besides its own."""

    keep: tuple[str, ...]
    free: tuple[str, ...]


@interrupted(GOES_ON)
def optimise(
    study_file: Path, out: Path, trials: int | None, keys: FreeKeys, setting: Setting
) -> int:
    """Search STUDY for fingers that are better in its [[objectives]], within its [constraints];
    or from a design for one that passes all verdicts."""
    needs("search", "distributed")
    if kind_of(study_file) != "study":
        if setting.fidelity is not None:
            raise click.UsageError("--fidelity belongs to a study; a design is searched in 3-D")
        return optimise_design(study_file, out, trials, Freedom(keys.keep, keys.free), setting)
    if keys.keep or keys.free:
        raise click.UsageError("--keep and --free belong to a design; a study names its keys")
    (text, study), folder = setting.read(study_file), study_file.parent
    refuse_aimless(study, study_file)
    target = out / study.name
    refuse_foreign(SEARCH_FOLDER, target)
    search = Search(study, base_design(study, study_file), run.study_scenes(study, folder))
    store = run.Store()
    journal, at = journal_path(target.absolute()), Cluster(setting.workers, setting.scheduler)
    with (
        Trials(study, search.base, journal) as trials_on_disk,  # locked till the folder is written
        terminal.progress(study.name, not terminal.as_json()) as show,
        at as cluster,
    ):
        report = SearchProgress(StudyProgress(show, cluster), len(search.scenes))

        def evaluated(plan: Sequence[run.Planned]) -> tuple[Outcome, ...]:
            limits, retry = study.limits, setting.retry
            return run.run_jobs(plan, store, cluster, limits, report.standing, retry=retry)

        batch = max(BATCH, setting.workers or 0)
        tried = searched(search, trials_on_disk, evaluated, trials, batch, report.trials)
        report.searching = False
        found = confirm(search, tried, evaluated, lambda message: show(message, None))
        show("writing the report", 1.0)
        with SEARCH_FOLDER.written(target) as aside:
            compared = write_optimised(aside, found, text)
    outcomes = [o for each in tried for o in each.outcomes]
    if terminal.as_json():
        line({"folder": str(target), **found.data()})
    elif not terminal.quiet():
        say_recommended(_head(compared))
        for sentence in (*found.sentences(), *verdict(found)):
            terminal.say_wrapped(sentence)
        _say_failures(kinds_of(outcomes), target)
        for table in tables(found):
            terminal.print_table(table.caption, table.columns, table.rows)
    _say_end(kinds_of([*outcomes, *found.again]), target)
    return 0 if any(outcome.status == "ok" for outcome in outcomes) else 1


def optimise_design(
    design_file: Path, out: Path, trials: int | None, freedom: Freedom, setting: Setting
) -> int:
    """Search from DESIGN until every verdict passes; write the finger, its analysis and a page."""
    design = load_design(design_file)
    name = f"{design.design.name[:_MOST_NAME]}-optimised"
    target, page, journal = (out / each for each in (name, f"{name}.html", f"{name}{ENDING}"))
    file = out / f"{name}.toml"
    refuse_foreign(RESULTS, target)
    _refuse_in_the_way(design_file, out, file, page)
    space_of(design, freedom)  # Refuses unknown keys before processes start.
    text = _text_for(design_file, out)

    def confirm(found: Design, files: bool = False) -> Result:
        case = Case(_named(found, name), mesh_error=True)
        return answer_of(case, out, silent, Products(files, files, fresh=False))

    def improved(found: Candidate) -> None:
        write_whole(file, edited_text(text, design, _named(found.design, name), out))

    try:
        with (
            terminal.progress(design.design.name, not terminal.as_json()) as show,
            Cluster(setting.workers, setting.scheduler) as cluster,
        ):
            evaluated = evaluated_by(cluster, setting.retry)
            calls = Callbacks(evaluated, confirm, show, improved, unready)
            found = search_passing(design, freedom, journal.absolute(), calls, trials)
            if found.best is not None:
                improved(found.best)
                if found.best.result is not None:
                    show("writing the report")
                    confirm(found.best.design, files=True)
    except SearchStopped as stopped:
        write_page(page, design, stopped.found)
        _say_found(stopped.found, design, target, file, page)
        raise
    write_page(page, design, found)
    _say_found(found, design, target, file, page)
    terminal.open_page(page)
    return 0 if found.passes else 1


def _text_for(design_file: Path, out: Path) -> str:
    """The user's text as a search continues it in ``out``: its first line says where the comments
    come from, and editors find the schema from there."""
    lines = [f"{_MADE_BY} {design_file}`, whose comments follow."]
    for each in file_text(design_file).splitlines():
        schema = design_file.parent / each.removeprefix(_SCHEMA).strip()
        if not each.startswith((_MADE_BY, _SCHEMA)):
            lines.append(each)
        elif each.startswith(_SCHEMA) and design_file.is_file() and schema.is_file():
            with suppress(ValueError):  # Windows: on another drive there is no way to it.
                lines.append(f"{_SCHEMA} {os.path.relpath(schema, out)}".replace(os.sep, "/"))
    return "\n".join([*lines, ""])


def _refuse_in_the_way(design_file: Path, out: Path, *written: Path) -> None:
    """DesignError where a file that the search writes is the user's own, or a folder."""
    for each in written:
        own = each.resolve() == design_file.resolve()
        if each.suffix == ".toml" and each.is_file():
            own = own or not file_text(each).startswith(_MADE_BY)
        if each.is_dir() or own:
            what = "a folder" if each.is_dir() else "your own file"
            bound = f"a folder where {each.name} can be written: it is {what}"
            raise DesignError([Fault("--out", str(out), bound, "choose another --out")], str(out))


def _named(design: Design, name: str) -> Design:
    own = design.design.model_copy(update={"name": name})
    return design.model_copy(update={"design": own})


def _say_found(found: Found, design: Design, target: Path, file: Path, page: Path) -> None:
    best = found.best
    changes = {} if best is None else changes_between(design, best.design)
    if terminal.as_json():
        paths = {"design": str(file), "folder": str(target), "page": str(page)}
        line(
            {**_found_data(found), **paths, "changes": {k: new for k, (_, new) in changes.items()}}
        )
        return
    if terminal.quiet():
        return
    if best is not None and best.result is not None:
        # What a fix would change, the search has tried; it proposes no second search.
        terminal.say_block(replace(verdict_view(best.result, str(file)), fixes=()), target)
    for words in filter(None, (found.given_up, found.conflict, found.note)):
        terminal.say_wrapped(words)
    for key, (old, new) in [*changes.items()][:_SHOWN]:
        terminal.say(f"  {key} = {new}" + ("" if old is None else f"   (was {old})"))
    if len(changes) > _SHOWN:
        terminal.say(f"  and {len(changes) - _SHOWN} more keys")
    if best is not None:
        terminal.say(f"design: {file}")
    terminal.say(f"search: {page}")
    if found.passes:
        terminal.say(
            f"next: fingerdesign mold {shlex.quote(str(file))} (can it be cast, and sense as cast?)"
        )


def _found_data(found: Found) -> dict[str, object]:
    """Facts of a finished search, for scripts."""
    return {
        "passes": found.passes,
        "trials": len(found.tried),
        "conflict": found.conflict,
        "excluding": list(GOALS) if found.front.excludes else [],
        "front": found.front.best,
        "note": found.note,
        "given_up": list(found.space.given_up),
    }


def _warn_of_another(target: Path, text: str) -> None:
    """Warn where the folder holds what another text of the study, or another study, gave."""
    former = target / "study.toml"
    if former.is_file() and former.read_text("utf-8", "replace") != text:
        remedy = "give it a study.name of its own, or another --out, to keep both"
        terminal.say_wrapped(
            f"{target} is of another study.toml, and is replaced; {remedy}", err=True
        )


@interrupted(GOES_ON)
def sweep(study_file: Path, out: Path, shard: str | None, setting: Setting) -> int:
    """Analyse every variant of STUDY, a TOML file or a shipped study, and compare them."""
    needs("search", "distributed")
    (text, study), folder = setting.read(study_file), study_file.parent
    part = (1, 1) if shard is None else shard_of(shard)
    target = out / (study.name if shard is None else f"{study.name}.{part[0]}-of-{part[1]}")
    refuse_foreign(FOLDER, target)
    _warn_of_another(target, text)
    scenes = run.study_scenes(study, folder)
    plan = run.planned(study, variants(study, base_design(study, study_file), part), scenes)
    most = len(range(part[0], number_of_points(study) + 1, part[1])) * len(scenes)
    with terminal.progress(study.name, not terminal.as_json()) as show:
        with ExitStack() as stack:
            cluster = stack.enter_context(Cluster(setting.workers, setting.scheduler))
            look, store = StudyProgress(show, cluster), run.Store()
            limits, retry = study.limits, setting.retry
            if most > MANY:
                aside = stack.enter_context(FOLDER.written(target))
                found = run.run_in_parts(plan, most, store, cluster, limits, look, retry=retry)
                compared, kinds = write_large_study(aside, study, found, text)
            else:
                outcomes = run.run_jobs(list(plan), store, cluster, limits, look, retry=retry)
        if most <= MANY:
            show("writing the report", 1.0)
            with FOLDER.written(target) as aside:
                compared = write_study(aside, study, outcomes, text)
            kinds = kinds_of(outcomes)
    if terminal.as_json():
        line({"folder": str(target), **_counts(kinds, look.last)})
    elif not terminal.quiet():
        _show(compared, kinds, look.last, target)
    _say_end(kinds, target)
    # Shards beyond the last variant have nothing to do, and fail nothing.
    return 0 if kinds.get("ok") or not most else 1


def shard_of(text: str) -> tuple[int, int]:
    """The shard "I/N" as (I, N), 1 <= I <= N. Raises UsageError for anything else.

    >>> shard_of("2/8")
    (2, 8)
    """
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", text)
    part = (int(found[1]), int(found[2])) if found else (0, 0)
    if not 1 <= part[0] <= part[1]:
        raise click.UsageError(f"--shard {text}: must be I/N with I from 1 to N, as 1/8")
    return part


def _counts(kinds: Mapping[str, int], last: run.Standing | None) -> dict[str, object]:
    """Counts of a study's outcomes, for scripts."""
    failed = {kind: number for kind, number in sorted(kinds.items()) if kind != "ok"}
    return {
        "variants": sum(kinds.values()),
        "failures": sum(failed.values()),
        "failures_by_kind": failed,
        "from_store": 0 if last is None else last.stored,
        "computed": 0 if last is None else last.computed,
        "seconds": 0.0 if last is None else round(last.seconds, 3),
    }


def _head(found: Comparison) -> Summary:
    facts = found.facts
    best = recommend(found.outcomes, facts.objectives, facts.constraints)
    return summary(found.outcomes, facts, best)


def _say_failures(every: Mapping[str, int], target: Path) -> None:
    """Count what failed, with where the causes are and whether to try again."""
    kinds = {kind: number for kind, number in sorted(every.items()) if kind != "ok"}
    if kinds:
        reported = ", ".join(f"{number} {FAILURE_WORDS[kind]}" for kind, number in kinds.items())
        terminal.say_wrapped(f"failed: {reported}; causes in {_causes(target)}")
    if kinds.keys() & set(run.TRANSIENT):
        click.echo("--retry runs these again, with the limits that the study has now")


def _show(
    found: Comparison, every: Mapping[str, int], last: run.Standing | None, target: Path
) -> None:
    head, counts = _head(found), _counts(every, last)
    terminal.say_wrapped(head.counts)
    _say_failures(every, target)
    if counts["computed"] == 0 and counts["from_store"]:
        click.echo("nothing was computed: every outcome was in the store")
    elif counts["from_store"]:
        click.echo(f"{counts['computed']} computed, {counts['from_store']} were in the store")
    say_recommended(head)
