"""Text of strangers made fit to be shown: names of designs, reasons of failures, values."""

from __future__ import annotations

import unicodedata
from typing import Any

MOST_TEXT = 400  # characters of any one text that is shown
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
    """As :func:`shown`, for a table of numbers: no spreadsheet takes it for a formula.

    >>> cell_text("=1+1"), cell_text("maeno2000")
    ("'=1+1", 'maeno2000')
    """
    return f"'{shown(text)}" if text.startswith(("=", "+", "-", "@")) else shown(text)
