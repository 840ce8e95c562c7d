"""What mold_report.json holds: the mold as made, its checks, its files."""

from __future__ import annotations

import hashlib
import json
import math
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import ConfigDict, Field, with_config
from typing_extensions import TypedDict

from fingerdesign.analysis.summary import versions
from fingerdesign.mold.plan.plan import Side, limits_of
from fingerdesign.records.base import Count, Size, closed, json_text, plain
from fingerdesign.version import __version__

if TYPE_CHECKING:
    from collections.abc import Sequence

    from fingerdesign.design.schema import Design
    from fingerdesign.mold.part import Check, PartMesh
    from fingerdesign.mold.plan.plan import MoldPlan
    from fingerdesign.mold.products.bill import Item, Silicone
    from fingerdesign.mold.products.flat_pattern import FlatPattern
    from fingerdesign.mold.products.notes import Notes
    from fingerdesign.mold.products.three_mf import Posed

SCHEMA_VERSION = 1
RECORD_FILE = "mold_report.json"
_PACKAGES = ("manifold3d", "lib3mf", "ezdxf", "pyvista")
MICRO = 9  # decimals of mm that a record keeps


Vector = Annotated[list[float], Field(min_length=3, max_length=3)]


@closed
class LimitsData(TypedDict):
    """What the process can make."""

    wall_mm: Size
    feature_mm: Size
    hole_mm: Size
    slot_mm: Size
    clearance_mm: Size
    pin_mm: Size
    tolerance_mm: Size


@closed
class ProcessData(TypedDict):
    """How the mold is made."""

    name: Literal["sla", "fdm", "machined"]
    cure: Literal["platinum", "condensation"]
    plate_fixture: Literal["comb", "jig", "slots"]
    draft_deg: Size
    chord_mm: Size
    limits: LimitsData
    comb: dict[str, Size]


@closed
class PrintData(TypedDict):
    """A part as it lies in mold.3mf."""

    down: Vector
    flat_area_mm2: Size
    size_mm: Vector


@closed
class PartData(TypedDict):
    """A part: where it comes off, its size in the mold, and how it lies on the printer's bed."""

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
    print: PrintData | None
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
    """Where a plate stands in the mold."""

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
    """How a side is closed, and how many plates it holds."""

    side: Side
    holding: Literal["wall", "comb", "jig", "slots"]
    slots: Count
    narrowest_slot_mm: Size | None
    shim_mm: Size
    sheet_mm: Size | None
    shift_mm: float | None


@closed
class HoleData(TypedDict):
    """A hole of the base plate, seen from its back: x to the right, z up."""

    kind: Literal["gate", "riser", "vent", "lock", "screw"]
    x_mm: float
    z_mm: float
    diameter_mm: Annotated[Size, Field(description="inside, at the finger")]
    outer_diameter_mm: Annotated[Size, Field(description="at the plate's back")]


@closed
class BaseData(TypedDict):
    """The base plate's half sizes, the finger's on it, and its holes."""

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


@closed
class SiliconeData(TypedDict):
    """What has to be mixed, and of what that consists."""

    finger_cm3: Size
    locks_cm3: Size
    gate_risers_vents_cm3: Size
    flash_cm3: Size
    excess: Size
    mixed_cm3: Size
    density_g_cm3: Size
    mass_g: Size
    sentence: str


@with_config(ConfigDict(extra="allow"))
class EffectData(TypedDict):
    """What a plate off its place does to its gage; its numbers are there where reason is null."""

    reason: str | None
    sentences: list[str]


@closed
class NotesData(TypedDict):
    """A section of the casting notes."""

    title: str
    steps: list[str]


@closed
class ItemData(TypedDict):
    """A row of the bill of materials."""

    item: str
    count: Count
    made: str
    material: str
    size: str
    mass_g: Size | None
    files: str


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
    warnings: list[str]
    notes: list[NotesData]
    bill: list[ItemData]
    files: Annotated[list[str], Field(description="names beside the record")]
    timings_s: dict[str, Size]
    seconds: Size
    peak_memory_MB: Size
    versions: dict[str, str]


@dataclass(frozen=True)
class MoldReport:
    """The record of one `fingerdesign mold`: plain values, ready to write.

    status is "ok" where every check passed; ``failure`` is the sentence of what could not be built
    (then there are no parts), or names the checks that failed. files: names beside the record.
    """

    design: str
    digest: str
    failure: str | None
    process: dict[str, Any]
    shrinkage: float
    scale: float | None
    parts: tuple[dict[str, Any], ...]
    plates: tuple[dict[str, Any], ...]
    placements: tuple[dict[str, Any], ...]
    fixture: tuple[dict[str, Any], ...]
    base: dict[str, Any]
    checks: tuple[dict[str, Any], ...]
    silicone: dict[str, Any] | None
    placement: dict[str, Any] | None
    warnings: tuple[str, ...]
    notes: tuple[dict[str, Any], ...]
    bill: tuple[dict[str, Any], ...]
    files: tuple[str, ...]
    timings_s: dict[str, float]
    seconds: float
    peak_memory_MB: float
    design_digest: str = ""
    versions: dict[str, str] = field(default_factory=dict)

    @property
    def status(self) -> str:
        """ "ok", or "failed": then see ``failure``."""
        return "ok" if self.failure is None else "failed"

    @property
    def failing(self) -> tuple[dict[str, Any], ...]:
        """The checks that did not pass."""
        return tuple(check for check in self.checks if not check["ok"])

    def data(self) -> dict[str, Any]:
        """As in the file."""
        values = plain(
            {name: getattr(self, name) for name in self.__dataclass_fields__}, decimals=MICRO
        )
        head = {name: values.pop(name) for name in ("design", "digest", "design_digest")}
        failure = values.pop("failure")
        return {
            "schema_version": SCHEMA_VERSION,
            **head,
            "status": self.status,
            "failure": failure,
            **values,
        }

    def to_json(self) -> str:
        """The text of mold_report.json."""
        return json_text(self.data())


def write_record(report: MoldReport, folder: Path) -> Path:
    """mold_report.json into a folder that exists."""
    path = folder / RECORD_FILE
    path.write_text(report.to_json(), encoding="utf-8")
    return path


def mold_digest(design: Design) -> str:
    """SHA-256 over the finger, its [mold] table and this package's version, in hexadecimal."""
    table = json.dumps(design.mold.model_dump(mode="json"), sort_keys=True)
    return hashlib.sha256("\n".join((design.digest(), table, __version__)).encode()).hexdigest()


def mold_versions() -> dict[str, str]:
    """Versions of this package and of what builds, checks and writes molds."""
    from importlib import metadata

    return versions() | {name: metadata.version(name) for name in _PACKAGES}


def process_data(design: Design) -> dict[str, Any]:
    """The process, its limits and the options of the [mold] table."""
    mold = design.mold
    limits = asdict(limits_of(mold))
    limits.pop("name")
    return {
        "name": mold.process,
        "cure": mold.cure,
        "plate_fixture": mold.plate_fixture,
        "draft_deg": mold.draft_deg,
        "chord_mm": mold.chord_mm,
        "limits": limits,
        "comb": mold.comb.model_dump(mode="json"),
    }


def part_data(part: PartMesh, number: int, posed: Posed | None, files: Sequence[str]) -> Any:
    """A part: where it comes off, its size in the mold, and how it lies on the printer's bed."""
    return {
        "number": number,
        "name": part.name,
        "made": part.made,
        "draw": None if part.draw is None else list(part.draw),
        "order": part.order,
        "size_mm": np.ptp(part.vertices, axis=0).tolist(),
        "volume_mm3": part.volume,
        "vertices": len(part.vertices),
        "triangles": len(part.triangles),
        "chord_mm": part.chord,
        "print": None
        if posed is None
        else {"down": list(posed.down), "flat_area_mm2": posed.flat_area, "size_mm": posed.size},
        "files": list(files),
    }


def pattern_data(pattern: FlatPattern, files: Sequence[str]) -> dict[str, Any]:
    """A different plate, as cut: how many of it, its size with legs, its bend."""
    wide, long = np.ptp(pattern.outline, axis=0).tolist()
    return {
        "name": pattern.name,
        "plates": list(pattern.plates),
        "count": len(pattern.plates),
        "material": pattern.material,
        "thickness_mm": pattern.thickness,
        "width_mm": wide,
        "length_mm": long,
        "bend_radius_mm": pattern.bend_radius,
        "files": list(files),
    }


def placement_rows(plan: MoldPlan, patterns: Sequence[FlatPattern]) -> tuple[dict[str, Any], ...]:
    """Where each plate stands in the mold, mm from the finger's axes, and which pattern it has."""
    names = {plate: pattern.name for pattern in patterns for plate in pattern.plates}
    sides: dict[int, list[str]] = {frame.index: [] for frame in plan.frames}
    for side in plan.sides:
        for slot in side.slots:
            sides[slot.plate].append(side.side)
    return tuple(
        {
            "plate": frame.index,
            "pattern": names.get(frame.index, ""),
            "x_mm": frame.x,
            "y_mm": frame.y,
            "z_mm": frame.z,
            "along": frame.along,
            "angle_deg": frame.angle_deg,
            "span_mm": frame.span,
            "held_at": sides[frame.index],
        }
        for frame in plan.frames
    )


def fixture_data(plan: MoldPlan) -> tuple[dict[str, Any], ...]:
    """How each side is closed, and how many plates it holds."""
    return tuple(
        {
            "side": side.side,
            "holding": side.holding,
            "slots": len(side.slots),
            "narrowest_slot_mm": min((slot.width for slot in side.slots), default=None),
            "shim_mm": max((slot.shim for slot in side.slots), default=0.0),
            "sheet_mm": side.sheet if side.holding in ("comb", "jig") else None,
            "shift_mm": side.shift if side.holding == "jig" else None,
        }
        for side in plan.sides
    )


def base_data(plan: MoldPlan) -> dict[str, Any]:
    """The base plate's half sizes, the finger's on it, and its holes, mm from the finger's axes."""
    return {
        "half_x_mm": plan.reach_x,
        "half_z_mm": plan.reach_z,
        "finger_half_x_mm": plan.half_width,
        "finger_half_z_mm": plan.half_depth,
        "holes": [
            {
                "kind": hole.kind,
                "x_mm": hole.x,
                "z_mm": hole.z,
                "diameter_mm": hole.diameter,
                "outer_diameter_mm": hole.outer_diameter,
            }
            for hole in plan.base_holes
        ],
    }


def silicone_data(silicone: Silicone) -> dict[str, Any]:
    """What has to be mixed, and of what that consists."""
    return {
        "finger_cm3": 1e-3 * silicone.rubber,
        "locks_cm3": 1e-3 * silicone.locks,
        "gate_risers_vents_cm3": 1e-3 * silicone.openings,
        "flash_cm3": 1e-3 * silicone.flash,
        "excess": silicone.excess,
        "mixed_cm3": silicone.mixed_cm3,
        "density_g_cm3": silicone.density_g_cm3,
        "mass_g": silicone.mass_g,
        "sentence": silicone.sentence,
    }


def checks_data(checks: Sequence[Check]) -> tuple[dict[str, Any], ...]:
    """Checks as plain values; a measure that is not finite is null (its sentence says why)."""
    rows = []
    for check in checks:
        row = asdict(check)
        for key in ("measured", "bound"):
            value = row[key]
            row[key] = None if value is None or not math.isfinite(value) else float(value)
        row["ok"] = bool(check.ok)
        rows.append(row)
    return tuple(rows)


def notes_data(notes: Sequence[Notes]) -> tuple[dict[str, Any], ...]:
    """The casting notes: sections of steps."""
    return tuple({"title": each.title, "steps": list(each.steps)} for each in notes)


def bill_data(items: Sequence[Item]) -> tuple[dict[str, Any], ...]:
    """The bill of materials, a row an item."""
    return tuple(asdict(item) for item in items)
