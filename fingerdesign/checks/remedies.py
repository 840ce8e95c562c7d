"""Faults with remedies that have been tried: a wrong remedy is worse than a general one."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass

from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.rows import with_key

_HALVINGS = 18  # 10 mm to 0.04 micrometres


@dataclass(frozen=True)
class Change:
    """A remedy in words, and the key and value that follow it; without a key it is not tried."""

    words: str
    key: str = ""
    value: float = 0.0

    @classmethod
    def to(cls, words: str, key: str, value: str) -> Change:
        """``words`` to ``value``: "raise plates.cover_mm to at least 2.1"."""
        if words in ("lower", "set"):
            words = f"{words} {key} to" + (" at most" if words == "lower" else "")
        return cls(f"{words} {value}", key, int(value) if key.endswith("count") else float(value))


@dataclass(frozen=True)
class Finding:
    """A fault, by how much (``over``, mm), and how its remedies are found, should it be
    reported."""

    key: str
    value: object
    bound: str
    over: float
    changes: Callable[[], list[Change]]
    otherwise: str

    def fault(self, design: Design, before: set[str], find: Callable[[Design], set[str]]) -> Fault:
        """The fault in words. ``find``: the keys of a changed design's faults; a change that does
        not end this one, or brings another than ``before``, is not reported."""

        def mends(change: Change) -> bool:
            if not change.key:
                return True
            trial = with_key(design, change.key, change.value)
            return trial is not None and find(trial) <= before - {self.key}

        words = [change.words for change in self.changes() if mends(change)]
        return Fault(self.key, self.value, self.bound, " or ".join(words) or self.otherwise)


def worst_by_key(findings: Iterable[Finding]) -> list[Finding]:
    """One finding a key, the worst."""
    kept: dict[str, Finding] = {}
    for finding in findings:
        if finding.key not in kept or finding.over > kept[finding.key].over:
            kept[finding.key] = finding
    return list(kept.values())


def set_to(design: Design, key: str, value: float, holds: Callable[[Design], bool]) -> bool:
    """Whether ``holds`` of the design with a key set; False where the value itself is refused."""
    trial = with_key(design, key, value)
    return trial is not None and holds(trial)


def greatest(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """The greatest value in [low, high] up to which ``holds``, by bisection; None: not at low."""
    if holds(high):
        return high
    if not holds(low):
        return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if holds(middle) else (low, middle)
    return low


def least(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """The least value in [low, high] from which on it ``holds``; None: not at any tried."""
    if holds(low):
        return low
    while not holds(high):  # too far may be as wrong as too near
        high = 0.5 * (low + high)
        if not high - low >= 1e-3:  # nor for NaN
            return None
    for _ in range(_HALVINGS):
        middle = 0.5 * (low + high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high
