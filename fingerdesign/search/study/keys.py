"""A study's keys: which may stand beside each other, shares of other lengths, values set."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any

from fingerdesign.design.faults import dotted, shown
from fingerdesign.design.keys import parts_of
from fingerdesign.errors import Fault
from fingerdesign.search.study.values import Choice

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.search.study.values import Choice


FILE_KEYS = ("body.step.file", "mesh.file")  # of a design: paths beside the study's file


def split_share(key: str) -> tuple[str, str]:
    """The two keys of a share.

    >>> split_share("plates.span_mm / body.depth_mm")
    ('plates.span_mm', 'body.depth_mm')
    """
    part, _, whole = (piece.strip() for piece in key.partition("/"))
    return part, whole


def set_keys(base: Design, values: Mapping[str, Choice]) -> dict[str, Any]:
    """Design keys and values: "x / y" is a share of y, which may be a studied key itself."""
    plain: dict[str, Any] = {key: value for key, value in values.items() if "/" not in key}
    for key, share in values.items():
        if "/" in key:
            part, whole = split_share(key)
            of = plain[whole] if whole in plain else value_of(base, whole)
            plain[part] = float(f"{float(share) * float(of):.9g}")
    return plain


def value_of(design: Design, key: str) -> Any:
    """The value of a dotted key; None where the design has no such key or it is absent."""

    found: Any = design.model_dump(mode="json")
    for part in parts_of(key):
        if isinstance(found, Mapping):
            found = found.get(part)
        elif isinstance(found, list) and isinstance(part, int) and part < len(found):
            found = found[part]
        else:
            return None
    return found


def key_faults(fixed: Mapping[str, Any], parameters: Iterable[str]) -> list[Fault]:
    """Faults of keys beside each other: one set twice, a share of a share, a variant's name."""
    faults = []
    targets: dict[str, str] = {}
    shares = {split_share(key)[0] for key in parameters if "/" in key}
    for key in parameters:
        target, where = split_share(key)[0], dotted(("parameters", key))
        if target in targets:
            bound = "a key that no other parameter sets"
            faults.append(Fault(where, f"beside {shown(targets[target])}", bound, "remove one"))
        targets[target] = key
        if target in fixed:
            bound = "a key that [fixed] does not set"
            faults.append(Fault(where, "in [fixed] too", bound, "remove one of them"))
        if "/" in key and split_share(key)[1] in shares:
            bound = "a share of a key that is no share itself"
            faults.append(Fault(where, "a share of a share", bound, "give that key a range"))
    for table, keys in (("fixed", list(fixed)), ("parameters", list(targets))):
        for key in keys:
            if key.split(".")[0].split("[")[0] == "design":
                bound = "another key: the study names its variants"
                faults.append(Fault(dotted((table, key)), "a name", bound, "set study.name"))
    return faults
