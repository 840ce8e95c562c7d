"""Whether plates end where they may: with the body, or clear of its end faces and walls."""

from __future__ import annotations

from collections.abc import Set
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design import clearance
from fingerdesign.design.clearance import LEAST_CLEARANCE_MM
from fingerdesign.design.faults import at_least, at_most, involves
from fingerdesign.design.plate_rows import PlateRow
from fingerdesign.design.remedies import Change, Finding, greatest
from fingerdesign.design.schema import Design
from fingerdesign.design.sides import CLOSE, limits, side_reaches


def end_findings(design: Design, row: PlateRow, doubtful: Set[str]) -> list[Finding]:
    """Plates whose span's ends pass the end faces, or leave a skin below the least over them."""
    *_, axis, deep, half = limits(design.body, row)
    if design.body.shape == "revolved":
        return _round(design, row, doubtful)
    if involves(doubtful, deep):
        return []
    over = np.array([_excess(frame.low, frame.high, half) for frame in row.frames])
    worst = int(np.argmax(over))
    if over[worst] <= 0.0:
        return []
    frame = row.frames[worst]
    name = _span_culprit(row, half)
    key, value = row.key(name), row.value(name)
    own_z = row.table.placement is not None and len(row.table.placement[frame.index]) > 3
    if own_z and name != "span_mm":
        key, value = row.blame(frame.index, name)

    def changes() -> list[Change]:
        sideways = max(abs(each.middle) for each in row.frames)
        most = 2.0 * (half - LEAST_CLEARANCE_MM - sideways)
        found = []
        if most > 0.1:
            found.append(Change.to("lower", row.key("span_mm"), at_most(most)))
        if sideways == 0.0:
            found.insert(0, Change.to("set", row.key("span_mm"), f"{2.0 * half:g}"))
            reach = at_least(2.0 * max(abs(frame.low), abs(frame.high)))
            found.append(Change.to(f"raise {deep} to at least", deep, reach))
        elif name != "span_mm" and not own_z:
            found.append(Change.to("set", row.key(name), "0"))
        return found

    bound = (
        f"such that plates end at |{axis}| = {half:g} or {LEAST_CLEARANCE_MM} mm inside it "
        f"(plate {frame.index}: {frame.low:.4g} to {frame.high:.4g}): a thinner skin cannot be cast"
    )
    otherwise = "move the plates inward"
    room = half - LEAST_CLEARANCE_MM
    if name == "span_mm":
        otherwise = f"lower {key} to at most {at_most(2.0 * room)}"
    elif own_z and room > 0.5 * frame.span:
        otherwise = f"move it to |{axis}| <= {at_most(room - 0.5 * frame.span)}"
    return [Finding(key, value, bound, float(over[worst]), changes, otherwise)]


def _excess(low: float, high: float, half: float) -> float:
    """By how much a span's ends are where they must not be, mm; 0: nothing."""
    worst = 0.0
    for end in (-low, high):
        if end > half + CLOSE or half - LEAST_CLEARANCE_MM + CLOSE < end < half - CLOSE:
            worst = max(worst, end - half + LEAST_CLEARANCE_MM)
    return worst


def _span_culprit(row: PlateRow, half: float) -> str:
    """Which of a row's keys to blame for spans that leave the body."""
    span, offset, stagger = (
        row.frames[0].span,
        abs(row.table.span_offset_mm),
        0.5 * abs(row.table.stagger_mm),
    )
    if span > 2.0 * half - 2.0 * LEAST_CLEARANCE_MM + CLOSE and (
        row.table.span_mm is not None or not offset + stagger
    ):
        return "span_mm"
    if offset and _excess(0.0, 0.5 * span + stagger, half) == 0.0:
        return "span_offset_mm"
    return "stagger_mm" if stagger else "span_offset_mm"


def _round(design: Design, row: PlateRow, doubtful: Set[str]) -> list[Finding]:
    """Plates of a revolved body that leave its round section."""
    if involves(doubtful, "body.width_mm"):
        return []
    allowed = 0.5 * design.body.width_mm - LEAST_CLEARANCE_MM
    reach = _radii(row)
    worst = int(np.argmax(reach))
    if reach[worst] <= allowed + CLOSE:
        return []
    frame = row.frames[worst]
    key, value = row.key("span_mm"), row.value("span_mm")

    def changes() -> list[Change]:
        along = float(side_reaches(row).max())
        sideways = max(abs(each.middle) for each in row.frames)
        room = np.sqrt(max(allowed**2 - along**2, 0.0)) - sideways
        raised = at_least(2.0 * (reach[worst] + LEAST_CLEARANCE_MM))
        found = [Change.to("raise body.width_mm to at least", "body.width_mm", raised)]
        narrow = greatest(covered, 0.1, 2.0 * room) if room > 0.05 else None
        if narrow is not None:
            found.insert(0, Change.to(f"set {key} to at most", key, at_most(narrow)))
        return found

    def covered(span: float) -> bool:
        """Toward the border the surface comes down: it may be what limits the span."""
        frames = tuple(
            replace(each, low=each.middle - 0.5 * span, high=each.middle + 0.5 * span)
            for each in row.frames
        )
        return bool(clearance.cover_clearances(design.body, frames).min() >= LEAST_CLEARANCE_MM)

    bound = (
        f"such that plates stay {LEAST_CLEARANCE_MM} mm inside the round section of radius "
        f"{allowed + LEAST_CLEARANCE_MM:g} (plate {frame.index} reaches {reach[worst]:.4g})"
    )
    over = float(reach[worst] - allowed)
    return [Finding(key, value, bound, over, changes, "shorten the row or narrow the plates")]


def _radii(row: PlateRow) -> Array:
    """How far each plate reaches from the axis of a revolved body, (plates,)."""
    groups = [clearance.plate_points(frame) for frame in row.frames]
    return np.array([np.hypot(points[:, 0], points[:, 2]).max() for points in groups])


def wall_findings(design: Design, row: PlateRow) -> list[Finding]:
    """Plates too near to the sides of a STEP body."""
    if design.body.shape != "step":
        return []
    distances = clearance.wall_clearances(design.body, row.frames)
    distances = np.where(np.isnan(distances), -np.inf, distances)
    worst = int(np.argmin(distances))
    if distances[worst] >= LEAST_CLEARANCE_MM - CLOSE:
        return []
    frame = row.frames[worst]
    narrow = tuple(replace(f, low=f.middle - 0.05, high=f.middle + 0.05) for f in row.frames)
    inside = clearance.wall_clearances(design.body, narrow)
    name = "pitch_mm" if frame.place else "length_mm"
    key, value = row.blame(frame.index, name)
    if inside.min() >= LEAST_CLEARANCE_MM:
        key, value = row.key("span_mm"), row.value("span_mm")
    bound = (
        f"such that plates stay {LEAST_CLEARANCE_MM} mm inside the body's sides "
        f"(plate {frame.index}: {distances[worst]:.4g})"
    )
    over = LEAST_CLEARANCE_MM - float(distances[worst])
    return [Finding(key, value, bound, over, list, "lower it or move the plates inward")]
