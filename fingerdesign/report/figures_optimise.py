"""The chart of a search: trials, front, reference and confirmed fingers; and how it went."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

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

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from fingerdesign.sweep.confirm import Judged
    from fingerdesign.sweep.optimise_folder import Optimised


def draw_front(found: Optimised, path: Path) -> None:
    """The first two objectives against each other, and the volume dominated by number of trials."""
    from fingerdesign.sweep.confirm import judged

    study = found.search.study
    trials = [judged(study, each.outcomes[0].name, each.outcomes) for each in found.tried]
    with house_style():
        figure = canvas(10.0, 4.9)
        plane, course = figure.subplots(1, 2, width_ratios=(1.6, 1.0))
        _plane(plane, found, trials)
        _course(course, found)
        figure.savefig(path, format="png", dpi=150, facecolor=PAPER, metadata={"Software": None})


def _plane(axes: Axes, found: Optimised, trials: Sequence[Judged]) -> None:
    told, study = found.confirmation, found.search.study
    first, second = (each.metric for each in study.objectives[:2])
    front = {found.tried[k].number for k in range(len(trials))} & set(told.front)
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
    quick, deep = study.study.fidelity, told.fidelity
    pairs = [(told.reference, told.thorough_reference, VERMILION, "s", "reference")]
    pairs += [(each.quick, each.thorough, GREEN, "D", "confirmed trial") for each in told.confirmed]
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
    from fingerdesign.sweep.metrics import METRICS

    unit = METRICS[metric].unit
    return f"{metric} ({unit})" if unit and not metric.endswith(f"_{unit}") else metric
