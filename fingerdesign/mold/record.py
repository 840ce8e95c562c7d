"""Content of mold_report.json: the mold as made, its checks, its files."""

import hashlib
import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, with_config
from typing_extensions import TypedDict

from fingerdesign.design.schema import Design
from fingerdesign.layout.fitting import GageFit
from fingerdesign.mold.part import Check, PartMesh
from fingerdesign.mold.plan.limits import comb_tolerance
from fingerdesign.mold.plan.patterns import FlatPattern
from fingerdesign.mold.plan.pieces import Side, SidePlan
from fingerdesign.mold.plan.plan import MoldPlan
from fingerdesign.mold.products.bill import ItemData
from fingerdesign.mold.products.casting import Casting, SiliconeData
from fingerdesign.mold.products.hours import HoursData, hours_of
from fingerdesign.mold.products.notes import warnings_of
from fingerdesign.mold.profile import ladders_of
from fingerdesign.mold.ready import sensor_of
from fingerdesign.records.base import Count, Size, closed, plain, values_of
from fingerdesign.runtime.machine import largest_memory_MB
from fingerdesign.version import __version__, versions

RECORD_FILE = "mold_report.json"
_PACKAGES = ("manifold3d", "lib3mf", "ezdxf", "pyvista")
MICRO = 9  # decimals of mm that a record keeps


Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


@closed
class LimitsData(TypedDict):
    """Sizes that the process can make."""

    wall_mm: Size
    feature_mm: Size
    hole_mm: Size
    slot_mm: Size
    clearance_mm: Size
    pin_mm: Size
    tolerance_mm: Size
    form_mm: Size


@closed
class ProcessData(TypedDict):
    """The process and the kind of mold."""

    name: Literal["sla", "fdm", "machined"]
    pour: Annotated[Literal["open", "closed"], Field(description="open: of the fewest parts")]
    closed_for: Annotated[str, Field(description="why it is not an open one; empty: it is")]
    cure: Literal["platinum", "condensation"]
    plate_fixture: Literal["comb", "slots"]
    draft_deg: Size
    chord_mm: Size
    limits: LimitsData
    comb: dict[str, Size]


@closed
class PartData(TypedDict):
    """A part: where it comes off, and its size in the mold."""

    number: Count
    name: str
    made: Literal["process", "sheet", "metal", "silicone"]
    draw: Annotated[Vector | None, Field(description="null: it stays with the finger")]
    order: Annotated[int, Field(description="lower ones are taken off before")]
    size_mm: Vector
    volume_mm3: Size
    vertices: Count
    triangles: Count
    chord_mm: Annotated[Size, Field(description="greatest distance to the exact surface")]
    files: list[str]


@closed
class PatternData(TypedDict):
    """A different plate, as cut."""

    name: str
    plates: list[Count]
    count: Count
    material: str
    thickness_mm: Size
    width_mm: Size
    length_mm: Annotated[Size, Field(description="with legs")]
    bend_radius_mm: Size | None
    files: list[str]


@closed
class PlacedData(TypedDict):
    """A plate's place in the mold."""

    plate: Count
    pattern: str
    x_mm: float
    y_mm: float
    z_mm: float
    along: Literal["x", "z"]
    angle_deg: float
    span_mm: Size
    held_at: list[Side]


@closed
class FixtureData(TypedDict):
    """A side: its way of holding plates, and how many it holds."""

    side: Side
    holding: Literal["wall", "comb", "slots"]
    slots: Count
    narrowest_slot_mm: Size | None
    sheet_mm: Size | None
    held_over_mm: Annotated[
        Size, Field(description="of a leg, from the finger's face to where it is last held")
    ]
    pushed: Annotated[bool, Field(description="by a second comb, so that no play counts")]


@closed
class LadderData(TypedDict):
    """A row of the test coupon, and what of it is a key's value."""

    key: Annotated[str, Field(description="of [mold.limits]")]
    kind: Literal["slot", "hole", "wall", "rib", "pin", "socket"]
    sizes_mm: Annotated[list[Size], Field(description="along the row; of a socket: its clearance")]
    measure: str


@closed
class HoleData(TypedDict):
    """A hole of the base plate, seen from its back: x to the right, z up."""

    kind: Literal["gate", "riser", "vent", "lock", "screw", "wires"]
    x_mm: float
    z_mm: float
    diameter_mm: Annotated[Size, Field(description="inside, at the finger")]
    outer_diameter_mm: Annotated[Size, Field(description="at the plate's back")]


@closed
class BaseData(TypedDict):
    """Half sizes of the base plate, the finger's mount, and of the finger on it; its holes."""

    half_x_mm: Size
    half_z_mm: Size
    finger_half_x_mm: Size
    finger_half_z_mm: Size
    holes: list[HoleData]


@closed
class CheckData(TypedDict):
    """A check; a measure that is not finite is null (its sentence says why)."""

    name: str
    part: Annotated[str, Field(description="empty: the mold as a whole")]
    ok: bool
    measured: float | None
    bound: float | None
    unit: str
    sentence: str


@with_config(ConfigDict(extra="allow"))
class EffectData(TypedDict):
    """Effect of a plate off its place on its gage; its numbers are there where reason is null."""

    reason: str | None
    sentences: list[str]


@closed
class SensorData(TypedDict):
    """Readiness as a sensor: gages that exist, where the model has them."""

    ready: bool
    reading_error: Annotated[
        Size | None, Field(description="worst change of a reading by placement, share; null: n/a")
    ]
    lead_error: Annotated[
        Size | None, Field(description="worst change of a reading by leads, share; null: n/a")
    ]
    gage: Annotated[str | None, Field(description="the type that fits the plates; null: none")]
    to_measure: Annotated[bool, Field(description="it is made by order; false: sold from stock")]
    reasons: Annotated[list[str], Field(description="why it is not ready")]
    fix: Annotated[list[str], Field(description="lines for the design that make it ready")]


@closed
class NotesData(TypedDict):
    """A section of the casting notes."""

    title: str
    steps: list[str]


@closed
class MoldData(TypedDict):
    """The content of mold_report.json."""

    schema_version: Literal[1]
    design: str
    digest: Annotated[str, Field(description="of finger, [mold] table and program")]
    design_digest: Annotated[str, Field(description="of the finger alone, as in results")]
    status: Annotated[Literal["ok", "failed"], Field(description="failed: see failure")]
    failure: Annotated[str | None, Field(description="what could not be built or failed")]
    process: ProcessData
    shrinkage: Annotated[Size, Field(description="linear, of the rubber, share")]
    scale: Annotated[Size, Field(description="of the cavity over the finger")]
    parts: list[PartData]
    plates: list[PatternData]
    placements: list[PlacedData]
    fixture: list[FixtureData]
    base: BaseData
    checks: list[CheckData]
    silicone: SiliconeData | None
    placement: EffectData | None
    leads: EffectData | None
    sensor: SensorData
    warnings: list[str]
    notes: list[NotesData]
    coupon: list[LadderData]
    bill: list[ItemData]
    hours: list[HoursData]
    files: Annotated[list[str], Field(description="names next to the record")]
    timings_s: dict[str, Size]
    seconds: Size
    peak_memory_MB: Size
    versions: dict[str, str]


@dataclass
class Outcome:
    """Facts of a mold that are known while it is made.

    fit       of a gage type to the plates; None without plates
    casting   None where nothing could be built, and then ``broken`` says why
    items     of the bill of materials; notes: to the caster
    """

    plan: MoldPlan
    fit: GageFit | None
    checks: tuple[Check, ...] = ()
    casting: Casting | None = None
    items: tuple[ItemData, ...] = ()
    notes: Sequence[Mapping[str, Any]] = ()
    placement: dict[str, Any] | None = None
    leads: dict[str, Any] | None = None
    broken: str | None = None


def failure_of(checks: tuple[Check, ...]) -> str | None:
    """Name the checks that failed, in a sentence; None where all passed.

    >>> failure_of((Check("wall", "core", False, 0.5, 1.0, "mm", "its wall is 0.5 mm"),))
    '1 of 1 check failed: wall (core)'
    """
    failed = [check for check in checks if not check.ok]
    if not failed:
        return None
    names = [f"{check.name} ({check.part})" if check.part else check.name for check in failed]
    more = f" and {len(names) - 6} more" if len(names) > 6 else ""
    whole = f"{len(checks)} check{'' if len(checks) == 1 else 's'}"
    return f"{len(failed)} of {whole} failed: {', '.join(names[:6])}{more}"


def mold_record(
    outcome: Outcome, files: list[str], timings_s: Mapping[str, float], seconds: float
) -> MoldData:
    """Write the record of one `fingerdesign mold`; files: names next to the record."""
    plan, placement, casting = outcome.plan, outcome.placement, outcome.casting
    design = plan.design
    made = (casting.meshes.parts, casting.patterns, hours_of(casting)) if casting else ((), (), ())
    parts, patterns, hours = made
    failure = "; ".join(filter(None, (outcome.broken, failure_of(outcome.checks)))) or None
    record: MoldData = plain(
        {
            "schema_version": 1,
            "design": design.design.name,
            "digest": mold_digest(design),
            "design_digest": design.digest(),
            "status": "ok" if failure is None else "failed",
            "failure": failure,
            "process": _process(plan),
            "shrinkage": design.mold.shrinkage_used,
            "scale": plan.scale,
            "parts": [_part(part, number, files) for number, part in enumerate(parts, start=1)],
            "plates": [_pattern(pattern, files) for pattern in patterns],
            "placements": _placements(plan, patterns),
            "silicone": casting and casting.silicone,
            "fixture": [_fixture(plan, side) for side in plan.sides],
            "base": _base(plan),
            "checks": [
                asdict(check) | {"measured": _finite(check.measured), "bound": _finite(check.bound)}
                for check in outcome.checks
            ],
            "placement": placement,
            "leads": outcome.leads,
            "sensor": sensor_of(design, outcome.fit, placement, outcome.leads),
            "warnings": warnings_of(plan, placement) if placement else [],
            "notes": outcome.notes,
            "coupon": [values_of(LadderData, each) for each in ladders_of(plan.limits)],
            "bill": outcome.items,
            "hours": hours,
            "files": files,
            "timings_s": dict(timings_s),
            "seconds": seconds,
            "peak_memory_MB": largest_memory_MB(),
            "versions": versions() | {name: metadata.version(name) for name in _PACKAGES},
        },
        decimals=MICRO,
    )
    return record


def _process(plan: MoldPlan) -> dict[str, Any]:
    mold = plan.design.mold
    return values_of(
        ProcessData,
        mold,
        name=mold.process,
        pour=plan.pour,
        closed_for=plan.closed_for,
        limits=values_of(LimitsData, plan.limits),
        comb=mold.comb.model_dump(mode="json") | {"tolerance_mm": comb_tolerance(mold)},
    )


def mold_digest(design: Design) -> str:
    """SHA-256 over the finger, its [mold] table and this package's version, in hexadecimal."""
    table = json.dumps(design.mold.model_dump(mode="json"), sort_keys=True)
    return hashlib.sha256("\n".join((design.digest(), table, __version__)).encode()).hexdigest()


def _part(part: PartMesh, number: int, files: list[str]) -> dict[str, Any]:
    return values_of(
        PartData,
        part,
        number=number,
        size_mm=np.ptp(part.vertices, axis=0),
        vertices=len(part.vertices),
        triangles=len(part.triangles),
        files=_files_of(part.name, files),
    )


def _pattern(pattern: FlatPattern, files: list[str]) -> dict[str, Any]:
    wide, long = np.ptp(pattern.outline, axis=0)
    files = _files_of(pattern.name, files)
    return values_of(PatternData, pattern, width_mm=wide, length_mm=long, files=files)


def _files_of(name: str, files: list[str]) -> list[str]:
    return [file for file in files if file in {f"{name}.{kind}" for kind in ("stl", "step", "dxf")}]


def _placements(plan: MoldPlan, patterns: Sequence[FlatPattern]) -> list[dict[str, Any]]:
    names = {plate: pattern.name for pattern in patterns for plate in pattern.plates}
    return [
        values_of(
            PlacedData,
            frame,
            plate=frame.index,
            pattern=names.get(frame.index, ""),
            held_at=plan.held_at.get(frame.index, []),
        )
        for frame in plan.frames
    ]


def _fixture(plan: MoldPlan, side: SidePlan) -> dict[str, Any]:
    over = {"wall": 0.0, "comb": side.sheet, "slots": plan.wall(side.side)}[side.holding]
    if side.outer:
        over = plan.wall(side.side) + side.sheet
    return values_of(
        FixtureData,
        side,
        slots=len(side.slots),
        narrowest_slot_mm=min((min(slot.width, slot.length) for slot in side.slots), default=None),
        sheet_mm=side.sheet or None,
        held_over_mm=over,
        pushed=side.outer is not None,
    )


def _base(plan: MoldPlan) -> dict[str, Any]:
    return {
        "half_x_mm": plan.mount_x,
        "half_z_mm": plan.mount_z,
        "finger_half_x_mm": plan.half_width,
        "finger_half_z_mm": plan.half_depth,
        "holes": [values_of(HoleData, hole) for hole in plan.base_holes],
    }


def _finite(value: float | None) -> float | None:
    return None if value is None or not math.isfinite(value) else float(value)
