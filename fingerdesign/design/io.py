"""Design and scene files: TOML in, with every fault at once; TOML out."""

from __future__ import annotations

import copy
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from fingerdesign.design.checks import design_faults
from fingerdesign.design.faults import fault_of, shown
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault

_Model = TypeVar("_Model", bound=BaseModel)
GEOMETRY_TABLES = ("body", "plates", "gages")
MAX_BYTES = 4_000_000  # a design of a few kilobytes; a scene of 10,000 rows stays below 1 MB


def load_design(path: str | Path) -> Design:
    """Read a design file. Raises :class:`DesignError` with every fault found in it."""
    return parse_design(_read(Path(path)), str(path))


def load_scene(path: str | Path) -> Scene:
    """Read a scene file. Raises :class:`DesignError` with every fault found in it."""
    return parse_scene(_read(Path(path)), str(path))


def parse_design(text: str, source: str = "") -> Design:
    """Return the design that TOML ``text`` says; ``source`` names it in the faults.

    Raises :class:`DesignError` with every fault of keys and values, and those of the geometry too
    as soon as the keys that the geometry rests on are sound.
    """
    return _design_of(_toml(text, source), source)


def parse_scene(text: str, source: str = "") -> Scene:
    """Return the scene that TOML ``text`` says; ``source`` names it in the faults.

    Raises :class:`DesignError` with every fault found.
    """
    data = _toml(text, source)
    scene, errors = _validated(Scene, data)
    if scene is None:
        raise DesignError(_distinct([fault_of(error, Scene) for error in errors]), source)
    return scene


def with_values(design: Design, values: Mapping[str, object]) -> Design:
    """Return a copy of ``design`` with dotted keys set, checked like a file.

    >>> from fingerdesign.design.io import parse_design, with_values
    >>> design = parse_design('design.name = "a"')
    >>> with_values(design, {"plates.pitch_mm": 0.9}).plates.pitch_mm
    0.9

    None takes a key's value away. Raises :class:`DesignError` with every fault.
    """
    data = design.model_dump(mode="json", exclude_none=True)
    for key, value in values.items():
        *tables, last = key.split(".")
        table = data
        for name in tables:
            table = table.setdefault(name, {})
            if not isinstance(table, dict):
                raise DesignError([Fault(key, shown(value), "a known key", f"{name} is a value")])
        if tables[:1] == ["materials"] and last != "source":
            table.pop("source", None)  # no longer that source's values
        if value is None:
            table.pop(last, None)
        else:
            table[last] = value
    return _design_of(data, design.design.name)


def dump_design(design: Design) -> str:
    """Return TOML text that reads back as the same design; absent keys are left out."""
    return _dump(design)


def dump_scene(scene: Scene) -> str:
    """Return TOML text that reads back as the same scene."""
    return _dump(scene)


def _dump(model: BaseModel) -> str:
    import tomlkit

    values = model.model_dump(mode="json", exclude_none=True)
    # Keys of no table stand before the first table, or TOML would make them a part of it.
    ordered = sorted(values.items(), key=lambda item: isinstance(item[1], dict))
    return tomlkit.dumps(dict(ordered))


def _read(path: Path) -> str:
    """Return a file's text; what cannot be read is a fault of the input."""
    try:
        if path.is_file() and path.stat().st_size > MAX_BYTES:
            bound = f"at most {MAX_BYTES} bytes"
            raise DesignError([Fault("file", path.stat().st_size, bound, "check the path")])
        return path.read_bytes().decode("utf-8-sig")
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        fault = Fault("file", str(path), "a readable TOML file", f"{why}")
        raise DesignError([fault]) from None


def _toml(text: str, source: str) -> dict[str, Any]:
    try:
        return tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a bad date, a 5000-digit integer are ValueError
        why = "too deeply nested" if isinstance(error, RecursionError) else str(error)
        raise DesignError([Fault("file", "(text)", "valid TOML", why)], source) from None


def _validated(
    model: type[_Model], data: dict[str, Any]
) -> tuple[_Model | None, list[ErrorDetails]]:
    try:
        return model.model_validate(data), []
    except ValidationError as error:
        return None, error.errors(include_url=False)


def _design_of(data: dict[str, Any], source: str) -> Design:
    design, errors = _validated(Design, data)
    faults = [fault_of(error, Design) for error in errors]
    sound = design if design is not None else _without_faulty_keys(data, errors)
    if sound is not None:
        faults += design_faults(sound)
        faults += _assumed_faults(sound)
    if faults or design is None:
        raise DesignError(_distinct(faults), source)
    return design


def _without_faulty_keys(data: dict[str, Any], errors: list[ErrorDetails]) -> Design | None:
    """Return the design without its faulty keys, None where the geometry rests on one of them."""
    pruned = copy.deepcopy(data)
    for error in errors:
        location = error["loc"]
        unknown = error["type"] == "extra_forbidden"
        if not location or (location[0] in GEOMETRY_TABLES and not unknown):
            return None
        table: Any = pruned
        keys = location if unknown else location[:2]
        for key in keys[:-1]:
            table = table.get(key) if isinstance(table, dict) else None
        if isinstance(table, dict):
            table.pop(keys[-1], None)
    pruned["design"] = {"name": "unnamed"}
    return _validated(Design, pruned)[0]


def _assumed_faults(design: Design) -> list[Fault]:
    values = design.model_dump(mode="json")
    known = set(_leaves(values))
    faults = []
    for index, key in enumerate(design.assumed):
        if key not in known:
            from difflib import get_close_matches

            near = get_close_matches(key, known, 1, 0.6)
            remedy = f"did you mean '{near[0]}'?" if near else "remove it"
            faults.append(
                Fault(f"assumed[{index}]", shown(key), "the dotted key of a value", remedy)
            )
    return faults


def _leaves(values: dict[str, Any], prefix: str = "") -> list[str]:
    keys: list[str] = []
    for name, value in values.items():
        keys += _leaves(value, f"{prefix}{name}.") if isinstance(value, dict) else [prefix + name]
    return keys


def _distinct(faults: list[Fault]) -> list[Fault]:
    """Drop repeated faults (one wrong row may be refused by more than one rule)."""
    return list({str(fault): fault for fault in faults}.values())
