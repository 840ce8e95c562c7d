"""Every failure that fingerdesign can name.

A message gives what went wrong and the remedy. Bad input is a :class:`DesignError` that
carries *all* faults found; everything else is the failure of one stage of the work.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Self

_MOST_ROWS = 10  # A file of bad rows is one mistake: ten show which.
MOST_TEXT = 400  # Characters of any one text of a stranger that are shown.
# Control, format (direction marks among them), surrogates, private use, line and paragraph ends.
_UNSEEN = frozenset({"Cc", "Cf", "Cs", "Co", "Zl", "Zp"})


def shown(text: str) -> str:
    r"""The text without control or direction characters, cut where it has no end.

    >>> shown("b" + chr(0x202E) + "c" + chr(10))
    'b\ufffdc\ufffd'
    """
    if len(text) <= MOST_TEXT and text.isprintable():
        return text
    cut = text[:MOST_TEXT]
    seen = "".join("\ufffd" if unicodedata.category(c) in _UNSEEN else c for c in cut)
    return seen + "…" if len(text) > MOST_TEXT else seen


def all_shown(value: Any) -> Any:
    """JSON data with every text in it, keys too, as :func:`shown`."""
    if isinstance(value, str):
        return shown(value)
    if isinstance(value, dict):
        return {shown(str(key)): all_shown(inner) for key, inner in value.items()}
    if isinstance(value, list | tuple):
        return [all_shown(inner) for inner in value]
    return value


def cell_text(text: str) -> str:
    """Make a text fit for a table of numbers: no spreadsheet takes it for a formula.

    >>> cell_text("=1+1"), cell_text("maeno2000")
    ("'=1+1", 'maeno2000')
    """
    return f"'{shown(text)}" if text.startswith(("=", "+", "-", "@")) else shown(text)


def printable(text: str) -> str:
    r"""The text with what a terminal would obey, or not show, as escapes; lines stay lines.

    >>> printable("a" + chr(27) + "[31m" + chr(0x202E)), printable("a" + chr(10) + "b")
    ('a\\x1b[31m\\u202e', 'a\nb')
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() or c == "\n" else ascii(c)[1:-1] for c in text)


@dataclass(frozen=True)
class Fault:
    """One thing wrong with an input file: key, value, bound and remedy. mends: keys and values that
    were tried and end it, where any are known.

    >>> str(Fault("plates.length_mm", 0.5, "at least gages.length_mm = 1.0", "lengthen the plate"))
    'plates.length_mm = 0.5: must be at least gages.length_mm = 1.0; lengthen the plate'
    """

    key: str
    value: object
    bound: str
    remedy: str
    mends: Mapping[str, float] = field(default_factory=dict, compare=False, repr=False)

    def __str__(self) -> str:
        return f"{self.key} = {self.value}: must be {self.bound}; {self.remedy}"


class PluginWarning(UserWarning):
    """A plug-in that is not loaded, and why; the work goes on without it."""


class FormerKeyWarning(UserWarning):
    """A key that has another name now; it is still read."""


class FingerDesignError(Exception):
    """Base of every error raised on purpose; its message is one readable sentence."""


def _lines(faults: Sequence[Fault]) -> list[str]:
    """Faults in words; of a key's rows, as increments_mm[0], no more than ``_MOST_ROWS``."""
    rows = Counter[str]()
    lines = []
    for fault in faults:
        key = re.sub(r"\[\d+\]", "[...]", fault.key)
        rows[key] += 1
        if rows[key] <= _MOST_ROWS or key == fault.key:
            lines.append(str(fault))
    more = [(key, n - _MOST_ROWS) for key, n in rows.items() if "[...]" in key and n > _MOST_ROWS]
    return lines + [f"{key}: {number} more" for key, number in more]


class DesignError(FingerDesignError):
    """The input is wrong. ``faults`` holds every fault found; the message the first ten of the rows
    of one key, and how many more there are."""

    def __init__(self, faults: list[Fault] | tuple[Fault, ...], source: str = "") -> None:
        self.faults = tuple(faults)
        self.source = source
        where = f"{source}: " if source else ""
        super().__init__("\n".join(f"{where}{line}" for line in _lines(self.faults)))

    def __reduce__(self) -> tuple[Any, ...]:  # pickled, it keeps its faults
        return DesignError, (self.faults, self.source)

    @classmethod
    def together(cls, errors: Sequence[Self]) -> Self:
        """Join several errors into one with all faults, each with its own source."""
        every = cls([fault for each in errors for fault in each.faults])
        every.args = ("\n".join(str(each) for each in errors if each.faults),)
        return every


class GeometryError(FingerDesignError):
    """The CAD kernel could not build the solid, or built one that fails its checks."""


class MeshError(FingerDesignError):
    """No mesh passed the acceptance gate."""


class PictureError(FingerDesignError):
    """The picture could not be drawn; the message gives the reason."""


class EstimatorError(FingerDesignError):
    """An estimator's file is not one, or is of another finger."""


class SolverError(FingerDesignError):
    """A linear or contact problem has no accepted answer; the message gives the reason."""
