"""Records with arrays in them as one file: an .npz whose plain values stand in it as JSON."""

from __future__ import annotations

import json
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel

from fingerdesign.records.base import ResultError
from fingerdesign.runtime.cache import GARBLED


def write_packed(path: Path, value: Any) -> None:
    """Write frozen dataclasses and pydantic models, with what they hold: arrays, numbers, texts,
    tuples, dicts and None. :func:`read_packed` reads it."""
    arrays: dict[str, Any] = {}
    about = json.dumps(_plain(value, arrays))
    with path.open("xb") as file:
        np.savez(file, about=np.array(about), **arrays)


def read_packed(path: Path, *kinds: type) -> Any:
    """What :func:`write_packed` wrote; of ``kinds`` alone, so a file can run no code.

    Raises ResultError where it is not there, or is not of these.
    """
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
            arrays = {name: data[name] for name in data.files}
        about = json.loads(str(arrays.pop("about")))
        return _made(about, arrays, {kind.__name__: kind for kind in kinds})
    except (*GARBLED, RecursionError) as error:
        why = f"{type(error).__name__}: {error}"[:200]
        raise ResultError(f"{path} cannot be read ({why}); run the analysis again") from error


def _plain(value: Any, arrays: dict[str, Any]) -> Any:
    if isinstance(value, np.ndarray):
        name = f"array_{len(arrays)}"
        arrays[name] = value
        return {"array": name}
    if isinstance(value, BaseModel):
        return {"kind": type(value).__name__, "values": value.model_dump(mode="json")}
    if is_dataclass(value):
        values = {each.name: _plain(getattr(value, each.name), arrays) for each in fields(value)}
        return {"kind": type(value).__name__, "values": values}
    if isinstance(value, dict):
        return {"pairs": [[key, _plain(each, arrays)] for key, each in value.items()]}
    if isinstance(value, tuple):
        return [_plain(each, arrays) for each in value]
    return value.item() if isinstance(value, np.generic) else value


def _made(plain: Any, arrays: dict[str, Any], kinds: dict[str, type]) -> Any:
    if isinstance(plain, list):
        return tuple(_made(each, arrays, kinds) for each in plain)
    if not isinstance(plain, dict):
        return plain
    if "array" in plain:
        return arrays[plain["array"]]
    if "pairs" in plain:
        return {key: _made(each, arrays, kinds) for key, each in plain["pairs"]}
    values = {name: _made(each, arrays, kinds) for name, each in plain["values"].items()}
    return kinds[plain["kind"]](**values)
