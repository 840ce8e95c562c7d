"""Tables of an optimisation: what stood by the thorough model, and what each objective hangs on."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.report.tables import Table
from fingerdesign.sweep.plain_text import shown

if TYPE_CHECKING:
    from fingerdesign.sweep.confirm import Judged
    from fingerdesign.sweep.optimise_folder import Optimised

NONE = "–"


def confirmed_table(found: Optimised) -> Table | None:
    """The reference and the confirmed fingers by both models; None where none was confirmed."""
    told = found.confirmation
    if told.thorough_reference is None:
        return None
    metrics = list(told.reference.metrics)
    quick = found.search.study.study.fidelity
    columns = [
        "finger",
        *(f"{metric}, {name}" for metric in metrics for name in (quick, told.fidelity)),
        "against the reference",
    ]
    pairs = [(told.reference, told.thorough_reference, "")]
    for each in told.confirmed:
        deep = each.thorough
        if deep.failure:
            standing = f"failed: {deep.failure}"
        elif deep.better_in_all(told.thorough_reference):
            standing = "better in every objective"
        elif deep.dominates(told.thorough_reference):
            standing = "dominates it"
        elif not deep.feasible:
            standing = "misses a constraint"
        else:
            standing = "does not dominate it"
        pairs.append((each.quick, deep, standing))
    rows = tuple(
        (
            shown(own.name),
            *(_number(each, metric) for metric in metrics for each in (own, deep)),
            shown(standing),
        )
        for own, deep, standing in pairs
    )
    caption = f"The best trials again, by {told.fidelity}"
    return Table("confirmed", caption, tuple(columns), rows, frozenset({0, len(columns) - 1}))


def sensitivity_tables(found: Optimised) -> list[Table]:
    """A table: a row a parameter, share and direction of each objective; none without numbers."""
    known = [each for each in found.sensitivities if each.explained is not None]
    if not known:
        return []
    columns = ["parameter"]
    for each in known:
        columns += [f"{each.metric}: share", f"{each.metric}: direction"]
    rows = []
    for key in found.search.study.parameters:
        row = [shown(key)]
        for each in known:
            effect = next(e for e in each.effects if e.parameter == key)
            direction = effect.direction
            row.append(f"{effect.share:.2f} ± {effect.spread:.2f}")
            row.append(NONE if direction is None else f"{direction:+.2f}")
        rows.append(tuple(row))
    said = ". ".join(each.words for each in found.sensitivities)
    caption = (
        f"What each objective hangs on. {said}. Share: of the variance that goes with the "
        "parameter, alone or in concert, with its standard error; direction: partial rank "
        "correlation, above 0 rising"
    )
    return [Table("sensitivity", caption, tuple(columns), tuple(rows), frozenset({0}))]


def _number(own: Judged, metric: str) -> str:
    value = own.metrics.get(metric)
    return NONE if value is None else f"{value:.4g}"
