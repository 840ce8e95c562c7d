"""Slots that lack webs between them: which key is owed the change, and remedies that were tried."""

from __future__ import annotations

from typing import TYPE_CHECKING

from fingerdesign.design.faults import at_most
from fingerdesign.design.plate_rows import PlateRow
from fingerdesign.errors import Fault
from fingerdesign.mold import slots
from fingerdesign.mold.fixture_trials import (
    TRIALS,
    Web,
    again,
    least_value,
    row_of,
    worst_exit,
    worst_web,
)
from fingerdesign.mold.leg_room import Room
from fingerdesign.mold.plan import Holding, Leg
from fingerdesign.mold.profiles import limits_of

if TYPE_CHECKING:
    from fingerdesign.design.mold import Comb, MoldLimits
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.profiles import Limits

_SMALLEST_MM = 0.02  # slot or web


def no_web(design: Design, limits: Limits, worst: Web) -> Fault:
    """The fault of two slots between which no web can stand."""
    holding, one, two, distance, web = worst
    between = "they overlap" if distance == 0.0 else f"{distance:.3g}"
    own = "mold.comb.web_mm" if holding == "comb" else "mold.limits.feature_mm"
    bound = (
        f"such that webs of {own} = {web:g} mm stand between slots of at least "
        f"{slots.least_slot(design, holding, limits):g} mm (plates {one} and {two}: {between})"
    )
    row = row_of(design, two)
    same = any(frame.index == one for frame in row.frames)
    key, value = row.blame(two, "pitch_mm" if same else "cover_mm")
    return Fault(key, value, bound, _wider(design, limits, row, holding, same, one, key))


def _wider(
    design: Design,
    limits: Limits,
    row: PlateRow,
    holding: Holding,
    same: bool,
    other: int,
    key: str,
) -> str:
    """The remedy of slots that lack webs: changes that were tried."""

    def holds(trial: Design, thorough: bool = False) -> bool:
        own = limits_of(trial.mold)
        return worst_web(trial, *again(trial, own, thorough), own) is None

    found = []
    if row.placed:
        found.append(f"move it away from plate {other}")
    elif same:
        pitch = row.table.pitch_mm
        wider = least_value(design, key, pitch, 3.0 * pitch + 1.0, holds)
        if wider is not None:
            found.append(f"raise {key} to at least {wider:g}")
    else:
        found.append(f"move the rows apart by {key}")
    changes: list[tuple[str, object, str]] = []
    if holding != "comb" and design.mold.plate_fixture != "comb":
        words = "set mold.plate_fixture = 'comb', whose slots are cut finer"
        changes.append(("plate_fixture", "comb", words))
    if design.mold.leg_mm is not None:
        changes.append(("leg_mm", None, "remove mold.leg_mm"))
    if design.mold.wire_mm > 0.0:
        changes.append(("wire_mm", 0.0, "set mold.wire_mm = 0 and lead the wires out elsewhere"))
    for name, value, words in changes:
        mold = design.mold.model_copy(update={name: value})
        if holds(design.model_copy(update={"mold": mold}), thorough=True):
            found.append(words)
    return " or ".join(found) or "space the plates out, or lower plates.count"


def demanded(
    design: Design, worst: Web | None, high: tuple[Leg, Room, float] | None
) -> Fault | None:
    """The slot or web that the file itself asks for, if that is why plates cannot be held.

    None: they could not be held without it either.
    """
    mold = design.mold
    tables: list[tuple[str, Comb | MoldLimits, tuple[str, ...]]]
    tables = [("limits", mold.limits, ("slot_mm", "feature_mm", "clearance_mm"))]
    if mold.plate_fixture == "comb":
        tables.insert(0, ("comb", mold.comb, ("slot_mm", "web_mm", "clearance_mm")))
    for where, table, names in tables:
        for name in names:
            value = getattr(table, name)
            if value is None or name not in table.model_fields_set:
                continue
            most = _most(design, where, name, float(value))
            if most is None:
                continue
            if worst is not None:
                why = f"webs stand between the slots of plates {worst[1]} and {worst[2]}"
            else:
                assert high is not None
                why = f"plate {high[0].plate}'s slot stays below the contact surface"
            key = f"mold.{where}.{name}"
            remedy = "lower it, or space the plates out by plates.pitch_mm and plates.cover_mm"
            return Fault(key, value, f"at most {at_most(most)}, such that {why}", remedy)
    return None


def _most(design: Design, where: str, name: str, high: float) -> float | None:
    """The greatest value of one of the mold's sizes at which its plates are held; None: at none."""
    mold = design.mold

    def holds(size: float) -> bool:
        table = getattr(mold, where).model_copy(update={name: size})
        trial = design.model_copy(update={"mold": mold.model_copy(update={where: table})})
        limits = limits_of(trial.mold)
        given = (trial, *again(trial, limits), limits)
        return worst_web(*given) is None and worst_exit(*given) is None

    low = min(_SMALLEST_MM, 0.5 * high)
    if not holds(low):
        return None
    for _ in range(TRIALS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low
