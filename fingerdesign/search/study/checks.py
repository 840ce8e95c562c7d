"""A study's keys held against the schema of designs, before any work.

Only what is wrong for itself is reported here: an unknown key, a wrong kind of value, a value
outside the key's own bounds. Whether a combination can exist is each variant's question.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from dataclasses import replace
from itertools import islice
from typing import TYPE_CHECKING, Any

from pydantic import ValidationError
from pydantic_core import ErrorDetails

from fingerdesign.design.faults import dotted, fault_of, shown, undexed
from fingerdesign.design.keys import parts_of, set_value
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.search.study.keys import set_keys, split_share, value_of
from fingerdesign.search.study.sampling import at_shares, number_of_points
from fingerdesign.search.study.values import Choice, Range

if TYPE_CHECKING:
    from fingerdesign.design.schema import Design
    from fingerdesign.search.study.file import Study
    from fingerdesign.search.study.values import Choice


# A study's keys: which may stand beside each other, shares of other lengths, values set.


REPORTED = 200  # faults; a file of more is not mended one by one


def study_faults(study: Study, base: Design) -> list[Fault]:
    """Faults of [fixed], of the parameters and of the grid's size, each reported once.

    At most ``REPORTED`` of them, and one that says so.
    """
    faults = list(islice(_faults(study, base), REPORTED + 1))
    try:
        number_of_points(study)
    except DesignError as error:
        faults += error.faults
    found = list({str(fault): fault for fault in faults}.values())
    if len(found) <= REPORTED:
        return found
    more = Fault(
        "file", f"more than {REPORTED} faults", "without any", "correct those reported first"
    )
    return [*found[:REPORTED], more]


def _faults(study: Study, base: Design) -> Iterator[Fault]:
    found = _share_faults(study, base)
    yield from found
    if found:
        return
    setting = {**study.fixed, **set_keys(base, _with_wholes(study, middle_values(study)))}
    yield from _fixed_faults(study, base, setting)
    # What is no key at all has nothing to say to the others, and is reported once.
    unknown = _unknown(study, base, setting)
    yield from unknown.values()
    sound = {key: value for key, value in setting.items() if key not in unknown}
    for key in study.parameters:
        if split_share(key)[0] not in unknown:
            yield from _value_faults(study, base, sound, key)


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


def _ends_of(parameter: Range) -> tuple[Choice, Choice]:
    """Its least and greatest value, as variants get them: of the kind that the step makes them."""
    return parameter.at(0.0), parameter.at(1.0 - 1e-12)


def _fixed_faults(study: Study, base: Design, setting: Mapping[str, Any]) -> Iterator[Fault]:
    data, refused = _set(base, setting)
    plain = {_plain(key): key for key in study.fixed}
    for fault, _ in (*refused, *_schema_faults(data, plain)):
        owner = next((each for each in plain if _stands_in(fault.key, each)), None)
        if owner is not None:
            where = dotted(("fixed", plain[owner])) + fault.key[len(owner) :]
            yield Fault(where, fault.value, fault.bound, fault.remedy)


def _unknown(study: Study, base: Design, setting: Mapping[str, Any]) -> dict[str, Fault]:
    """The studied keys that designs do not have, with the fault of each."""
    data, refused = _set(base, setting)
    plain = {_plain(split_share(key)[0]): key for key in study.parameters}
    found: dict[str, Fault] = {}
    for fault in (*(fault for fault, _ in refused), *_unknown_faults(data, plain)):
        for owner, key in plain.items():
            if _stands_in(fault.key, owner) or _stands_in(owner, fault.key):
                value = shown(_shown(study.parameters[key]))
                where = dotted(("parameters", key))
                found[split_share(key)[0]] = Fault(where, value, fault.bound, fault.remedy)
    return found


def _value_faults(
    study: Study, base: Design, setting: Mapping[str, Any], key: str
) -> Iterator[Fault]:
    """Of each value of a parameter; of a range its ends."""
    target, share = split_share(key)[0], "/" in key
    where, plain = dotted(("parameters", key)), _plain(target)
    parameter = study.parameters[key]
    data, _ = _set(base, setting)
    for value in _ends_of(parameter) if isinstance(parameter, Range) else parameter:
        if not share:
            set_value(data, target, value)
        for fault, bounds in _schema_faults(data, (plain,)):
            # A share's product is out of bounds or not with the length that it is of.
            if _stands_in(fault.key, plain) and not (share and bounds):
                yield Fault(where, shown(value), fault.bound, fault.remedy)
        if share:
            return


def _plain(key: str) -> str:
    """A dotted key as faults write it: in quotes where a part needs them."""
    return dotted(parts_of(key))


def _stands_in(key: str, owner: str) -> bool:
    """Whether a fault's key is that key, or stands in it."""
    return undexed(key) == undexed(owner) or key.startswith((f"{owner}.", f"{owner}["))


def _set(
    base: Design, setting: Mapping[str, Any]
) -> tuple[dict[str, Any], list[tuple[Fault, bool]]]:
    """The base's data with keys set, and faults of those that lead nowhere."""
    data = base.model_dump(mode="json", exclude_none=True)
    refused: list[tuple[Fault, bool]] = []
    for key, value in setting.items():
        try:
            set_value(data, key, deepcopy(value))
        except DesignError as error:
            refused += [(replace(fault, key=_plain(key)), False) for fault in error.faults]
    return data, refused


def _errors(data: Mapping[str, Any]) -> list[ErrorDetails]:
    try:
        Design.model_validate(data)
    except ValidationError as error:
        return error.errors(include_url=False)
    return []


def _unknown_faults(data: Mapping[str, Any], owners: Iterable[str]) -> Iterator[Fault]:
    wanted = tuple(owners)
    for each in _errors(data):
        if each["type"] == "extra_forbidden":
            key = dotted(each["loc"])
            if any(_stands_in(key, owner) or _stands_in(owner, key) for owner in wanted):
                yield fault_of(each, Design)


def _schema_faults(data: Mapping[str, Any], owners: Iterable[str]) -> list[tuple[Fault, bool]]:
    """Faults of ``owners`` by themselves, each with whether it is one of the value's bounds."""
    wanted = tuple(owners)
    found: list[tuple[Fault, bool]] = []
    for each in _errors(data):
        unknown = each["type"] == "extra_forbidden"  # its words take long to find
        if unknown and not any(_stands_in(dotted(each["loc"]), owner) for owner in wanted):
            continue
        fault = fault_of(each, Design)
        combined = each["type"] == "fault" and each["ctx"]["key"]
        if not combined or fault.key.endswith(".material"):
            found.append((fault, each["type"].startswith(("greater_", "less_"))))
    return found
