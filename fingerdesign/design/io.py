"""Reading and writing of design and scene files: TOML text, its keys, their faults."""

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from fingerdesign.design.faults import fault_of
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design, unknown_names
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.files import whole_content, why_unread

MAX_BYTES = 2_000_000  # A design has some kilobytes; a scene of 10,000 rows stays below 1 MB.
# The largest shipped file has 80 keys, three tables deep. Many more take minutes to be refused one
# by one, and much deeper ones exceed Python's recursion limit in whatever reads them.
MAX_KEYS, MAX_DEPTH = 5_000, 20
_SHOWN = 60  # Characters of a line that is not TOML.
_DECIMAL_COMMA = re.compile(r"=\s*-?\d+,\d")

_Model = TypeVar("_Model", bound=BaseModel)
_Found = TypeVar("_Found", bound=BaseModel, covariant=True)


@dataclass(frozen=True)
class Judged(Generic[_Found]):
    """The content of a file, and every fault of the first stage that found any.

    ``value`` is None where keys are faulty.
    """

    value: _Found | None
    faults: list[Fault]

    def sound(self, source: str) -> _Found:
        """Return the value; DesignError with every fault where there are any."""
        if self.faults or self.value is None:
            raise DesignError(self.faults, source)
        return self.value


def read_text(file: str | Path) -> str:
    """Return a file's text. Raises :class:`DesignError` where it cannot be read."""
    try:
        return whole_content(file, MAX_BYTES).decode("utf-8-sig")
    except (OSError, ValueError) as error:
        fault = Fault("file", str(file), "a readable TOML file", why_unread(error))
        raise DesignError([fault]) from None


def parse_toml(text: str, source: str = "") -> dict[str, Any]:
    """Return the tables of TOML ``text``. DesignError where it is none, or has too many or too deep
    keys."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a bad date, a 5000-digit integer are ValueError
        why = "too deeply nested" if isinstance(error, RecursionError) else str(error)[:300]
        if twice := re.match(r"Cannot declare \('(\w+)',\) twice", why):
            why += f"; put the keys that begin with `{twice[1]}.` under [{twice[1]}]"
        line = _line_of(why, text)
        if _DECIMAL_COMMA.search(line):
            why += "; decimals have a point, not a comma"
        raise DesignError([Fault("file", line, "valid TOML", why)], source) from None
    _refuse_large(data, source)
    return data


def _line_of(why: str, text: str) -> str:
    """Return the line that TOML's parser names, with its number."""
    if (at := re.search(r"at line (\d+)", why)) is None:
        return "(text)"
    line = text.split("\n")[int(at[1]) - 1]
    return f"line {at[1]}: {line.strip()[:_SHOWN]}"


def _refuse_large(data: dict[str, Any], source: str) -> None:
    level: list[Any] = [data]
    keys, depth = 0, 0
    while level and depth <= MAX_DEPTH and keys <= MAX_KEYS:
        keys, depth = keys + sum(len(each) for each in level if isinstance(each, dict)), depth + 1
        level = [inner for each in level for inner in _nested(each)]
    if level or keys > MAX_KEYS:
        bound = f"at most {MAX_KEYS} keys, {MAX_DEPTH} tables or arrays deep"
        value = f"{keys} keys or more" if keys > MAX_KEYS else f"{depth} deep or more"
        remedy = "check the path, or leave out keys"
        raise DesignError([Fault("file", value, bound, remedy)], source)


def _nested(value: Any) -> list[Any]:
    """List the tables and arrays right inside a table or an array."""
    values = value.values() if isinstance(value, dict) else value
    return [each for each in values if isinstance(each, dict | list)]


def judge_keys(model: type[_Model], data: dict[str, Any]) -> Judged[_Model]:
    """Validate the tables of a file: the model, or every fault of its keys."""
    try:
        return Judged(model.model_validate(data), [])
    except ValidationError as error:
        errors = [e for e in error.errors(include_url=False) if not _counts_only_sound(e)]
    faults = [fault_of(each, model) for each in errors]
    if issubclass(model, Design):  # a rule between tables, which pydantic asks of sound ones only
        for refusal in unknown_names(data):
            own = ErrorDetails(type="fault", loc=(), msg="", input=None, ctx=refusal.context or {})
            faults.append(fault_of(own, model))
    return Judged(None, distinct(faults))


def _counts_only_sound(error: ErrorDetails) -> bool:
    """Tell whether an array is called too short only because its faulty entries do not count."""
    entries = error["input"]
    least = error.get("ctx", {}).get("min_length", 0)
    return error["type"] == "too_short" and (
        isinstance(entries, (list, tuple)) and len(entries) >= least
    )


def judge_scene(text: str, source: str = "") -> Judged[Scene]:
    """Read a scene from TOML ``text``, and its faults. DesignError where the text is no TOML."""
    return judge_keys(Scene, parse_toml(text, source))


def parse_scene(text: str, source: str = "") -> Scene:
    """Return the scene of TOML ``text``; ``source`` names it in the faults. Raises
    :class:`DesignError` with every fault found."""
    return judge_scene(text, source).sound(source)


def design_data(design: Design) -> dict[str, Any]:
    """Return a design's tables as a file gives them; keys that followed the finger are left out,
    so that they follow it again where another value is set."""
    data = design.model_dump(mode="json", exclude_none=True)
    for key in set(design.grip.FOLLOWING) - design.grip.model_fields_set:
        data["grip"].pop(key, None)
    return data


def dump_design(design: Design) -> str:
    """Return TOML text that reads back as the same design; absent keys are left out."""
    import tomlkit

    values = design.model_dump(mode="json", exclude_none=True)
    # Keys of no table stand before the first table, or TOML would make them a part of it.
    ordered = sorted(values.items(), key=lambda item: isinstance(item[1], dict))
    return tomlkit.dumps(dict(ordered))


def distinct(faults: list[Fault]) -> list[Fault]:
    """Drop repeated faults (one wrong row may be refused by more than one rule)."""
    return list({str(fault): fault for fault in faults}.values())
