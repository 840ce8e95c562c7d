"""Every failure that fingerdesign can name.

A failure says what went wrong and what to do about it. Bad input is a :class:`DesignError` that
carries *all* faults found; everything else is the failure of one stage of the work.
"""

from __future__ import annotations

from dataclasses import dataclass


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
    """One thing wrong with an input file: key, value, bound and remedy.

    >>> str(Fault("plates.length_mm", 0.5, "at least gages.length_mm = 1.0", "lengthen the plate"))
    'plates.length_mm = 0.5: must be at least gages.length_mm = 1.0; lengthen the plate'
    """

    key: str
    value: object
    bound: str
    remedy: str

    def __str__(self) -> str:
        return f"{self.key} = {self.value}: must be {self.bound}; {self.remedy}"


class FingerDesignError(Exception):
    """Base of every error raised on purpose; its message is one readable sentence."""


class DesignError(FingerDesignError):
    """The input is wrong. ``faults`` holds every fault found, not only the first."""

    def __init__(self, faults: list[Fault] | tuple[Fault, ...], source: str = "") -> None:
        self.faults = tuple(faults)
        self.source = source
        where = f"{source}: " if source else ""
        super().__init__("\n".join(f"{where}{fault}" for fault in self.faults))


class GeometryError(FingerDesignError):
    """The CAD kernel could not build the solid, or built one that fails its checks."""


class MeshError(FingerDesignError):
    """No mesh passed the acceptance gate."""


class SolverError(FingerDesignError):
    """A linear or contact problem has no accepted answer; the message gives the reason."""
