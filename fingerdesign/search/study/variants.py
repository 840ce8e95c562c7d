"""Variants of a study: its base with the studied keys set; those that cannot exist with reasons."""

import itertools
import math
from collections.abc import Iterable, Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from itertools import islice
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.faults import dotted, fault_of, shown, undexed
from fingerdesign.design.io import design_data, distinct
from fingerdesign.design.keys import parts_of, set_value
from fingerdesign.design.mesh import mesh_file_faults
from fingerdesign.design.schema import Design
from fingerdesign.design.shipped import shipped_names
from fingerdesign.errors import DesignError, Fault
from fingerdesign.search.study.file import REPORTED, Study
from fingerdesign.search.study.values import (
    Choice,
    Parameter,
    Range,
    all_numbers,
    set_keys,
    split_share,
    value_of,
)

MOST_GRID = 100_000  # variants
Values = dict[str, Choice]
# Keys that name what must be there, whatever the other keys are.
_NAMES = (".material", "gages.kind", "mold.gage")
_NO_KEY = "extra_forbidden"  # pydantic's name of that fault


def points(study: Study) -> Iterator[Values]:
    """The values of each variant, in order. DesignError for a grid that has no end."""
    if study.study.sampling != "grid":
        return _drawn(study)
    levels = _levels(study)
    return (dict(zip(levels, each, strict=True)) for each in itertools.product(*levels.values()))


def number_of_points(study: Study) -> int:
    """Number of variants of the study."""
    if study.study.count is not None:
        return study.study.count
    return math.prod(len(values) for values in _levels(study).values())


def at_shares(study: Study, shares: tuple[float, ...]) -> Values:
    """The values at shares in [0, 1) of each parameter."""
    return {
        key: each.at(share)
        if isinstance(each, Range)
        else each[min(int(share * len(each)), len(each) - 1)]
        for (key, each), share in zip(study.parameters.items(), shares, strict=True)
    }


def _levels(study: Study) -> dict[str, list[Choice]]:
    """Each parameter's values on the grid."""
    found: dict[str, list[Choice]] = {}
    faults = []
    for key, parameter in study.parameters.items():
        levels = _number_of_levels(parameter)
        if isinstance(parameter, Range) and (levels is None or levels > MOST_GRID):
            bound = "a list, or a range with a step, where study.sampling = 'grid'"
            remedy = "give a list or a step without log, or set study.sampling = 'sobol'"
            where = dotted(("parameters", key))
            faults.append(Fault(where, f"{parameter.low} to {parameter.high}", bound, remedy))
        else:
            found[key] = _values_of(parameter)
    count = math.prod(len(values) for values in found.values())
    if not faults and count > MOST_GRID:
        remedy = "give fewer values, or set study.sampling = 'sobol'"
        faults.append(Fault("parameters", f"{count} variants", f"at most {MOST_GRID}", remedy))
    if faults:
        raise DesignError(faults)
    return found


def _number_of_levels(parameter: Parameter) -> int | None:
    return parameter.levels if isinstance(parameter, Range) else len(parameter)


def _values_of(parameter: Parameter) -> list[Choice]:
    """Every value of a list, or of a range with levels."""
    if not isinstance(parameter, Range):
        return list(parameter)
    count = parameter.levels or 0
    return [parameter.at((level + 0.5) / count) for level in range(count)]


def combinations(study: Study, most: int) -> list[Values] | None:
    """All values that the parameters can take together; None where they are more than ``most``, or
    where a range has no levels."""
    levels = [_number_of_levels(each) for each in study.parameters.values()]
    if None in levels or math.prod(each or 0 for each in levels) > most:
        return None
    every = itertools.product(*map(_values_of, study.parameters.values()))
    return [dict(zip(study.parameters, each, strict=True)) for each in every]


def _drawn(study: Study) -> Iterator[Values]:
    import numpy as np
    from scipy.stats import qmc

    count, dimension = number_of_points(study), len(study.parameters)
    chance = np.random.default_rng(study.study.seed)
    if study.study.sampling == "sobol":
        engine: Any = qmc.Sobol(dimension, scramble=True, rng=chance)
        # A power of 2 is balanced; the first of it are taken.
        shares = engine.random_base2(max(0, math.ceil(math.log2(count))))[:count]
    else:
        shares = qmc.LatinHypercube(dimension, rng=chance).random(count)
    return (at_shares(study, tuple(float(share) for share in row)) for row in shares)


def study_faults(study: Study, base: Design) -> list[Fault]:
    """Faults of [fixed], of the parameters and of the grid's size, each reported once.

    Unknown keys, wrong kinds of values and values outside a key's own bounds; combinations are
    judged variant by variant. At most ``REPORTED`` faults, and one that says so.
    """
    faults = _share_faults(study, base) or list(islice(_key_faults(study, base), REPORTED + 1))
    try:
        number_of_points(study)
    except DesignError as error:
        faults += error.faults
    found = distinct(faults)
    if len(found) <= REPORTED:
        return found
    remedy = "correct those reported first"
    return [*found[:REPORTED], Fault("file", f"more than {REPORTED} faults", "without any", remedy)]


def middle_values(study: Study) -> dict[str, Choice]:
    """A value of each parameter, of the middle of its range or list."""
    return at_shares(study, (0.5,) * len(study.parameters))


def _share_faults(study: Study, base: Design) -> list[Fault]:
    faults = []
    for key, parameter in study.parameters.items():
        if "/" not in key:
            continue
        where, whole = dotted(("parameters", key)), split_share(key)[1]
        of = study.parameters.get(whole, (study.fixed.get(whole, value_of(base, whole)),))
        if not all_numbers(of):
            bound = f"a share of a key that holds a number, not of {shown(whole)}"
            remedy = "correct the key, or give it in [fixed]"
            faults.append(Fault(where, _shown(parameter), bound, remedy))
        if not all_numbers(parameter):
            faults.append(Fault(where, _shown(parameter), "numbers: shares", "correct it"))
    return faults


def _shown(parameter: Parameter) -> str:
    if isinstance(parameter, Range):
        return shown(f"{parameter.low} to {parameter.high}")
    return shown(parameter)


def _key_faults(study: Study, base: Design) -> Iterator[Fault]:
    """Faults of [fixed], of unknown keys, and of each parameter's values by themselves."""
    setting = _middle_setting(study, base)
    data, refused = _set(base, setting)
    fixed, varied = _plain_keys(study)
    faults = [(each, _NO_KEY) for each in refused] + _schema_faults(data, (*fixed, *varied))
    for fault, kind in faults:
        own = _fixed_key(fault, fixed)
        if own is not None:
            yield own
        if kind != _NO_KEY:
            continue
        # What is no key at all is reported once, and left out for the others.
        for key in (key for plain, key in varied.items() if _overlap(fault.key, plain)):
            setting.pop(split_share(key)[0], None)
            own_value = _shown(study.parameters[key])
            yield replace(fault, key=dotted(("parameters", key)), value=own_value)
    for key in study.parameters:
        if split_share(key)[0] in setting:
            yield from _value_faults(study, base, setting, key)


def _fixed_key(fault: Fault, fixed: Mapping[str, str]) -> Fault | None:
    """A design's fault under the key of [fixed] that it is of; None where it is of none."""
    owner = next((each for each in fixed if _is_inside(fault.key, each)), None)
    if owner is None:
        return None
    return replace(fault, key=dotted(("fixed", fixed[owner])) + fault.key[len(owner) :])


def _plain_keys(study: Study) -> tuple[dict[str, str], dict[str, str]]:
    """The fixed and the varied keys, by how faults write them."""
    varied = {_plain(split_share(key)[0]): key for key in study.parameters}
    return {_plain(key): key for key in study.fixed}, varied


def _middle_setting(study: Study, base: Design) -> dict[str, Any]:
    """The fixed keys, and a value of each parameter of the middle of its range or list."""
    wholes = {split_share(key)[1] for key in study.parameters if "/" in key} & set(study.fixed)
    own = {key: study.fixed[key] for key in wholes}  # which shares are of
    return {**study.fixed, **set_keys(base, {**own, **middle_values(study)})}


def _value_faults(
    study: Study, base: Design, setting: Mapping[str, Any], key: str
) -> Iterator[Fault]:
    """Faults of each value of a parameter; of a range its ends."""
    target, share = split_share(key)[0], "/" in key
    plain, parameter = _plain(target), study.parameters[key]
    data, _ = _set(base, setting)
    # A range's ends as variants get them: of the kind that the step makes them.
    shares = (0.0, 1.0 - 1e-12)
    ends = map(parameter.at, shares) if isinstance(parameter, Range) else parameter
    for value in ends:
        if not share:
            set_value(data, target, value)
        for fault, kind in _schema_faults(data, (plain,)):
            # A share's product is out of bounds or not with the length that it is of.
            bounds = kind.startswith(("greater_", "less_"))
            if _is_inside(fault.key, plain) and not (share and bounds):
                yield replace(fault, key=dotted(("parameters", key)), value=shown(value))
        if share:
            return


def _plain(key: str) -> str:
    """A dotted key as faults write it: in quotes where a part needs them."""
    return dotted(parts_of(key))


def _is_inside(key: str, owner: str) -> bool:
    """Return True where a fault's key is that key, or inside it."""
    return undexed(key) == undexed(owner) or key.startswith((f"{owner}.", f"{owner}["))


def _overlap(key: str, other: str) -> bool:
    """Return True where one of two keys is the other, or inside it."""
    return _is_inside(key, other) or _is_inside(other, key)


def _set(base: Design, setting: Mapping[str, Any]) -> tuple[dict[str, Any], list[Fault]]:
    """The base's data with keys set, and faults of those that lead nowhere."""
    data = design_data(base)
    refused: list[Fault] = []
    for key, value in setting.items():
        try:
            set_value(data, key, deepcopy(value))
        except DesignError as error:
            refused += [replace(fault, key=_plain(key)) for fault in error.faults]
    return data, refused


def _schema_faults(data: Mapping[str, Any], owners: Iterable[str]) -> list[tuple[Fault, str]]:
    """Faults of ``owners`` by themselves, or of a table that contains one, each with its kind."""
    keys, found = tuple(owners), list[tuple[Fault, str]]()
    try:
        Design.model_validate(data)
    except ValidationError as error:
        for each in error.errors(include_url=False):
            kind, where = each["type"], dotted(each["loc"])
            if kind == _NO_KEY and not any(_overlap(where, own) for own in keys):
                continue  # its words take long to find
            fault = fault_of(each, Design)
            combined = kind == "fault" and each["ctx"]["key"]
            if not combined or fault.key.endswith(_NAMES):
                found.append((fault, kind))
    return found


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


def base_design(study: Study, file: Path | None = None) -> Design:
    """The study's base with [fixed] set; a base that is a file lies next to the study's own file
    (None: in the working directory).

    DesignError with every fault of the base, of [fixed], and of parameters: unknown keys, values
    outside a key's bounds, a grid without end. Where the base can only exist with values of the
    parameters, those of the middle are set; plates that do not fit are each variant's fault.
    """
    folder, source = (Path.cwd(), "") if file is None else (file.parent, str(file))
    found = _found(study.study.base, folder, source)
    if faults := study_faults(study, found):
        raise DesignError(faults, source)
    fixed = {"design.name": study.name, **study.fixed}
    try:
        return with_values(found, fixed)
    except DesignError as error:
        middle = set_keys(_bare(found, fixed) or found, middle_values(study))
        try:
            return with_values(found, {**fixed, **middle})
        except DesignError:
            own = _bare(found, {**fixed, **middle}) or _bare(found, fixed)
            unread = mesh_file_faults(own.mesh) if own and "mesh.file" in study.fixed else ()
            if own is None or unread:
                keys = _plain_keys(study)[0]
                faults = [_fixed_key(each, keys) or each for each in unread or error.faults]
                raise DesignError(faults, source) from None
            return own


def _found(base: str, folder: Path, source: str) -> Design:
    """Load the file next to the study's, or else a shipped design."""
    own = folder / base
    try:
        shipped = base in shipped_names() and not own.is_file()
        return load_design(base if shipped else own)
    except (OSError, ValueError) as error:
        why = error.strerror if isinstance(error, OSError) else "it is no path"
        fault = Fault("study.base", shown(base), "a shipped design or a readable file", f"{why}")
        raise DesignError([fault], source) from None


def _bare(base: Design, values: Mapping[str, Any]) -> Design | None:
    """The base with keys set, its geometry unjudged; None where the keys contradict each other."""
    data = design_data(base)
    for key, value in values.items():
        set_value(data, key, value)
    try:
        return type(base).model_validate(data)
    except ValidationError:
        return None


def variants(study: Study, base: Design, shard: tuple[int, int] = (1, 1)) -> Iterator[Variant]:
    """Every variant of the study, invalid ones too, in order; of shard (i, n) each n-th from i."""
    digits = max(4, len(str(number_of_points(study))))
    for number, values in islice(enumerate(points(study), start=1), shard[0] - 1, None, shard[1]):
        yield variant_of(study, base, number, values, digits)


def variant_of(
    study: Study, base: Design, number: int, values: Mapping[str, Choice], digits: int = 4
) -> Variant:
    """The base with keys set; its name is the study's with the number."""
    digits = max(digits, len(str(number)))
    found = Variant(number, f"{_stem(study.name, digits)}-{number:0{digits}d}", dict(values), None)
    try:
        design = with_values(base, {"design.name": found.name, **set_keys(base, values)})
    except DesignError as error:
        return replace(found, faults=error.faults)
    return replace(found, design=design)


def stems(name: str) -> tuple[str, ...]:
    """Beginnings of the names of a study's variants, before the number."""
    return tuple(dict.fromkeys(_stem(name, digits) for digits in (4, 5, 6)))


def _stem(name: str, digits: int) -> str:
    """The part of a study's name that a variant's is no longer than a name may be."""
    return name[: 63 - digits].rstrip(".")
