"""The lists of generated variants: those that are, and those that cannot be with every reason."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING

from fingerdesign.errors import Fault
from fingerdesign.sweep.plain_text import cell_text

if TYPE_CHECKING:
    from fingerdesign.sweep.variants import Variant

VARIANTS, INVALID = "variants.csv", "invalid.csv"


def variants_csv(keys: Sequence[str], found: Iterable[tuple[Variant, str]]) -> str:
    """A row a valid variant: number, name, values, the design's digest, what came of its CAD."""
    rows = [
        [variant.number, variant.name, *_values(variant, keys), variant.design.digest(), cad]
        for variant, cad in found
        if variant.design is not None
    ]
    return _csv(["number", "name", *keys, "design_digest", "cad"], rows)


def invalid_csv(keys: Sequence[str], found: Iterable[Variant]) -> str:
    """A row a fault: number and name of the variant, its values, and the fault in parts."""
    rows = [
        [variant.number, variant.name, *_values(variant, keys), *_parts(fault)]
        for variant in found
        if variant.design is None
        for fault in variant.faults
    ]
    return _csv(["number", "name", *keys, "key", "value", "must_be", "remedy"], rows)


def reasons(found: Iterable[Variant]) -> list[tuple[str, int, Fault, str]]:
    """Why variants are invalid, most frequent first: key, of how many, one fault and whose it is.

    A variant with several faults of one key counts once.
    """
    counted: dict[str, tuple[int, Fault, str]] = {}
    for variant in found:
        for key, fault in {fault.key: fault for fault in variant.faults}.items():
            count, first, name = counted.get(key, (0, fault, variant.name))
            counted[key] = (count + 1, first, name)
    ordered = sorted(counted.items(), key=lambda item: (-item[1][0], item[0]))
    return [(key, count, fault, name) for key, (count, fault, name) in ordered]


def _values(variant: Variant, keys: Sequence[str]) -> list[object]:
    return [variant.values.get(key) for key in keys]


def _parts(fault: Fault) -> list[object]:
    return [fault.key, str(fault.value), fault.bound, fault.remedy]


def _csv(header: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(cell_text(name) for name in header)
    for row in rows:
        writer.writerow("" if cell is None else _cell(cell) for cell in row)
    return stream.getvalue()


def _cell(value: object) -> object:
    return cell_text(value) if isinstance(value, str) else value
