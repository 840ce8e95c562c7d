"""Outcome of one finger in a study: metrics, and the little that a comparison shows of it.

Units stand in the names; forces are those on the finger, strains microstrain. JSON in and out, NaN
never written; CSV for pandas and spreadsheets. The standard library only.
"""

import json
from collections.abc import Hashable, Iterable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, is_dataclass
from functools import cache
from itertools import chain, islice, zip_longest
from operator import attrgetter
from typing import Any, Literal, Self, cast

from fingerdesign.errors import FingerDesignError, cell_text
from fingerdesign.records.base import csv_text

SCHEMA_VERSION = 1
_DEEPEST = 30  # of tables in tables; designs are 4 deep
MOST = 1e30  # of any number's size: sums and squares of what is shown stay finite
# Columns of the CSV files: facts of an outcome and of its work, and the path of its scene.
OWN = ("name", "digest", "scene", "fidelity", "status")
WORK = ("seconds", "core_seconds", "peak_memory_MB")
CHECKS = ("plane_strain_error", "mesh_error")
_PATH = (
    *("approach_mm", "shear_mm", "normal_force_N", "tangential_force_N", "stick_ratio"),
    "contact_width_mm",
)
Numbers = tuple[float | None, ...]
FailureKind = Literal["invalid", "refused", "failed", "crashed", "timeout", "memory"]


@dataclass(frozen=True)
class Failure:
    """Reason why there is no result.

    kind "invalid": no finger (the design's faults); "refused": no analysis of it; "failed": the
    work ended with a reason; "crashed": its process died; "timeout"; "memory".
    """

    kind: FailureKind
    sentence: str


@dataclass(frozen=True)
class GripOutcome:
    """One grip: the result's own keys, and its path of forces, thinned to at most 60 points."""

    controller: str
    friction_coefficient: float
    object_mass_g: float
    lifted: bool
    gross_slip: bool
    safety_margin: float | None
    peak_normal_force_N: float
    minimum_stick_ratio: float | None
    normal_force_N: Numbers = ()
    tangential_force_N: Numbers = ()


@dataclass(frozen=True)
class Traces:
    """The path of the scene, increment by increment (lists of one length).

    gage_x_mm: place of each gage; gages: readings of every increment, microstrain. contact_x_mm,
    contact_z_mm (empty in plane strain): the candidate points; status: of every increment one
    character a point, "." open, "#" stick, "/" slip.
    """

    approach_mm: Numbers = ()
    shear_mm: Numbers = ()
    normal_force_N: Numbers = ()
    tangential_force_N: Numbers = ()
    stick_ratio: Numbers = ()
    contact_width_mm: Numbers = ()
    gage_x_mm: Numbers = ()
    gages: tuple[Numbers, ...] = ()
    contact_x_mm: Numbers = ()
    contact_z_mm: Numbers = ()
    status: tuple[str, ...] = ()


@dataclass(frozen=True)
class Validity:
    """Trust in the numbers.

    plane_strain_error: forecast of what plane strain overstates F_n by, a share; None where it was
    not used or no section tells. mesh_error: estimated, a share; None where not estimated.
    """

    plane_strain_error: float | None = None
    mesh_error: float | None = None
    sentences: tuple[str, ...] = ()


@dataclass(frozen=True)
class Outcome:
    """One variant of a study, analysed or failed.

    digest    of design, scene, fidelity and version: what the store keeps it by
    name      of the variant (the user's text: escape it wherever it is shown)
    values    the studied keys and their values; design: the whole design as TOML data
    metrics   by name (search/study/metrics.py), None where one does not apply
    failure   None where status is "ok"
    """

    digest: str
    name: str
    values: dict[str, Any]
    design: dict[str, Any]
    scene: str
    fidelity: str
    status: Literal["ok", "failed"]
    failure: Failure | None = None
    metrics: dict[str, float | None] = field(default_factory=dict)
    traces: Traces = Traces()
    grips: tuple[GripOutcome, ...] = ()
    validity: Validity = Validity()
    warnings: tuple[str, ...] = ()
    versions: dict[str, str] = field(default_factory=dict)
    seeds: dict[str, int] = field(default_factory=dict)
    seconds: float = 0.0
    core_seconds: float = 0.0
    peak_memory_MB: float = 0.0
    schema_version: int = SCHEMA_VERSION

    def to_json(self) -> str:
        """One line of JSON; ValueError for a number that is not finite."""
        return json.dumps(asdict(self), allow_nan=False, separators=(",", ":"))

    @classmethod
    def from_json(cls, text: str) -> Self:
        """Read back, strictly; :class:`OutcomeError` for what is no whole outcome."""
        from pydantic import ValidationError

        try:
            found: Self = _adapter(cast(Hashable, cls)).validate_json(text)
        except (ValidationError, RecursionError, ValueError) as error:
            why = error.errors()[0]["msg"] if isinstance(error, ValidationError) else str(error)
            raise OutcomeError(f"no outcome: {why}") from error
        if found.schema_version != SCHEMA_VERSION:
            raise OutcomeError(f"schema version {found.schema_version}, not {SCHEMA_VERSION}")
        if (found.failure is None) != (found.status == "ok"):
            raise OutcomeError(f"no outcome: status {found.status} and failure {found.failure}")
        refuse_endless(vars(found))
        _refuse_unequal(found)
        return found


@cache
def _adapter(kind: Hashable) -> Any:
    """The strict reader of a class; made once, in 5 ms."""
    from pydantic import ConfigDict, TypeAdapter, with_config

    return TypeAdapter(with_config(ConfigDict(extra="forbid"))(cast(type, kind)))


class OutcomeError(FingerDesignError):
    """A text is no whole outcome."""


def bounded(number: float | None) -> bool:
    """True if it is no number at all, or a finite one of at most ``MOST`` in size."""
    return number is None or abs(number) <= MOST


def refuse_endless(value: Any) -> None:
    """OutcomeError where a number in plain data or dataclasses is endless, or the data too deep."""
    level: list[Any] = [value]
    for _ in range(_DEEPEST):
        inner: list[Any] = []
        for each in level:
            if isinstance(each, int | float):
                if not bounded(each):
                    raise OutcomeError(f"no outcome: a number beyond {MOST:g} in size")
            elif isinstance(each, dict):
                inner += each.values()
            elif isinstance(each, list | tuple):
                inner += each
            elif is_dataclass(each):
                inner += vars(each).values()
        if not inner:
            return
        level = inner
    raise OutcomeError(f"no outcome: data more than {_DEEPEST} deep")


def _refuse_unequal(outcome: Outcome) -> None:
    """OutcomeError where lists that are drawn together differ in length; empty is unknown."""
    traces = outcome.traces
    along = [getattr(traces, name) for name in _PATH]
    together: dict[str, Sequence[Sequence[Any]]] = {
        "traces, increment by increment": (*along, traces.gages, traces.status),
        "traces.gages": (traces.gage_x_mm, *traces.gages),
        "traces.status": (traces.contact_x_mm, traces.contact_z_mm, *traces.status),
    }
    for number, grip in enumerate(outcome.grips):
        together[f"grips[{number}]"] = (grip.normal_force_N, grip.tangential_force_N)
    for key, lists in together.items():
        if len({len(each) for each in lists if each}) > 1:
            raise OutcomeError(f"no outcome: {key}: lists of different lengths")
    if len({len(row) for row in traces.gages}) > 1:
        raise OutcomeError("no outcome: traces.gages: an increment without readings")


def designs_csv(outcomes: Sequence[Outcome]) -> str:
    """A row an outcome, in order: facts, studied values by their keys, metrics, validity, work. A
    metric that has the name of a fact of the work (core_seconds) is written once, as the fact."""
    keys = dict.fromkeys(chain.from_iterable(each.values for each in outcomes))
    metrics = dict.fromkeys(chain.from_iterable(each.metrics for each in outcomes))
    names = [name for name in metrics if name not in WORK]
    checks = [name for name in CHECKS if name not in metrics]
    header = [*OWN, "failure_kind", "failure", *keys, *names, *checks, *WORK]
    rows = (
        [
            *attrgetter(*OWN)(outcome),
            *(vars(outcome.failure).values() if outcome.failure else ("", "")),
            *map(outcome.values.get, keys),
            *map(outcome.metrics.get, names),
            *(getattr(outcome.validity, name) for name in checks),
            *attrgetter(*WORK)(outcome),
        ]
        for outcome in outcomes
    )
    return cells_csv(header, rows)


def increments_csv(outcomes: Sequence[Outcome]) -> str:
    """A row an increment of every outcome's path, with its gages' readings, microstrain."""
    most = max((len(o.traces.gage_x_mm) for o in outcomes), default=0)
    gages = [f"gage_{number}_microstrain" for number in range(most)]
    header = ["name", "digest", "increment", *_PATH, *gages]
    return cells_csv(header, (row for outcome in outcomes for row in _increments(outcome, most)))


def grips_csv(outcomes: Sequence[Outcome]) -> str:
    """A row for each stored step of every grip: its forces, with the grip's own facts."""
    facts = ("controller", "friction_coefficient", "object_mass_g", "lifted", "gross_slip")
    forces = ("normal_force_N", "tangential_force_N")
    header = ["name", "digest", "grip", *facts, "safety_margin", "step", *forces]
    rows = (
        [
            *(outcome.name, outcome.digest, number, *(getattr(grip, fact) for fact in facts)),
            *(grip.safety_margin, step, normal, tangential),
        ]
        for outcome in outcomes
        for number, grip in enumerate(outcome.grips)
        for step, (normal, tangential) in enumerate(
            zip_longest(grip.normal_force_N, grip.tangential_force_N)
        )
    )
    return cells_csv(header, rows)


def _increments(outcome: Outcome, gages: int) -> Iterator[list[Any]]:
    traces = outcome.traces
    path = zip_longest(*(getattr(traces, name) for name in _PATH))
    for number, row in enumerate(islice(path, len(traces.normal_force_N))):
        readings = traces.gages[number] if number < len(traces.gages) else ()
        empty = [None] * (gages - len(readings))
        yield [outcome.name, outcome.digest, number + 1, *row, *readings, *empty]


def cells_csv(header: Iterable[str], rows: Iterable[Iterable[Any]]) -> str:
    """A table in which a line is one row: numbers exact, None an empty cell, plain data JSON, texts
    as of :func:`cell_text`, so that a spreadsheet takes none for a formula."""

    def cell(value: Any) -> Any:
        if value is None or isinstance(value, bool | int | float):
            return value
        return cell_text(value if isinstance(value, str) else json.dumps(value))

    return csv_text(map(cell_text, header), ([cell(value) for value in row] for row in rows))
