"""Remedies with numbers for faults of room: found by planning the mold again with another value."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

from fingerdesign.errors import DesignError, Fault

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.profiles import Limits

Planned = Callable[["Design"], list[Fault]]

_UP = (1.05, 1.1, 1.2, 1.3, 1.5, 1.75, 2.0, 2.5)
_DOWN = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
_BOLT, _PIN, _WALL = "mold.bolt", "mold.limits.pin_mm", "mold.limits.wall_mm"
_GATE, _VENT, _HOLE = "mold.gate_mm", "mold.vent_mm", "mold.limits.hole_mm"
_HEIGHT, _WIDTH, _DEPTH = "body.base_height_mm", "body.width_mm", "body.depth_mm"
_PROCESS = "mold.process"
# Faults that one change may mend together -> the keys that are tried.
_GROUPS: tuple[tuple[tuple[str, ...], tuple[str, ...]], ...] = (
    ((_BOLT, _PIN, _WALL), (_HEIGHT, _DEPTH, _WALL, _PIN, _PROCESS)),
    ((_GATE, _VENT), (_HOLE, _WIDTH, _DEPTH, _WALL, _PROCESS)),
)


def with_remedies(
    design: Design, limits: Limits, faults: list[Fault], planned: Planned
) -> list[Fault]:
    """The same faults; where one of room has a change of one key that mends it, its remedy says so.

    A change is named only if ``planned`` (a design's faults, remedies left out) with it finds none
    of the faults of its group any more, and no new ones.
    """
    if not faults:
        return faults
    before = {fault.key for fault in faults}
    for keys, tried in _GROUPS:
        group = {fault.key for fault in faults if fault.key in keys}
        if not group:
            continue
        found = [
            text for key in tried if (text := _mended(design, limits, key, group, before, planned))
        ]
        if found:
            remedy = f"one of these mends it: {'; '.join(found)}"
            faults = [replace(f, remedy=remedy) if f.key in group else f for f in faults]
    return faults


def _mended(
    design: Design, limits: Limits, key: str, group: set[str], before: set[str], planned: Planned
) -> str:
    """The first change of a key that mends a group of faults, as in a design file; "" for none."""
    from fingerdesign.design.io import with_values

    for values in _candidates(design, limits, key):
        try:
            after = {fault.key for fault in planned(with_values(design, dict(values)))}
        except DesignError:
            continue
        if not after & group and after <= before:
            return ", ".join(f"{name} = {_said(value)}" for name, value in values.items())
    return ""


def _candidates(design: Design, limits: Limits, key: str) -> Iterator[Mapping[str, float | str]]:
    """Values of a key, the nearest to what it is first; a round body's width is its depth."""
    body = design.body
    if key == _PROCESS:
        yield from ({key: name} for name in ("sla", "machined", "fdm") if name != limits.name)
    elif key.startswith("body."):
        if body.step is not None:
            return
        name = key.removeprefix("body.")
        if name == "depth_mm" and body.shape == "revolved":
            return
        also = {_DEPTH} if name == "width_mm" and body.shape == "revolved" else set[str]()
        now = float(getattr(body, name))
        for share in _UP:
            value = round(share * now, 1)
            if value > now:
                yield dict.fromkeys((key, *also), value)
    else:
        now = float(getattr(limits, key.removeprefix("mold.limits.")))
        yield from ({key: round(share * now, 2)} for share in _DOWN)


def _said(value: float | str) -> str:
    return f"'{value}'" if isinstance(value, str) else f"{value:g}"
