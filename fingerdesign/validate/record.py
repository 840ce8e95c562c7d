"""What validate.json and validate.csv hold. Errors are parts of one."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import Field
from typing_extensions import TypedDict

from fingerdesign.analysis.fidelity.readings import QUANTITIES
from fingerdesign.records.base import Count, Size, closed, csv_text, json_text
from fingerdesign.validate.advice import KEEP, LIMIT

if TYPE_CHECKING:
    from fingerdesign.validate.assumptions import Assumption
    from fingerdesign.validate.comparison import Answer, Comparison, Side
    from fingerdesign.validate.gages import AlongZ

SCHEMA_VERSION = 1
RECORD_FILE = "validate.json"
CSV_FILE = "validate.csv"
SIDES = ("equal_motion", "equal_force")


@closed
class SpreadData(TypedDict):
    """Parts of one, over the path."""

    greatest: Size
    median: Size


@closed
class ErrorsData(TypedDict):
    """Of each quantity; null: prescribed, or cannot differ."""

    normal_force: SpreadData | None
    tangential_force: SpreadData | None
    contact_width: SpreadData | None
    stick_ratio: SpreadData | None
    gage: SpreadData | None


@closed
class SideData(TypedDict):
    """Two models at equal motion, or at equal force."""

    rows: Count
    rows_left_out: Count
    note: str
    errors: ErrorsData
    gages: Annotated[list[Size], Field(description="greatest of each gage")]


@closed
class AnswerData(TypedDict):
    """What one model says, a value a row of the path."""

    model: str
    dimension: Literal[2, 3]
    dofs: Count
    seconds: Size
    normal_force_N: list[float]
    tangential_force_N: list[float]
    contact_width_mm: list[float]
    stick_ratio: list[float]
    gages_microstrain: list[list[float]]


@closed
class ComparisonData(TypedDict):
    """Two models; a side is null where it cannot be had, and ``missing`` says why."""

    label: str
    assumed: AnswerData
    better: AnswerData
    equal_motion: SideData | None
    equal_force: SideData | None
    missing: list[str]


@closed
class PlaceData(TypedDict):
    """Gages at one place along z."""

    z_mm: Size
    greatest: Size
    median: Size
    gages: list[float]


@closed
class RowData(TypedDict):
    """One assumption."""

    assumption: str
    title: str
    assumed: str
    better: str
    kind: Literal["model", "value", "reading"]
    tested: bool
    reason: Annotated[str | None, Field(description="why it was not tested")]
    seconds: Size | None
    better_seconds: Size | None
    saving: Size | None
    equal_motion: SideData | None
    equal_force: SideData | None
    verdict: Literal["keep", "limited", "drop", "measure", "not tested"]
    advice: str
    comparisons: list[ComparisonData]
    along_z: list[PlaceData] | None


@closed
class Thresholds(TypedDict):
    """Errors up to which an assumption is kept, or kept within limits."""

    keep: Size
    limit: Size


@closed
class ValidationData(TypedDict):
    """The content of validate.json."""

    schema_version: Literal[1]
    design: str
    scene: str
    digest: str
    status: Annotated[Literal["ok", "failed"], Field(description="failed: see failure")]
    failure: Annotated[str | None, Field(description="a model failed and no row was told")]
    deep: bool
    gages: Count
    thresholds: Thresholds
    assumptions: list[RowData]
    seconds: Size
    peak_memory_MB: Size
    versions: dict[str, str]


@dataclass(frozen=True)
class Row:
    """One assumption, tested or not (then ``reason`` says why): plain values, ready to write.

    seconds, better_seconds: of the comparison that costs most; saving: their ratio (both None for a
    value: another one costs the same). equal_motion, equal_force: the worst over all comparisons,
    {quantity: {greatest, median}, or None where it is prescribed or cannot differ}, the greatest
    error of each gage, rows compared and left out; None where nothing could be compared.
    """

    key: str
    title: str
    assumed: str
    better: str
    kind: str
    tested: bool
    reason: str | None = None
    seconds: float | None = None
    better_seconds: float | None = None
    saving: float | None = None
    equal_motion: dict[str, Any] | None = None
    equal_force: dict[str, Any] | None = None
    verdict: str = "not tested"
    advice: str = ""
    comparisons: tuple[dict[str, Any], ...] = ()
    along_z: tuple[dict[str, Any], ...] | None = None

    def greatest(self, side: str, quantity: str) -> float | None:
        """The greatest error of a quantity at "equal_motion" or "equal_force"; None: no error."""
        found = getattr(self, side)
        reported = None if found is None else found["errors"][quantity]
        return None if reported is None else float(reported["greatest"])

    def data(self) -> dict[str, Any]:
        """As in the file."""
        values = {name: getattr(self, name) for name in self.__dataclass_fields__}
        values["assumption"] = values.pop("key")
        return {
            "assumption": values.pop("assumption"),
            **values,
            "comparisons": list(self.comparisons),
            "along_z": None if self.along_z is None else list(self.along_z),
        }


@dataclass(frozen=True)
class Validation:
    """The record of one `fingerdesign validate`. seconds: of everything, reports apart."""

    design: str
    scene: str
    digest: str
    deep: bool
    gages: int
    rows: tuple[Row, ...]
    seconds: float
    versions: dict[str, str] = field(default_factory=dict)
    peak_memory_MB: float = 0.0
    failure: str | None = None

    @property
    def status(self) -> str:
        """ "failed" where a model failed and nothing was reported; ``failure`` says of what."""
        return "ok" if self.failure is None else "failed"

    def row(self, key: str) -> Row:
        """The row of an assumption. KeyError where there is none."""
        for row in self.rows:
            if row.key == key:
                return row
        raise KeyError(key)

    def data(self) -> dict[str, Any]:
        """As in the file."""
        return {
            "schema_version": SCHEMA_VERSION,
            "design": self.design,
            "scene": self.scene,
            "digest": self.digest,
            "status": self.status,
            "failure": self.failure,
            "deep": self.deep,
            "gages": self.gages,
            "thresholds": {"keep": KEEP, "limit": LIMIT},
            "assumptions": [row.data() for row in self.rows],
            "seconds": self.seconds,
            "peak_memory_MB": self.peak_memory_MB,
            "versions": self.versions,
        }

    def to_json(self) -> str:
        """The text of validate.json."""
        return json_text(self.data())


def compared_row(
    of: Assumption,
    comparisons: list[Comparison],
    verdict: str,
    advice: str,
    along_z: AlongZ | None = None,
) -> Row:
    """The row of an assumption that was compared."""
    most = max(comparisons, key=lambda each: each.better.seconds)
    seconds, better = most.assumed.seconds, most.better.seconds
    if of.kind == "value":  # the better one is the design's here, and another value costs the same
        seconds = better
    return Row(
        key=of.key,
        title=of.title,
        assumed=of.assumed,
        better=of.better,
        kind=of.kind,
        tested=True,
        seconds=seconds,
        better_seconds=None if of.kind == "value" else better,
        saving=None if of.kind == "value" else better / max(seconds, 1e-9),
        equal_motion=_worst([each.motion for each in comparisons]),
        equal_force=_worst([each.force for each in comparisons]),
        verdict=verdict,
        advice=advice,
        comparisons=tuple(_comparison(each) for each in comparisons),
        along_z=None if along_z is None else _along(along_z),
    )


def untested_row(of: Assumption, reason: str) -> Row:
    """The row of an assumption that could not be tested."""
    advice = f"Not tested: {reason}."
    return Row(of.key, of.title, of.assumed, of.better, of.kind, False, reason, advice=advice)


def rows_csv(validation: Validation) -> str:
    """A row for each assumption at equal motion and at equal force; empty where there is none."""
    header = ["assumption", "at", "tested", "verdict", "seconds", "better_seconds", "saving"]
    header += [f"{name}_{which}" for name in QUANTITIES for which in ("greatest", "median")]
    header += ["rows", "rows_left_out", "advice"]
    return csv_text(header, (_cells(row, name) for row in validation.rows for name in SIDES))


def _cells(row: Row, name: str) -> list[Any]:
    side = getattr(row, name)
    cells = [row.key, name, row.tested, row.verdict, row.seconds, row.better_seconds, row.saving]
    for quantity in QUANTITIES:
        found = side["errors"][quantity] if side else None
        cells += [found["greatest"], found["median"]] if found else [None, None]
    return [*cells, *([side["rows"], side["rows_left_out"]] if side else [None, None]), row.advice]


def _comparison(of: Comparison) -> dict[str, Any]:
    return {
        "label": of.label,
        "assumed": _answer(of.assumed),
        "better": _answer(of.better),
        "equal_motion": None if of.motion is None else _side(of.motion),
        "equal_force": None if of.force is None else _side(of.force),
        "missing": list(of.missing),
    }


def _answer(of: Answer) -> dict[str, Any]:
    return {
        "model": of.name,
        "dimension": of.dimension,
        "dofs": of.dofs,
        "seconds": of.seconds,
        "normal_force_N": of.readings.normal_force.tolist(),
        "tangential_force_N": of.readings.tangential_force.tolist(),
        "contact_width_mm": of.readings.contact_width.tolist(),
        "stick_ratio": of.readings.stick_ratio.tolist(),
        "gages_microstrain": of.readings.reading.tolist(),
    }


def _side(of: Side) -> dict[str, Any]:
    return {
        "rows": of.rows,
        "rows_left_out": of.left_out,
        "note": of.note,
        "errors": {
            name: found and {"greatest": found.greatest, "median": found.median}
            for name, found in of.errors.items()
        },
        "gages": list(of.gages),
    }


def _worst(sides: list[Side | None]) -> dict[str, Any] | None:
    """The worst of each number over several comparisons."""
    reported = [_side(side) for side in sides if side is not None]
    if not reported:
        return None
    return {
        "rows": min(each["rows"] for each in reported),
        "rows_left_out": max(each["rows_left_out"] for each in reported),
        "note": "; ".join(dict.fromkeys(each["note"] for each in reported if each["note"])),
        "errors": {
            name: _worst_spread([each["errors"][name] for each in reported]) for name in QUANTITIES
        },
        "gages": [
            max(values) for values in zip(*(each["gages"] for each in reported), strict=True)
        ],
    }


def _worst_spread(spreads: list[dict[str, float] | None]) -> dict[str, float] | None:
    reported = [each for each in spreads if each is not None]
    if not reported:
        return None
    return {which: max(each[which] for each in reported) for which in ("greatest", "median")}


def _along(of: AlongZ) -> tuple[dict[str, Any], ...]:
    return tuple(
        {
            "z_mm": place,
            "greatest": gage.greatest,
            "median": gage.median,
            "gages": list(side.gages),
        }
        for place, side in zip(of.z_mm, of.sides, strict=True)
        if (gage := side.errors["gage"]) is not None
    )
