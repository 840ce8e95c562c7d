"""Variants of a study: its base with the studied keys set; those that cannot exist with reasons."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.checks.load import with_values
from fingerdesign.checks.starter import find_design, shipped_designs
from fingerdesign.design.faults import shown
from fingerdesign.design.keys import set_value
from fingerdesign.errors import DesignError, Fault
from fingerdesign.search.study.checks import middle_values, study_faults
from fingerdesign.search.study.keys import set_keys
from fingerdesign.search.study.sampling import number_of_points, points
from fingerdesign.search.study.values import Choice

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.search.study.file import Study
    from fingerdesign.search.study.values import Choice


# Points of a study: every combination of a grid, a Latin hypercube or a Sobol sequence; seeded.


@dataclass(frozen=True)
class Variant:
    """One design of a study; ``design`` None where it is invalid, and ``faults`` say why.

    number from 1; ``name`` is safe as a file's name; ``values``: the studied keys as drawn, a share
    ("x / y") as such.
    """

    number: int
    name: str
    values: dict[str, Choice]
    design: Design | None
    faults: tuple[Fault, ...] = ()


def base_design(study: Study, folder: Path | None = None) -> Design:
    """The study's base with [fixed] set; files lie in ``folder`` (None: the working directory).

    DesignError with every fault of the base, of [fixed], and of parameters: unknown keys, values
    outside a key's bounds, a grid without end. Where the base can only exist with values of the
    parameters, those of the middle are set; plates that do not fit are each variant's fault.
    """
    found = _found(study.study.base, folder or Path.cwd())
    faults = study_faults(study, found)
    if faults:
        raise DesignError(faults)
    fixed = {"design.name": study.name, **study.fixed}
    try:
        return with_values(found, fixed)
    except DesignError as error:
        middle = set_keys(_bare(found, fixed) or found, middle_values(study))
        try:
            return with_values(found, {**fixed, **middle})
        except DesignError:
            own = _bare(found, {**fixed, **middle}) or _bare(found, fixed)
            if own is None:
                raise error from None
            return own


def _found(base: str, folder: Path) -> Design:
    """A file beside the study's comes first, then a shipped design."""
    beside = folder / base
    try:
        shipped = base in shipped_designs() and not beside.is_file()
        return find_design(base if shipped else beside)
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no path"
        fault = Fault("study.base", shown(base), "a shipped design or a readable file", f"{why}")
        raise DesignError([fault]) from None


def _bare(base: Design, values: Mapping[str, Any]) -> Design | None:
    """The base with keys set, its geometry unjudged; None where the keys contradict each other."""
    from pydantic import ValidationError

    data = base.model_dump(mode="json", exclude_none=True)
    for key, value in values.items():
        set_value(data, key, value)
    try:
        return type(base).model_validate(data)
    except ValidationError:
        return None


def variants(study: Study, base: Design) -> Iterator[Variant]:
    """Every variant of the study, invalid ones too, in order."""
    digits = max(4, len(str(number_of_points(study))))
    for number, values in enumerate(points(study), start=1):
        yield variant_of(study, base, number, values, digits)


def variant_of(
    study: Study, base: Design, number: int, values: Mapping[str, Choice], digits: int = 4
) -> Variant:
    """The base with keys set; its name is the study's with the number."""
    digits = max(digits, len(str(number)))
    name = f"{_stem(study.name, digits)}-{number:0{digits}d}"
    try:
        design = with_values(base, {"design.name": name, **set_keys(base, values)})
    except DesignError as error:
        return Variant(number, name, dict(values), None, error.faults)
    return Variant(number, name, dict(values), design)


def stems(name: str) -> tuple[str, ...]:
    """What the names of a study's variants may start with, before the number."""
    return tuple(dict.fromkeys(_stem(name, digits) for digits in (4, 5, 6)))


def _stem(name: str, digits: int) -> str:
    """So much of a study's name that a variant's is no longer than a name may be."""
    return name[: 63 - digits].rstrip(".")
