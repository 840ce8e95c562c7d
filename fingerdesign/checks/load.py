"""Designs from files: keys and geometry judged, with every fault of a stage at once.

Stages: the keys, each by itself and, where those of its table are sound, with each other; then, of
a design whose keys are sound, the geometry.
"""

from collections.abc import Iterator, Mapping
from contextlib import nullcontext
from difflib import get_close_matches
from os import PathLike
from pathlib import Path
from typing import Any

from fingerdesign.checks.body import body_faults
from fingerdesign.checks.design import design_faults
from fingerdesign.checks.follow import followed
from fingerdesign.design.faults import shown
from fingerdesign.design.io import Judged, design_data, distinct, judge_keys, parse_toml
from fingerdesign.design.keys import leaves, set_value
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import file_text
from fingerdesign.design.step import resolved
from fingerdesign.errors import Fault
from fingerdesign.runtime.registry import code_allowed


def load_design(file_or_name: str | Path, *, allow_code: bool = False) -> Design:
    """Return the design of a file, or the shipped one of that name where there is no such file.

    allow_code: import the controller's class that the file names as "package.module:Class". Raises
    :class:`DesignError` with every fault of the file.
    """
    folder = Path(file_or_name).parent
    text = file_text(file_or_name)
    return parse_design(text, str(file_or_name), folder, allow_code=allow_code)


def parse_design(
    text: str, source: str = "", folder: Path | None = None, *, allow_code: bool = False
) -> Design:
    """Return the design of TOML ``text``; ``source`` names it in the faults.

    Files that it names lie in ``folder`` (None: the working directory) or are absolute. The sizes
    of a STEP body are read from its file. allow_code: as of :func:`load_design`.

    Raises :class:`DesignError` with every fault of the keys; where they are sound, with every one
    of the geometry.
    """
    with code_allowed() if allow_code else nullcontext():
        return judge_design(text, source, folder).sound(source)


def with_values(design: Design, values: Mapping[str, object]) -> Design:
    """Return a copy of ``design`` with dotted keys set, checked like a file.

    >>> from fingerdesign.checks.load import parse_design, with_values
    >>> design = parse_design('design.name = "a"')
    >>> with_values(design, {"plates.pitch_mm": 0.9}).plates.pitch_mm
    0.9

    A further row's keys are written ``plates.rows[0].cover_mm``. None takes a key's value away;
    numpy's numbers and arrays, and paths, are taken like Python's own.
    A controller "package.module:Class" must be permitted first, by ``fingerdesign.allow_code``.
    Raises :class:`DesignError` with every fault.
    """
    data = design_data(design)
    if design.body.step is not None:  # its file, which may change, decides its sizes
        for key in ("width_mm", "depth_mm", "base_height_mm"):
            del data["body"][key]
    # A hardness takes a modulus away: one that is set next to it comes later.
    for key, value in sorted(values.items(), key=lambda item: not item[0].endswith(".shore_a")):
        set_value(data, key, _plain(value))
    return judge_data(data).sound(design.design.name)


def _plain(value: object) -> object:
    """A value as a file would give it, and so those in its tables and lists."""
    if isinstance(value, Mapping):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        return [_plain(each) for each in value]
    if isinstance(value, PathLike):
        return str(value)
    kind = getattr(getattr(value, "dtype", None), "kind", "")  # numpy is not imported for it
    if kind not in tuple("biufU") or hasattr(value, "mask") or not hasattr(value, "tolist"):
        return repr(value) if kind else value  # of times and gaps no number is made
    return value.tolist()


def without_plates(design: Design) -> Design:
    """Return the same finger with nothing in the rubber but a core if there is one: the other side
    of a rig that reads one finger alone."""
    of_plates = ("plates.placement", "plates.rows", "assumed")
    of_gages = ("grip.hardware.dead_gages", "grip.hardware.dying_gages")
    return with_values(design, {"plates.count": 0, **dict.fromkeys((*of_plates, *of_gages))})


def judge_design(text: str, source: str = "", folder: Path | None = None) -> Judged[Design]:
    """Read a design from TOML ``text``, and its faults.

    ``folder``: where files that it names are. Raises :class:`DesignError` only where the text is no
    TOML.
    """
    return judge_data(parse_toml(text, source), folder)


def judge_data(data: dict[str, Any], folder: Path | None = None) -> Judged[Design]:
    """Judge a design's tables, as :func:`judge_design` does."""
    complete, faults = resolved(data, folder)
    found = judge_keys(Design, complete)
    keys = distinct([*faults, *found.faults])
    if keys or found.value is None:
        return Judged(None, keys)
    design = found.value if body_faults(found.value.body) else followed(found.value)
    return Judged(design, distinct([*design_faults(design), *_assumed_faults(design)]))


def _assumed_faults(design: Design) -> Iterator[Fault]:
    known = set(_keys_in(design.model_dump(mode="json"))) if design.assumed else set()
    for index, key in enumerate(design.assumed):
        if key not in known:
            near = get_close_matches(key, known, 1, 0.6)
            remedy = f"did you mean '{near[0]}'?" if near else "remove it"
            yield Fault(f"assumed[{index}]", shown(key), "the dotted key of a value", remedy)


def _keys_in(values: dict[str, Any]) -> Iterator[str]:
    """Dotted keys, those of arrays of tables too."""
    for name, value in leaves(values):
        yield name
        for index, row in enumerate(value if isinstance(value, list) else ()):
            keys = _keys_in(row) if isinstance(row, dict) else ()
            yield from (f"{name}[{index}].{key}" for key in keys)
