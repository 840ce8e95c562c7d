"""OUT/NAME of an optimisation: a study's files, with what was searched, confirmed and decides.

study.json  has "optimise" besides: the front, the confirmation, sensitivities
front.png   trials, reference and confirmed fingers in the first two objectives
"""

from __future__ import annotations

from pathlib import Path

from fingerdesign.records.folder import RecordFolder
from fingerdesign.search.compare.page import compare_html
from fingerdesign.search.compare.read import STUDY_FILE
from fingerdesign.search.optimise.confirm import Optimised
from fingerdesign.search.optimise.page import (
    confirmed_table,
    draw_front,
    sensitivity_tables,
    verdict,
)
from fingerdesign.search.run.folder import FILES, REPORT_FILE, write_study

CHART_FILE = "front.png"
FOLDER = RecordFolder("optimisation", STUDY_FILE, (*FILES, CHART_FILE))


def journal_beside(target: Path) -> Path:
    """The file that keeps an optimisation's trials, beside its folder."""
    return target.with_name(f"{target.name}.trials.jsonl")


def write_optimised(folder: Path, found: Optimised, source: str) -> None:
    """Write all files into ``folder``; ``source``: the text of the study's file."""
    from dataclasses import replace

    study, reported = found.search.study, found.confirmation
    compared = write_study(folder, study, found.outcomes, source, {"optimise": found.data()})
    tables = [confirmed_table(found), *sensitivity_tables(found)]
    record = {key: text for key, text in compared.facts.record.items() if key != "optimise"}
    facts = replace(compared.facts, sources=(), record=record)
    page = compare_html(
        compared.outcomes,
        facts,
        answer=verdict(found),
        notes=found.sentences(),
        tables=[table for table in tables if table is not None],
        references=[
            each.name for each in (reported.reference, reported.thorough_reference) if each
        ],
    )
    (folder / REPORT_FILE).write_text(page, encoding="utf-8", newline="\n")
    if len(study.objectives) > 1:
        draw_front(found, folder / CHART_FILE)
