"""Records, from one typed definition: JSON text, its shipped schema, CSV, reading it again.

A record's file is typed by a TypedDict (or a frozen dataclass) whose keys are the file's, in their
order, each with its bound and meaning:

    @closed
    class Hole(TypedDict):
        kind: Literal["gate", "vent"]
        diameter_mm: Annotated[Size, Field(description="inside, at the finger")]

``python -m fingerdesign.records.base`` writes the shipped schemas again.
"""

import csv
import io
import json
import math
import re
from collections.abc import Iterable
from dataclasses import asdict, is_dataclass
from importlib import import_module
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import ConfigDict, Field, TypeAdapter, with_config

from fingerdesign.errors import FingerDesignError

Size = Annotated[float, Field(ge=0.0)]
Count = Annotated[int, Field(ge=0)]

# A file of the wheel's data: the type that it describes, and its title.
SCHEMAS = {
    "result": ("fingerdesign.records.result:Result", ""),
    "validate": (
        "fingerdesign.validate.record:Validation",
        "What each modelling assumption costs (fingerdesign validate)",
    ),
    "control": (
        "fingerdesign.trials.record:ControlData",
        "Controllers over friction, weight, noise and faults (fingerdesign study)",
    ),
    "calibration": (
        "fingerdesign.sensing.identify.bench_report:CalibrationData",
        "One finger as its bench measured it (fingerdesign identify)",
    ),
    "identification": (
        "fingerdesign.sensing.identify.trace_report:IdentificationData",
        "Rubber, friction and gages from one trace (fingerdesign identify)",
    ),
    "tolerance": (
        "fingerdesign.tolerance.record:ToleranceData",
        "Spread of fingers as cast (fingerdesign tolerance)",
    ),
    "gripbench": (
        "fingerdesign.trials.gripbench:Scorecard",
        "Controllers on a fixed set of fingers and objects (fingerdesign study gripbench)",
    ),
    "recorded": (
        "fingerdesign.trials.recorded.sets:RecordedData",
        "Detectors of slip on recordings of others (fingerdesign study --recorded)",
    ),
    "atlas": (
        "fingerdesign.search.passing.atlas:Atlas",
        "Verified fingers that `new` starts from (fingerdesign bench atlas)",
    ),
    "mold": ("fingerdesign.mold.record:MoldData", "A finger's mold (fingerdesign mold)"),
}
closed = with_config(ConfigDict(extra="forbid"))  # all keys of the type, and no others
strict = with_config(ConfigDict(extra="forbid", strict=True))  # nor another type for a value
DATA = Path(__file__).resolve().parents[1] / "data"
_UNIT = re.compile("_(mm[23]?|cm3|N|Nmm|MPa)$")
_DIALECT = "https://json-schema.org/draft/2020-12/schema"


class ResultError(FingerDesignError):
    """A result cannot be written: it holds a value that is no number, or the folder is not ours."""


def values_of(kind: type, *sources: object, **given: Any) -> dict[str, Any]:
    """The values of a record's keys: those given, and of the rest what the first source that has it
    has under the key's name or, in the key's unit, under its name without it.

    >>> from types import SimpleNamespace
    >>> class Moved: shear_mm: float; rows: int
    >>> values_of(Moved, SimpleNamespace(shear=0.2, rows=9), rows=3)
    {'shear_mm': 0.2, 'rows': 3}
    """
    found = {}
    for key in kind.__annotations__:
        pairs = ((source, name) for source in sources for name in (key, _UNIT.sub("", key)))
        own = (getattr(source, name) for source, name in pairs if hasattr(source, name))
        found[key] = given[key] if key in given else next(own)
    return found


def plain(value: Any, key: str = "", decimals: int | None = None) -> Any:
    """The value in JSON's own types, floats rounded to ``decimals`` where these are given. Raises
    ResultError for what is no finite number, naming its key."""
    if isinstance(value, np.generic | np.ndarray):
        value = value.tolist()
    if is_dataclass(value) and not isinstance(value, type):
        value = asdict(value)
    if isinstance(value, dict):
        return {
            str(k): plain(v, f"{key}.{k}" if key else str(k), decimals) for k, v in value.items()
        }
    if isinstance(value, list | tuple):
        return [plain(v, f"{key}[{i}]", decimals) for i, v in enumerate(value)]
    if isinstance(value, float):
        if not math.isfinite(value):
            raise ResultError(f"{key} = {value} is not a finite number; the result is not written")
        return value if decimals is None else round(value, decimals) + 0.0
    return value


def json_text(value: Any, indent: int = 2, ascii_only: bool = True) -> str:
    """The value as the text of a file, keys in their order; ResultError on NaN or infinity."""
    text = json.dumps(plain(value), indent=indent, ensure_ascii=ascii_only, allow_nan=False)
    return text + "\n"


def csv_text(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A table as CSV; an empty cell where there is no value (None or NaN)."""
    stream = io.StringIO()
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow(header)
    writer.writerows(["" if cell is None or cell != cell else cell for cell in row] for row in rows)
    return stream.getvalue()


def write_csv(path: Path, header: Iterable[str], rows: Iterable[Iterable[Any]]) -> None:
    """A table as a CSV file, its lines ended alike on every system."""
    path.write_text(csv_text(header, rows), encoding="utf-8", newline="")


def json_schema(name: str) -> dict[str, Any]:
    """The schema of a kind of record: all keys are there, no others."""
    target, title = SCHEMAS[name]
    module, _, kind = target.partition(":")
    made = TypeAdapter(getattr(import_module(module), kind)).json_schema()
    return {"$schema": _DIALECT, **made} | ({"title": title} if title else {})


def schema_text(name: str) -> str:
    """The schema the way it is shipped, as fingerdesign/data/NAME.schema.json."""
    return json.dumps(json_schema(name), indent=2) + "\n"


if __name__ == "__main__":
    for each in SCHEMAS:
        (DATA / f"{each}.schema.json").write_text(schema_text(each), encoding="utf-8")
