"""Misplaced plates as findings, and remedies that are tried before they are reported.

Each fault names the worst plate (numbered from 0, row by row). A wrong remedy is worse than a
general one, so that a change is reported only where the changed design has no such fault.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Self

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault
from fingerdesign.layout.clearance import LEAST_CLEARANCE_MM
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.row_keys import PlateRow, with_key

CLOSE = 1e-9  # Rounding of lengths, mm.
STAY = f"such that plates stay {LEAST_CLEARANCE_MM} mm"  # how most bounds begin
_HALVINGS = 18  # 10 mm to 0.04 micrometres.


@dataclass(frozen=True)
class Change:
    """A remedy in words, and the key and value that follow it; without a key it is not tried."""

    words: str
    key: str = ""
    value: float = 0.0

    @classmethod
    def to(cls, words: str, key: str, value: str) -> Self:
        """``words`` to ``value``: "raise plates.cover_mm to at least 2.1"."""
        if words in ("lower", "set"):
            words = f"{words} {key} to" + (" at most" if words == "lower" else "")
        return cls(f"{words} {value}", key, int(value) if key.endswith("count") else float(value))


@dataclass(frozen=True)
class Misplacement:
    """A fault, by how much (``over``, mm), and a function that finds its remedies."""

    key: str
    value: object
    bound: str
    over: float
    changes: Callable[[], list[Change]]
    otherwise: str

    def fault(self, design: Design, before: set[str], find: Callable[[Design], set[str]]) -> Fault:
        """Report the fault. ``find``: the keys of a changed design's faults; a change that does not
        end this one, or brings another than ``before``, is not reported."""

        def mends(change: Change) -> bool:
            if not change.key:
                return True
            trial = with_key(design, change.key, change.value)
            return trial is not None and find(trial) <= before - {self.key}

        found = [change for change in self.changes() if mends(change)]
        words = " or ".join(change.words for change in found) or self.otherwise
        tried = {change.key: change.value for change in found if change.key}
        return Fault(self.key, self.value, self.bound, words, tried)


def worst_by_key(findings: Iterable[Misplacement]) -> list[Misplacement]:
    """Return one finding a key, the worst."""
    worst: dict[str, Misplacement] = {}
    for finding in findings:
        if finding.key not in worst or finding.over > worst[finding.key].over:
            worst[finding.key] = finding
    return list(worst.values())


def too_near(
    row: PlateRow, distances: Array, unknown: float = -np.inf
) -> tuple[PlateFrame, float] | None:
    """Return the plate of the least distance (plates,), mm, and that distance, where it is below
    the least clearance; ``unknown``: the value that NaN counts as."""
    distances = np.where(np.isnan(distances), unknown, distances)
    worst = int(np.argmin(distances))
    if distances[worst] >= LEAST_CLEARANCE_MM - CLOSE:
        return None
    return row.frames[worst], float(distances[worst])


def mended_by(
    design: Design, key: str, find: Callable[[Design], list[Misplacement]]
) -> Callable[[object], bool]:
    """Return a test of a key's value: is it accepted, and does it leave nothing to ``find``?"""

    def mends(value: object) -> bool:
        trial = with_key(design, key, value)
        return trial is not None and not find(trial)

    return mends


def greatest(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """Find the greatest value in [low, high] up to which ``holds``; None: not at low."""
    if holds(high):
        return high
    return edge(holds, low, high) if holds(low) else None


def least(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """Find the least value in [low, high] from which on it ``holds``; None: not at any tried."""
    if holds(low):
        return low
    while not holds(high):  # too far may be as wrong as too near
        high = 0.5 * (low + high)
        if not high - low >= 1e-3:  # nor for NaN
            return None
    return edge(holds, high, low)


def edge(
    holds: Callable[[float], bool], good: float, bad: float, halvings: int = _HALVINGS
) -> float:
    """Bisect between a good and a bad value for the one up to which it ``holds``."""
    for _ in range(halvings):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good
