"""Keys of former versions: read under their new names until December 2027, with a note."""

import warnings
from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import Any

from fingerdesign.errors import FormerKeyWarning

RENAMED = {
    "grip.regulator.taught_grips": "grip.regulator.training_grips",
    "grip.regulator.taught_fingers": "grip.regulator.training_fingers",
}
# Digests are made with the names under which the keys were first written, so that they stay.
FIRST_NAMES = {new.rpartition(".")[2]: old.rpartition(".")[2] for old, new in RENAMED.items()}


def current_key(key: str) -> str:
    """Return the present name of a dotted key; a former one is reported as a warning."""
    if key in RENAMED:
        warnings.warn(f"note: {key} is now {RENAMED[key]}", FormerKeyWarning, stacklevel=2)
    return RENAMED.get(key, key)


def with_current_keys(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a design's tables with former keys under their present names."""
    found = {old: table[last] for old, table, last in _places(data) if last in table}
    if not found:
        return data
    copied = deepcopy(dict(data))
    for old, table, last in _places(copied):
        if old in found:
            table[current_key(old).rpartition(".")[2]] = table.pop(last)
    return copied


def _places(data: Mapping[str, Any]) -> Iterator[tuple[str, Any, str]]:
    """List former keys, the table that would hold each, and its last part."""
    for old in RENAMED:
        *tables, last = old.split(".")
        table: Any = data
        for name in tables:
            table = table.get(name) if isinstance(table, Mapping) else None
        if isinstance(table, Mapping):
            yield old, table, last
