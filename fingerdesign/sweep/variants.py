"""Variants of a study: its base with the studied keys set; those that cannot exist with reasons."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from fingerdesign.errors import DesignError, Fault
from fingerdesign.sweep.sampling import number_of_points, points

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.sweep.study_file import Choice, Study


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

    DesignError with every fault of the base, of [fixed], and of parameters that name no key.
    """
    from fingerdesign.design.io import with_values
    from fingerdesign.design.starter import find_design

    base = Path(study.study.base)
    beside = (folder or Path.cwd()) / base
    found = find_design(beside if beside.is_file() else base)
    design = with_values(found, {"design.name": study.name, **study.fixed})
    _refuse_unknown(design, study)
    return design


def variants(study: Study, base: Design) -> Iterator[Variant]:
    """Every variant of the study, invalid ones too, in order."""
    digits = max(4, len(str(number_of_points(study))))
    for number, values in enumerate(points(study), start=1):
        yield variant_of(study, base, number, values, digits)


def variant_of(
    study: Study, base: Design, number: int, values: Mapping[str, Choice], digits: int = 4
) -> Variant:
    """The base with keys set; its name is the study's with the number."""
    from fingerdesign.design.io import with_values

    name = f"{study.name[: 63 - digits].rstrip('.')}-{number:0{digits}d}"
    try:
        design = with_values(base, {"design.name": name, **set_keys(base, values)})
    except DesignError as error:
        return Variant(number, name, dict(values), None, error.faults)
    return Variant(number, name, dict(values), design)


def set_keys(base: Design, values: Mapping[str, Choice]) -> dict[str, Any]:
    """Design keys and values: "x / y" is a share of y, which may be a studied key itself."""
    plain: dict[str, Any] = {key: value for key, value in values.items() if "/" not in key}
    for key, share in values.items():
        if "/" in key:
            part, whole = split_share(key)
            of = plain[whole] if whole in plain else value_of(base, whole)
            plain[part] = float(f"{float(share) * float(of):.9g}")
    return plain


def split_share(key: str) -> tuple[str, str]:
    """The two keys of a share.

    >>> split_share("plates.span_mm / body.depth_mm")
    ('plates.span_mm', 'body.depth_mm')
    """
    part, _, whole = (piece.strip() for piece in key.partition("/"))
    return part, whole


def value_of(design: Design, key: str) -> Any:
    """The value of a dotted key; None where the design has no such key or it is absent."""
    found: Any = design
    for name in key.split("."):
        found = found.get(name) if isinstance(found, Mapping) else getattr(found, name, None)
    return found


def _refuse_unknown(base: Design, study: Study) -> None:
    """DesignError where a parameter names no key of a design, or a share no length."""
    from fingerdesign.design.io import with_values

    faults: list[Fault] = []
    for key, first in _ends(study):
        where = f'parameters."{key}"'
        if "/" in key:
            whole = split_share(key)[1]
            of = value_of(base, whole)
            if isinstance(of, bool) or not isinstance(of, (int, float)):
                remedy = "correct the key, or give it in [fixed]"
                bound = f"a share of a key that holds a number, not of {whole!r}"
                faults.append(Fault(where, first, bound, remedy))
                continue
            if isinstance(first, bool) or not isinstance(first, (int, float)):
                faults.append(Fault(where, first, "a number: a share", "correct it"))
                continue
        try:
            with_values(base, set_keys(base, {key: first}))
        except DesignError as error:
            target = split_share(key)[0]
            # Whether combinations can exist is each variant's question.
            own = [fault for fault in error.faults if fault.key == target and _of_key(fault)]
            faults += [Fault(where, each.value, each.bound, each.remedy) for each in own]
    if faults:
        raise DesignError(list({str(fault): fault for fault in faults}.values()))


def _ends(study: Study) -> Iterator[tuple[str, Choice]]:
    """Each parameter's key with the values that its bounds are held against."""
    from fingerdesign.sweep.study_file import Range

    for key, parameter in study.parameters.items():
        ends = (parameter.low, parameter.high) if isinstance(parameter, Range) else parameter
        yield from ((key, end) for end in ends)


def _of_key(fault: Fault) -> bool:
    """Whether a fault is one of the key alone, not of the geometry."""
    alone = ("a known key", "one of", "a number", "a whole number", "text", "an array", "a table")
    limits = ("more than", "at least", "less than", "at most", "a known material")
    return (
        fault.bound.startswith(alone)
        or (fault.bound.startswith(limits) and fault.remedy in ("increase it", "decrease it"))
        or fault.bound.startswith("a known material")
    )
