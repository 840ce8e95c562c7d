"""Wording faults: from pydantic's errors to key, value, bound and remedy; bounds rounded safely."""

import difflib
import json
import math
import re
from collections.abc import Iterator, Mapping
from typing import Any, get_args

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from fingerdesign.errors import Fault

TYPES = {
    "float_type": "a number",
    "int_type": "a whole number",
    "int_from_float": "a whole number",
    "finite_number": "a finite number",
    "string_type": "text in quotes",
    "tuple_type": "an array",
    "dict_type": "a table",
    "model_type": "a table",
    "model_attributes_type": "a table",
}
LIMITS = {
    "greater_than": ("gt", "more than {}", "increase it"),
    "greater_than_equal": ("ge", "at least {}", "increase it"),
    "less_than": ("lt", "less than {}", "decrease it"),
    "less_than_equal": ("le", "at most {}", "decrease it"),
    "too_short": ("min_length", "an array of at least {}", "add to it"),
    "too_long": ("max_length", "an array of at most {}", "shorten it"),
    "string_too_short": ("min_length", "at least {} characters", "lengthen it"),
    "string_too_long": ("max_length", "at most {} characters", "shorten it"),
}


def dotted(location: tuple[int | str, ...]) -> str:
    """Write an error's location as a TOML key.

    >>> dotted(("path", "increments_mm", 3, 1))
    'path.increments_mm[3][1]'
    >>> dotted(("plates", "a b"))
    'plates."a b"'
    """
    text = ""
    for part in location:
        if isinstance(part, int):
            text += f"[{part}]"
        else:
            name = part if re.fullmatch(r"[A-Za-z0-9_-]+", part) else json.dumps(part)
            text += f".{name}" if text else name
    return text


def undexed(key: str) -> str:
    """Return a dotted key without the indices at its end.

    >>> undexed("path.increments_mm[3][1]")
    'path.increments_mm'
    """
    return re.sub(r"(\[\d+\])+$", "", key)


def shown(value: object, width: int = 60) -> str:
    """Write a value the way TOML does, cut to ``width`` characters."""
    if isinstance(value, bool):
        text = str(value).lower()
    elif isinstance(value, Mapping):
        text = "a table"
    else:
        try:
            text = repr(list(value) if isinstance(value, tuple) else value)
        except ValueError:  # Python declines to print integers of more than 4300 digits
            text = "a huge number"
    return text if len(text) <= width else f"{text[: width - 3]}..."


def table_at(model: type[BaseModel], location: tuple[int | str, ...]) -> type[BaseModel] | None:
    """Return the table's class that ``location`` leads to, None where it leads to no table."""
    current, parts = model, list(location)
    while parts:
        if isinstance(parts[0], int):  # of an array of tables: every entry is the same table
            parts.pop(0)
            continue
        part = str(parts.pop(0))
        info = current.model_fields.get(part)
        tables = tables_in(info.annotation) if info else []
        if not tables:
            return None
        if _is_mapping(current, part):
            parts = parts[1:]  # the user's own name: every name leads to the same table
        current = tables[0]
    return current


def _is_mapping(model: type[BaseModel], field: str) -> bool:
    return getattr(model.model_fields[field].annotation, "__origin__", None) is dict


def tables_in(annotation: Any) -> list[type[BaseModel]]:
    """The tables that a field may hold."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [table for part in get_args(annotation) for table in tables_in(part)]


def known_keys(model: type[BaseModel], prefix: str = "") -> Iterator[str]:
    """Yield the dotted keys of a file; a table keyed by the user's names shows them as NAME."""
    for name, info in model.model_fields.items():
        key = f"{prefix}{name}"
        tables = tables_in(info.annotation)
        if tables:
            inner = f"{key}.NAME." if _is_mapping(model, name) else f"{key}."
            yield from known_keys(tables[0], inner)
        else:
            yield key


def _unknown(model: type[BaseModel], location: tuple[int | str, ...], value: object) -> Fault:
    key, name = dotted(location), str(location[-1])
    top = model.model_fields.get(name)
    if len(location) > 1 and top is not None and not tables_in(top.annotation):
        remedy = f"'{name}' belongs at the top of the file, before the first [table]"
        return Fault(key, shown(value), "a known key", remedy)
    if len(location) > 1 and top is not None and isinstance(value, dict) and value:
        inner = ", ".join(f"`{key}`" for key in value)
        remedy = f"dotted keys go before the first [table]; put {inner} under [{name}]"
        return Fault(key, shown(value), "a known key", remedy)
    nearest = _nearest_key(model, location, name)
    remedy = f"did you mean {nearest}?" if nearest else "remove it"
    return Fault(key, shown(value), "a known key", remedy)


def _nearest_key(model: type[BaseModel], location: tuple[int | str, ...], name: str) -> str:
    """Find the key that was meant: the right one in the wrong table, rather than one of a like name
    in this table; "" for none."""
    table = table_at(model, location[:-1]) or model
    near = difflib.get_close_matches(name, table.model_fields, 1, 0.6)
    by_name: dict[str, str] = {}
    for known in known_keys(model):  # of several keys of one name, that of the outermost table
        last = known.rpartition(".")[2]
        if known.count(".") < by_name.get(last, "." * 99).count("."):
            by_name[last] = known
    elsewhere = difflib.get_close_matches(name, by_name, 1, 0.8)
    if name in by_name or not near:
        return by_name[elsewhere[0]] if elsewhere else ""
    return dotted((*location[:-1], near[0]))


def fault_of(error: ErrorDetails, model: type[BaseModel]) -> Fault:
    """Return the fault that one of pydantic's errors on ``model`` amounts to."""
    kind, location, context = error["type"], error["loc"], error.get("ctx", {})
    key, value = dotted(location) or "file", error["input"]
    bound, remedy = f"valid ({error['msg']})", "correct it"
    if kind == "fault":
        own = context["value"]
        text = own if own == "(absent)" else shown(own)
        return Fault(context["key"] or key, text, context["bound"], context["remedy"])
    if kind == "extra_forbidden":
        return _unknown(model, location, value)
    if kind == "missing":
        return Fault(_required(model, location), "(absent)", "given", "add it")
    if kind == "literal_error":
        choices = str(context["expected"]).replace("'", "").replace(" or ", ", ")
        near = difflib.get_close_matches(str(value), choices.split(", "), 1, 0.5)
        bound = f"one of {choices}"
        remedy = f"did you mean '{near[0]}'?" if near else "choose one of them"
    elif kind in TYPES:
        bound = TYPES[kind]
        remedy = "remove the quotes" if isinstance(value, str) else remedy
    elif kind in LIMITS:
        name, words, remedy = LIMITS[kind]
        bound = words.format(context[name])
    return Fault(key, shown(value), bound, remedy)


def _required(model: type[BaseModel], location: tuple[int | str, ...]) -> str:
    """Return the dotted key that is missing: of an absent table, its first required one."""
    table = table_at(model, location)
    fields = table.model_fields.items() if table else ()
    needed = [name for name, info in fields if info.is_required()]
    return dotted((*location, *needed[:1]))


def at_least(value: float) -> str:
    """Write a lower bound, rounded up to a micrometre.

    >>> at_least(0.8600000001)
    '0.861'
    """
    return f"{math.ceil(value * 1000.0 - 1e-9) / 1000.0:.10g}"


def at_most(value: float) -> str:
    """Write an upper bound, rounded down to a micrometre.

    >>> at_least(1.2341), at_most(1.2349), at_most(1.235)
    ('1.235', '1.234', '1.235')
    """
    return f"{math.floor(value * 1000.0 + 1e-9) / 1000.0:.10g}"
