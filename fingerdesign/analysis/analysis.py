"""An analysis with the arrays that its report needs, beside the record of it."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from fingerdesign.records.arrays import (
    ContactHistory,
    FieldHistory,
    GageLayout,
    GripTrace,
    SlipStudy,
)
from fingerdesign.records.result import Result, SlipStudySummary

if TYPE_CHECKING:
    from fingerdesign.contact.problem import ContactProblem
    from fingerdesign.layout.frames import PlateFrame
    from fingerdesign.mesh.types import Mesh


@dataclass(frozen=True)
class Analysis:
    """A result and the arrays behind it: all that the report is made from.

    A part that was not computed is None or empty and the report leaves its figures out, saying so.
    depth_mm: the body's depth, which the picture of a plane-strain section is drawn with.
    problem: the condensed finger and its object, with the gages of the array, to ask more of.
    The result's summaries of the slip studies are made from ``slip_studies`` where it has none.
    """

    result: Result
    contact: ContactHistory | None = None
    slip_studies: tuple[SlipStudy, ...] = ()
    grip_traces: tuple[GripTrace, ...] = ()
    mesh: Mesh | None = None
    fields: FieldHistory | None = None
    plates: tuple[PlateFrame, ...] = ()
    gages: GageLayout | None = None
    depth_mm: float = 10.0
    problem: ContactProblem | None = None

    def __post_init__(self) -> None:
        if self.slip_studies and not self.result.slip_studies:
            summaries = tuple(
                SlipStudySummary(
                    friction_coefficient=study.friction_coefficient,
                    rank_correlation=study.rank_correlation,
                    rank_correlation_raw=study.rank_correlation_raw,
                    threshold_microstrain_per_N=study.threshold,
                    force_floor_N=study.force_floor_N,
                )
                for study in self.slip_studies
            )
            result = dataclasses.replace(self.result, slip_studies=summaries)
            object.__setattr__(self, "result", result)
