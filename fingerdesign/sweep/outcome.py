"""What came of one finger in a study: metrics, and the little that a comparison shows of it.

Units stand in the names; forces are those on the finger, strains microstrain. JSON in and out, NaN
never written. The standard library only.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field, is_dataclass
from typing import Any, Literal

from fingerdesign.errors import FingerDesignError

SCHEMA_VERSION = 1
_DEEPEST = 30  # of tables in tables; designs are 4 deep
MOST = 1e30  # of any number's size: sums and squares of what is shown stay finite
FailureKind = Literal["invalid", "refused", "failed", "crashed", "timeout", "memory"]
Numbers = tuple[float | None, ...]


@dataclass(frozen=True)
class Failure:
    """Why there is no result.

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
    """How far the numbers may be believed.

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
    metrics   by name (sweep/metrics.py), None where one does not apply
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
    def from_json(cls, text: str) -> Outcome:
        """Read back, strictly; :class:`OutcomeError` for what is no whole outcome."""
        from pydantic import ConfigDict, TypeAdapter, ValidationError, with_config

        try:
            adapter = TypeAdapter(with_config(ConfigDict(extra="forbid"))(cls))
            found: Outcome = adapter.validate_json(text)
        except (ValidationError, RecursionError, ValueError) as error:
            why = error.errors()[0]["msg"] if isinstance(error, ValidationError) else str(error)
            raise OutcomeError(f"no outcome: {why}") from error
        if found.schema_version != SCHEMA_VERSION:
            raise OutcomeError(f"schema version {found.schema_version}, not {SCHEMA_VERSION}")
        if (found.failure is None) != (found.status == "ok"):
            raise OutcomeError(f"no outcome: status {found.status} and failure {found.failure}")
        refuse_endless(vars(found))
        return found


class OutcomeError(FingerDesignError):
    """A text is no whole outcome."""


def bounded(number: float | None) -> bool:
    """Whether it is no number at all, or a finite one of at most ``MOST`` in size."""
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
