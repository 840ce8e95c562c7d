"""What casting notes are made from, and the words that they share."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fingerdesign.mold.part import CORE, PartMesh

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.mold.flat_pattern import FlatPattern
    from fingerdesign.mold.plan import BaseHole, MoldPlan
    from fingerdesign.mold.silicone import Silicone


@dataclass(frozen=True)
class Bench:
    """What the notes are made from."""

    design: Design
    plan: MoldPlan
    parts: Sequence[PartMesh]
    patterns: Sequence[FlatPattern]
    silicone: Silicone

    @property
    def polyurethane(self) -> bool:
        """Whether the elastomer is no silicone."""
        return self.design.body.material.startswith("polyurethane")

    @property
    def elastomer(self) -> str:
        """What is poured, in a word."""
        return "polyurethane" if self.polyurethane else "silicone"

    @property
    def core(self) -> bool:
        """Whether a core is cast in."""
        return any(part.name == CORE for part in self.parts)


def of_kind(holes: Sequence[BaseHole], kind: str) -> list[BaseHole]:
    """The base plate's holes of a kind."""
    return [hole for hole in holes if hole.kind == kind]


def count_text(number: int, what: str) -> str:
    """``number`` things in words."""
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def numbers_text(plates: Sequence[int]) -> str:
    """Whole numbers, runs shortened.

    >>> numbers_text([0, 1, 2, 5, 7, 8])
    '0-2, 5, 7-8'
    """
    runs: list[list[int]] = []
    for plate in sorted(plates):
        if runs and plate == runs[-1][-1] + 1:
            runs[-1].append(plate)
        else:
            runs.append([plate])
    return ", ".join(str(r[0]) if len(r) == 1 else f"{r[0]}-{r[-1]}" for r in runs)


def listed(names: Sequence[str]) -> str:
    """Words as a list in a sentence."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"


def words(name: str) -> str:
    """A name as a reader meets it: without underscores."""
    return name.replace("_", " ")
