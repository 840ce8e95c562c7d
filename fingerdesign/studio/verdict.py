"""The page's words on the numbers: three questions, a table, the section's text."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fingerdesign.analysis.detection import WANTED_STICK_CHANGE
from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.records.verdict import Status
from fingerdesign.report.page import texts_of
from fingerdesign.studio.numbers import Numbers

WORDS = Path(__file__).parent / "templates" / "words.toml"
# The report has the same bound for "follows"; a warning is clearly above the correlation
# of the step index alone (0.44 in 3-D).
GOOD, FAIR = 0.9, 0.6
# A change of the stick ratio by this much is measured before the grip is lost: there a hand that is
# controlled by it starts to hold.
ROUGH = 0.3
_LITTLE = 0.2  # of a contact that sticks: it is about to slip


def verdict(now: Numbers) -> list[dict[str, str]]:
    """Questions, the status of each (a note where the path does not show it), the reasons."""
    change = None if now.measured is None else -now.measured.smallest_stick_change
    measurable = _graded(change, -WANTED_STICK_CHANGE, -ROUGH)
    return [
        _finding("holds", _holds(now), now),
        _finding("follows", _graded(now.correlation, GOOD, FAIR), now),
        _finding("measurable", measurable, now),
    ]


def _holds(now: Numbers) -> Status:
    if not now.touches:
        return "note"
    if now.slips:
        return "fail"
    return "pass" if now.ratio[-1] >= _LITTLE else "warning"


def _graded(value: float | None, good: float, fair: float) -> Status:
    if value is None:
        return "note"
    return "pass" if value >= good else "warning" if value >= fair else "fail"


def _finding(name: str, status: Status, now: Numbers) -> dict[str, str]:
    texts = texts_of(WORDS)[name]
    detail = texts.get(status, texts["other"]).format(
        now=now,
        normal=now.normal[-1],
        tangential=now.tangential[-1],
        percent=100.0 * (now.ratio[-1] or 0.0),
        target=WANTED_STICK_CHANGE,
    )
    detail = " ".join(detail.split())
    return {"status": status, "question": texts["question"], "detail": detail}


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
