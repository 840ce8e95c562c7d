"""An optimisation's answer in sentences: who beats the reference, by how much, and what decides."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from fingerdesign.errors import shown
from fingerdesign.records.folder import RecordFolder
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
from fingerdesign.search.optimise.confirm import Optimised, judged
from fingerdesign.search.optimise.sensitivity import LEAST
from fingerdesign.search.run.folder import FILES, REPORT_FILE, write_study
from fingerdesign.search.study.metrics import METRICS

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from fingerdesign.search.optimise.confirm import Confirmation, Judged, Optimised


# Tables of an optimisation: what stood by the thorough model, and what each objective hangs on.

NONE = "–"


def confirmed_table(found: Optimised) -> Table | None:
    """The reference and the confirmed fingers by both models; None where none was confirmed."""
    reported = found.confirmation
    if reported.thorough_reference is None:
        return None
    metrics = list(reported.reference.metrics)
    quick = found.search.study.study.fidelity
    columns = [
        "finger",
        *(f"{metric}, {name}" for metric in metrics for name in (quick, reported.fidelity)),
        "against the reference",
    ]
    pairs = [(reported.reference, reported.thorough_reference, "")]
    for each in reported.confirmed:
        deep = each.thorough
        if deep.failure:
            standing = f"failed: {deep.failure}"
        elif deep.better_in_all(reported.thorough_reference):
            standing = "better in every objective"
        elif deep.dominates(reported.thorough_reference):
            standing = "dominates it"
        elif not deep.feasible:
            standing = "misses a constraint"
        else:
            standing = "does not dominate it"
        pairs.append((each.quick, deep, standing))
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
    study = found.search.study
    trials = [judged(study, each.outcomes[0].name, each.outcomes) for each in found.tried]
    with house_style():
        figure = canvas(10.0, 4.9)
        plane, course = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
        _plane(plane, found, trials)
        _course(course, found)
        figure.savefig(path, format="png", dpi=150, facecolor=PAPER, metadata={"Software": None})


def _plane(axes: Axes, found: Optimised, trials: Sequence[Judged]) -> None:
    reported, study = found.confirmation, found.search.study
    first, second = (each.metric for each in study.objectives[:2])
    front = {found.tried[k].number for k in range(len(trials))} & set(reported.front)
    groups = (
        (
            "misses a constraint",
            "x",
            MUTED,
            [t for t in trials if not t.failure and not t.feasible],
        ),
        ("trial", "o", BLUE, [t for t in trials if t.feasible]),
    )
    for label, marker, colour, some in groups:
        axes.plot(*_points(some, first, second), marker, color=colour, ms=4.0, label=label)
    on_front = [own for each, own in zip(found.tried, trials, strict=True) if each.number in front]
    x, y = _points(on_front, first, second)
    order = np.argsort(x)
    axes.plot(
        np.array(x)[order], np.array(y)[order], color=BLUE, lw=1.2, ds="steps-post", label="front"
    )
    quick, deep = study.study.fidelity, reported.fidelity
    pairs = [(reported.reference, reported.thorough_reference, VERMILION, "s", "reference")]
    pairs += [
        (each.quick, each.thorough, GREEN, "D", "confirmed trial") for each in reported.confirmed
    ]
    seen: set[str] = set()
    for own, thorough, colour, marker, label in pairs:
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
    axes.set_title(f"{len(trials)} trials of {study.name}")
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
_MODEL = {"plane-strain": "in plane strain", "3d": "in 3-D"}


def verdict(found: Optimised) -> tuple[str, ...]:
    """Who dominates the reference and by how much, by both models; what the objectives hang on."""
    reported = found.confirmation
    goals = {each.metric: each.direction for each in found.search.study.objectives}
    if reported.thorough_reference is None:
        said = _quick(found, goals)
    else:
        said = _confirmed(reported, reported.thorough_reference, goals)
    return (*said, *_sensitivity(found))


def _quick(found: Optimised, goals: Mapping[str, str]) -> list[str]:
    """By the search's own model alone."""
    reported, study = found.confirmation, found.search.study
    where = _where(study.study.fidelity)
    by_number = {each.number: each for each in found.tried}
    first = (*(n for n in reported.front if n in reported.dominating), *reported.dominating)
    best = list(dict.fromkeys(first))
    fingers = [
        judged(study, by_number[n].outcomes[0].name, by_number[n].outcomes)
        for n in best[:MOST_NAMED]
    ]
    said = [_beats(own, reported.reference, goals, where) for own in fingers]
    said += _more(len(best) - len(fingers))
    if not best:
        said.append(f"No trial dominates the reference, {shown(reported.reference.name)}, {where}.")
    return [*said, "No more thorough model confirmed this."]


def _confirmed(reported: Confirmation, deep: Judged, goals: Mapping[str, str]) -> list[str]:
    """By the thorough model, with the quick one's numbers beside."""
    where = _where(reported.fidelity)
    if deep.failure:
        return [f"Nothing could be confirmed: the reference failed {where}: {shown(deep.failure)}"]
    said = []
    for each in reported.standing[:MOST_NAMED]:
        quick = _against(each.quick, reported.reference, goals)
        said.append(f"{_beats(each.thorough, deep, goals, where)} The search had seen {quick}.")
    said += _more(len(reported.standing) - MOST_NAMED)
    if not reported.standing:
        many = len(reported.confirmed)
        of = "The one finger" if many == 1 else f"None of the {many} fingers"
        verb = "does not dominate" if many == 1 else "dominates"
        said.append(f"{of} analysed again {where} {verb} the reference, {shown(deep.name)}, there.")
        said += [
            f"{shown(each.thorough.name)}: {_against(each.thorough, deep, goals)}."
            for each in reported.confirmed[:MOST_NAMED]
            if not each.thorough.failure
        ]
    return said


def _beats(own: Judged, reference: Judged, goals: Mapping[str, str], where: str) -> str:
    how = ", better in every objective" if own.better_in_all(reference) else ""
    return (
        f"{shown(own.name)} dominates the reference, {shown(reference.name)}, {where}{how}: "
        f"{_against(own, reference, goals)}."
    )


def _against(own: Judged, reference: Judged, goals: Mapping[str, str]) -> str:
    """As "stick error 0.05 against 0.1 (50 % lower)", of each objective."""
    return ", ".join(
        _one(metric, own.metrics.get(metric), reference.metrics.get(metric), goal)
        for metric, goal in goals.items()
    )


def _one(metric: str, own: float | None, other: float | None, goal: str) -> str:
    title = metric_title(metric)
    if own is None or other is None:
        return f"{title} unknown"
    if own == other:
        return f"{title} {own:.4g} as there"
    way = "lower" if own < other else "higher"
    much = f"{100 * abs(own - other) / abs(other):.3g} % {way}" if other else way
    worse = "" if (own < other) == (goal == "min") else ", worse"
    return f"{title} {own:.4g} against {other:.4g} ({much}{worse})"


def _sensitivity(found: Optimised) -> list[str]:
    """What each objective hangs on most, or why that is not known."""
    said = []
    unknown = []
    for each in found.sensitivities:
        if each.explained is None or not each.effects:
            unknown.append(each)
            continue
        first = max(each.effects, key=lambda effect: effect.share)
        way = ""
        if first.direction is not None:
            way = ", rising with it" if first.direction > 0 else ", falling with it"
        said.append(
            f"{metric_title(each.metric).capitalize()} hangs most on {shown(first.parameter)} "
            f"({100 * first.share:.0f} % of its variance{way}): see the table of the search."
        )
    few = [each for each in unknown if each.count < LEAST]
    if few:
        names = _and([metric_title(each.metric) for each in few])
        counts = min(each.count for each in few)
        trials = "1 trial is" if counts == 1 else f"{counts} trials are"
        said.append(f"What {names} hangs on is not told: {trials} too few, {LEAST} are needed.")
    level = [each for each in unknown if each.count >= LEAST]
    if level:
        names = _and([metric_title(each.metric) for each in level])
        said.append(f"What {names} hangs on is not told: it is the same in all trials.")
    return said


def _more(count: int) -> list[str]:
    if count <= 0:
        return []
    return ["One more dominates it too." if count == 1 else f"{count} more dominate it too."]


def _where(fidelity: str) -> str:
    return _MODEL.get(fidelity, f"by {fidelity}")


def _and(parts: Sequence[str]) -> str:
    return " and ".join(filter(None, (", ".join(parts[:-1]), *parts[-1:])))


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
