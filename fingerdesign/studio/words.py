"""The page's words on the numbers of a press: a question, a table, the section's text."""

from pathlib import Path

import numpy as np

from fingerdesign.design.schema import Design
from fingerdesign.layout.bodies import crest_height
from fingerdesign.records.verdict import Status
from fingerdesign.report.page import texts_of
from fingerdesign.studio.numbers import Numbers

WORDS = Path(__file__).parent / "templates" / "words.toml"
_LITTLE = 0.2  # of a contact that sticks: it is about to slip


def finding(now: Numbers) -> dict[str, str]:
    """Question, status (a note without contact) and reason: whether the contact of the press holds.

    The verdicts on the finger are of judge.py.
    """
    status: Status = "note"
    if now.touches:
        status = "pass" if now.ratio[-1] >= _LITTLE else "warning"
        status = "fail" if now.slips else status
    texts, percent = texts_of(WORDS)["holds"], 100.0 * (now.ratio[-1] or 0.0)
    forces = {"normal": now.normal[-1], "tangential": now.tangential[-1]}
    detail = texts.get(status, texts["other"]).format(now=now, percent=percent, **forces)
    return {"status": status, "question": texts["question"], "detail": " ".join(detail.split())}


def table(now: Numbers, before: Numbers | None = None) -> list[list[str]]:
    """Rows of the numbers: name, unit, of the pinned state (if any), now."""
    sides = [_cells(each) for each in (before, now) if each is not None]
    return [[*head, *(cells[head] for cells in sides)] for head in sides[0]]


def _cells(now: Numbers) -> dict[tuple[str, str], str]:
    """The number of each name and unit."""
    return {
        ("normal force", "N"): f"{now.normal[-1]:.3g}",
        ("tangential force", "N"): f"{now.tangential[-1]:.3g}",
        ("contact width", "mm"): f"{now.width:.2f}",
        ("stick ratio", ""): f"{now.ratio[-1]:.2f}" if now.touches else "–",
        ("peak pressure", "MPa"): f"{now.peak:.3g}",
        ("best gage, by shear", "µε"): f"{np.abs(now.signals).max(initial=0.0):.3g}",
    }


def section_words(design: Design, now: Numbers | None) -> str:
    """The text alternative of the section."""
    words = f"Section of {design.design.name}: {design.body.width_mm:g} mm wide, "
    words += f"{float(crest_height(design.body)):.4g} mm high, {design.plates.number} plates."
    if now is not None and now.touches:
        words += f" The contact is {now.width:.2f} mm wide; {now.ratio[-1]:.0%} of it sticks."
    return words
