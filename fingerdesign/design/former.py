"""Keys and words of former versions: read under their new names until December 2027, noted."""

import warnings
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from typing import Any

from fingerdesign.errors import FormerKeyWarning

RENAMED = {
    "grip.regulator.taught_grips": "grip.regulator.training_grips",
    "grip.regulator.taught_fingers": "grip.regulator.training_fingers",
}
# Words that a key takes, by the former one.
WORDS = {"mesh.mesher": {"extrude": "sweep"}}
# Digests are made with the names under which the keys were first written, so that they stay.
FIRST_NAMES = {new.rpartition(".")[2]: old.rpartition(".")[2] for old, new in RENAMED.items()}


def current_key(key: str) -> str:
    """Return the present name of a dotted key; a former one is reported as a warning."""
    if key in RENAMED:
        warnings.warn(f"note: {key} is now {RENAMED[key]}", FormerKeyWarning, stacklevel=2)
    return RENAMED.get(key, key)


def with_current_keys(data: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a design's tables with former keys and words under their present names."""
    found = [old for old, table, last in _places(data, RENAMED) if last in table]
    words = [key for key, table, last in _places(data, WORDS) if _former(key, table.get(last))]
    if not found and not words:
        return data
    copied = deepcopy(dict(data))
    for old, table, last in _places(copied, RENAMED):
        if old in found:
            table[current_key(old).rpartition(".")[2]] = table.pop(last)
    for key, table, last in _places(copied, WORDS):
        if key in words:
            old, table[last] = table[last], WORDS[key][table[last]]
            note = f'note: {key} = "{old}" is now "{table[last]}"'
            warnings.warn(note, FormerKeyWarning, stacklevel=2)
    return copied


def _former(key: str, value: Any) -> bool:
    return isinstance(value, str) and value in WORDS[key]


def _places(data: Mapping[str, Any], keys: Iterable[str]) -> Iterator[tuple[str, Any, str]]:
    """List keys, the table that would hold each, and its last part."""
    for old in keys:
        *tables, last = old.split(".")
        table: Any = data
        for name in tables:
            table = table.get(name) if isinstance(table, Mapping) else None
        if isinstance(table, Mapping):
            yield old, table, last
