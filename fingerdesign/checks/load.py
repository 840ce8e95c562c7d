"""Design and scene files: TOML in, with every fault of a stage at once; TOML out.

Stages: the keys, each by itself and, where those of its table are sound, with each other; then, of
a design whose keys are sound, the geometry.
"""

import tomllib
from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Generic, TypeVar

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

from fingerdesign.checks.body import body_faults
from fingerdesign.checks.design import design_faults
from fingerdesign.checks.follow import followed
from fingerdesign.design.faults import fault_of, leaves, set_value, shown
from fingerdesign.design.scene import Scene
from fingerdesign.design.schema import Design, unknown_materials
from fingerdesign.design.step import resolved
from fingerdesign.errors import DesignError, Fault
from fingerdesign.runtime.registry import code_allowed

# A finger without its plates: the other side of a rig that reads one finger alone.


def without_plates(design: Design) -> Design:
    """The same body, mesh and grip, and nothing in the rubber but a core if there is one."""
    gone = ("plates.placement", "plates.rows", "grip.hardware.dead_gages", "assumed")
    return with_values(design, {"plates.count": 0, **dict.fromkeys(gone)})


_Model = TypeVar("_Model", bound=BaseModel)
_Found = TypeVar("_Found", bound=BaseModel, covariant=True)
MAX_BYTES = 2_000_000  # a design of a few kilobytes; a scene of 10,000 rows stays below 1 MB
# The largest shipped file has 80 keys, three tables deep. Many more take minutes to be refused one
# by one, and much deeper ones end Python's recursion in whatever reads them.
MAX_KEYS, MAX_DEPTH = 5_000, 20


@dataclass(frozen=True)
class Judged(Generic[_Found]):
    """What a file says, and every fault of the first stage that found any.

    ``value`` is None where keys are faulty.
    """

    value: _Found | None
    faults: list[Fault]

    def sound(self, source: str) -> _Found:
        """The value; DesignError with every fault where there are any."""
        if self.faults or self.value is None:
            raise DesignError(self.faults, source)
        return self.value


def load_design(path: str | Path, *, allow_code: bool = False) -> Design:
    """Read a design file. Raises :class:`DesignError` with every fault found in it.

    allow_code: import the controller's class that the file names as "package.module:Class".
    """
    return parse_design(read_text(path), str(path), Path(path).parent, allow_code=allow_code)


def load_scene(path: str | Path) -> Scene:
    """Read a scene file. Raises :class:`DesignError` with every fault found in it."""
    return parse_scene(read_text(path), str(path))


def parse_design(
    text: str, source: str = "", folder: Path | None = None, *, allow_code: bool = False
) -> Design:
    """Return the design that TOML ``text`` says; ``source`` names it in the faults.

    Files that it names lie in ``folder`` (None: the working directory) or are absolute. The sizes
    of a STEP body are read from its file. allow_code: as of :func:`load_design`.

    Raises :class:`DesignError` with every fault of the keys; where they are sound, with every one
    of the geometry.
    """
    with code_allowed() if allow_code else nullcontext():
        return judge_design(text, source, folder).sound(source)


def parse_scene(text: str, source: str = "") -> Scene:
    """Return the scene that TOML ``text`` says; ``source`` names it in the faults.

    Raises :class:`DesignError` with every fault found.
    """
    return judge_scene(text, source).sound(source)


def with_values(design: Design, values: Mapping[str, object]) -> Design:
    """Return a copy of ``design`` with dotted keys set, checked like a file.

    >>> from fingerdesign.checks.load import parse_design, with_values
    >>> design = parse_design('design.name = "a"')
    >>> with_values(design, {"plates.pitch_mm": 0.9}).plates.pitch_mm
    0.9

    A further row's keys are written ``plates.rows[0].cover_mm``. None takes a key's value away.
    A controller "package.module:Class" must be permitted first, by ``fingerdesign.allow_code``.
    Raises :class:`DesignError` with every fault.
    """
    data = design_data(design)
    if design.body.step is not None:  # its file, which may change, decides its sizes
        for key in ("width_mm", "depth_mm", "base_height_mm"):
            del data["body"][key]
    for key, value in values.items():
        set_value(data, key, value)
    return judge_data(data).sound(design.design.name)


def design_data(design: Design) -> dict[str, Any]:
    """A design's tables as a file gives them; keys that followed the finger are left out, so that
    they follow it anew where another value is set."""
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


def read_text(file: str | Path) -> str:
    """Return a file's text. Raises :class:`DesignError` where it cannot be read."""
    path = Path(file)
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
        raise DesignError([Fault("file", str(path), "a readable TOML file", f"{why}")]) from None


def parse_toml(text: str, source: str = "") -> dict[str, Any]:
    """What TOML ``text`` holds. DesignError where it is none, or has too many or too deep keys."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # a bad date, a 5000-digit integer are ValueError
        why = "too deeply nested" if isinstance(error, RecursionError) else str(error)[:300]
        raise DesignError([Fault("file", "(text)", "valid TOML", why)], source) from None
    level: list[Any] = [data]
    keys, depth = 0, 0
    while level and depth <= MAX_DEPTH and keys <= MAX_KEYS:
        tables = [each for each in level if isinstance(each, dict)]
        keys, depth = keys + sum(map(len, tables)), depth + 1
        inside = [*(each.values() for each in tables), *(e for e in level if isinstance(e, list))]
        level = [each for values in inside for each in values if isinstance(each, dict | list)]
    if level or keys > MAX_KEYS:
        bound = f"at most {MAX_KEYS} keys, {MAX_DEPTH} tables or arrays deep"
        value = f"{keys} keys or more" if keys > MAX_KEYS else f"{depth} deep or more"
        raise DesignError(
            [Fault("file", value, bound, "check the path, or leave out keys")], source
        )
    return data


def _validated(model: type[_Model], data: dict[str, Any]) -> Judged[_Model]:
    """The model that data says, or every fault of its keys."""
    try:
        return Judged(model.model_validate(data), [])
    except ValidationError as error:
        errors = [e for e in error.errors(include_url=False) if not _counts_only_sound(e)]
    faults = [fault_of(each, model) for each in errors]
    if issubclass(model, Design):  # a rule between tables, which pydantic asks of sound ones only
        for refusal in unknown_materials(data):
            own = ErrorDetails(type="fault", loc=(), msg="", input=None, ctx=refusal.context or {})
            faults.append(fault_of(own, model))
    return Judged(None, _distinct(faults))


def _counts_only_sound(error: ErrorDetails) -> bool:
    """Whether an array is called too short only because its faulty entries were not counted."""
    entries = error["input"]
    least = error.get("ctx", {}).get("min_length", 0)
    return error["type"] == "too_short" and (
        isinstance(entries, (list, tuple)) and len(entries) >= least
    )


def judge_design(text: str, source: str = "", folder: Path | None = None) -> Judged[Design]:
    """Return what a design's TOML ``text`` says, and its faults.

    ``folder``: where files that it names lie. Raises :class:`DesignError` only where the text is no
    TOML.
    """
    return judge_data(parse_toml(text, source), folder)


def judge_scene(text: str, source: str = "") -> Judged[Scene]:
    """Return what a scene's TOML ``text`` says, as :func:`judge_design` does."""
    return _validated(Scene, parse_toml(text, source))


def judge_data(data: dict[str, Any], folder: Path | None = None) -> Judged[Design]:
    """As :func:`judge_design`, of what the text holds."""
    complete, faults = resolved(data, folder)
    found = _validated(Design, complete)
    keys = _distinct([*faults, *found.faults])
    if keys or found.value is None:
        return Judged(None, keys)
    design = found.value if body_faults(found.value.body) else followed(found.value)
    return Judged(design, _distinct(design_faults(design) + _assumed_faults(design)))


def _assumed_faults(design: Design) -> list[Fault]:
    known = set(_keys_in(design.model_dump(mode="json")))
    faults = []
    for index, key in enumerate(design.assumed):
        if key not in known:
            near = get_close_matches(key, known, 1, 0.6)
            remedy = f"did you mean '{near[0]}'?" if near else "remove it"
            bound = "the dotted key of a value"
            faults.append(Fault(f"assumed[{index}]", shown(key), bound, remedy))
    return faults


def _keys_in(values: dict[str, Any]) -> Iterator[str]:
    """Dotted keys, those of arrays of tables too."""
    for name, value in leaves(values):
        yield name
        for index, row in enumerate(value if isinstance(value, list) else ()):
            yield from (
                (f"{name}[{index}].{key}" for key in _keys_in(row)) if isinstance(row, dict) else ()
            )


def _distinct(faults: list[Fault]) -> list[Fault]:
    """Drop repeated faults (one wrong row may be refused by more than one rule)."""
    return list({str(fault): fault for fault in faults}.values())
