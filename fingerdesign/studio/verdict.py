"""The page's words on the numbers: three questions, a table, the section's text."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from fingerdesign.analysis.detection import WANTED_STICK_CHANGE
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.report.page import paragraphs
from fingerdesign.studio.numbers import Numbers

WORDS = Path(__file__).parent / "templates" / "words.txt.j2"
# The report has the same bound for "follows"; a partial answer is clearly above the correlation
# of the step index alone (0.44 in 3-D).
GOOD, FAIR = 0.9, 0.6
# A change of the stick ratio by this much is measured before the grip is lost: there a hand that is
# controlled by it starts to hold.
ROUGH = 0.3
_LITTLE = 0.2  # of a contact that sticks: it is about to slip


def verdict(now: Numbers) -> list[dict[str, str]]:
    """Questions, answers ("yes", "partly", "no", "open") and their reasons."""
    change = None if now.measured is None else -now.measured.smallest_stick_change
    measurable = _graded(change, -WANTED_STICK_CHANGE, -ROUGH)
    return [
        _finding("holds", _holds(now), now=now),
        _finding("follows", _graded(now.correlation, GOOD, FAIR), now=now),
        _finding("measurable", measurable, now=now, target=WANTED_STICK_CHANGE),
    ]


def _holds(now: Numbers) -> str:
    if not now.touches:
        return "open"
    if now.slips:
        return "no"
    return "yes" if now.ratio[-1] >= _LITTLE else "partly"


def _graded(value: float | None, good: float, fair: float) -> str:
    if value is None:
        return "open"
    return "yes" if value >= good else "partly" if value >= fair else "no"


def _finding(name: str, answer: str, **values: Any) -> dict[str, str]:
    question, detail = paragraphs(WORDS, name, answer=answer, **values)
    return {"answer": answer, "question": question, "detail": detail}


def table(now: Numbers, before: Numbers | None = None) -> list[list[str]]:
    """Rows of the numbers: name, unit, of the pinned state (if any), now."""
    sides = ([before] if before is not None else []) + [now]
    columns = [_cells(each) for each in sides]
    heads = [(name, unit) for name, unit, _ in columns[0]]
    return [
        [name, unit, *(cells[row][2] for cells in columns)]
        for row, (name, unit) in enumerate(heads)
    ]


def _cells(now: Numbers) -> list[tuple[str, str, str]]:
    ratio = f"{now.ratio[-1]:.2f}" if now.touches else "–"
    most = float(np.abs(now.signals).max(initial=0.0))
    follows = "–" if now.correlation is None else f"{now.correlation:.2f}"
    seen = "–" if now.measured is None else f"{now.measured.smallest_stick_change:.2g}"
    return [
        ("normal force", "N", f"{now.normal[-1]:.3g}"),
        ("tangential force", "N", f"{now.tangential[-1]:.3g}"),
        ("contact width", "mm", f"{now.width:.2f}"),
        ("stick ratio", "", ratio),
        ("peak pressure", "MPa", f"{now.peak:.3g}"),
        ("best gage, by shear", "µε", f"{most:.3g}"),
        ("area follows stick", "", follows),
        ("smallest change of stick seen", "", seen),
    ]


def section_words(design: Design, now: Numbers | None) -> str:
    """The text alternative of the section."""
    words = f"Section of {design.design.name}: {design.body.width_mm:g} mm wide, "
    words += f"{float(crest_height(design.body)):.4g} mm high, {design.plates.number} plates."
    if now is not None and now.touches:
        words += f" The contact is {now.width:.2f} mm wide; {now.ratio[-1]:.0%} of it sticks."
    return words
