"""compare.html: many designs on one page that opens offline, with the scripts inside."""

from __future__ import annotations

import base64
import gzip
from collections import Counter
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from fingerdesign.errors import shown
from fingerdesign.records.outcome import Outcome, designs_csv, grips_csv, increments_csv
from fingerdesign.report.page import rendered
from fingerdesign.report.table import Table, value_text
from fingerdesign.search.compare.data import detail, page_data, script_json
from fingerdesign.search.compare.facts import StudyFacts
from fingerdesign.search.compare.geometry import COMPARE_VIEW_SCRIPTS, COMPARE_VIEW_STYLES
from fingerdesign.search.compare.recommend import recommend
from fingerdesign.search.compare.table import design_table
from fingerdesign.search.compare.words import summary

TEMPLATES = Path(__file__).parent / "templates"

SCRIPTS = (
    *("compare_page.js", "compare_table.js", "compare_filter.js", "compare_pareto.js"),
    *("compare_pair.js", "compare_save.js"),
)
STYLES = ("compare.css",)
TOGETHER = 16  # designs whose heavy parts are unpacked together


def compare_html(
    outcomes: Sequence[Outcome],
    facts: StudyFacts,
    *,
    answer: Sequence[str] = (),
    notes: Sequence[str] = (),
    tables: Sequence[Table] = (),
    references: Sequence[str] = (),
) -> str:
    """The whole page as text: the outcomes in their order, and all of their numbers inside.

    answer: of a search, sentences that head the page; notes, tables: what it found and what each
    objective hangs on; references: names of the outcomes that it was to beat.

    Every text of an outcome or of ``facts`` is a stranger's: it is escaped, and without control
    characters.
    """
    found = recommend(outcomes, facts.objectives, facts.constraints)
    table = design_table(outcomes, facts, found)
    data = page_data(outcomes, facts, found)
    data["study"]["references"] = [
        number
        for number, outcome in enumerate(outcomes)
        if any(outcome.name == each or outcome.name.startswith(f"{each} (") for each in references)
    ]
    data["columns"] = [
        {
            "path": list(column.path),
            "title": column.title,
            "unit": column.unit,
            "numeric": column.numeric,
            "goal": column.goal,
            "wanted": column.wanted,
        }
        for column in table.columns
    ]
    return rendered(
        TEMPLATES / "compare.html.j2",
        name=shown(facts.name),
        data=_inert(data),
        details=list(_details(outcomes)),
        together=TOGETHER,
        archives={name: _packed(text) for name, text in _files(outcomes)},
        designs=data["designs"],
        summary=summary(outcomes, facts, found),
        chosen=found.chosen,
        table=table,
        answer=[shown(each) for each in answer],
        notes=[shown(note) for note in notes],
        search_tables=tables,
        failures=_failures(outcomes),
        record=_record(outcomes, facts),
        page_style=_texts((*STYLES, *COMPARE_VIEW_STYLES)),
        scripts=_texts((*SCRIPTS, *COMPARE_VIEW_SCRIPTS)),
    )


def _details(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """The heavy parts of TOGETHER designs at a time, packed lists of JSON."""
    for first in range(0, len(outcomes), TOGETHER):
        some = [detail(outcome) for outcome in outcomes[first : first + TOGETHER]]
        yield _packed(script_json(some))


def _files(outcomes: Sequence[Outcome]) -> Iterator[tuple[str, str]]:
    """The files that the page offers, name and text; exact, unlike what is drawn."""
    yield "designs.csv", designs_csv(outcomes)
    yield "outcomes.jsonl", "".join(f"{outcome.to_json()}\n" for outcome in outcomes)
    yield "increments.csv", increments_csv(outcomes)
    yield "grips.csv", grips_csv(outcomes)


def _packed(text: str) -> str:
    """gzip in base64: browsers open a page of a few MB faster than one of many."""
    return base64.b64encode(gzip.compress(text.encode(), 6, mtime=0)).decode("ascii")


def _failures(outcomes: Sequence[Outcome]) -> Table:
    rows = tuple(
        (
            shown(outcome.name),
            outcome.failure.kind if outcome.failure else "",
            shown(outcome.failure.sentence) if outcome.failure else "",
            shown(", ".join(f"{key} = {value_text(v)}" for key, v in outcome.values.items())),
        )
        for outcome in outcomes
        if outcome.status == "failed"
    )
    columns = ("design", "kind", "cause", "values")
    return Table("failures", "Designs without a result", columns, rows, frozenset(range(4)))


def _record(outcomes: Sequence[Outcome], facts: StudyFacts) -> Table:
    """Versions, seeds, sources and what else repeats it."""
    rows = [("outcomes from", shown(source)) for source in facts.sources]
    rows += [(shown(key), shown(value)) for key, value in facts.record.items()]
    for name, told in (("versions", "versions"), ("seeds", "seeds")):
        many = Counter(
            ", ".join(f"{key} {value}" for key, value in getattr(outcome, told).items())
            for outcome in outcomes
        )
        for text, count in many.most_common():
            of = f" ({count} designs)" if len(many) > 1 else ""
            rows.append((f"{name}{of}", shown(text) or "not recorded"))
    total = sum(outcome.seconds for outcome in outcomes)
    rows.append(("time of all designs", f"{total:.0f} s"))
    return Table("record", "The record", ("what", "value"), tuple(rows), frozenset({0, 1}))


def _texts(names: Sequence[str]) -> Any:
    """Files of the templates' folder, one after another; the program's own, so not escaped."""
    from markupsafe import Markup

    return Markup("\n".join((TEMPLATES / name).read_text(encoding="utf-8") for name in names))


def _inert(data: Any) -> Any:
    """Data as the text of a <script> element that no browser runs."""
    from markupsafe import Markup

    return Markup(script_json(data))
