"""An optimisation's answer in sentences: who beats the reference, by how much, and what decides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.errors import shown
from fingerdesign.records.folder import RecordFolder
from fingerdesign.report.page import sentences
from fingerdesign.report.style import (
    BLUE,
    GREEN,
    INK,
    MUTED,
    PAPER,
    VERMILION,
    canvas,
    house_style,
)
from fingerdesign.report.table import Table
from fingerdesign.search.compare.page import compare_html
from fingerdesign.search.compare.read import STUDY_FILE
from fingerdesign.search.compare.table import metric_title
from fingerdesign.search.optimise.confirm import WORDS, Optimised
from fingerdesign.search.optimise.sensitivity import LEAST
from fingerdesign.search.run.folder import FILES, REPORT_FILE, write_study
from fingerdesign.search.study.metrics import METRICS

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from fingerdesign.search.optimise.confirm import Judged


# Tables of an optimisation: what stood by the thorough model, and what each objective hangs on.

NONE = "–"


def confirmed_table(found: Optimised) -> Table | None:
    """The reference and the confirmed fingers by both models; None where none was confirmed."""
    reported = found.confirmation
    reference = reported.thorough_reference
    if reference is None:
        return None
    metrics = list(reported.reference.metrics)
    quick = found.search.study.study.fidelity
    columns = [
        "finger",
        *(f"{metric}, {name}" for metric in metrics for name in (quick, reported.fidelity)),
        "against the reference",
    ]
    pairs = [(reported.reference, reference, "")]
    pairs += [
        (each.quick, each.thorough, _standing(each.thorough, reference))
        for each in reported.confirmed
    ]
    rows = tuple(
        (
            shown(own.name),
            *(_number(each, metric) for metric in metrics for each in (own, deep)),
            shown(standing),
        )
        for own, deep, standing in pairs
    )
    caption = f"The best trials again, by {reported.fidelity}"
    return Table("confirmed", caption, tuple(columns), rows, frozenset({0, len(columns) - 1}))


def _standing(own: Judged, reference: Judged) -> str:
    if own.failure:
        return f"failed: {own.failure}"
    if own.better_in_all(reference):
        return "better in every objective"
    if own.dominates(reference):
        return "dominates it"
    return "does not dominate it" if own.feasible else "misses a constraint"


def sensitivity_tables(found: Optimised) -> list[Table]:
    """A table: a row a parameter, share and direction of each objective; none without numbers."""
    known = [each for each in found.sensitivities if each.explained is not None]
    if not known:
        return []
    columns = ["parameter"]
    for each in known:
        columns += [f"{each.metric}: share", f"{each.metric}: direction"]
    rows = []
    for key in found.search.study.parameters:
        row = [shown(key)]
        for each in known:
            effect = next(e for e in each.effects if e.parameter == key)
            direction = effect.direction
            row.append(f"{effect.share:.2f} ± {effect.spread:.2f}")
            row.append(NONE if direction is None else f"{direction:+.2f}")
        rows.append(tuple(row))
    said = ". ".join(each.words for each in found.sensitivities)
    caption = (
        f"What each objective hangs on. {said}. Share: of the variance that goes with the "
        "parameter, alone or in concert, with its standard error; direction: partial rank "
        "correlation, above 0 rising"
    )
    return [Table("sensitivity", caption, tuple(columns), tuple(rows), frozenset({0}))]


def _number(own: Judged, metric: str) -> str:
    value = own.metrics.get(metric)
    return NONE if value is None else f"{value:.4g}"


# The chart of a search: trials, front, reference and confirmed fingers; and how it went.


def draw_front(found: Optimised, path: Path) -> None:
    """The first two objectives against each other, and the volume dominated by number of trials."""
    with house_style():
        figure = canvas(10.0, 4.9)
        plane, course = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
        _plane(plane, found)
        _course(course, found)
        figure.savefig(path, format="png", dpi=150, facecolor=PAPER, metadata={"Software": None})


def _plane(axes: Axes, found: Optimised) -> None:
    reported, study = found.confirmation, found.search.study
    first, second = (each.metric for each in study.objectives[:2])
    missing = [own for own in found.judged if not own.failure and not own.feasible]
    feasible = [own for own in found.judged if own.feasible]
    axes.plot(
        *_points(missing, first, second), "x", color=MUTED, ms=4.0, label="misses a constraint"
    )
    axes.plot(*_points(feasible, first, second), "o", color=BLUE, ms=4.0, label="trial")
    pairs = zip(found.tried, found.judged, strict=True)
    front = [own for each, own in pairs if each.number in reported.front]
    x, y = _points(sorted(front, key=lambda own: own.metrics[first] or 0.0), first, second)
    axes.plot(x, y, color=BLUE, lw=1.2, ds="steps-post", label="front")
    quick, deep = study.study.fidelity, reported.fidelity
    drawn = [(reported.reference, reported.thorough_reference, VERMILION, "s", "reference")]
    found_again = ((each.quick, each.thorough) for each in reported.confirmed)
    drawn += [(*both, GREEN, "D", "confirmed trial") for both in found_again]
    seen: set[str] = set()
    for own, thorough, colour, marker, label in drawn:
        both = [each for each in (own, thorough) if each is not None and not each.failure]
        axes.plot(*_points(both, first, second), color=colour, lw=0.8, ls=(0, (2, 2)))
        for each, filled, name in ((own, False, quick), (thorough, True, deep)):
            if each is None or each.failure:
                continue
            text = f"{label}, {name}"
            axes.plot(
                *_points([each], first, second),
                marker,
                color=colour,
                mfc=colour if filled else PAPER,
                ms=7.0,
                label=None if text in seen else text,
            )
            seen.add(text)
    axes.set_xlabel(_words(first))
    axes.set_ylabel(_words(second))
    axes.set_title(f"{len(found.judged)} trials of {study.name}")
    axes.legend(fontsize=7.5)


def _course(axes: Axes, found: Optimised) -> None:
    volumes = found.confirmation.volumes
    axes.step(range(1, len(volumes) + 1), 100.0 * np.array(volumes), where="post", color=INK)
    axes.set_ylim(0.0, 105.0)
    axes.set_xlabel("trials")
    axes.set_ylabel("dominated volume, % of the last")
    axes.set_title("How the search went")


def _points(some: Sequence[Judged], first: str, second: str) -> tuple[list[float], list[float]]:
    pairs = [(each.metrics[first], each.metrics[second]) for each in some]
    known = [(x, y) for x, y in pairs if x is not None and y is not None]
    return [x for x, _ in known], [y for _, y in known]


def _words(metric: str) -> str:
    unit = METRICS[metric].unit
    return f"{metric} ({unit})" if unit and not metric.endswith(f"_{unit}") else metric


MOST_NAMED = 3


def verdict(found: Optimised) -> tuple[str, ...]:
    """Who dominates the reference and by how much, by both models; what the objectives hang on."""
    goals = {each.metric: each.direction for each in found.search.study.objectives}
    dominating, front = found.confirmation.dominating, found.confirmation.front
    places = {each.number: place for place, each in enumerate(found.tried)}
    first = sorted(dominating, key=lambda number: number not in front)
    best = [found.judged[places[number]] for number in first]
    texts = shown, metric_title
    return (
        *sentences(WORDS, "verdict", found, goals, best, MOST_NAMED, *texts),
        *sentences(WORDS, "hang", found.sensitivities, LEAST, *texts),
    )


# OUT/NAME of an optimisation: a study's files, with what was searched, confirmed and decides.
#
# study.json  has "optimise" besides: the front, the confirmation, sensitivities
# front.png   trials, reference and confirmed fingers in the first two objectives

CHART_FILE = "front.png"
FOLDER = RecordFolder("optimisation", STUDY_FILE, (*FILES, CHART_FILE))


def journal_beside(target: Path) -> Path:
    """The file that keeps an optimisation's trials, beside its folder."""
    return target.with_name(f"{target.name}.trials.jsonl")


def write_optimised(folder: Path, found: Optimised, source: str) -> None:
    """Write all files into ``folder``; ``source``: the text of the study's file."""
    study, reported = found.search.study, found.confirmation
    compared = write_study(folder, study, found.outcomes, source, {"optimise": found.data()})
    tables = [confirmed_table(found), *sensitivity_tables(found)]
    record = {key: text for key, text in compared.facts.record.items() if key != "optimise"}
    page = compare_html(
        compared.outcomes,
        replace(compared.facts, sources=(), record=record),
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
