"""control.html: success of every controller, and the forces it takes, on one page for offline use.

The success chart and the best controller come first; tables fold out.
"""

from dataclasses import dataclass
from pathlib import Path

from fingerdesign.report.page import render_page, sentences
from fingerdesign.trials.figures import (
    WORDS,
    chart_png,
    force_figure,
    map_figure,
    paths_figure,
    success_figure,
)
from fingerdesign.trials.record import ControlData, ControlStudy
from fingerdesign.trials.tables import (
    condition_tables,
    main_tables,
    noise_tables,
    tug_tables,
    tuning_tables,
    warning_tables,
)

__all__ = ["answers", "chart_png", "control_html"]
PAGE = Path(__file__).parent / "templates" / "control.html.j2"
HELD_SHARE = 0.99  # The regulator is to hold this fraction of the grid.


@dataclass(frozen=True)
class Question:
    """One question of the study, its answer ("yes", "no", "partly" or "best") and the numbers."""

    answer: str
    question: str
    detail: str


def answers(data: ControlData) -> list[Question]:
    """Answers to the study's questions that it can give: the best controller first; none for a
    lone rival."""
    rows = {
        (each["controller"], row.noise_microstrain): row
        for each in data["controllers"]
        for row in each["by_noise"]
    }
    found = sentences(WORDS, "answers", data, rows, HELD_SHARE)
    return [Question(*line.split("\t")) for line in found]


def control_html(study: ControlStudy) -> str:
    """The page of a study; figures are of its ``trace_noise``."""
    data, noise = study.data, study.trace_noise
    figures = [force_figure(data, study.trials, noise)]
    if data["conditions"]["perturbed"] is None:
        figures.append(map_figure(data, study.trials, noise))
        figures.append(paths_figure(study.traces, noise))
    folded = {
        "Who lifts, and how": main_tables(data, noise),
        "Tuning": tuning_tables(data["tuning"]),
        "By noise": noise_tables(data) if len(data["conditions"]["noises_microstrain"]) > 1 else [],
        "Tugged": tug_tables(data),
        "Warnings before slip": warning_tables(data, noise),
        "Conditions": condition_tables(data),
    }
    return render_page(
        PAGE,
        data=data,
        answers=answers(data),
        success=success_figure(data),
        figures=figures,
        folded={title: tables for title, tables in folded.items() if tables},
    )
