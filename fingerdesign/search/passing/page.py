"""The page of a search for a passing finger: where it began, where it ended, what was given up."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.analysis.detection import WANTED_STICK_CHANGE
from fingerdesign.analysis.page.section import dimension_shapes, draw_shapes, section_shapes
from fingerdesign.analysis.verdicts import GOOD_CORRELATION, verdict_view
from fingerdesign.design.schema import Design
from fingerdesign.records.verdict import Verdict, VerdictView
from fingerdesign.report import style
from fingerdesign.report.page import Item, Page, Section, Text, page_html
from fingerdesign.report.table import Table, value_text
from fingerdesign.search.passing.found import Found
from fingerdesign.search.passing.front import GOALS, pair_of
from fingerdesign.search.passing.hands import WIDEST_STEPS
from fingerdesign.search.passing.space import changes_between
from fingerdesign.search.study.metrics import METRICS

# Metrics that a user may miss after a search for verdicts.
_GIVEN_UP = ("plates", "stiffness_N_per_mm", "peak_pressure_MPa", "rubber_volume_ml")
_ARC = "body.arc_radius_mm"

LACKS = """A hand is the settings of the grip. Its shortfall is 0 if it lifts at every friction with
a force between the limits. A lift that fails adds 1 to 2; a force that is twice beyond a limit adds
1."""


def passing_page(design: Design, found: Found) -> str:
    """The page as HTML that opens offline; ``design``: where the search began."""
    best = found.best
    count = f"{len(found.tried)} trials"
    view = _view(found)
    with style.house_style():
        charts: list[Item] = [_trials_figure(found)] if found.tried else []
        first = charts.pop() if charts and best is None else Text(found.conflict)
        if best is not None:
            first = _sections(design, best.design)
    sections = [
        Section("conflict", "Why none passes", [Text(found.conflict)] if found.conflict else []),
        Section("note", "What to know", [Text(found.note)] if found.note else []),
        Section("changes", "What changed", [*_changes(design, found)]),
        Section("search", "The search", [*charts, *_tables(found)]),
    ]
    title = f"{design.design.name}: search for a passing finger"
    return page_html(
        Page(
            title=title,
            heading=title,
            lead=" · ".join([view.summary if view else "no finger passes", count]),
            sections=[each for each in sections if each.items],
            record=[Text(f"Searched keys: {', '.join(found.space.parameters)}.", "quiet")],
            first=first,
            view=view,
        )
    )


def _view(found: Found) -> VerdictView | None:
    """The verdicts of the best finger, and a warning where there is more to know."""
    if found.best is None or found.best.result is None:
        return None
    view = verdict_view(found.best.result)
    more = Verdict("warning", "what to know", "before you cast it: see below")
    # What a fix would change, the search has tried; it proposes no second search.
    return replace(view, fixes=(), verdicts=(*view.verdicts, *([more] if found.note else [])))


def write_page(path: Path, design: Design, found: Found) -> None:
    path.write_text(passing_page(design, found), encoding="utf-8", newline="\n")


def _sections(before: Design, after: Design) -> style.ReportFigure:
    """Both sections with dimensions, before above after."""
    figure = style.canvas(7.2, 6.4)
    panels = figure.subplots(2, 1)
    for axes, design, title in zip(panels, (before, after), ("before", "after"), strict=True):
        draw_shapes(axes, [*section_shapes(design), *dimension_shapes(design)])
        axes.set_title(f"{title}: {design.plates.number} plates (mm)")
    for limits in ("xlim", "ylim"):  # One scale, so that sizes can be compared.
        ends = [getattr(axes, f"get_{limits}")() for axes in panels]
        for axes in panels:
            axes.set(**{limits: (np.min(ends), np.max(ends))})
    words = f"Section of {before.design.name} before and after the search."
    image = style.to_svg(figure, "sections", words)
    return style.ReportFigure("sections", "Before and after", image, words, words)


def _trials_figure(found: Found) -> style.ReportFigure:
    """Each trial's gages: rank correlation against the smallest stick change seen."""
    figure = style.canvas(7.2, 3.4)
    axes = figure.subplots()
    front = found.front
    pairs, best = (np.array(each).reshape(-1, 2) for each in (front.trials, front.best))
    names = " against ".join(GOALS)
    if len(best) > 1:
        axes.step(best[:, 1], best[:, 0], color=style.VERMILION, lw=1.2, label=f"front: {names}")
    axes.plot(pairs[:, 1], pairs[:, 0], "o", color=style.BLUE, ms=4.0, label="trial")
    if found.best is not None:
        own = np.reshape([*pair_of(found.best.sensed)], (-1, 2))
        axes.plot(own[:, 1], own[:, 0], "D", color=style.GREEN, ms=7.0, label="taken")
    axes.axhline(GOOD_CORRELATION, color=style.MUTED, lw=0.8)
    axes.axvline(WANTED_STICK_CHANGE, color=style.MUTED, lw=0.8)
    axes.set_xscale("log")
    axes.set_xlabel(f"{GOALS[1]}: smallest stick change seen")
    axes.set_ylabel(f"{GOALS[0]}: least rank correlation")
    axes.legend(fontsize=7.5)
    reading = f"{front.sentence()} " if front.trials else ""
    reading += (
        f"Good fingers are at the upper left: rank correlation over {GOOD_CORRELATION:g}, stick "
        f"change under {WANTED_STICK_CHANGE:g}."
    )
    if lacking := len(found.tried) - len(front.trials):
        reading += f" Not drawn: trials that lack one of the two, {lacking} of {len(found.tried)}."
    image = style.to_svg(figure, "trials", reading)
    return style.ReportFigure("trials", "Gages of all trials", image, reading, reading)


def _changes(design: Design, found: Found) -> Iterator[Item]:
    """List what was given up, the changed keys, quantities of the first trial and the one taken."""
    if found.best is None:
        return
    if found.given_up:
        yield Text(found.given_up)
    if lost := ", ".join(found.space.replaced):
        words = "Given up, since one plain row of plates below a crown was searched"
        yield Text(f"{words}: {lost}.")
    changes = changes_between(design, found.best.design)
    if _ARC in changes and design.body.shape in ("block", "step"):
        changes[_ARC] = None, changes[_ARC][1]  # It had no arc.
    changed = tuple((key, *map(_text, values)) for key, values in changes.items())
    columns = ("key", "before", "after")
    yield Table("changed", "Changed keys", columns, changed, frozenset(range(3)))
    ends = found.tried[0].outcomes[0], found.best.sensed
    rows = tuple(
        (_named(name), *(_number(each.metrics.get(name)) for each in ends)) for name in _GIVEN_UP
    )
    words = "What else changed, by the trials' swept cells; the report has the finger's own mesh"
    columns = ("quantity", "first trial: your sizes within the ranges", "taken")
    yield Table("given-up", words, columns, rows, frozenset({0}))


def _text(value: Any) -> str:
    return "–" if value is None else value_text(value)


def _named(name: str) -> str:
    """A metric's meaning with its unit."""
    metric = METRICS[name]
    return f"{metric.words} ({metric.unit})" if metric.unit else metric.words


def _number(value: float | None) -> str:
    return "–" if value is None or math.isinf(value) else f"{value:.4g}"


def _tables(found: Found) -> Sequence[Item]:
    """Fingers for which a hand was searched."""
    rows = tuple(
        (
            each.sensed.name,
            _number(each.sensed.metrics.get("area_correlation")),
            _number(each.sensed.metrics.get("smallest_stick_change")),
            _number(each.hand.shortfall),
            _number(each.hand.stepped),
            "not analysed" if each.result is None else ", ".join(each.failing) or "all pass",
        )
        for each in found.candidates
    )
    columns = (
        "trial",
        "rank correlation",
        "stick change",
        "shortfall of the hand",
        f"with steps ±{100.0 * (WIDEST_STEPS - 1.0):.0f} %",
        "verdicts on its own mesh",
    )
    hands = Table("hands", "Fingers with a hand", columns, rows, frozenset({0, 5}))
    return [hands, Text(LACKS, "quiet")] if rows else []
