"""Plates too near to the contact surface, the base, the sides or the end faces of the body."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.checks.remedies import (
    CLOSE,
    STAY,
    Change,
    Misplacement,
    greatest,
    least,
    mended_by,
    too_near,
    worst_by_key,
)
from fingerdesign.design.faults import at_least, at_most
from fingerdesign.design.schema import Body, Design, Plates
from fingerdesign.layout import clearance
from fingerdesign.layout.clearance import LEAST_CLEARANCE_MM
from fingerdesign.layout.gaps import flat_corners
from fingerdesign.layout.row_keys import PlateRow, plate_rows
from fingerdesign.layout.rows import row_frames

_INWARD = "move the plates inward"


def limits(body: Body, row: PlateRow) -> tuple[str, str, float, str, str, float]:
    """Return axis, key and half-extent of the body along the row, then across it."""
    x = ("x", "body.width_mm", 0.5 * body.width_mm)
    z = ("z", "body.depth_mm" if not body.kind.turned else x[1], 0.5 * body.depth_mm)
    return (*x, *z) if row.table.along == "x" else (*z, *x)


def side_reaches(row: PlateRow) -> Array:
    """Return the reach of each plate from the middle along its row, mm (plates,); infinite where
    the surface has ended."""
    if any(frame.bend_radius is not None for frame in row.frames):
        reach = np.array([np.abs(frame.outline()[:, 0]).max() for frame in row.frames])
    else:
        reach = np.abs(flat_corners(row.frames)[..., 0]).max(axis=1)
    return np.where(np.isnan(reach), np.inf, reach)


def row_reach(body: Body, table: Plates) -> float:
    """Return the reach of a row's plates along it, mm; of a level row without making its frames."""
    if not table.layout.level:
        return float(side_reaches(PlateRow(table, tuple(row_frames(body, table, 0)))).max())
    angle = np.radians(table.angle_deg)
    own = table.length_mm * abs(np.cos(angle)) + table.thickness_mm * abs(np.sin(angle))
    row = 0.5 * (table.count - 1) * table.pitch_mm
    return float(abs(table.offset_mm) + row + 0.5 * own)


def side_findings(design: Design, row: PlateRow) -> list[Misplacement]:
    """Find a row whose plates come too near to the sides, or lie where the surface has ended."""
    axis, wide, half, *_ = limits(design.body, row)
    reach, allowed = side_reaches(row), half - LEAST_CLEARANCE_MM
    worst = int(np.argmax(reach))
    if reach[worst] <= allowed:  # a place under which the surface ends
        reach = np.where([np.isnan(frame.y) for frame in row.frames], np.inf, reach)
        worst = int(np.argmax(reach))
    if reach[worst] <= allowed + CLOSE:
        return []
    frame = row.frames[worst]

    def fits(name: str, value: float) -> bool:
        return row_reach(design.body, row.table.model_copy(update={name: value})) <= allowed

    pitch, offset = row.table.pitch_mm, row.table.offset_mm
    name = "length_mm"
    if not row.placed and offset and fits("offset_mm", 0.0):
        name = "offset_mm"
    elif not row.placed and frame.place != 0.0:
        name = "pitch_mm"
    key, value = row.blame(frame.index, name)

    def own_changes() -> Iterator[Change]:
        inner = allowed - (reach[worst] - abs(frame.place))
        if row.placed:
            if inner >= 0:
                yield Change(f"move it to |{axis}| <= {at_most(inner)}")
        elif name == "pitch_mm":
            most = greatest(lambda p: fits("pitch_mm", p), 0.01, pitch)
            if most is not None:
                yield Change.to("lower it to at most", key, at_most(most))
            fewer = next((n for n in range(row.table.count - 1, 0, -1) if fits("count", n)), None)
            if fewer is not None:
                yield Change.to("lower", row.key("count"), str(fewer))
        elif name == "offset_mm":
            most = greatest(lambda o: fits("offset_mm", np.copysign(o, offset)), 0.0, abs(offset))
            if most is not None:
                sign = "-" if offset < 0 else ""
                yield Change.to("set it to", key, sign + at_most(most))

    def changes() -> list[Change]:
        found = [*own_changes()]
        if np.isfinite(reach[worst]):
            raised = at_least(2.0 * (reach[worst] + LEAST_CLEARANCE_MM))
            found.append(Change.to(f"raise {wide} to at least", wide, raised))
        return found

    reported = f"{reach[worst]:.4g}" if np.isfinite(reach[worst]) else "beyond the surface"
    bound = f"{STAY} inside |{axis}| = {half:g} (plate {frame.index} reaches {reported})"
    over, otherwise = float(min(reach[worst], 1e6)) - allowed, f"{_INWARD} or shorten them"
    return [Misplacement(key, value, bound, over, changes, otherwise)]


def end_findings(design: Design, row: PlateRow, number: int) -> list[Misplacement]:
    """Find plates whose span's ends pass the end faces, or leave a skin below the least over
    them."""
    *_, axis, deep, half = limits(design.body, row)
    if design.body.kind.turned:
        return _round(design, row, number)
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
    otherwise = _INWARD
    room = half - LEAST_CLEARANCE_MM
    if name == "span_mm":
        otherwise = f"lower {key} to at most {at_most(2.0 * room)}"
    elif own_z and room > 0.5 * frame.span:
        otherwise = f"move it to |{axis}| <= {at_most(room - 0.5 * frame.span)}"
    return [Misplacement(key, value, bound, float(over[worst]), changes, otherwise)]


def _excess(low: float, high: float, half: float) -> float:
    """Return the length by which a span's ends are out of bounds, mm; 0: they are inside."""
    inner = half - LEAST_CLEARANCE_MM
    thin = [e for e in (-low, high) if e > half + CLOSE or inner + CLOSE < e < half - CLOSE]
    return max((end - half + LEAST_CLEARANCE_MM for end in thin), default=0.0)


def _span_culprit(row: PlateRow, half: float) -> str:
    """Name the row's key to blame for spans that leave the body."""
    span, table = row.frames[0].span, row.table
    offset, stagger = abs(table.span_offset_mm), 0.5 * abs(table.stagger_mm)
    wide = span > 2.0 * half - 2.0 * LEAST_CLEARANCE_MM + CLOSE
    if wide and (table.span_mm is not None or not offset + stagger):
        return "span_mm"
    if offset and _excess(0.0, 0.5 * span + stagger, half) == 0.0:
        return "span_offset_mm"
    return "stagger_mm" if stagger else "span_offset_mm"


def _round(design: Design, row: PlateRow, number: int) -> list[Misplacement]:
    """Plates of a revolved body that leave its round section."""
    allowed = 0.5 * design.body.width_mm - LEAST_CLEARANCE_MM
    groups = [clearance.plate_points(frame) for frame in row.frames]
    reach = np.array([np.hypot(points[:, 0], points[:, 2]).max() for points in groups])
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
        # Toward the border the surface comes down: it may be what limits the span.
        clear = mended_by(design, key, lambda trial: _cover(trial, number))
        narrow = greatest(clear, 0.1, 2.0 * room) if room > 0.05 else None
        if narrow is not None:
            found.insert(0, Change.to(f"set {key} to at most", key, at_most(narrow)))
        return found

    section = f"the round section of radius {allowed + LEAST_CLEARANCE_MM:g}"
    bound = f"{STAY} inside {section} (plate {frame.index} reaches {reach[worst]:.4g})"
    over = float(reach[worst] - allowed)
    return [Misplacement(key, value, bound, over, changes, "shorten the row or narrow the plates")]


def wall_findings(design: Design, row: PlateRow) -> list[Misplacement]:
    """Find plates too near to the sides of a STEP body."""
    if design.body.shape != "step":
        return []
    found = too_near(row, clearance.wall_clearances(design.body, row.frames))
    if found is None:
        return []
    frame, distance = found
    narrow = tuple(replace(f, low=f.middle - 0.05, high=f.middle + 0.05) for f in row.frames)
    inside = clearance.wall_clearances(design.body, narrow)
    name = "pitch_mm" if frame.place else "length_mm"
    key, value = row.blame(frame.index, name)
    if inside.min() >= LEAST_CLEARANCE_MM:
        key, value = row.key("span_mm"), row.value("span_mm")
    bound = f"{STAY} inside the body's sides (plate {frame.index}: {distance:.4g})"
    over = LEAST_CLEARANCE_MM - distance
    return [Misplacement(key, value, bound, over, list, "lower it or move the plates inward")]


def placing_findings(design: Design) -> list[Misplacement]:
    """Find every plate too near to a face of the body; one finding a key.

    A row whose plates reach the sides is not judged against the surface.
    """
    found: list[Misplacement] = []
    for number, row in enumerate(plate_rows(design)):
        outside = side_findings(design, row)
        found += outside
        if any(not np.isfinite(frame.y) for frame in row.frames):
            continue
        ends = end_findings(design, row, number)
        found += ends
        if outside:
            continue
        if not ends:
            found += wall_findings(design, row)
            found += _cover(design, number)
        found += _base(design, row)
    return worst_by_key(found)


def _cover(design: Design, number: int) -> list[Misplacement]:
    row = plate_rows(design)[number]
    found = too_near(row, clearance.cover_clearances(design.body, row.frames))
    if found is None:
        return []
    frame, distance = found
    key, value = row.blame(frame.index, "cover_mm")

    def lower(down: float) -> bool:
        moved = (replace(frame, y=frame.y - down),)
        return bool(clearance.cover_clearances(design.body, moved)[0] >= LEAST_CLEARANCE_MM)

    def changes() -> list[Change]:
        room = max(frame.y, LEAST_CLEARANCE_MM)
        if row.placed:
            down = least(lower, 0.0, room)
            return [] if down is None else [Change(f"lower its y by at least {at_least(down)}")]
        cover = row.table.cover_mm
        clear = mended_by(design, key, lambda trial: _cover(trial, number))
        raised = least(clear, cover, cover + room)
        words = f"raise {key} to at least"
        return [] if raised is None else [Change.to(words, key, at_least(raised))]

    place = f"{distance:.4g}" if np.isfinite(distance) else "beyond it"
    worst = f"(plate {frame.index}: {place})"
    bound = f"such that plates lie {LEAST_CLEARANCE_MM} mm below the contact surface {worst}"
    return [Misplacement(key, value, bound, LEAST_CLEARANCE_MM - distance, changes, _INWARD)]


def _base(design: Design, row: PlateRow) -> list[Misplacement]:
    found = too_near(row, np.array([frame.outline()[:, 1].min() for frame in row.frames]))
    if found is None:
        return []
    frame, height = found
    short = LEAST_CLEARANCE_MM - height
    key, value = row.blame(frame.index, "cover_mm")

    def changes() -> list[Change]:
        if row.placed:
            return [Change(f"raise its y by at least {at_least(short)}")]
        base = "body.base_height_mm"
        raised = at_least(design.body.base_height_mm + short)
        found = [Change.to(f"raise {base} to at least", base, raised)]
        lowered = row.table.cover_mm - short
        if lowered > 0.01:
            found.insert(0, Change.to(f"lower {key} to at most", key, at_most(lowered)))
        return found

    bound = f"{STAY} above the base y = 0 (plate {frame.index}: {height:.4g})"
    return [Misplacement(key, value, bound, short, changes, "move the plates upward")]
