"""What keeps a mold's fasteners from being made: each with key, value, bound and remedy."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from fingerdesign.design.faults import at_least, at_most
from fingerdesign.errors import Fault
from fingerdesign.mold.columns import SLENDER, SPARE_MM, Columns, most_draft
from fingerdesign.mold.fasteners import (
    KEY_MM,
    insert_bolts,
    insert_pin_length,
    insert_pins,
    key_height,
    least_rim,
)
from fingerdesign.mold.walls import Walls, pin_height, z_bolt_height

if TYPE_CHECKING:
    from fingerdesign.design.mold import Mold
    from fingerdesign.mold.plan import Side
    from fingerdesign.mold.profiles import Limits

_LEAST_KEY_MM = 0.3


def limit_faults(mold: Mold, limits: Limits, reach: float) -> list[Fault]:
    """Limits that contradict each other, and plates of the mold below the process's wall; pins
    reach as far as ``reach`` into their sockets."""
    faults = []
    name = f"of mold.process = '{limits.name}'"
    given = mold.limits.model_dump(exclude_none=True)
    if limits.feature_mm > limits.wall_mm:
        remedy = "a web that can be made is no thicker than a wall that can"
        if "feature_mm" in given or "wall_mm" not in given:
            bound = f"at most mold.limits.wall_mm = {limits.wall_mm:g}"
            faults.append(Fault("mold.limits.feature_mm", limits.feature_mm, bound, remedy))
        else:
            bound = f"at least mold.limits.feature_mm = {limits.feature_mm:g}"
            faults.append(Fault("mold.limits.wall_mm", limits.wall_mm, bound, remedy))
    thick = _least_pin(mold, limits, reach)
    if limits.pin_mm < thick:
        bound = (
            f"at least {at_least(thick)}: sockets are {limits.clearance_mm:g} wider all round, and "
            f"tips at a draft of {mold.draft_deg:g} degrees at least {limits.feature_mm:g}"
        )
        remedy = "thicken the pins, or lower mold.draft_deg or mold.limits.clearance_mm"
        if "pin_mm" in given:
            faults.append(Fault("mold.limits.pin_mm", limits.pin_mm, bound, remedy))
    if limits.clearance_mm > 0.25 * limits.pin_mm and "pin_mm" not in given:
        bound = f"at most a quarter of mold.limits.pin_mm, {at_most(0.25 * limits.pin_mm)}"
        remedy = "pins in wider sockets locate nothing: lower it or take thicker pins"
        faults.append(Fault("mold.limits.clearance_mm", limits.clearance_mm, bound, remedy))
    for key, value in (("insert_mm", mold.insert_mm), ("base_mm", mold.base_mm)):
        if value < limits.wall_mm:
            bound = f"at least the least wall {name}, {at_least(limits.wall_mm)}"
            faults.append(Fault(f"mold.{key}", value, bound, "thicken it or take another process"))
    for key, hole in (("gate", mold.gate_mm), ("vent", mold.vent_mm), ("lock", mold.lock_mm)):
        if hole is not None and hole < limits.hole_mm:
            bound = f"at least the least hole {name}, {at_least(limits.hole_mm)}"
            faults.append(Fault(f"mold.{key}_mm", hole, bound, "widen it or take another process"))
    return faults


def _least_pin(mold: Mold, limits: Limits, reach: float) -> float:
    """Least diameter of the small pins, mm: four clearances, and a tip that can be made.

    Pins get shorter as they get thinner: ``reach`` moves with the big pins' diameter.
    """
    least = 4.0 * limits.clearance_mm
    if limits.dowels:
        return max(least, limits.feature_mm)
    lean = 2.0 * math.tan(math.radians(mold.draft_deg))
    slope = 1.0 - SLENDER * lean
    if slope <= 0.0:  # no diameter helps: the draft itself is refused
        return least
    rest = max(reach - SLENDER * limits.pin_mm, 0.0)
    key = limits.feature_mm + lean * KEY_MM
    return max(least, key, (limits.feature_mm + lean * rest) / slope)


def fastener_faults(mold: Mold, limits: Limits, walls: Walls, columns: Columns) -> list[Fault]:
    """What of bolts, pins and keys does not fit the walls of a mold."""
    return [
        *_wall_faults(mold, limits, columns),
        *_height_faults(mold, limits, walls, columns),
        *_draft_faults(mold, limits, walls, columns),
        *_room_faults(mold, limits, walls, columns),
    ]


def _wall_faults(mold: Mold, limits: Limits, columns: Columns) -> list[Fault]:
    if mold.wall_mm is None or mold.wall_mm >= columns.wall_z - 1e-9:
        return []
    dowels = "dowels" if limits.dowels else "pins"
    bound = (
        f"at least {at_least(columns.wall_z)}: {columns.size} bolts, {dowels} of "
        f"{columns.big:g} mm and walls of {limits.wall_mm:g} mm ('{limits.name}') between them"
    )
    remedy = "leave it out: it is then computed"
    if columns.size != "M2":
        remedy += "; or set mold.bolt = 'M2'"
    return [Fault("mold.wall_mm", mold.wall_mm, bound, remedy)]


def _height_faults(mold: Mold, limits: Limits, walls: Walls, columns: Columns) -> list[Fault]:
    """Walls too low for the bolt that was asked for, or for anything."""
    faults = []
    rim = walls.extent.rim
    if mold.bolt != "auto" and z_bolt_height(walls, columns) is None:
        low = rim < columns.rise
        where = f"the walls' height, {at_most(rim)}" if low else "what the slots leave of the walls"
        bound = f"a bolt that fits {where}: {mold.bolt} needs {at_least(columns.rise)} mm"
        faults.append(Fault("mold.bolt", mold.bolt, bound, "set mold.bolt = 'auto'"))
    most = rim - least_rim(columns, columns.big) + columns.gap - SPARE_MM
    most = min(most, rim - _LEAST_KEY_MM - columns.clearance - SPARE_MM)
    if limits.wall_mm > most + 1e-9:
        higher = limits.wall_mm - most
        bound = (
            f"at most {at_most(most)}: the mold's walls are {at_most(rim)} mm high"
            if most > 0.0
            else f"a wall with room above and below pins of {columns.big:g} mm: the mold's walls, "
            f"{at_most(rim)} mm high, are {at_least(higher)} mm too low"
        )
        remedy = f"take another mold.process or make the finger {at_least(higher)} mm higher"
        faults.append(Fault("mold.limits.wall_mm", limits.wall_mm, bound, remedy))
    return faults


def _draft_faults(mold: Mold, limits: Limits, walls: Walls, columns: Columns) -> list[Fault]:
    least = limits.feature_mm
    bounds = [most_draft(columns.small, max(key_height(walls, columns), 1e-3), least)]
    if not limits.dowels:
        longest = insert_pin_length(columns, columns.small, walls.extent.rim, walls)
        if pin_height(walls, columns) is not None:
            longest = max(longest, columns.reach)
        bounds.append(most_draft(columns.small, max(longest, 1e-3), least))
    most = min(bounds)
    if mold.draft_deg <= most or (most <= 0.0 and mold.limits.pin_mm is not None):
        return []  # the pin that is too thin is refused
    if most <= 0.0:
        bound = f"at most mold.limits.pin_mm = {columns.small:g}: pins end in webs that can be made"
        remedy = "lower it or raise mold.limits.pin_mm"
        return [Fault("mold.limits.feature_mm", limits.feature_mm, bound, remedy)]
    what = "keys" if most == bounds[0] else "pins"
    bound = f"at most {at_most(most)}: {what} of {columns.small:g} mm end thinner than {least:g}"
    remedy = "lower it or raise mold.limits.pin_mm"
    return [Fault("mold.draft_deg", mold.draft_deg, bound, remedy)]


def _room_faults(mold: Mold, limits: Limits, walls: Walls, columns: Columns) -> list[Fault]:
    """No place for an upright bolt or pin beside what the walls hold."""
    faults = []
    low = z_bolt_height(walls, columns) is None
    if mold.bolt == "auto" or not low:
        for side, x, z in insert_bolts(walls, columns, low):
            if x is None or z is None:
                bound = _bolt_bound(side, walls, columns, low)
                remedy = "move the plates' legs, or take a higher or deeper finger"
                faults.append(Fault("mold.bolt", mold.bolt, bound, remedy))
                break
    for side, x, z, _ in insert_pins(walls, columns, pin_height(walls, columns) is None):
        if x is None or z is None:
            room = 2.0 * (0.5 * columns.small + columns.clearance + columns.gap)
            bound = (
                f"a pin with room in the {side} wall, beside plates and seams: with its walls it "
                f"takes {at_least(room)} mm"
            )
            remedy = "lower it, or move the plates' legs"
            faults.append(Fault("mold.limits.pin_mm", limits.pin_mm, bound, remedy))
            break
    return faults


def _bolt_bound(side: Side, walls: Walls, columns: Columns, low: bool) -> str:
    along = f"along z it needs walls {at_least(columns.rise)} mm high"
    along += f", they are {at_most(walls.extent.rim)}" if walls.extent.rim < columns.rise else ""
    reach = walls.extent.corner if side.endswith("x") else walls.extent.half_width
    upright = f"upright it needs {at_least(columns.rise)} of the {side} wall's {2.0 * reach:.4g} mm"
    upright += "" if 2.0 * reach < columns.rise else " beside what it holds"
    return f"a bolt with room: for {columns.size}, " + (f"{along}; {upright}" if low else upright)
