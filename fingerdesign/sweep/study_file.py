"""A study file: a design, the keys that are varied, and what is asked of each variant.

[study] name, base, sampling, count, seed, fidelity, tolerance, scenes      [fixed] design keys
[parameters] key = [choices] or { low, high, log, step }      [limits]      [cost]
[[objectives]] metric, goal      [constraints] metric = { at_least, at_most }      [optimise]
"""

from __future__ import annotations

import math
import tomllib
from pathlib import Path
from typing import Annotated, Any, Literal, Self

from pydantic import AfterValidator, Discriminator, Field, Tag, ValidationError, model_validator
from pydantic_core import ErrorDetails

from fingerdesign.design.base import Many, Table, refuse
from fingerdesign.design.faults import fault_of
from fingerdesign.design.tables import safe_name
from fingerdesign.errors import DesignError, Fault
from fingerdesign.sweep.metrics import METRICS, known_metric

MOST_VARIANTS = 100_000
MOST_CHOICES = 1000
Choice = bool | int | float | str
Goal = Literal["min", "max"]
MetricName = Annotated[str, AfterValidator(known_metric)]


class StudyTable(Table):
    """``[study]``: its name, the design it starts from, how variants are drawn and analysed."""

    name: Annotated[str, AfterValidator(safe_name)] = Field(
        description="names the folder and the variants: letters, digits, - _ ."
    )
    base: str = Field(min_length=1, max_length=4096, description="a shipped design or a file")
    sampling: Literal["grid", "latin_hypercube", "sobol"] = "sobol"
    count: int | None = Field(default=None, ge=1, le=MOST_VARIANTS, description="not of a grid")
    seed: int = Field(default=0, ge=0, le=2**31)
    fidelity: Literal["plane-strain", "3d", "auto"] = "plane-strain"
    tolerance: float = Field(default=0.02, ge=1e-3, le=0.5, description="of fidelity auto")
    scenes: Many[str] = Field(
        default=(), max_length=20, description="none: the fundamental case and the design's grips"
    )

    @model_validator(mode="after")
    def _counted(self) -> Self:
        if self.sampling == "grid" and self.count is not None:
            remedy = "remove it, or set study.sampling = 'sobol'"
            raise refuse(self.count, "absent where sampling = 'grid'", remedy, "study.count")
        if self.sampling != "grid" and self.count is None:
            remedy = "say how many variants are drawn"
            raise refuse("(absent)", "given where sampling is not 'grid'", remedy, "study.count")
        return self


class Range(Table):
    """``{ low, high }``: whole numbers stay whole; ``step`` counts from ``low``."""

    low: int | float
    high: int | float
    log: bool = Field(default=False, description="even in the logarithm")
    step: int | float | None = Field(default=None, gt=0)

    @model_validator(mode="after")
    def _ordered(self) -> Self:
        if not self.low < self.high:
            raise refuse(self.high, f"more than low = {self.low}", "correct the range")
        if self.log and (self.low <= 0 or self.step is not None):
            raise refuse(self.low, "above 0 and without step where log = true", "remove log")
        return self

    @property
    def whole(self) -> bool:
        """Whether its values are whole numbers."""
        return all(isinstance(each, int) for each in (self.low, self.high, self.step or 1))

    @property
    def levels(self) -> int | None:
        """How many values it has; None where they are continuous."""
        step = self.step if self.step is not None else (1 if self.whole else None)
        if step is None or self.log:
            return None
        return math.floor((self.high - self.low) / step + 1e-9) + 1

    def at(self, share: float) -> int | float:
        """The value at a share in [0, 1) of the range."""
        levels = self.levels
        if levels is not None:
            step = self.step if self.step is not None else 1
            value = self.low + step * min(int(share * levels), levels - 1)
            return value if self.whole else float(f"{value:.10g}")
        if self.log:
            found = self.low * (self.high / self.low) ** share
        else:
            found = self.low + share * (self.high - self.low)
        return round(found) if self.whole else float(f"{found:.6g}")


class Limits(Table):
    """``[limits]`` of each variant."""

    time_s: float = Field(default=300.0, gt=0, le=1e6)
    memory_MB: float = Field(default=4000.0, ge=200, le=1e7)


class Cost(Table):
    """``[cost]``: what the metric "cost" adds up, in a currency of the user's."""

    fixed: float = Field(default=0.0, ge=0)
    plate: float = Field(default=2.0, ge=0)
    gage: float = Field(default=8.0, ge=0)
    silicone_per_ml: float = Field(default=0.05, ge=0)


class Objective(Table):
    """One of ``[[objectives]]``; ``goal`` absent: what the metric is better by."""

    metric: MetricName
    goal: Goal | None = None

    @property
    def direction(self) -> Goal:
        """min or max."""
        better = METRICS[self.metric].better
        return self.goal or better or "min"


class Bound(Table):
    """What a metric of ``[constraints]`` must keep."""

    at_least: float | None = None
    at_most: float | None = None

    @model_validator(mode="after")
    def _said(self) -> Self:
        if self.at_least is None and self.at_most is None:
            raise refuse("{}", "at_least or at_most or both", "give one")
        if None not in (self.at_least, self.at_most) and self.at_least > self.at_most:  # type: ignore[operator]
            raise refuse(self.at_least, f"at most at_most = {self.at_most}", "correct one")
        return self

    def excess(self, value: float | None) -> float:
        """How far a value lies outside, 0 within; infinite for a metric without a value."""
        if value is None:
            return math.inf
        low = -math.inf if self.at_least is None else self.at_least
        high = math.inf if self.at_most is None else self.at_most
        return max(low - value, value - high, 0.0)


class Optimise(Table):
    """``[optimise]``: how many trials; the best ``confirm`` are analysed again in 3-D."""

    trials: int = Field(default=100, ge=1, le=MOST_VARIANTS)
    confirm: int = Field(default=3, ge=0, le=100)
    confirm_fidelity: Literal["3d", "auto"] = "3d"


Choices = Annotated[Many[Choice], Field(min_length=1, max_length=MOST_CHOICES)]
Parameter = Annotated[
    Annotated[Range, Tag("range")] | Annotated[Choices, Tag("choices")],
    Discriminator(lambda value: "range" if isinstance(value, (dict, Range)) else "choices"),
]


class Study(Table):
    """A whole study file; ``folder``: where files that it names lie (not a key)."""

    study: StudyTable
    fixed: dict[str, Any] = Field(default_factory=dict, max_length=1000)
    parameters: dict[str, Parameter] = Field(min_length=1, max_length=100)
    limits: Limits = Field(default_factory=Limits)
    cost: Cost = Field(default_factory=Cost)
    objectives: Many[Objective] = Field(default=(), max_length=10)
    constraints: dict[MetricName, Bound] = Field(default_factory=dict)
    optimise: Optimise = Field(default_factory=Optimise)

    @property
    def name(self) -> str:
        """The study's name."""
        return self.study.name

    def digest(self) -> str:
        """SHA-256 of what decides the variants and their outcomes' selection."""
        from fingerdesign.design.digest import content_digest

        return content_digest(self)


def read_study(path: Path | str) -> Study:
    """The study of a file, or the shipped one of that name. DesignError with every fault."""
    from fingerdesign.design.io import read_text

    found = study_path(Path(path))
    return parse_study(read_text(found), str(path))


def study_path(path: Path) -> Path:
    """The study's file, or that of the shipped one of that name."""
    from fingerdesign.design.starter import shipped_path

    shipped = shipped_path("maeno2000").parent / "studies" / f"{path.name}.toml"
    return shipped if not path.suffix and path.parent == Path() and shipped.is_file() else path


def parse_study(text: str, source: str = "") -> Study:
    """The study that TOML ``text`` says. DesignError with every fault of its keys."""
    try:
        data = tomllib.loads(text)
    except (ValueError, RecursionError) as error:
        raise DesignError([Fault("file", "(text)", "valid TOML", str(error))], source) from None
    if "scene" in data or "also" in data:
        remedy = "run it by `fingerdesign bench plane-strain --study FILE`"
        fault = Fault("file", source or "(text)", "a study of fingers, not of plane strain", remedy)
        raise DesignError([fault], source)
    try:
        return Study.model_validate(data)
    except ValidationError as error:
        raise DesignError([_fault(each) for each in error.errors()], source) from None


def _fault(error: ErrorDetails) -> Fault:
    """In the words of a design's faults, without the marks that pydantic puts into its place."""
    location = tuple(part for part in error["loc"] if part not in ("range", "choices", "[key]"))
    placed = error.copy()
    placed["loc"] = location
    return fault_of(placed, Study)
