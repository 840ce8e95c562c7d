"""A study file: a design, the keys that are varied, and the objectives and constraints.

[study] name, base, sampling, count, seed, fidelity, tolerance, scenes      [fixed] design keys
[parameters] key = [choices] or { low, high, log, step }      [limits]      [cost]
[[objectives]] metric, goal      [constraints] metric = { at_least, at_most }      [optimise]
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path, PurePath
from typing import Annotated, Any, Literal, Self

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationError,
    field_validator,
    model_validator,
)
from pydantic_core import ErrorDetails

from fingerdesign.design.base import Many, Table, refuse
from fingerdesign.design.digest import content_digest
from fingerdesign.design.faults import dotted, fault_of, shown
from fingerdesign.design.io import distinct, parse_toml
from fingerdesign.design.schema import safe_name
from fingerdesign.design.shipped import file_text
from fingerdesign.errors import DesignError, Fault
from fingerdesign.search.study.metrics import METRICS, OF_GRIPS, Goal, known_metric
from fingerdesign.search.study.values import (
    FILE_KEYS,
    Key,
    Parameter,
    Range,
    Text,
    flattened,
    key_faults,
    maybe_number,
    shallow,
)

MOST_VARIANTS = 100_000
MOST_PRICE = 1e6
MetricName = Annotated[str, AfterValidator(known_metric)]
_End = Annotated[float | None, BeforeValidator(maybe_number)]
REPORTED = 200  # faults; a file of more is not mended one by one


class StudyTable(Table):
    """``[study]``: its name, the design it starts from, how variants are drawn and analysed."""

    name: Annotated[str, AfterValidator(safe_name)] = Field(
        description="names the folder and the variants: letters, digits, - _ ."
    )
    base: Text = Field(description="a shipped design, or a file next to the study's")
    sampling: Literal["grid", "latin_hypercube", "sobol"] = "sobol"
    count: int | None = Field(default=None, ge=1, le=MOST_VARIANTS, description="not of a grid")
    seed: int = Field(default=0, ge=0, le=2**31)
    fidelity: Literal["plane-strain", "3d", "auto"] = "plane-strain"
    tolerance: float = Field(default=0.02, ge=1e-3, le=0.5, description="of fidelity auto")
    scenes: Many[Text] = Field(
        default=(), max_length=20, description="none: the fundamental case and the design's grips"
    )

    @field_validator("scenes")
    @classmethod
    def _distinct(cls, scenes: tuple[str, ...]) -> tuple[str, ...]:
        if (at := _twice([PurePath(scene).stem for scene in scenes])) is not None:
            bound = "scenes of different names (without folder and ending)"
            raise refuse(scenes[at], bound, "rename its file, or name it once")
        return scenes

    @model_validator(mode="after")
    def _counted(self) -> Self:
        if self.sampling == "grid" and self.count is not None:
            remedy = "remove it, or set study.sampling = 'sobol'"
            raise refuse(self.count, "absent where sampling = 'grid'", remedy, "study.count")
        if self.sampling != "grid" and self.count is None:
            remedy = "give the number of variants"
            raise refuse("(absent)", "given where sampling is not 'grid'", remedy, "study.count")
        return self


class Limits(Table):
    """``[limits]`` of each variant."""

    time_s: float = Field(default=300.0, gt=0, le=1e6)
    memory_MB: float = Field(default=4000.0, ge=200, le=1e7)


class Cost(Table):
    """``[cost]``: what the metric "cost" adds up, in a currency of the user's."""

    fixed: float = Field(default=0.0, ge=0, le=MOST_PRICE)
    plate: float = Field(default=2.0, ge=0, le=MOST_PRICE)
    gage: float = Field(default=8.0, ge=0, le=MOST_PRICE)
    silicone_per_ml: float = Field(default=0.05, ge=0, le=MOST_PRICE)


class Objective(Table):
    """One of ``[[objectives]]``; ``goal`` absent: what the metric is better by."""

    metric: MetricName
    goal: Goal | None = None

    @model_validator(mode="after")
    def _directed(self) -> Self:
        if self.goal is None and METRICS[self.metric].better is None:
            bound = f"given for {self.metric}, of which neither end is better by itself"
            raise refuse("(absent)", bound, "add goal = 'min' or goal = 'max'", "goal")
        return self

    @property
    def direction(self) -> Goal:
        better = self.goal or METRICS[self.metric].better
        assert better is not None
        return better


class Bound(Table):
    """Bounds of a metric of ``[constraints]``."""

    at_least: _End = None
    at_most: _End = None

    @model_validator(mode="after")
    def _given(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise refuse("{}", "at_least or at_most or both", "give one")
        if None not in (self.at_least, self.at_most) and self.at_least > self.at_most:  # type: ignore[operator]
            raise refuse(self.at_least, f"at most at_most = {self.at_most}", "correct one")
        return self

    def excess(self, value: float | None) -> float:
        """Distance of a value outside the bounds, 0 within; infinite without a value."""
        return math.inf if value is None else max(self.beyond(value), 0.0)

    def beyond(self, value: float) -> float:
        """Distance of a value outside the bounds; within, the negative one to the nearer bound."""
        low = -math.inf if self.at_least is None else self.at_least
        high = math.inf if self.at_most is None else self.at_most
        return max(low - value, value - high)


class Optimise(Table):
    """``[optimise]``: how many trials; the best ``confirm`` are analysed again in 3-D."""

    trials: int = Field(default=40, ge=1, le=MOST_VARIANTS)
    confirm: int = Field(default=3, ge=0, le=100)
    confirm_fidelity: Literal["3d", "auto"] = "3d"


class Study(Table):
    """A whole study file."""

    study: StudyTable
    fixed: dict[Key, Annotated[Any, AfterValidator(shallow)]] = Field(
        default_factory=dict, max_length=1000
    )
    parameters: dict[Key, Parameter] = Field(min_length=1, max_length=100)
    limits: Limits = Field(default_factory=Limits)
    cost: Cost = Field(default_factory=Cost)
    objectives: Many[Objective] = Field(default=(), max_length=10)
    constraints: dict[MetricName, Bound] = Field(default_factory=dict)
    optimise: Optimise = Field(default_factory=Optimise)

    @model_validator(mode="before")
    @classmethod
    def _dotted(cls, data: Any) -> Any:
        """``body.depth_mm`` without quotes means the same as with them."""
        if not isinstance(data, Mapping):
            return data
        tables = {name: data[name] for name in ("fixed", "parameters") if name in data}
        return {**data, **{name: _flat(name, table) for name, table in tables.items()}}

    @field_validator("objectives")
    @classmethod
    def _requested_once(cls, objectives: tuple[Objective, ...]) -> tuple[Objective, ...]:
        names = [objective.metric for objective in objectives]
        if (at := _twice(names)) is not None:
            raise refuse(names[at], "a metric that no other objective has", "remove one of them")
        return objectives

    @model_validator(mode="after")
    def _measured(self) -> Self:
        requested = (*(each.metric for each in self.objectives), *self.constraints)
        of_grips = ", ".join(name for name in dict.fromkeys(requested) if name in OF_GRIPS)
        if self.study.scenes and of_grips:
            remedy = f"leave out study.scenes, or {of_grips}"
            raise refuse(of_grips, "metrics that a scene gives: it has no grips", remedy, "study")
        return self

    @property
    def name(self) -> str:
        return self.study.name

    def digest(self) -> str:
        """SHA-256 of what decides the variants and their outcomes' selection."""
        return content_digest(self)


def _flat(name: str, table: Any) -> Any:
    if not isinstance(table, Mapping):
        return table
    pairs = list(flattened(table))
    keys = [key for key, _ in pairs]
    if (at := _twice(keys)) is not None:
        raise refuse(keys[at], "a key that is given once", "remove one of them", name)
    return dict(pairs)


def _twice(names: Sequence[str]) -> int | None:
    """The place of the first name that stands before it too; None where all differ."""
    first: dict[str, int] = {}
    return next((at for at, name in enumerate(names) if first.setdefault(name, at) != at), None)


def read_study(path: Path | str) -> Study:
    """The study of a file, or the shipped one of that name. DesignError with every fault."""
    return parse_study(file_text(path, "study"), str(path))


def parse_study(text: str, source: str = "") -> Study:
    """The study of TOML ``text``. DesignError with every fault of its keys.

    Files that parameters and [fixed] name lie where ``source`` does.
    """
    data = parse_toml(text, source)
    if "scene" in data or "also" in data:
        remedy = "run it by `fingerdesign bench plane-strain --study FILE`"
        fault = Fault("file", source or "(text)", "a study of fingers, not of plane strain", remedy)
        raise DesignError([fault], source)
    try:
        study = Study.model_validate(data)
    except ValidationError as error:
        found = error.errors(include_url=False)
        faults = distinct([_fault(each) for each in found[:REPORTED]])
        if len(found) > REPORTED:
            bound, remedy = f"without any of {REPORTED}", "correct those reported first"
            faults.append(Fault("file", f"{len(found)} faults", bound, remedy))
        raise DesignError(faults, source) from None
    if faults := key_faults(study.fixed, study.parameters):
        raise DesignError(faults, source)

    def placed(key: str, value: Any) -> Any:
        named = key in FILE_KEYS and isinstance(value, str) and value
        return str((Path(source).parent / value).absolute()) if named else value

    fixed = {key: placed(key, value) for key, value in study.fixed.items()}
    parameters = {
        key: each if isinstance(each, Range) else tuple(placed(key, value) for value in each)
        for key, each in study.parameters.items()
    }
    return study.model_copy(update={"fixed": fixed, "parameters": parameters})


def _fault(error: ErrorDetails) -> Fault:
    """In the words of a design's faults, without the marks that pydantic puts into its place."""
    location = tuple(
        shown(part, 80)[1:-1] if isinstance(part, str) and len(part) > 80 else part
        for part in error["loc"]
        if part != "[key]"
    )
    if location == ("parameters",) and error["type"] in ("missing", "too_short"):
        remedy = 'add one, such as "plates.pitch_mm" = { low = 0.8, high = 1.2 }'
        return Fault("parameters", "{}", "a table of at least one key", remedy)
    if location[:1] == ("parameters",) and location[2:3] in (("range",), ("choices",)):
        if len(location) == 3 and error["type"] == "tuple_type":
            bound = "a list of choices or a range { low = .., high = .. }"
            return Fault(dotted(location[:2]), shown(error["input"]), bound, "correct it")
        location = (*location[:2], *location[3:])
    found = fault_of(_placed(error, location), Study)
    return replace(found, key=found.key.replace("\x7f", "\\x7f"))


def _placed(error: ErrorDetails, location: tuple[int | str, ...]) -> ErrorDetails:
    """The error at ``location``, or at the key of the table there that it is of."""
    placed = error.copy()
    placed["loc"] = location
    own = error.get("ctx", {}).get("key") if error["type"] == "fault" else None
    if own and location and "." not in own:
        placed["ctx"] = {**error["ctx"], "key": ""}
        placed["loc"] = (*location, own)
    return placed
