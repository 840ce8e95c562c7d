"""A table as text, the same for a page and a terminal: caption, columns, rows of cells."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Table:
    """One table. Cells are text, ready to show; ``texts`` are the columns that are no numbers."""

    key: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: frozenset[int] = frozenset()


def value_text(value: Any) -> str:
    """A design's value as TOML would have it, near enough to read."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, float):
        return f"{value:g}"
    if value is None:
        return "not set"
    if isinstance(value, Mapping):
        return ", ".join(f"{k} = {value_text(v)}" for k, v in value.items() if v is not None)
    if isinstance(value, list | tuple) and value and isinstance(value[0], Mapping):
        return "; ".join(value_text(table) for table in value)
    if isinstance(value, list | tuple):
        return "[" + ", ".join(value_text(item) for item in value) + "]"
    return str(value)
