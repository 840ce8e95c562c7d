"""An optimisation's folder: a study's files, with its answer, tables and chart.

study.json has "optimise" too: the front, the confirmation, sensitivities. front.png shows trials,
reference and confirmed fingers in the first two objectives.
"""

from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.errors import shown
from fingerdesign.records.folder import RecordFolder
from fingerdesign.report import style
from fingerdesign.report.style import Axes
from fingerdesign.report.table import Table
from fingerdesign.search.compare.folder import FILES, write_study
from fingerdesign.search.compare.page import SearchFindings
from fingerdesign.search.compare.read import STUDY_FILE, Comparison
from fingerdesign.search.optimise import words
from fingerdesign.search.optimise.confirm import Judged, Optimised
from fingerdesign.search.optimise.trials import ENDING
from fingerdesign.search.study.metrics import METRICS

NONE = "–"
CHART_FILE = "front.png"
FOLDER = RecordFolder("optimisation", STUDY_FILE, (*FILES, CHART_FILE))
# Of the trials, whether feasible: mark, colour, name.
_TRIALS = ((False, "x", style.MUTED, "not feasible"), (True, "o", style.BLUE, "trial"))


def tables(found: Optimised) -> list[Table]:
    """Those of an optimisation that have anything to say."""
    return [*_confirmed_table(found), *_sensitivity_table(found)]


def _confirmed_table(found: Optimised) -> Iterator[Table]:
    """The reference and the confirmed fingers by both models, where any was confirmed."""
    reference = found.thorough_reference
    if reference is None:
        return
    metrics, quick = list(found.reference.metrics), found.search.study.study.fidelity
    columns = (
        "finger",
        *(f"{_words(metric)}, {name}" for metric in metrics for name in (quick, found.fidelity)),
        "against the reference",
    )
    pairs = [(found.reference, reference, "")]
    pairs += [(c.quick, c.thorough, _standing(c.thorough, reference)) for c in found.confirmed]
    rows = tuple(
        (
            shown(own.name),
            *(_number(each, metric) for metric in metrics for each in (own, deep)),
            shown(standing),
        )
        for own, deep, standing in pairs
    )
    caption = f"The best trials again, by {found.fidelity}"
    yield Table("confirmed", caption, columns, rows, frozenset({0, len(columns) - 1}))


def _standing(own: Judged, reference: Judged) -> str:
    if own.failure:
        return f"failed: {own.failure}"
    if own.better_in_all(reference):
        return "better in every objective"
    if own.dominates(reference):
        return "dominates it"
    if own.lacks:
        return "; ".join(own.lacks.values())
    return "does not dominate it" if own.feasible else "misses a constraint"


def _number(own: Judged, metric: str) -> str:
    value = own.metrics.get(metric)
    return NONE if value is None else f"{value:.4g}"


def _sensitivity_table(found: Optimised) -> Iterator[Table]:
    """A row a parameter, share and direction of each objective, where there are numbers."""
    known = [each for each in found.sensitivities if each.explained is not None]
    rows = []
    for key in found.search.study.parameters:
        row = [shown(key)]
        for effect in (e for each in known for e in each.effects if e.parameter == key):
            row.append(f"{effect.share:.2f}")
            row.append(NONE if effect.direction is None else f"{effect.direction:+.2f}")
        rows.append(tuple(row))
    ends = [f"{each.metric}: {part}" for each in known for part in ("share", "direction")]
    if known:
        caption, columns = words.shares_caption(found.sensitivities), ("parameter", *ends)
        yield Table("sensitivity", caption, columns, tuple(rows), frozenset({0}))


def front_png(found: Optimised) -> bytes:
    """The first two objectives against each other, and the volume dominated by number of trials."""
    with style.house_style():
        figure = style.canvas(10.0, 4.9)
        plane, course = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
        _plane(plane, found)
        _course(course, found)
        return style.to_png(figure)


def _plane(axes: Axes, found: Optimised) -> None:
    study = found.search.study
    first, second = (each.metric for each in study.objectives[:2])

    def drawn(some: Iterable[Judged | None], *look: str, **more: Any) -> None:
        known = [each for each in some if each is not None and not each.failure]
        points = [(each.metrics[first], each.metrics[second]) for each in known]
        axes.plot(*np.reshape([p for p in points if None not in p], (-1, 2)).T, *look, **more)

    for feasible, look, colour, label in _TRIALS:
        some = [own for own in found.judged if own.feasible is feasible]
        drawn(some, look, color=colour, ms=4.0, label=label)
    front = [found.judged[number - 1] for number in found.front]
    front.sort(key=lambda own: own.metrics[first] or 0.0)
    drawn(front, color=style.BLUE, lw=1.2, ds="steps-post", label="front")
    pairs = [(found.reference, found.thorough_reference, style.VERMILION, "s", "reference")]
    pairs += [(e.quick, e.thorough, style.GREEN, "D", "confirmed trial") for e in found.confirmed]
    seen = set[str]()
    for own, thorough, colour, marker, label in pairs:
        drawn((own, thorough), color=colour, lw=0.8, ls=(0, (2, 2)))
        for each, fill, name in (
            (own, style.PAPER, study.study.fidelity),
            (thorough, colour, found.fidelity),
        ):
            if each is not None and not each.failure:
                text = f"{label}, {name}"
                named = None if text in seen else text
                drawn((each,), marker, color=colour, mfc=fill, ms=7.0, label=named)
                seen.add(text)
    axes.set_xlabel(_words(first))
    axes.set_ylabel(_words(second))
    axes.set_title(f"{len(found.judged)} trials of {study.name}")
    axes.legend(fontsize=7.5)


def _course(axes: Axes, found: Optimised) -> None:
    volumes = found.volumes
    axes.step(range(1, len(volumes) + 1), 100.0 * np.array(volumes), where="post", color=style.INK)
    axes.set_ylim(0.0, 105.0)
    axes.set_xlabel("trials")
    axes.set_ylabel("dominated volume, % of the last")
    axes.set_title("How the search went")


def _words(metric: str) -> str:
    unit = METRICS[metric].unit
    return f"{metric} ({unit})" if unit and not metric.endswith(f"_{unit}") else metric


def verdict(found: Optimised) -> tuple[str, ...]:
    """Who dominates the reference and by how much, by both models; what the objectives hang on."""
    return (*words.reference_sentences(found), *words.sensitivity_sentences(found.sensitivities))


def journal_path(target: Path) -> Path:
    """The file of an optimisation's trials, next to its folder."""
    return target.with_name(f"{target.name}{ENDING}")


def write_optimised(folder: Path, found: Optimised, source: str) -> Comparison:
    """Write all files into ``folder``; what its page compares. source: the text of the study's
    file."""
    compared = write_study(
        folder,
        found.search.study,
        found.outcomes,
        source,
        {"optimise": found.data()},
        SearchFindings(
            answer=verdict(found),
            verdicts=(words.tile(found),),
            notes=tuple(found.sentences()),
            tables=tuple(tables(found)),
            references=tuple(
                each.name for each in (found.reference, found.thorough_reference) if each
            ),
        ),
    )
    if len(found.search.study.objectives) > 1:
        (folder / CHART_FILE).write_bytes(front_png(found))
    return compared
