"""The fidelity ladder as a table of the report: what was tried, what it cost, why it ended."""

from __future__ import annotations

from fingerdesign.report.numbers import number_text
from fingerdesign.report.tables import Table
from fingerdesign.results import Result, TriedModel

QUANTITIES = {
    "normal_force": "F_n",
    "tangential_force": "F_t",
    "stick_ratio": "stick ratio",
    "gage": "gages",
}


def ladder_table(result: Result) -> Table | None:
    """A row a model that --fidelity auto tried; None where it did not choose."""
    if result.ladder is None:
        return None
    ladder = result.ladder
    columns = (
        *("model", "equations", "seconds"),
        *(f"{name}, %" for name in QUANTITIES.values()),
        "why",
    )
    rows = tuple(
        (each.name, f"{each.dofs:,}", number_text(each.seconds, 2), *_errors(each), each.why)
        for each in ladder.models
    )
    caption = (
        f"Models tried for a tolerance of {100 * ladder.tolerance:g} %, with their estimated "
        f"errors; chosen: {ladder.chosen}"
    )
    return Table("ladder", caption, columns, rows, frozenset({0, 7}))


def _errors(tried: TriedModel) -> list[str]:
    found = tried.error_estimates
    if found is None:
        return ["-"] * len(QUANTITIES)
    return [f"{100.0 * found[name]:.2g}" if name in found else "-" for name in QUANTITIES]
