"""OUT/NAME of a study: outcomes, tables and the comparison page, whole or not at all.

study.json  the study, what repeats it, counts    study.toml  its file, as it was read
outcomes.jsonl  an outcome a line, all of it      outcomes.csv, failures.csv    for pandas
report.html  the designs compared
outcomes.sqlite  of a large study, instead of the lines and tables: records/columns.py
"""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from fingerdesign.records.base import json_text
from fingerdesign.records.columns import FACTS, row_of
from fingerdesign.records.folder import RecordFolder
from fingerdesign.records.outcome import Outcome, cells_csv, designs_csv
from fingerdesign.runtime.columns import ColumnWriter
from fingerdesign.search.compare.large import COLUMNS_FILE
from fingerdesign.search.compare.page import SearchFindings, compare_html
from fingerdesign.search.compare.read import OUTCOMES_FILE, STUDY_FILE, Comparison, read_comparison
from fingerdesign.search.study.file import Study
from fingerdesign.version import versions

REPORT_FILE = "report.html"
FILES = (STUDY_FILE, "study.toml", OUTCOMES_FILE, "outcomes.csv", "failures.csv", REPORT_FILE)
FOLDER = RecordFolder("study", STUDY_FILE, (*FILES, COLUMNS_FILE))


def write_study(
    folder: Path,
    study: Study,
    outcomes: Sequence[Outcome],
    source: str,
    more: dict[str, Any] | None = None,
    search: SearchFindings | None = None,
) -> Comparison:
    """Write the files of a study into ``folder``; what its page compares.

    source: the text of the study's file; more: further facts for study.json; search: results of
    a search, for the page.
    """
    record = study_record(study, kinds_of(outcomes)) | (more or {})
    texts = {
        STUDY_FILE: json_text(record),
        "study.toml": source,
        OUTCOMES_FILE: "".join(f"{outcome.to_json()}\n" for outcome in outcomes),
        "outcomes.csv": designs_csv(outcomes),
        "failures.csv": failures_csv(outcomes),
    }
    return _written(folder, texts, search)


def write_large_study(
    folder: Path, study: Study, outcomes: Iterable[Outcome], source: str
) -> tuple[Comparison, dict[str, int]]:
    """Write the files of a study of many outcomes into ``folder``, as they come; what its page
    compares, and how many outcomes there are of each kind."""
    kinds = Counter[str]()
    with ColumnWriter(folder / COLUMNS_FILE, FACTS) as columns:
        for outcome in outcomes:
            columns.add(row_of(outcome))
            kinds.update(kinds_of([outcome]))
    record = json_text(study_record(study, kinds))
    return _written(folder, {STUDY_FILE: record, "study.toml": source}), kinds


def _written(
    folder: Path, texts: Mapping[str, str], search: SearchFindings | None = None
) -> Comparison:
    """Write the texts of a study's folder, then its page; what that compares."""
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8", newline="\n")
    found = read_comparison([folder])  # as `compare` will read it
    facts = replace(found.facts, sources=())  # a folder that is gone once it is renamed
    html = compare_html(found.outcomes, facts, search)
    (folder / REPORT_FILE).write_text(html, encoding="utf-8", newline="\n")
    return found


def kinds_of(outcomes: Iterable[Outcome]) -> dict[str, int]:
    """The number of outcomes of each kind: "ok", or that of their failure."""
    return Counter("ok" if each.failure is None else each.failure.kind for each in outcomes)


def study_record(study: Study, kinds: Mapping[str, int]) -> dict[str, Any]:
    """The record study.json: all that repeats the study, and how many outcomes of each kind."""
    table = study.study
    return {
        "schema_version": 1,
        "name": study.name,
        "digest": study.digest(),
        **{key: getattr(table, key) for key in ("base", "sampling", "count", "seed", "fidelity")},
        "tolerance": table.tolerance if table.fidelity == "auto" else None,
        "scenes": list(table.scenes),
        "fixed": study.fixed,
        "parameters": {
            key: list(parameter) if isinstance(parameter, tuple) else parameter.model_dump()
            for key, parameter in study.parameters.items()
        },
        "limits": study.limits.model_dump(),
        "cost": study.cost.model_dump(),
        "objectives": [
            {"metric": each.metric, "goal": each.direction} for each in study.objectives
        ],
        "constraints": {name: bound.model_dump() for name, bound in study.constraints.items()},
        "outcomes": {"all": sum(kinds.values()), **dict(sorted(kinds.items()))},
        "versions": versions(),
    }


def failures_csv(outcomes: Sequence[Outcome]) -> str:
    """A row a failed outcome: its kind, its cause in a sentence, its values."""
    failed = [(each, each.failure) for each in outcomes if each.failure is not None]
    keys = list(dict.fromkeys(key for outcome, _ in failed for key in outcome.values))
    rows = (
        [
            *(outcome.name, outcome.scene, failure.kind, failure.sentence),
            *(outcome.values.get(key, "") for key in keys),
            outcome.digest,
        ]
        for outcome, failure in failed
    )
    return cells_csv(("name", "scene", "kind", "cause", *keys, "digest"), rows)
