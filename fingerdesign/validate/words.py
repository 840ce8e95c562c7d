"""Errors in words: the same on the page, in the terminal and in advice."""

from __future__ import annotations

from collections.abc import Mapping

MANY = 10.0  # from here on no percents
NONE = "–"  # prescribed, or nothing that could differ


def times(error: float) -> str:
    """For what is no matter of percents.

    >>> times(2612.3)
    '2,612 times'
    """
    return f"{error:,.0f} times"


def percent_cell(error: float) -> str:
    """A table's cell under "%".

    >>> percent_cell(0.259), percent_cell(1.615), percent_cell(2612.3)
    ('25.90', '162', '2,612 times')
    """
    if error >= MANY:
        return times(error)
    hundred = 100.0 * error
    return f"{hundred:.0f}" if hundred >= 99.5 else f"{hundred:.2f}"


def spread_cell(quantity: str, found: Mapping[str, float] | None) -> str:
    """The greatest error, the median in brackets.

    >>> spread_cell("gage", {"greatest": 0.259, "median": 0.257}), spread_cell("gage", None)
    ('25.90 (25.70)', '–')
    """
    if found is None:
        return NONE
    if quantity == "stick_ratio":
        return f"{found['greatest']:.3f} ({found['median']:.3f})"
    return f"{percent_cell(found['greatest'])} ({percent_cell(found['median'])})"
