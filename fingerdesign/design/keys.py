"""Dotted keys of a design: ``plates.rows[0].cover_mm`` as a place in nested tables and arrays."""

import re
from collections.abc import Iterator, Mapping
from typing import Any

from fingerdesign.design.faults import shown
from fingerdesign.design.former import current_key
from fingerdesign.errors import DesignError, Fault


def leaves(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """List the dotted keys of a table, and of those in it, with their values."""
    for key, value in table.items():
        if isinstance(value, Mapping):
            yield from leaves(value, f"{prefix}{key}.")
        else:
            yield prefix + key, value


def parts_of(key: str) -> tuple[str | int, ...]:
    """Split a dotted key into the names and numbers that a dotted key leads through.

    >>> parts_of("plates.rows[1].cover_mm")
    ('plates', 'rows', 1, 'cover_mm')

    Raises :class:`DesignError` for brackets that hold no number.
    """
    parts: list[str | int] = []
    for part in key.split("."):
        found = re.fullmatch(r"([^\[\]]*)((?:\[\d+\])*)", part)
        if found is None:
            raise DesignError([Fault(key, shown(part), "a known key", "write a row as rows[0]")])
        parts += [found[1], *(int(number) for number in re.findall(r"\d+", found[2]))]
    return tuple(parts)


# What no longer holds of a material of which another value is set: its source, and the modulus that
# follows its hardness.
_DECIDED = {"source": (), "shore_a": ("source", "youngs_modulus_MPa")}


def set_value(data: dict[str, Any], key: str, value: object) -> None:
    """Set a dotted key in a design's nested tables, in place; None takes it away.

    Tables that are absent are made; the next row of an array of tables may be added. Raises
    :class:`DesignError` where the key leads through a value or beyond an array.

    >>> data = {"plates": {"rows": [{"count": 3}]}}
    >>> set_value(data, "plates.rows[0].cover_mm", 2.0)
    >>> set_value(data, "plates.rows[1].along", "z")
    >>> data
    {'plates': {'rows': [{'count': 3, 'cover_mm': 2.0}, {'along': 'z'}]}}
    """

    def refused(why: str) -> DesignError:
        return DesignError([Fault(key, shown(value), "a known key", why)])

    key = current_key(key)
    *places, last = parts_of(key)
    table: Any = data
    for place, following in zip(places, parts_of(key)[1:], strict=True):
        table = _entered(table, place, [] if isinstance(following, int) else {}, refused)
    if isinstance(table, list):
        most = len(table) - (value is None)
        if not isinstance(last, int) or last > most:
            raise refused(f"there are {len(table)} of them, numbered from 0")
        table[last : last + 1] = [] if value is None else [value]
    elif not isinstance(table, dict):
        raise refused(f"{places[-1]} is a value")
    else:
        if places[:1] == ["materials"]:
            gone = _DECIDED.get(str(last), ("source",))
            for each in gone[: 1 if value is None else None]:
                table.pop(each, None)
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value


def _entered(table: Any, place: str | int, empty: Any, refused: Any) -> Any:
    if isinstance(place, int):
        if not isinstance(table, list) or place > len(table):
            known = len(table) if isinstance(table, list) else 0
            raise refused(f"there are {known} of them, numbered from 0")
        if place == len(table):
            table.append(empty)
        return table[place]
    if not isinstance(table, dict):
        raise refused("it leads through a value")
    inner = table.setdefault(place, empty)
    if not isinstance(inner, (dict, list)):
        raise refused(f"{place} is a value")
    return inner
