"""What every table of a design or scene file has in common: frozen, strict, no unknown keys."""

from __future__ import annotations

from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict
from pydantic_core import PydanticCustomError


class Table(BaseModel):
    """One frozen TOML table.

    Strict: strings and booleans are not numbers, whole numbers are accepted as floats, NaN and
    infinity are refused, and so is every key that the table does not name.
    """

    model_config = ConfigDict(
        strict=True, frozen=True, extra="forbid", allow_inf_nan=False, validate_default=True
    )


def _as_tuple(value: Any) -> Any:
    """Turn the lists that TOML and JSON give into tuples, so that a frozen table stays frozen."""
    return tuple(value) if isinstance(value, list) else value


_T = TypeVar("_T")
Row2 = Annotated[tuple[float, float], BeforeValidator(_as_tuple)]
Row3 = Annotated[tuple[float, float, float], BeforeValidator(_as_tuple)]
Many = Annotated[tuple[_T, ...], BeforeValidator(_as_tuple)]


def refuse(value: object, bound: str, remedy: str, key: str = "") -> PydanticCustomError:
    """Return the error a validator raises to word its own fault.

    ``bound`` completes "must be ...", ``remedy`` says what to do; ``key`` (dotted) names the key
    when the validator sits on a whole table.
    """
    return PydanticCustomError(
        "fault", "{bound}; {remedy}", {"value": value, "bound": bound, "remedy": remedy, "key": key}
    )
