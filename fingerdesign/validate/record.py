"""Records of validate.json and validate.csv. Errors are parts of one."""

from dataclasses import asdict, dataclass
from typing import Annotated, Any, Literal

from pydantic import Field
from typing_extensions import TypedDict

from fingerdesign.analysis.fidelity.readings import QUANTITIES
from fingerdesign.records.base import Count, Size, closed, csv_text, json_text, plain

RECORD_FILE = "validate.json"
CSV_FILE = "validate.csv"
SIDES = ("equal_motion", "equal_force")

Kind = Literal["model", "value", "reading"]
Verdict = Literal["keep", "limited", "drop", "measure", "not tested"]


@closed
@dataclass(frozen=True)
class Spread:
    """Parts of one, over the path."""

    greatest: Size
    median: Size


@closed
class Errors(TypedDict):
    """Errors of each quantity; null: prescribed, or cannot differ."""

    normal_force: Spread | None
    tangential_force: Spread | None
    contact_width: Spread | None
    stick_ratio: Spread | None
    gage: Spread | None


@closed
@dataclass(frozen=True)
class Side:
    """Two models at equal motion, or at equal force."""

    rows: Count
    rows_left_out: Count
    note: str
    errors: Errors
    gages: Annotated[tuple[Size, ...], Field(description="greatest of each gage")]

    def spread(self, quantity: str) -> Spread | None:
        """The errors of a quantity; None where it has none."""
        found: Spread | None = self.errors[quantity]  # type: ignore[literal-required]
        return found


@closed
@dataclass(frozen=True)
class AnswerData:
    """Answer of one model, a value a row of the path."""

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
@dataclass(frozen=True)
class ComparisonData:
    """Two models; a side is null where it cannot be had, and ``missing`` says why."""

    label: str
    assumed: AnswerData
    better: AnswerData
    equal_motion: Side | None
    equal_force: Side | None
    missing: tuple[str, ...]


@closed
@dataclass(frozen=True)
class Row:
    """One assumption.

    seconds, better_seconds: of the comparison that costs most; saving: their ratio (both None for a
    value: another one costs the same). equal_motion, equal_force: the worst over all comparisons;
    None where nothing could be compared.
    """

    assumption: str
    title: str
    assumed: str
    better: str
    kind: Kind
    tested: bool
    reason: Annotated[str | None, Field(description="why it was not tested")]
    seconds: Size | None
    better_seconds: Size | None
    saving: Size | None
    equal_motion: Side | None
    equal_force: Side | None
    verdict: Verdict
    advice: str
    comparisons: tuple[ComparisonData, ...]

    def greatest(self, side: str, quantity: str) -> float | None:
        """The greatest error of a quantity at "equal_motion" or "equal_force"; None: no error."""
        found: Side | None = getattr(self, side)
        spread = None if found is None else found.spread(quantity)
        return None if spread is None else spread.greatest


@closed
@dataclass(frozen=True)
class Thresholds:
    """Errors up to which an assumption is good, or good within limits."""

    keep: Size
    limit: Size


THRESHOLDS = Thresholds(keep=0.02, limit=0.10)


@closed
@dataclass(frozen=True)
class Validation:
    """The content of validate.json: one `fingerdesign validate`."""

    schema_version: Literal[1]
    design: str
    scene: str
    digest: str
    status: Annotated[Literal["ok", "failed"], Field(description="failed: see failure")]
    failure: Annotated[str | None, Field(description="a model failed and no row was reported")]
    deep: bool
    gages: Count
    thresholds: Thresholds
    assumptions: tuple[Row, ...]
    seconds: Size
    peak_memory_MB: Size
    versions: dict[str, str]

    def row(self, key: str) -> Row:
        """The row of an assumption. KeyError where there is none."""
        return {row.assumption: row for row in self.assumptions}[key]

    def data(self) -> dict[str, Any]:
        found: dict[str, Any] = plain(asdict(self))
        return found

    def to_json(self) -> str:
        return json_text(self.data())

    def to_csv(self) -> str:
        """A row for each assumption at equal motion and at equal force; empty: there is none."""
        header = ["assumption", "at", "tested", "verdict", "seconds", "better_seconds", "saving"]
        header += [f"{name}_{which}" for name in QUANTITIES for which in ("greatest", "median")]
        header += ["rows", "rows_left_out", "advice"]
        return csv_text(header, (_cells(row, name) for row in self.assumptions for name in SIDES))


def _cells(row: Row, at: str) -> list[Any]:
    cells = [row.assumption, at, row.tested, row.verdict]
    cells += [row.seconds, row.better_seconds, row.saving]
    side: Side | None = getattr(row, at)
    for quantity in QUANTITIES:
        found = None if side is None else side.spread(quantity)
        cells += [found.greatest, found.median] if found else [None, None]
    return [*cells, *([side.rows, side.rows_left_out] if side else [None, None]), row.advice]


def _worst_spread(sides: list[Side], name: str) -> Spread | None:
    every = [spread for side in sides if (spread := side.spread(name)) is not None]
    if not every:
        return None
    return Spread(max(each.greatest for each in every), max(each.median for each in every))


def worst_side(sides: list[Side | None]) -> Side | None:
    """The worst of each number over several comparisons."""
    found = [side for side in sides if side is not None]
    if not found:
        return None
    errors: Any = {name: _worst_spread(found, name) for name in QUANTITIES}
    return Side(
        rows=min(side.rows for side in found),
        rows_left_out=max(side.rows_left_out for side in found),
        note="; ".join(dict.fromkeys(side.note for side in found if side.note)),
        errors=errors,
        gages=tuple(max(each) for each in zip(*(side.gages for side in found), strict=True)),
    )
