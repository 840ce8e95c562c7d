"""Sizes that a machine and a cutter hold, as a file, and the coupon that measures them.

The file is written next to each mold, to be corrected by what the coupon shows; ``--profile`` reads
it.
"""

from dataclasses import dataclass, replace
from itertools import groupby, pairwise
from pathlib import Path
from typing import Literal

from fingerdesign.checks.load import with_values
from fingerdesign.design.io import parse_toml, read_text
from fingerdesign.design.mold import Comb, MoldLimits
from fingerdesign.design.schema import Design
from fingerdesign.errors import DesignError, Fault
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.mold.plan.limits import Limits, comb_tolerance, limits_of
from fingerdesign.mold.plan.plan import MoldPlan

PROFILE_FILE = "profile.toml"
_KEYS = ("process", "limits", "comb")
_TABLES = "give process, [limits] or [comb]; all else of a mold is its design's"
_HEAD = """\
# What this mold was planned with, mm. Make the coupon, measure it row by row, correct the values
# here, and plan the mold again: fingerdesign mold DESIGN --profile FILE
"""
SPACER_MM = 12.0  # wide, under the mold on the bench
AROUND_MM = 2.0  # rubber around the cell's plates; how far a comb lies in its groove
STEPS = (0.5, 0.7, 1.0, 1.4, 2.0)  # sizes of a row of the coupon, of what the process is taken for


@dataclass(frozen=True)
class Ladder:
    """One row of the coupon: one kind of feature in sizes (mm, rising) around what the process is
    taken to hold. key: of ``[mold.limits]``. measure: what of the row is the key's value."""

    key: str
    kind: Literal["slot", "hole", "wall", "rib", "pin", "socket"]
    sizes: tuple[float, ...]
    measure: str


def ladders_of(limits: Limits) -> tuple[Ladder, ...]:
    """The rows of the coupon, in their order on it.

    >>> from fingerdesign.design.mold import Mold
    >>> [ladder.sizes for ladder in ladders_of(limits_of(Mold())) if ladder.kind == "slot"]
    [(0.25, 0.35, 0.5, 0.7, 1.0)]
    """

    def sizes(value: float) -> tuple[float, ...]:
        return tuple(round(step * value, 3) for step in STEPS)

    found = [
        Ladder("slot_mm", "slot", sizes(limits.slot_mm), "the least that is open throughout"),
        Ladder("hole_mm", "hole", sizes(limits.hole_mm), "the least that is open throughout"),
        Ladder("wall_mm", "wall", sizes(limits.wall_mm), "the least that is straight"),
        Ladder("feature_mm", "rib", sizes(limits.feature_mm), "the least that is whole"),
    ]
    if not limits.dowels:
        found.append(Ladder("pin_mm", "pin", sizes(limits.pin_mm), "the least that stays on"))
    if limits.clearance_mm > 0.0:
        by = "a steel dowel" if limits.dowels else "coupon_pin"
        what = f"the least into which {by} slides"
        found.append(Ladder("clearance_mm", "socket", sizes(limits.clearance_mm), what))
    return tuple(found)


def cell_plates(plan: MoldPlan) -> tuple[PlateFrame, ...]:
    """Two neighbouring plates that leave through the same sides, combs before slots, in the middle
    of those that do; of a finger with one plate that leaves, that one. Empty: there are none."""
    combed = {slot.plate for side, slot, _ in plan.leg_slots if side.comb}
    frames = tuple(frame for frame in plan.frames if frame.index in plan.held_at)
    alike = groupby(frames, lambda frame: (plan.held_at[frame.index], frame.along))
    pairs = [pair for _, group in alike for pair in pairwise(group)]
    pairs = [pair for pair in pairs if pair[0].index in combed] or pairs
    if pairs:
        return pairs[len(pairs) // 2]
    return frames if len(frames) == 1 else ()


def profile_text(design: Design) -> str:
    """The profile that a mold is planned with, as TOML; each key with its meaning, and with the row
    of the coupon that shows it."""
    mold = design.mold
    process = limits_of(mold)
    limits = {key: getattr(process, key) for key in MoldLimits.model_fields}
    comb = mold.comb.model_dump() | {"tolerance_mm": comb_tolerance(mold)}
    rows = {ladder.key: ladder for ladder in ladders_of(process)}
    lines = [_HEAD, f'process = "{mold.process}"']
    for name, table, values in (("limits", MoldLimits, limits), ("comb", Comb, comb)):
        lines.append(f"\n[{name}]")
        for key, field in table.model_fields.items():
            meaning = (field.description or "").partition(";")[0]
            if name == "limits" and key in rows:
                sizes = ", ".join(f"{size:g}" for size in rows[key].sizes)
                lines.append(f"# coupon, {rows[key].kind}s of {sizes}: {rows[key].measure}")
            lines.append(f"{key} = {values[key]:g}  # {meaning}")
    return "\n".join(lines) + "\n"


def with_profile(design: Design, file: Path) -> Design:
    """The design with a profile's keys in its [mold] table; DesignError with every fault of it, by
    its own keys."""
    data = parse_toml(read_text(file), str(file))
    values: dict[str, object] = {}
    faults = [] if data else [Fault("file", "no key", "a profile", _TABLES)]
    for key, value in data.items():
        inner = value if isinstance(value, dict) else {"": value}
        for name, each in inner.items():
            if key not in _KEYS or "." in name:
                faults.append(Fault(f"{key}.{name}".rstrip("."), each, "a profile's key", _TABLES))
            else:
                values[f"mold.{key}.{name}".rstrip(".")] = each
    try:
        found = with_values(design, values)
    except DesignError as error:
        own = (replace(fault, key=fault.key.removeprefix("mold.")) for fault in error.faults)
        raise DesignError([*faults, *own], str(file)) from error
    if faults:
        raise DesignError(faults, str(file))
    return found
