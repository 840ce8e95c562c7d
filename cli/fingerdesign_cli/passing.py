"""``fingerdesign optimise DESIGN``: a finger that passes all verdicts, from one design."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from fingerdesign.analysis.case import Case
from fingerdesign.analysis.verdicts import verdict_view
from fingerdesign.checks.load import judge_design, load_design
from fingerdesign.design.io import dump_design
from fingerdesign.design.keys import leaves
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import file_text
from fingerdesign.errors import DesignError
from fingerdesign.records.outcome import Outcome
from fingerdesign.records.result import Result
from fingerdesign.records.result_files import RESULTS
from fingerdesign.runtime.files import write_whole
from fingerdesign.search.optimise.trials import Trials
from fingerdesign.search.passing.page import write_page
from fingerdesign.search.passing.passing import Found, find_passing, most_trials, study_of
from fingerdesign.search.passing.space import Freedom, changes_between, space_of
from fingerdesign.search.run.cluster import Cluster
from fingerdesign.search.run.run import Planned, Store, run_jobs
from fingerdesign_cli.analyse import Products, answer_of
from fingerdesign_cli.inputs import refuse_foreign
from fingerdesign_cli.search import Setting, line
from fingerdesign_cli.terminal import as_json, open_page, progress, quiet, say, say_block

_SHOWN = 12  # Changed keys in the terminal; the page has all.


def optimise_design(
    design_file: Path, out: Path, trials: int | None, freedom: Freedom, setting: Setting
) -> int:
    """Search from DESIGN until every verdict passes; write the finger, its analysis and a page."""
    design = load_design(design_file)
    space = space_of(design, freedom)
    name = f"{design.design.name}-optimised"
    target, page, journal = (out / each for each in (name, f"{name}.html", f"{name}.trials.jsonl"))
    file = out / f"{name}.toml"
    refuse_foreign(RESULTS, target)
    study, store = study_of(space), Store()
    most = most_trials(space.base) if trials is None else trials
    text = file_text(design_file)
    with (
        Trials(study, space.base, journal.absolute(), space.starts) as trials_on_disk,
        progress(design.design.name, not as_json()) as show,
        Cluster(setting.workers, setting.scheduler) as cluster,
    ):

        def evaluated(plan: Sequence[Planned]) -> tuple[Outcome, ...]:
            return run_jobs(plan, store, cluster, study.limits, retry=setting.retry)

        def confirm(found: Design) -> Result:
            case = Case(_named(found, name), mesh_error=True)
            return answer_of(case, out, lambda *words: None, Products(False, False, False))

        def improved(found: Design) -> None:
            write_whole(file, _toml(text, design, _named(found, name)))

        found = find_passing(
            space, freedom, trials_on_disk, evaluated, confirm, most, show, improved
        )
        if found.best is not None:
            best = _named(found.best.design, name)
            write_whole(file, _toml(text, design, best))
            if found.best.result is not None:
                show("writing the report")
                answer_of(Case(best, mesh_error=True), out, show, Products(True, True, False))
        write_page(page, design, found)
    _say(found, design, target, file, page)
    open_page(page)
    return 0 if found.passes else 1


def _named(design: Design, name: str) -> Design:
    return design.model_copy(update={"design": replace_name(design, name)})


def replace_name(design: Design, name: str) -> Any:
    """The ``[design]`` table with another name."""
    return design.design.model_copy(update={"name": name})


def _toml(text: str, before: Design, after: Design) -> str:
    """The user's own text with the changed keys set, its comments unchanged; the whole design anew
    where that does not read back as the same finger."""
    from fingerdesign.studio.document import with_keys

    values = {key: new for key, (_, new) in changes_between(before, after).items()}
    values |= {"design.name": after.design.name}
    known = dict(leaves(before.model_dump(mode="json", exclude_none=True)))
    values = {key: v for key, v in values.items() if v is not None or key in known}
    try:
        edited = with_keys(text, values)
        if judge_design(edited).sound("").digest() == after.digest():
            return edited
    except (DesignError, ValueError, KeyError):
        pass  # What TOML's editor cannot set in place is written as a whole.
    return dump_design(after)


def _say(found: Found, design: Design, target: Path, file: Path, page: Path) -> None:
    best = found.best
    changes = {} if best is None else changes_between(design, best.design)
    if as_json():
        line(
            {
                "passes": found.passes,
                "trials": len(found.tried),
                "design": str(file),
                "folder": str(target),
                "page": str(page),
                "conflict": found.conflict,
                "changes": {key: new for key, (_, new) in changes.items()},
            }
        )
        return
    if quiet():
        return
    if best is not None and best.result is not None:
        say_block(verdict_view(best.result, str(file)), target)
    if found.conflict:
        say(found.conflict)
    for key, (old, new) in [*changes.items()][:_SHOWN]:
        say(f"  {key} = {new}" + ("" if old is None else f"   (was {old})"))
    if len(changes) > _SHOWN:
        say(f"  and {len(changes) - _SHOWN} more keys")
    if best is not None:
        say(f"design: {file}")
    say(f"search: {page}")
