"""A mold's checks as tables: every one, or a row a kind with the one that is nearest its bound."""

from __future__ import annotations

import math
from typing import Any

from fingerdesign.report.mold_tables import DASH, as_words
from fingerdesign.report.tables import Table

HEADS = ("check", "part", "measured", "bound", "unit", "what was found")


def checks_table(checks: list[dict[str, Any]], key: str, caption: str) -> Table | None:
    """Checks, a row each; None where there are none."""
    if not checks:
        return None
    rows = tuple((check["name"], *_check_cells(check)) for check in checks)
    return Table(f"checks-{key}", f"{caption}: {len(rows)}", HEADS, rows, frozenset({0, 1, 4, 5}))


def kinds_table(checks: list[dict[str, Any]]) -> Table | None:
    """What was checked, a row a kind: how often, how many failed, and the one nearest its bound."""
    kinds: dict[str, list[dict[str, Any]]] = {}
    for check in checks:
        kinds.setdefault(check["name"], []).append(check)
    rows = []
    for name, alike in kinds.items():
        failed = [check for check in alike if not check["ok"]]
        nearest = min(failed or alike, key=_room)
        count = (str(len(alike)), str(len(failed) or DASH))
        rows.append((name, *count, *_check_cells(nearest)))
    if not rows:
        return None
    columns = ("check", "checked", "failed", "nearest its bound", *HEADS[2:])
    caption = "What was checked; of each kind the one that is nearest its bound"
    return Table("checks-kinds", caption, columns, tuple(rows), frozenset({0, 3, 6, 7}))


def _check_cells(check: dict[str, Any]) -> tuple[str, ...]:
    return (
        as_words(check["part"]) or "mold",
        _measure(check["measured"]),
        _measure(check["bound"]),
        check["unit"] or DASH,
        check["sentence"],
    )


def _room(check: dict[str, Any]) -> float:
    """How far a measure is from its bound, relative to the larger; 0: at it, or not told."""
    measured, bound = check["measured"], check["bound"]
    if measured is None or bound is None:
        return 0.0
    most = max(abs(measured), abs(bound))
    return float(abs(measured - bound) / most) if most > 0.0 else 0.0


def _measure(value: float | None) -> str:
    """A measured value in four digits; a dash where there is none.

    >>> _measure(0.123456), _measure(None), _measure(0.0), _measure(15.0)
    ('0.1235', '–', '0', '15')
    """
    if value is None or not math.isfinite(value):
        return DASH
    return "0" if abs(value) < 1e-12 else f"{value:.4g}"
