"""compare.html: many designs on one page that opens offline, with the scripts inside.

The page carries its data as JSON. The light part (metrics, values, validity) is read when it opens;
the heavy one (designs, traces, contact maps, shapes) only when a design is viewed or saved.
"""

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from html import escape
from pathlib import Path
from typing import Any

from fingerdesign.errors import all_shown, shown
from fingerdesign.records.outcome import Outcome, Traces, designs_csv, grips_csv, increments_csv
from fingerdesign.records.verdict import Verdict, VerdictView
from fingerdesign.report.figure import round_values
from fingerdesign.report.page import (
    Bullets,
    Fold,
    Item,
    Page,
    Section,
    Text,
    Widget,
    pack,
    page_html,
    widget,
)
from fingerdesign.report.table import Table, value_text
from fingerdesign.search.compare import figures
from fingerdesign.search.compare.geometry import packed_geometry
from fingerdesign.search.compare.recommend import (
    SHOWN,
    Recommendation,
    StudyFacts,
    recommend,
    uncertainty,
    why_not,
)
from fingerdesign.search.compare.table import (
    DIGEST_SHOWN,
    Column,
    DesignTable,
    design_table,
    value_at,
)
from fingerdesign.search.compare.words import Summary, summary

TEMPLATES = Path(__file__).parent / "templates"
SIDES = ((0, "A", "mark-a"), (1, "B", "mark-b"))
READINGS = {
    "normal_force_N": "normal force (N)",
    "tangential_force_N": "tangential force (N)",
    "stick_ratio": "stick ratio",
    "contact_width_mm": "contact width (mm)",
    "approach_mm": "approach (mm)",
    "shear_mm": "shear (mm)",
}
_HEAVY: dict[str, Any] = {"design": {}, "traces": Traces(), "grips": (), "schema_version": 0}
SCRIPTS = ("page.js", "table.js", "charts.js", "pareto.js", "parallel.js", "views.js")
MOST_TICK = 14  # characters of a text next to an axis
MOST_AXES = 5  # of values, and of metrics, that the lines of all designs begin with
TOGETHER = 16  # designs whose heavy parts are unpacked together
NOTHING = "No design was analysed: there is nothing to draw."
NO_FAILURES = "None: every design was analysed."
CHANCE = """±: two standard deviations of what chance changes, another mesh or another seed.
Values that differ by less show no difference."""
DIGESTS = """The digest of each design, over design, scene, fidelity and version, is in the table
(its first 12 digits) and in the downloads (whole)."""


def page_data(
    outcomes: Sequence[Outcome],
    facts: StudyFacts,
    found: Recommendation,
    references: Sequence[int] = (),
) -> dict[str, Any]:
    """The light part: the study, how charts look, and every design in order.

    references: indices of the reference designs of a search.
    """
    feasible, front, designs = set(found.feasible), set(found.front), []
    competing = feasible.difference(found.failing)
    for number, outcome in enumerate(outcomes):
        missed = list(why_not(outcome, facts.objectives, facts.constraints))
        marks = {
            "the reference": number in references,
            "recommended": number == found.chosen,
            "fails verdicts": number in found.failing,
            "not feasible": number not in feasible,
        }
        # How the chart of two measures shows a design that is not on their front.
        kinds = dict(zip(("reference", "star", "failing", "out"), marks.values(), strict=True))
        notes = [f"not feasible, {'; '.join(missed)}."] if missed else []
        own = {
            "feasible": number in feasible,
            "competes": number in competing,
            "front": number in front,
            "kind": next((kind for kind, holds in kinds.items() if holds), "in"),
            "marks": [mark for mark, holds in marks.items() if holds],
            "missed": all_shown(missed),
            "unsure": {
                name: SHOWN * unsure
                for name in outcome.metrics
                if (unsure := uncertainty(outcome, name))
            },
            "notes": all_shown([*notes, *(f"warning: {warning}" for warning in outcome.warnings)]),
        }
        light = asdict(replace(outcome, **_HEAVY))
        designs.append(all_shown({k: v for k, v in light.items() if k not in _HEAVY}) | own)
    pair = _pair(outcomes, found)
    study = {"name": all_shown(facts.name), "recommended": found.chosen, "pair": pair}
    looks = figures.LOOKS["looks"]
    return {"looks": looks, "together": TOGETHER, "study": study, "designs": designs}


def _pair(outcomes: Sequence[Outcome], found: Recommendation) -> list[int | None]:
    """The two that are chosen at first: the recommended design and the runner-up."""
    good = [number for number, outcome in enumerate(outcomes) if outcome.status == "ok"]
    first = next(iter(good), None) if found.chosen is None else found.chosen
    others = (number for number in good if number != first)
    second = next(others, None) if found.runner_up is None else found.runner_up
    return [first, second]


def detail(outcome: Outcome, frictions: Mapping[float, int]) -> dict[str, Any]:
    """The heavy part of one design, as it is drawn.

    For drawing alone: what the page offers for download is the outcome's own numbers.
    """
    traces = outcome.traces
    geometry = packed_geometry(outcome.design, traces)
    found: dict[str, Any] = all_shown(
        {
            "size": geometry["size"],
            "words": f"{geometry['words']} {geometry['note']}".strip(),
            "figures": {
                "shape": figures.shape_figure(geometry, bool(traces.contact_z_mm)),
                "contact": figures.contact_figure(traces),
                "gages": figures.gages_figure(traces),
                "forces": figures.forces_figure(outcome, frictions),
            },
            "readings": {key: round_values(getattr(traces, key)) for key in READINGS},
            "count": max(len(traces.normal_force_N), len(traces.gages), len(traces.status)),
            "status": traces.status,
            "accuracy": figures.accuracy(outcome),
            "warnings": [*outcome.validity.sentences, *outcome.warnings],
        }
    )
    return found


def script_json(value: Any) -> str:
    """JSON that can stand in a <script> element: nothing in it ends the element or opens another.

    >>> script_json({"name": "</script>"})
    '{"name":"\\\\u003c/script\\\\u003e"}'
    """
    text = json.dumps(value, allow_nan=False, separators=(",", ":"))  # ASCII alone
    return text.replace("<", "\\u003c").replace(">", "\\u003e").replace("&", "\\u0026")


@dataclass(frozen=True)
class SearchFindings:
    """Results of a search that its page shows.

    answer: sentences about the reference; verdicts: tiles about it; notes, tables: further results;
    references: names of the outcomes that the search was to beat.
    """

    answer: tuple[str, ...] = ()
    verdicts: tuple[Verdict, ...] = ()
    notes: tuple[str, ...] = ()
    tables: tuple[Table, ...] = ()
    references: tuple[str, ...] = ()


def compare_html(
    outcomes: Sequence[Outcome], facts: StudyFacts, search: SearchFindings | None = None
) -> str:
    """The whole page as text: the outcomes in their order, and all of their numbers inside.

    Every text of an outcome or of ``facts`` is untrusted: it is escaped, and without control
    characters.
    """
    search = search or SearchFindings()
    found = recommend(outcomes, facts.objectives, facts.constraints)
    table = design_table(outcomes, facts, found)
    reference = _places(outcomes, search.references)
    data = page_data(outcomes, facts, found, reference)
    data["columns"] = [_column(column, outcomes) for column in table.columns]
    for number, rank, cells in table.rows:
        data["designs"][number] |= {"standing": cells[0], "rank": rank}
    axes, head = _first_axes(outcomes, table, facts), summary(outcomes, facts, found)
    lines = [*table.places("values")[:MOST_AXES], *table.places("metrics")[:MOST_AXES]]
    parallel = _widget("parallel", columns=table.columns, lines=lines)
    first: Item = Text(NOTHING)
    designs: Item = Text(NOTHING)
    if table.rows:
        designs = _widget("designs", table=table, designs=data["designs"])
        if axes:
            first = _widget("chart", columns=table.columns, axes=axes)
    pair = _widget("pair", sides=SIDES, readings=READINGS)
    failures = _failures(outcomes)
    sections = [
        Section("designs", "All designs", [designs]),
        Section("summary", "Which finger", list(_which(head, search))),
        Section("pair", "Two designs", [pair]),
        Section("parallel", "All at once", [parallel]),
        Section("search", "The search", [*map(Text, all_shown(search.notes)), *search.tables]),
        Section("failures", "Failures", [failures if failures.rows else Text(NO_FAILURES)]),
        Section("downloads", "Downloads", [_widget("downloads")]),
    ]
    title = f"{shown(facts.name)}: fingers compared"
    page = Page(
        title=title,
        heading=title,
        lead=head.lead,
        sections=[each for each in sections if each.items],
        record=[_record(outcomes, facts), Text(DIGESTS, "quiet")],
        first=first,
        view=VerdictView(facts.name, "", 0.0, (*search.verdicts, *head.verdicts)),
        end=[_carried(outcomes, data)],
        style=(TEMPLATES / "compare.css").read_text(encoding="utf-8"),
        scripts=[TEMPLATES / name for name in SCRIPTS],
    )
    return page_html(page)


def _widget(name: str, **values: Any) -> Widget:
    return widget(TEMPLATES / f"{name}.html.j2", **values)


def _carried(outcomes: Sequence[Outcome], data: dict[str, Any]) -> Widget:
    """The bar of the chosen two, the page's data, and the files that it saves, unrounded."""
    files = {
        "designs.csv": designs_csv(outcomes),
        "outcomes.jsonl": "".join(f"{outcome.to_json()}\n" for outcome in outcomes),
        "increments.csv": increments_csv(outcomes),
        "grips.csv": grips_csv(outcomes),
    }
    return _widget(
        "data",
        sides=SIDES,
        data=script_json(data),
        details=list(_details(outcomes)),
        archives={name: pack(text) for name, text in files.items()},
    )


def _which(head: Summary, search: SearchFindings) -> Iterator[Item]:
    """The recommended finger and the reasons; what a search found against its reference."""
    yield Text(head.words, "" if head.recommended else "warnings")
    if head.values:
        caption = "Its values of what was varied"
        rows = tuple(head.values.items())
        yield Table("values", caption, ("key", "value"), rows, frozenset({0, 1}))
    if head.table is not None:
        yield head.table
        yield Text(CHANCE, "quiet")
    if head.given_up:
        yield Fold("What others of the front do better", [Bullets(head.given_up)])
    if search.answer:
        yield Bullets(all_shown(search.answer))
    if head.warnings:
        yield Bullets(head.warnings, "warnings")
    yield Fold("How many were compared", [Text(head.counts)])


def _places(outcomes: Sequence[Outcome], names: Sequence[str]) -> list[int]:
    """The outcomes of these names, also with a mark behind the name."""
    marked = tuple(f"{each} (" for each in names)
    return [k for k, o in enumerate(outcomes) if o.name in names or o.name.startswith(marked)]


def _column(column: Column, outcomes: Sequence[Outcome]) -> dict[str, Any]:
    """Facts of a column for the page's scripts.

    label, alike, short: its heading next to an axis, there where all have one value, and above an
    axis; most: characters shown of a text; kinds: the texts that it has; ticks: those as marks of
    an axis. What Plotly shows it reads as markup: label, alike, short and ticks are escaped.
    """
    better = {"min": "   ← better", "max": "   better →"}.get(column.goal or "", "")
    better += f" ({column.scale})" if column.scale else ""
    found: dict[str, Any] = {
        "path": list(column.path),
        "title": column.title,
        "heading": column.heading,
        "numeric": column.numeric,
        "goal": column.goal,
        "label": escape(column.heading) + better,
        "alike": f"{escape(column.heading)}: the same for all shown",
        "short": "<br>".join(escape(each) for each in (column.title, column.unit) if each),
    }
    if column.path[0] == "digest":
        return found | {"most": DIGEST_SHOWN}
    if not column.numeric:
        found |= _kinds([value_at(outcome, column.path) for outcome in outcomes])
    return found


def _kinds(every: Sequence[Any]) -> dict[str, Any]:
    """The different texts of a column, and those as marks of an axis."""
    loaded = [(each, json.loads(each)) for each in {json.dumps(value) for value in every}]
    known = [value if isinstance(value, str) else text for text, value in loaded if text != "null"]
    kinds = sorted(all_shown(known))
    texts = [each if len(each) <= MOST_TICK else f"{each[: MOST_TICK - 1]}…" for each in kinds]
    marks = {"ticktext": [escape(each) for each in texts], "tickvals": [*range(len(texts))]}
    return {"kinds": kinds, "ticks": {"tickmode": "array", **marks}}


def _first_axes(
    outcomes: Sequence[Outcome], table: DesignTable, facts: StudyFacts
) -> tuple[int, int] | None:
    """The columns that the chart begins with: objectives, those that decide nothing last."""
    numeric = [place for place, column in enumerate(table.columns) if column.numeric]

    def alike(place: int) -> bool:
        path = table.columns[place].path
        return len({value_at(outcomes[number], path) for number, _, _ in table.rows}) < 2

    by_path = {column.path: place for place, column in enumerate(table.columns)}
    objectives = [
        by_path[path] for each in facts.objectives if (path := ("metrics", each.metric)) in by_path
    ]
    order = list(dict.fromkeys([*sorted(objectives, key=alike), *numeric]))
    return (order[0], order[min(1, len(order) - 1)]) if order else None


def _details(outcomes: Sequence[Outcome]) -> Iterator[str]:
    """The heavy parts of TOGETHER designs at a time, by their numbers, as packed JSON."""
    frictions = figures.frictions_of(outcomes)
    for first in range(0, len(outcomes), TOGETHER):
        some = enumerate(outcomes[first : first + TOGETHER], first)
        yield pack(script_json({number: detail(each, frictions) for number, each in some}))


def _failures(outcomes: Sequence[Outcome]) -> Table:
    rows = tuple(
        (
            shown(outcome.name),
            outcome.failure.kind,
            shown(outcome.failure.sentence),
            shown(", ".join(f"{key} = {value_text(v)}" for key, v in outcome.values.items())),
        )
        for outcome in outcomes
        if outcome.failure is not None
    )
    columns = ("design", "kind", "cause", "values")
    return Table("failures", "Designs without a result", columns, rows, frozenset(range(4)))


def _record(outcomes: Sequence[Outcome], facts: StudyFacts) -> Table:
    """Versions, seeds, sources and what else repeats it."""
    rows = [("outcomes from", shown(source)) for source in facts.sources]
    rows += [(shown(key), shown(value)) for key, value in facts.record.items()]
    for name in ("versions", "seeds"):
        many = Counter(
            ", ".join(f"{key} {value}" for key, value in getattr(outcome, name).items())
            for outcome in outcomes
        )
        for text, count in many.most_common():
            of = f" ({count} designs)" if len(many) > 1 else ""
            rows.append((f"{name}{of}", shown(text) or "not recorded"))
    total = sum(outcome.seconds for outcome in outcomes)
    rows.append(("time of all designs", f"{total:.0f} s"))
    return Table("record", "The record", ("what", "value"), tuple(rows), frozenset({0, 1}))
