"""Design and scene files: TOML in, with every fault at once; TOML out."""

from __future__ import annotations

import copy
import re
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from fingerdesign.checks.design import design_faults
from fingerdesign.design.faults import fault_of, involves, shown, undexed
from fingerdesign.design.keys import parts_of, set_value
from fingerdesign.design.mesh import resolved_file
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design
from fingerdesign.design.step_file import resolved, without_sizes
from fingerdesign.errors import DesignError, Fault

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design


# A finger without its plates: the other side of a rig that reads one finger alone.


def without_plates(design: Design) -> Design:
    """The same body, mesh and grip, and nothing in the rubber but a core if there is one."""
    gone = ("plates.placement", "plates.rows", "grip.hardware.dead_gages", "assumed")
    return with_values(design, {"plates.count": 0, **dict.fromkeys(gone)})


_Model = TypeVar("_Model", bound=BaseModel)
_Found = TypeVar("_Found", bound=BaseModel, covariant=True)
MAX_ROUNDS = 12  # of taking faulty keys out; three are the most that any known file needs
MAX_BYTES = 4_000_000  # a design of a few kilobytes; a scene of 10,000 rows stays below 1 MB


@dataclass(frozen=True)
class Judged(Generic[_Found]):
    """A file's content with faulty keys replaced by defaults, and every fault found in it.

    ``value`` is None where nothing sound is left. ``doubtful`` names the keys whose values are not
    the user's: a fault that involves one of them cannot be told.
    """

    value: _Found | None
    faults: list[Fault]
    doubtful: frozenset[str]


def load_design(path: str | Path) -> Design:
    """Read a design file. Raises :class:`DesignError` with every fault found in it."""
    return parse_design(_read(Path(path)), str(path), Path(path).parent)


def load_scene(path: str | Path) -> Scene:
    """Read a scene file. Raises :class:`DesignError` with every fault found in it."""
    return parse_scene(_read(Path(path)), str(path))


def parse_design(text: str, source: str = "", folder: Path | None = None) -> Design:
    """Return the design that TOML ``text`` says; ``source`` names it in the faults.

    Files that it names lie in ``folder`` (None: the working directory) or are absolute. The sizes
    of a STEP body are read from its file.

    Raises :class:`DesignError` with every fault of keys and values, and every one of the geometry
    that involves no faulty key: the geometry is judged with faulty keys replaced by their defaults
    (a misspelt key makes the one that was meant faulty), and what such a default may have caused
    or hidden is told only once the key is mended.
    """
    return _design_of(_toml(text, source), source, folder)


def parse_scene(text: str, source: str = "") -> Scene:
    """Return the scene that TOML ``text`` says; ``source`` names it in the faults.

    Raises :class:`DesignError` with every fault found.
    """
    found = judge_scene(text, source)
    if found.faults or found.value is None:
        raise DesignError(found.faults, source)
    return found.value


def with_values(design: Design, values: Mapping[str, object]) -> Design:
    """Return a copy of ``design`` with dotted keys set, checked like a file.

    >>> from fingerdesign.checks.load import parse_design, with_values
    >>> design = parse_design('design.name = "a"')
    >>> with_values(design, {"plates.pitch_mm": 0.9}).plates.pitch_mm
    0.9

    A further row's keys are written ``plates.rows[0].cover_mm``. None takes a key's value away.
    Raises :class:`DesignError` with every fault.
    """
    data = without_sizes(design.model_dump(mode="json", exclude_none=True))
    for key, value in values.items():
        set_value(data, key, value)
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
        if path.exists() and not path.is_file() and not path.is_dir():
            bound = "an ordinary file"
            raise DesignError([Fault("file", str(path), bound, "a device or pipe may never end")])
        with path.open("rb") as stream:
            content = stream.read(MAX_BYTES + 1)
        if len(content) > MAX_BYTES:
            bound = f"at most {MAX_BYTES} bytes"
            raise DesignError([Fault("file", str(path), bound, "check the path")])
        return content.decode("utf-8-sig")
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
        return None, [e for e in error.errors(include_url=False) if not _counts_only_sound(e)]


_ROWS = "increments_mm|increments_N"


def _counts_only_sound(error: ErrorDetails) -> bool:
    """Whether an array is called too short only because its faulty entries were not counted."""
    entries = error["input"]
    least = error.get("ctx", {}).get("min_length", 0)
    return error["type"] == "too_short" and (
        isinstance(entries, (list, tuple)) and len(entries) >= least
    )


def judge_design(text: str, source: str = "", folder: Path | None = None) -> Judged[Design]:
    """Return what can be said of a design's TOML ``text``: the design as far as it is sound.

    ``folder``: where files that it names lie. Raises :class:`DesignError` only where the text is no
    TOML.
    """
    return _judged_design(_toml(text, source), folder)


def judge_scene(text: str, source: str = "") -> Judged[Scene]:
    """Return what can be said of a scene's TOML ``text``, as :func:`judge_design` does."""
    return _judged(Scene, _toml(text, source), {"path": {_ROWS: [[1.0, 0.0]]}})


def read_text(path: str | Path) -> str:
    """Return a file's text. Raises :class:`DesignError` where it cannot be read."""
    return _read(Path(path))


def _judged_design(data: dict[str, Any], folder: Path | None) -> Judged[Design]:
    known = resolved(resolved_file(data, folder or Path.cwd()), folder)
    found = _judged(Design, known.data, {"design": {"name": "unnamed"}})
    told = [*known.faults, *found.faults]
    doubtful = found.doubtful | known.doubtful
    if found.value is None:
        return Judged(None, _distinct(told), doubtful)
    geometry = design_faults(found.value, doubtful)
    faults = told + geometry + _assumed_faults(found.value, doubtful)
    doubtful |= {undexed(fault.key) for fault in geometry}
    return Judged(found.value, _distinct(faults), doubtful)


def _design_of(data: dict[str, Any], source: str, folder: Path | None = None) -> Design:
    found = _judged_design(data, folder)
    if found.faults or found.value is None:
        raise DesignError(found.faults, source)
    return found.value


def _judged(
    model: type[_Model], data: dict[str, Any], required: Mapping[str, Mapping[str, Any]]
) -> Judged[_Model]:
    """Take faulty keys out until the rest validates; ``required`` stands in for what must be, a
    key or one of several ("a|b").

    Some rules are not asked while a key is faulty, so each round may find further faults; those
    that a key taken out has caused are left out.
    """
    pruned, faults = copy.deepcopy(data), list[Fault]()
    doubtful: frozenset[str] = frozenset()
    for _ in range(MAX_ROUNDS):
        value, errors = _validated(model, pruned)
        if value is not None:
            return Judged(value, _distinct(faults), doubtful)
        found = [fault_of(error, model) for error in errors]
        faults += [fault for fault in found if not _caused(fault, doubtful)]
        before = (copy.deepcopy(pruned), doubtful)
        for error, fault in zip(errors, found, strict=True):
            if error["type"] == "extra_forbidden":
                doubtful |= _meant(fault)
            else:
                doubtful |= {undexed(fault.key)}
            _take_out(pruned, error)
        for table, values in required.items():
            inner = pruned.setdefault(table, {})
            for names, stand_in in values.items() if isinstance(inner, dict) else ():
                if not any(name in inner for name in names.split("|")):
                    inner[names.split("|")[0]] = stand_in
        if before == (pruned, doubtful):
            break
    return Judged(None, _distinct(faults), doubtful)


def _meant(fault: Fault) -> frozenset[str]:
    """The known key that an unknown one was meant to be, as far as its remedy can tell."""
    found = re.fullmatch(r"did you mean (.+)\?", fault.remedy)
    return frozenset(found.groups()) if found else frozenset()


def _caused(fault: Fault, doubtful: frozenset[str]) -> bool:
    """Whether a fault may be owed to a key that was taken out in an earlier round."""
    key = undexed(fault.key)
    beside = {
        "body.dome_radius_mm": ("body.shape",),
        "body.arc_radius_mm": ("body.shape",),
        "body.depth_mm": ("body.shape", "body.width_mm"),
        "body.step.file": ("body.shape", "body.step"),
        "body.edge": ("body.edge_radius_mm",),
        "plates.hole_pitch_mm": ("plates.hole_diameter_mm",),
        "plates.rows": ("plates.placement",),
        "body.material": ("materials",),
        "body.core.material": ("materials",),
        "plates.material": ("materials",),
    }
    return involves(doubtful, key, *beside.get(key, ()))


def _take_out(data: dict[str, Any], error: ErrorDetails) -> None:
    """Remove what an error is about: the key, or the table that lacks a key."""
    location: list[str | int] = list(error["loc"])
    named = error.get("ctx", {}).get("key") if error["type"] == "fault" else None
    if named:
        location = list(parts_of(undexed(named)))
    if error["type"] == "missing":
        location = location[:-1]
    if location == ["body", "dome_radius_mm"] and "dome_radius_mm" not in data.get("body", {}):
        location = ["body", "shape"]
    table: Any = data
    for index, name in enumerate(location):
        if not isinstance(table, dict) or name not in table:
            return
        inner = table[name]
        if name == "rows" and isinstance(inner, list) and index + 2 < len(location):
            number = location[index + 1]
            inner = inner[number] if isinstance(number, int) and number < len(inner) else None
            if isinstance(inner, dict):  # a row stands for itself: the others keep their numbers
                inner.pop(location[index + 2], None)
                return
        if index + 1 == len(location) or not isinstance(inner, dict):
            del table[name]
            return
        table = inner


def _assumed_faults(design: Design, doubtful: frozenset[str]) -> list[Fault]:
    values = design.model_dump(mode="json")
    known = set(_leaves(values))
    faults = []
    for index, key in enumerate(design.assumed):
        if key not in known and not involves(doubtful, key):
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
        if isinstance(value, dict):
            keys += _leaves(value, f"{prefix}{name}.")
            continue
        keys.append(prefix + name)
        for index, row in enumerate(value if isinstance(value, list) else ()):
            keys += _leaves(row, f"{prefix}{name}[{index}].") if isinstance(row, dict) else []
    return keys


def _distinct(faults: list[Fault]) -> list[Fault]:
    """Drop repeated faults (one wrong row may be refused by more than one rule)."""
    return list({str(fault): fault for fault in faults}.values())
