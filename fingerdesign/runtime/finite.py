"""JSON of finite numbers alone: Python reads 1e400 as infinite, and NaN as a number."""

import json
import math
from typing import Any


def finite_json(text: str) -> Any:
    """The data of a JSON text. ValueError for what is none, or a number that is not finite.

    >>> finite_json("[1, 0.5]")
    [1, 0.5]
    """
    return json.loads(text, parse_float=_finite, parse_int=_whole, parse_constant=_finite)


def _finite(text: str) -> float:
    value = float(text)
    if not math.isfinite(value):
        raise ValueError(f"{text[:40]} is not a finite number")
    return value


def _whole(text: str) -> int:
    _finite(text)
    return int(text)
