"""Record of tolerance.json. Spreads are standard deviations, of one or of the row's own."""

import math
from dataclasses import dataclass
from typing import Annotated, Literal

from pydantic import Field

from fingerdesign.records.base import Size, closed


@closed
@dataclass(frozen=True)
class SourceData:
    """One cause of scatter; share: of the readings' variance; most_sensitive: its parameter."""

    words: str
    tolerance: Size
    unit: str
    share: Size
    most_sensitive: str
    calibrated: Annotated[bool, Field(description="a bench measures it, so that it drops out")]


@closed
@dataclass(frozen=True)
class RowData:
    """A row of the path: as designed, and standard deviations as made and once calibrated."""

    normal_force_N: float
    tangential_force_N: float
    stick_ratio: float
    largest_reading_microstrain: Size
    normal_force_std_N: tuple[Size, Size]
    tangential_force_std_N: tuple[Size, Size]
    stick_ratio_std: tuple[Size, Size]
    reading_std_microstrain: tuple[Size, Size]
    gage_area_mm: Annotated[Size | None, Field(description="of rows that only shear; else null")]
    gage_area_std_mm: tuple[Size, Size]
    on_kink: Annotated[Size, Field(description="share of the force on nodes between two statuses")]


@closed
@dataclass(frozen=True)
class CastData:
    """Real models of fingers as cast, lifted by the design's own controller.

    share: of their lifts with a margin of 1.1 to 1.5, interval: at 95 %; lifted: of all lifts;
    by_motion: of the fingers, as ``yield_by_motion``; it and spreads of the readings (RMS over rows
    and gages) and of the largest normal force: by derivatives for these fingers, and by models.
    """

    fingers: int
    share: Size
    interval: tuple[Size, Size]
    lifted: Size
    by_motion: tuple[Size, Size]
    reading_std_microstrain: tuple[Size, Size]
    normal_force_std_N: tuple[Size, Size]


@closed
@dataclass(frozen=True)
class ToleranceData:
    """The content of tolerance.json: one `fingerdesign tolerance`."""

    schema_version: Literal[1]
    design: str
    scene: str
    fidelity: str
    rows: tuple[RowData, ...]
    sources: tuple[SourceData, ...]
    gage_std_microstrain: Annotated[
        tuple[Size, ...], Field(description="of each gage as made, RMS over the rows")
    ]
    yield_by_motion: Annotated[
        tuple[Size, Size],
        Field(
            description="share of fingers, as made and once calibrated, with a margin of 1.1 to 1.5"
            " where a stage closes all of them alike"
        ),
    ]
    cast: Annotated[CastData | None, Field(description="by real models, where they were asked for")]
    seconds: Size
    versions: dict[str, str]
    gage_response: Annotated[
        tuple[Size, Size] | None,
        Field(
            description="greatest reading per tangential force, microstrain/N: as designed, and "
            "what 90 % of fingers as made reach; null without a row that only shears"
        ),
    ] = None
    other_model: Annotated[
        tuple[str, ...], Field(description="keys of the design that derivatives are not known for")
    ] = ()

    @property
    def margin_std(self) -> tuple[float, float]:
        """Relative deviations of the margin by motion: it goes with the largest normal force."""
        row = max(self.rows, key=lambda each: each.normal_force_N)
        made, calibrated = row.normal_force_std_N
        return made / row.normal_force_N, calibrated / row.normal_force_N

    @property
    def reading_std(self) -> tuple[float, float]:
        """Deviations of readings, as made and calibrated, over their row's largest: RMS of rows."""
        rows = [row for row in self.rows if row.largest_reading_microstrain > 0.0]

        def share(k: int) -> float:
            each = [r.reading_std_microstrain[k] / r.largest_reading_microstrain for r in rows]
            return math.hypot(*each) / math.sqrt(max(len(rows), 1))

        return share(0), share(1)
