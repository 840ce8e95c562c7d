"""A study's keys held against the schema of designs, before any work.

Only what is wrong for itself is told here: an unknown key, a wrong kind of value, a value outside
the key's own bounds. Whether a combination can exist is each variant's question.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from copy import deepcopy
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError

from fingerdesign.design.faults import dotted, fault_of, shown, undexed
from fingerdesign.errors import DesignError, Fault
from fingerdesign.sweep.sampling import at_shares, number_of_points
from fingerdesign.sweep.study_keys import set_keys, split_share, value_of
from fingerdesign.sweep.study_values import Choice, Range

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.sweep.study_file import Study


def study_faults(study: Study, base: Design) -> list[Fault]:
    """Faults of [fixed], of the parameters and of the grid's size, each told once."""
    faults = _share_faults(study, base)
    if not faults:
        middle = middle_values(study)
        plain = set_keys(base, _with_wholes(study, middle))
        setting = {**study.fixed, **plain}
        faults += _fixed_faults(study, base, setting)
        for key, value in _ends(study):
            faults += _value_faults(base, setting, key, value)
    try:
        number_of_points(study)
    except DesignError as error:
        faults += error.faults
    return list({str(fault): fault for fault in faults}.values())


def middle_values(study: Study) -> dict[str, Choice]:
    """A value of each parameter, of the middle of its range or list."""
    return at_shares(study, (0.5,) * len(study.parameters))


def _with_wholes(study: Study, values: Mapping[str, Choice]) -> dict[str, Choice]:
    """With the values of [fixed] that shares are of."""
    wholes = {split_share(key)[1] for key in study.parameters if "/" in key}
    return {**{key: study.fixed[key] for key in wholes & set(study.fixed)}, **values}


def _share_faults(study: Study, base: Design) -> list[Fault]:
    faults = []
    for key, parameter in study.parameters.items():
        if "/" not in key:
            continue
        where, whole = dotted(("parameters", key)), split_share(key)[1]
        of = study.parameters.get(whole, (study.fixed.get(whole, value_of(base, whole)),))
        if not isinstance(of, Range) and not all(_is_number(each) for each in of):
            bound = f"a share of a key that holds a number, not of {shown(whole)}"
            remedy = "correct the key, or give it in [fixed]"
            faults.append(Fault(where, shown(_shown(parameter)), bound, remedy))
        if not isinstance(parameter, Range) and not all(_is_number(each) for each in parameter):
            faults.append(Fault(where, shown(parameter), "numbers: shares", "correct it"))
    return faults


def _is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _shown(parameter: Range | tuple[Choice, ...]) -> object:
    return f"{parameter.low} to {parameter.high}" if isinstance(parameter, Range) else parameter


def _ends(study: Study) -> Iterator[tuple[str, Choice]]:
    """Each parameter's key with the values that its bounds are held against."""
    for key, parameter in study.parameters.items():
        ends = _ends_of(parameter) if isinstance(parameter, Range) else parameter
        yield from ((key, end) for end in ends)


def _ends_of(parameter: Range) -> tuple[Choice, Choice]:
    """Its least and greatest value, as variants get them: of the kind that the step makes them."""
    return parameter.at(0.0), parameter.at(1.0 - 1e-12)


def _fixed_faults(study: Study, base: Design, setting: Mapping[str, Any]) -> list[Fault]:
    faults = []
    for fault, _ in _schema_faults(base, setting):
        owner = _owner(fault.key, study.fixed)
        if owner is not None:
            where = dotted(("fixed", owner)) + fault.key[len(owner) :]
            faults.append(Fault(where, fault.value, fault.bound, fault.remedy))
    return faults


def _value_faults(base: Design, setting: Mapping[str, Any], key: str, value: Choice) -> list[Fault]:
    target, share = split_share(key)[0], "/" in key
    setting = setting if share else {**setting, target: value}
    where = dotted(("parameters", key))
    return [
        Fault(where, shown(value), fault.bound, fault.remedy)
        for fault, bounds in _schema_faults(base, setting)
        # A share's product is out of bounds or not with the length that it is of.
        if _owner(fault.key, (target,)) is not None and not (share and bounds)
    ]


def _owner(key: str, keys: Any) -> str | None:
    """The one of ``keys`` that a fault's key is or stands in."""
    plain = undexed(key)
    for each in keys:
        if plain == undexed(each) or key.startswith((f"{each}.", f"{each}[")):
            return str(each)
    return None


def _schema_faults(base: Design, setting: Mapping[str, Any]) -> list[tuple[Fault, bool]]:
    """Faults of keys by themselves, each with whether it is one of the value's bounds."""
    from fingerdesign.design.keys import set_value
    from fingerdesign.design.schema import Design

    data = base.model_dump(mode="json", exclude_none=True)
    found: list[tuple[Fault, bool]] = []
    for key, value in setting.items():
        try:
            set_value(data, key, deepcopy(value))
        except DesignError as error:
            found += [(fault, False) for fault in error.faults]
    try:
        Design.model_validate(data)
    except ValidationError as error:
        for each in error.errors(include_url=False):
            fault = fault_of(each, Design)
            combined = each["type"] == "fault" and each["ctx"]["key"]
            if not combined or fault.key.endswith(".material"):
                found.append((fault, each["type"].startswith(("greater_", "less_"))))
    return found
