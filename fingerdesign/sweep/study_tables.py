"""Tables of a study file beside its keys: how variants are drawn, limits, prices, what counts."""

from __future__ import annotations

import math
from pathlib import PurePath
from typing import Annotated, Literal, Self

from pydantic import AfterValidator, Field, field_validator, model_validator

from fingerdesign.design.base import Many, Table, refuse
from fingerdesign.design.tables import safe_name
from fingerdesign.sweep.metrics import METRICS, known_metric
from fingerdesign.sweep.study_values import Text

MOST_VARIANTS = 100_000
MOST_PRICE = 1e6
Goal = Literal["min", "max"]
MetricName = Annotated[str, AfterValidator(known_metric)]


class StudyTable(Table):
    """``[study]``: its name, the design it starts from, how variants are drawn and analysed."""

    name: Annotated[str, AfterValidator(safe_name)] = Field(
        description="names the folder and the variants: letters, digits, - _ ."
    )
    base: Text = Field(description="a shipped design, or a file beside the study's")
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
    def _told_apart(cls, scenes: tuple[str, ...]) -> tuple[str, ...]:
        names = [PurePath(scene).stem for scene in scenes]
        twice = [scene for at, scene in enumerate(scenes) if names[at] in names[:at]]
        if twice:
            bound = "scenes of different names (without folder and ending)"
            raise refuse(twice[0], bound, "rename its file, or name it once")
        return scenes

    @model_validator(mode="after")
    def _counted(self) -> Self:
        if self.sampling == "grid" and self.count is not None:
            remedy = "remove it, or set study.sampling = 'sobol'"
            raise refuse(self.count, "absent where sampling = 'grid'", remedy, "study.count")
        if self.sampling != "grid" and self.count is None:
            remedy = "say how many variants are drawn"
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
        """min or max."""
        better = self.goal or METRICS[self.metric].better
        assert better is not None
        return better


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
