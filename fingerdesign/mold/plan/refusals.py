"""Refusals of a mold: what cannot be made, by which key, with its bound and its remedy in words.

A step of the plan returns refusals with their numbers; their sentences are in templates. A number
in the format ``least`` is rounded up to a micrometre, one in the format ``most`` down.
"""

import string
import tomllib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from fingerdesign.design.faults import at_least, at_most
from fingerdesign.errors import DesignError, Fault

# kind of a refusal -> what the key's value must be, what to do
TEXTS = Path(__file__).parents[1] / "templates" / "refusals.toml"
SENTENCES: Mapping[str, tuple[str, str]] = tomllib.loads(TEXTS.read_text(encoding="utf-8"))


@dataclass(frozen=True)
class Refusal:
    """A reason why there is no mold: its kind among SENTENCES, the key at fault with its value, and
    the numbers of its sentences; ``remedy`` takes the place of the general one."""

    kind: str
    key: str
    value: object
    numbers: Mapping[str, Any]
    remedy: str = ""

    @property
    def fault(self) -> Fault:
        """The refusal as a fault, in words."""
        writer = _Writer()
        bound, remedy = (writer.vformat(text, (), self.numbers) for text in SENTENCES[self.kind])
        return Fault(self.key, self.value, bound, self.remedy or remedy)


class MoldRefused(DesignError):
    """There is no mold of a design: ``refusals`` say why."""

    def __init__(self, refusals: Sequence[Refusal], source: str) -> None:
        super().__init__([refusal.fault for refusal in refusals], source)
        self.refusals = tuple(refusals)


class _Writer(string.Formatter):
    """Text with numbers in the formats ``least`` and ``most``."""

    def format_field(self, value: Any, format_spec: str) -> Any:
        rounded = {"least": at_least, "most": at_most}.get(format_spec)
        return rounded(value) if rounded else super().format_field(value, format_spec)
