"""A table as text, the same for a page and a terminal: caption, columns, rows of cells."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.records.result import IncrementResult

# Of a column's scale, or of its unit (N, mm, MPa, microstrain) if that is more: rounding noise.
NOISE = 1e-9


def without_noise(values: Iterable[float | None] | Array, scale: float = 0.0) -> np.ndarray:
    """The values with rounding noise, and minus zero, made zero; None becomes NaN.

    scale: the largest value of what they are compared with; their own largest counts anyway.
    """
    out = np.array(values if isinstance(values, np.ndarray) else list(values), dtype=float)
    finite = np.abs(out[np.isfinite(out)])
    floor = NOISE * max(1.0, scale, float(finite.max(initial=0.0)))
    out[np.abs(out) < floor] = 0.0
    return out


def number_text(value: float | None, decimals: int = 3) -> str:
    """Fixed decimals, so that a column lines up; a dash where there is no value.

    >>> number_text(0.123456), number_text(-1e-9), number_text(None)
    ('0.123', '0.000', '–')
    """
    if value is None or not math.isfinite(value):
        return "–"
    text = f"{value:.{decimals}f}"
    return text.removeprefix("-") if float(text) == 0 else text


def column_texts(
    values: Iterable[float | None], decimals: int = 3, scale: float = 0.0
) -> list[str]:
    """A column in one format: ``decimals``, or more where even its largest value needs them.

    >>> column_texts([12.0, 2e-4, -1e-17, None])
    ['12.000', '0.000', '0.000', '–']
    >>> column_texts([0.0, 0.000123])
    ['0.00000', '0.00012']
    """
    tidy = without_noise(values, scale)
    most = float(np.abs(tidy[np.isfinite(tidy)]).max(initial=0.0))
    if most > 0:
        decimals = max(decimals, min(6, 1 - math.floor(math.log10(most))))
    return [number_text(value, decimals) for value in tidy.tolist()]


def loaded_increments(rows: Sequence[IncrementResult]) -> list[int]:
    """Which increments press on the finger, by their place."""
    force = without_noise(row.normal_force_N for row in rows)
    return np.flatnonzero(force > 0).tolist()


@dataclass(frozen=True)
class Table:
    """One table. Cells are text, ready to show; ``texts`` are the columns that are no numbers."""

    key: str
    caption: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    texts: frozenset[int] = frozenset()
    kind: ClassVar[str] = "table"


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
    if isinstance(value, list | tuple):
        texts = [value_text(item) for item in value]
        tables = value and isinstance(value[0], Mapping)
        return "; ".join(texts) if tables else f"[{', '.join(texts)}]"
    return str(value)
