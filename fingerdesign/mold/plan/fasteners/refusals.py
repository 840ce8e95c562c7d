"""Refusals of bolts and pins that do not fit, and of limits that contradict each other."""

import math

from fingerdesign.design.mold import Mold
from fingerdesign.mold.plan.fasteners.columns import (
    SLENDER,
    Columns,
    Fit,
    insert_pin_length,
    most_draft,
)
from fingerdesign.mold.plan.limits import SPARE_MM, Limits
from fingerdesign.mold.plan.plan import MoldPlan, Pour
from fingerdesign.mold.plan.refusals import Refusal

LEAST_PIN = 0.4  # length over diameter: a shorter pin guides nothing


def limit_refusals(mold: Mold, limits: Limits, reach: float, pour: Pour) -> list[Refusal]:
    """Refuse limits that contradict each other, plates of the mold below the process's wall, and
    holes that are given below its hole; pins reach as far as ``reach`` into their sockets."""
    given, thick = mold.limits.model_dump(exclude_none=True), _least_pin(mold, limits, reach)
    of, found = "mold.limits.", list[Refusal]()
    if limits.feature_mm > limits.wall_mm:
        if "feature_mm" in given or "wall_mm" not in given:
            blamed = Refusal("thick_web", f"{of}feature_mm", limits.feature_mm, {"limits": limits})
        else:
            blamed = Refusal("thin_wall_limit", f"{of}wall_mm", limits.wall_mm, {"limits": limits})
        found.append(blamed)
    if limits.pin_mm < thick and "pin_mm" in given:
        numbers = {"limits": limits, "thick": thick, "draft": mold.draft_deg}
        found.append(Refusal("thin_pins", f"{of}pin_mm", limits.pin_mm, numbers))
    if limits.clearance_mm > 0.25 * limits.pin_mm and "pin_mm" not in given:
        most = {"most": 0.25 * limits.pin_mm}
        found.append(Refusal("wide_sockets", f"{of}clearance_mm", limits.clearance_mm, most))
    walls, holes = ("insert_mm", "base_mm"), ("lock_mm", "gate_mm", "vent_mm")
    for key in (*walls, *(holes if pour == "closed" else holes[:1])):
        size, usual = getattr(mold, key), Mold.model_fields[key].default
        least = limits.wall_mm if key in walls else limits.hole_mm
        if size is not None and size < least and (key in walls or size != usual):
            kind = "thin_wall" if key in walls else "narrow_hole"
            found.append(Refusal(kind, f"mold.{key}", size, {"limits": limits}))
    return found


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
    return max(least, (limits.feature_mm + lean * rest) / slope)


def fastener_refusals(mold: Mold, plan: MoldPlan, fit: Fit) -> list[Refusal]:
    """Refuse bolts and pins that do not fit the walls of a closed mold."""
    columns, found = fit.columns, list[Refusal]()
    if mold.wall_mm is not None and mold.wall_mm < columns.wall_z - 1e-9:
        numbers = {"limits": columns.limits, "columns": columns}
        found.append(Refusal("thin_end_walls", "mold.wall_mm", mold.wall_mm, numbers))
    return [
        *found,
        *_low_walls(mold, plan, columns, fit.bolt_height is None),
        *_pointed_pins(mold, plan, columns, fit.pin_height is not None),
        *_no_room(mold, plan, fit),
    ]


def _low_walls(mold: Mold, plan: MoldPlan, columns: Columns, low: bool) -> list[Refusal]:
    """Refuse walls too low for the bolt that was requested, or for anything."""
    found, rim, wall = list[Refusal](), plan.rim, columns.limits.wall_mm
    if mold.bolt != "auto" and low:
        numbers = {"rim": rim, "columns": columns}
        found.append(Refusal("big_bolt", "mold.bolt", mold.bolt, numbers))
    most = rim - LEAST_PIN * columns.big - columns.clearance - SPARE_MM
    if wall > most + 1e-9:
        of = {"most": most, "rim": rim, "columns": columns, "higher": wall - most}
        kind = "thick_walls" if most > 0 else "low_walls"
        found.append(Refusal(kind, "mold.limits.wall_mm", wall, of))
    return found


def _pointed_pins(mold: Mold, plan: MoldPlan, columns: Columns, level: bool) -> list[Refusal]:
    """Refuse pins without a tip; ``level``: there are pins along z, too."""
    if columns.limits.dowels:
        return []
    least = columns.limits.feature_mm
    longest = insert_pin_length(plan, columns, columns.small, plan.rim)
    if level:
        longest = max(longest, columns.reach)
    most = most_draft(columns.small, max(longest, 1e-3), least)
    if mold.draft_deg <= most or (most <= 0.0 and mold.limits.pin_mm is not None):
        return []  # the pin that is too thin is refused
    if most <= 0.0:
        return [Refusal("webs_on_pins", "mold.limits.feature_mm", least, {"columns": columns})]
    of = {"most": most, "columns": columns, "limits": columns.limits}
    return [Refusal("great_draft", "mold.draft_deg", mold.draft_deg, of)]


def _no_room(mold: Mold, plan: MoldPlan, fit: Fit) -> list[Refusal]:
    """Refuse upright bolts and pins without a place next to what the walls hold."""
    found, columns, low = list[Refusal](), fit.columns, fit.bolt_height is None
    bolts = fit.bolts if mold.bolt == "auto" or not low else ()
    lacking = next((side for side, x, z in bolts if math.isnan(x + z)), None)
    if lacking is not None:
        length = 2.0 * (plan.corner if lacking.endswith("x") else plan.half_width)
        of = {"side": lacking, "columns": columns, "rim": plan.rim, "length": length}
        found.append(Refusal("no_low_bolt" if low else "no_bolt", "mold.bolt", mold.bolt, of))
    lacking = next((side for side, x, z, _ in fit.pins if math.isnan(x + z)), None)
    if lacking is not None:
        room = 2.0 * (0.5 * columns.small + columns.clearance + columns.gap)
        key, pin = "mold.limits.pin_mm", columns.limits.pin_mm
        found.append(Refusal("no_pin", key, pin, {"side": lacking, "room": room}))
    return found
