"""Choices and ranges of a study's parameters; untrusted text is bounded."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import Annotated, Any, Self

from pydantic import AfterValidator, BeforeValidator, Discriminator, Field, Tag, model_validator
from pydantic import PlainValidator as Plain

from fingerdesign.design.base import Many, Table, refuse
from fingerdesign.design.faults import dotted, shown
from fingerdesign.design.keys import parts_of
from fingerdesign.design.schema import Design
from fingerdesign.errors import Fault

MOST = 1e12  # of any number's size: no key of a design takes more
MOST_CHOICES = 200
MOST_TEXT = 1000  # characters of a text that a study names something by
MOST_DEPTH = 8  # of tables in tables; a design's own are 3 deep
MOST_LEVELS = 1_000_000
_PART = re.compile(r"[^\[\]]+(\[\d{1,4}\])*")  # of a dotted key
Choice = bool | int | float | str
FILE_KEYS = ("body.step.file", "mesh.file")  # of a design: paths relative to the study's file


class Estimated:
    """A refused value in words: pydantic itself would write out all of it, however long or deep."""

    def __init__(self, value: object) -> None:
        try:
            self._text = shown(value)
        except RecursionError:
            self._text = "tables within tables"

    def __repr__(self) -> str:
        return self._text


def plain_text(value: str) -> str:
    """The text itself; a fault where it holds control or direction characters."""
    if not value.isprintable():
        raise refuse(Estimated(value), "text without control characters", "correct it")
    return value


def dotted_key(value: str) -> str:
    """The key itself, or the share of two keys; a fault where it is written wrongly."""
    for piece in value.split("/"):
        if not all(_PART.fullmatch(part) for part in piece.strip().split(".")):
            bound = "a dotted key, such as plates.count or plates.rows[0].count"
            raise refuse(Estimated(value), bound, "correct it")
    return value


Text = Annotated[str, Field(min_length=1, max_length=MOST_TEXT), AfterValidator(plain_text)]
Key = Annotated[Text, AfterValidator(dotted_key)]


def is_number(value: Any) -> bool:
    """Return True for a number; true and false are none."""
    return isinstance(value, int | float) and not isinstance(value, bool)


def all_numbers(parameter: Parameter) -> bool:
    """Return True where a parameter has an order: a range, or choices that are numbers."""
    return isinstance(parameter, Range) or all(is_number(each) for each in parameter)


def has_value(parameter: Parameter, value: Choice) -> bool:
    """Return True where a parameter can take the value: a choice, or a number of its range."""
    if not isinstance(parameter, Range):
        return any(type(each) is type(value) and each == value for each in parameter)
    slack = 1e-9 * (parameter.high - parameter.low)  # of values that were rounded to its steps
    return is_number(value) and (parameter.low - slack <= float(value) <= parameter.high + slack)


def _number(value: Any) -> Any:
    if not is_number(value):
        remedy = "remove the quotes" if isinstance(value, str) else "correct it"
        raise refuse(Estimated(value), "a number", remedy)
    if not abs(value) <= MOST:  # nor is NaN
        raise refuse(Estimated(value), f"a finite number of at most {MOST:g} in size", "correct it")
    return value


def _choice(value: Any) -> Any:
    if isinstance(value, bool):
        return value
    if not isinstance(value, str):
        if not isinstance(value, (int, float)):
            raise refuse(Estimated(value), "a number, text in quotes, true or false", "correct it")
        return _number(value)
    if len(value) > MOST_TEXT:
        raise refuse(Estimated(value), f"at most {MOST_TEXT} characters", "shorten it")
    return plain_text(value)


def _distinct(values: tuple[Choice, ...]) -> tuple[Choice, ...]:
    seen = [(isinstance(value, bool), value) for value in values]
    for place, each in enumerate(seen):
        if each in seen[:place]:
            raise refuse(list(values), "values that differ", f"give {values[place]!r} once")
    return values


def maybe_number(value: Any) -> Any:
    """A number of bounded size, or None."""
    return None if value is None else _number(value)


Number = Annotated[int | float, BeforeValidator(_number)]
_Step = Annotated[int | float | None, BeforeValidator(maybe_number)]


class Range(Table):
    """``{ low, high }``: whole numbers stay whole; ``step`` counts from ``low``."""

    low: Number
    high: Number
    log: bool = Field(default=False, description="even in the logarithm")
    step: _Step = None

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low < self.high:
            raise refuse(self.high, f"more than low = {self.low}", "correct the range", "high")
        width = self.high - self.low
        if self.step is not None and not width / MOST_LEVELS <= self.step <= width:
            bound = f"from {width / MOST_LEVELS:.6g} to {width:.6g} (high - low)"
            raise refuse(self.step, bound, "correct it, or give the values as a list", "step")
        if self.log and self.low <= 0:
            raise refuse(self.low, "above 0 where log = true", "remove log", "low")
        if self.log and self.step is not None:
            raise refuse(self.step, "absent where log = true", "remove one of them", "step")
        return self

    @property
    def whole(self) -> bool:
        """True where all its values are whole numbers."""
        return all(isinstance(each, int) for each in (self.low, self.high, self.step or 1))

    @property
    def levels(self) -> int | None:
        """Number of its values; None where they are continuous, or whole and logarithmic."""
        step = self.step if self.step is not None else (1 if self.whole else None)
        if step is None or self.log:
            return None
        return math.floor((self.high - self.low) / step + 1e-9) + 1

    def at(self, share: float) -> int | float:
        """The value at a share in [0, 1) of the range; never outside it."""
        levels = self.levels
        if levels is not None:
            step = self.step if self.step is not None else 1
            value = self.low + step * min(int(share * levels), levels - 1)
            return value if self.whole else min(float(f"{value:.12g}"), float(self.high))
        if self.log:
            found = self.low * math.exp(share * self._log_width)
        else:
            found = self.low + share * (self.high - self.low)
        if self.whole:
            return min(max(round(found), int(self.low)), int(self.high))
        reported = float(f"{found:.{self._digits}g}")
        return min(max(reported, float(self.low)), float(self.high))

    def share(self, value: int | float) -> float:
        """The share of the range, 0 to 1, that gives a value of it; of a level its middle."""
        if self.levels is not None:
            step = self.step if self.step is not None else 1
            return (round((value - self.low) / step) + 0.5) / self.levels
        if self.log:
            return (math.log(value) - math.log(self.low)) / self._log_width
        return (value - self.low) / (self.high - self.low)

    @property
    def _log_width(self) -> float:
        return math.log(self.high) - math.log(self.low)  # Their ratio may exceed any float.

    @property
    def _digits(self) -> int:
        """Digits that tell a hundred thousand values of the range apart."""
        relative = max(abs(self.low), abs(self.high)) / (self.high - self.low)
        return min(15, 6 + max(0, math.floor(math.log10(relative))))


Choices = Annotated[
    Many[Annotated[Choice, Plain(_choice)]],
    Field(min_length=1, max_length=MOST_CHOICES),
    AfterValidator(_distinct),
]
Parameter = Annotated[
    Annotated[Range, Tag("range")] | Annotated[Choices, Tag("choices")],
    Discriminator(lambda value: "range" if isinstance(value, (Mapping, Range)) else "choices"),
]


def shallow(value: Any) -> Any:
    """The value itself; a fault where tables or arrays lie too deep in each other, or what is in
    them is endless."""
    level, depth = [value], 0
    while level:
        depth += 1
        if depth > MOST_DEPTH:
            raise refuse(Estimated(value), f"at most {MOST_DEPTH} tables deep", "correct it")
        inner: list[Any] = []
        for each in level:
            if isinstance(each, Mapping):
                inner += [*each, *each.values()]
            elif isinstance(each, list):
                inner += each
            elif isinstance(each, (str, int, float)):
                _choice(each)
        level = inner
    return value


def flattened(table: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, Any]]:
    """Tables in a table as dotted keys: ``body.depth_mm = 1`` means ``"body.depth_mm" = 1``.

    >>> dict(flattened({"body": {"depth_mm": {"low": 1, "high": 2}}, "plates.count": [3]}))
    {'body.depth_mm': {'low': 1, 'high': 2}, 'plates.count': [3]}
    """
    for name, value in table.items():
        key = f"{prefix}{name}"
        ranges = {"low", "high", "log", "step"}
        inner = isinstance(value, Mapping) and value and ranges.isdisjoint(value)
        if inner and key.count(".") < MOST_DEPTH:
            yield from flattened(value, f"{key}.")
        else:
            yield key, value


def split_share(key: str) -> tuple[str, str]:
    """The two keys of a share.

    >>> split_share("plates.span_mm / body.depth_mm")
    ('plates.span_mm', 'body.depth_mm')
    """
    part, _, whole = (piece.strip() for piece in key.partition("/"))
    return part, whole


def set_keys(base: Design, values: Mapping[str, Choice]) -> dict[str, Any]:
    """Design keys and values: "x / y" is a share of y, which may be a studied key itself."""
    plain: dict[str, Any] = {key: value for key, value in values.items() if "/" not in key}
    for key, share in values.items():
        if "/" in key:
            part, whole = split_share(key)
            of = plain[whole] if whole in plain else value_of(base, whole)
            plain[part] = float(f"{float(share) * float(of):.9g}")
    return plain


def value_of(design: Design, key: str) -> Any:
    """The value of a dotted key; None where the design has no such key or it is absent."""
    return value_in(design.model_dump(mode="json"), key)


def value_in(data: Mapping[str, Any], key: str) -> Any:
    """The value of a dotted key in a design's tables; None where there is none."""
    found: Any = data
    for part in parts_of(key):
        if isinstance(found, Mapping):
            found = found.get(part)
        elif isinstance(found, list) and isinstance(part, int) and part < len(found):
            found = found[part]
        else:
            return None
    return found


def key_faults(fixed: Mapping[str, Any], parameters: Iterable[str]) -> list[Fault]:
    """Faults of keys together: one set twice, a share of a share, a variant's name."""
    faults = []
    targets: dict[str, str] = {}
    shares = {split_share(key)[0] for key in parameters if "/" in key}
    for key in parameters:
        (target, whole), where = split_share(key), dotted(("parameters", key))
        if target in targets:
            bound = "a key that no other parameter sets"
            faults.append(Fault(where, f"set by {shown(targets[target])} too", bound, "remove one"))
        targets[target] = key
        if target in fixed:
            bound = "a key that [fixed] does not set"
            faults.append(Fault(where, "in [fixed] too", bound, "remove one of them"))
        if whole in shares:
            bound = "a share of a key that is no share itself"
            faults.append(Fault(where, "a share of a share", bound, "give that key a range"))
    for table, keys in (("fixed", list(fixed)), ("parameters", list(targets))):
        for key in keys:
            if key.split(".")[0].split("[")[0] == "design":
                bound = "another key: the study names its variants"
                faults.append(Fault(dotted((table, key)), "a name", bound, "set study.name"))
    return faults
