"""A mold's report.html: verdict, pictures, casting notes to tick, tables; offline, printable."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.mold.part import axis_name
from fingerdesign.report.page import render_page
from fingerdesign.report.table import number_text

if TYPE_CHECKING:
    from fingerdesign.mold.picture import Pictures
    from fingerdesign.mold.record import CheckData, HoleData, MoldData

TEMPLATES = Path(__file__).parent / "templates"


def mold_html(record: MoldData, pictures: Pictures | None, missing: str = "") -> str:
    """The page, from what mold_report.json holds; ``missing`` says why there are no pictures."""
    return render_page(
        TEMPLATES / "mold.html.j2",
        page_style=(TEMPLATES / "mold.css").read_text(encoding="utf-8"),
        data=record,
        pictures=pictures,
        missing=missing,
        kinds=kinds_of(record["checks"]),
        labels=labels(record["base"]["holes"]),
        axis_name=axis_name,
        measure=measure,
        number=number_text,
    )


def labels(holes: list[HoleData]) -> list[str]:
    """A label a hole: its kind's letter, and a number where there are more of them.

    >>> labels([{"kind": "gate"}, {"kind": "vent"}, {"kind": "vent"}])
    ['G', 'V1', 'V2']
    """
    kinds = [hole["kind"] for hole in holes]
    numbers = [kinds[: k + 1].count(kind) for k, kind in enumerate(kinds)]
    return [
        f"{kind[0].upper()}{number if kinds.count(kind) > 1 else ''}"
        for kind, number in zip(kinds, numbers, strict=True)
    ]


def kinds_of(checks: list[CheckData]) -> list[dict[str, Any]]:
    """Count each kind of check: how often, how many failed, and the one nearest its bound."""
    found = []
    for name in dict.fromkeys(check["name"] for check in checks):
        alike = [check for check in checks if check["name"] == name]
        failed = [check for check in alike if not check["ok"]]
        nearest = min(failed or alike, key=_room)
        found.append({"checked": len(alike), "failed": len(failed), "nearest": nearest})
    return found


def _room(check: CheckData) -> float:
    """Distance of a measure from its bound, relative to the larger; 0: at it, or not reported."""
    measured, bound = check["measured"], check["bound"]
    if measured is None or bound is None:
        return 0.0
    most = max(abs(measured), abs(bound))
    return float(abs(measured - bound) / most) if most > 0.0 else 0.0


def measure(value: float | None) -> str:
    """A measured value in four digits; a dash where there is none.

    >>> measure(0.123456), measure(None), measure(0.0), measure(15.0)
    ('0.1235', '–', '0', '15')
    """
    if value is None or not math.isfinite(value):
        return "–"
    return "0" if abs(value) < 1e-12 else f"{value:.4g}"
