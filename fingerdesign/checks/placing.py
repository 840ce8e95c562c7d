"""Whether plates lie clear of the contact surface, the base, the sides and the end faces.

Each fault names the worst plate (numbered from 0, row by row) and remedies that have been tried: a
wrong remedy is worse than a general one.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.faults import at_least, at_most
from fingerdesign.design.schema import Body, Design, Plates
from fingerdesign.errors import Fault
from fingerdesign.layout import clearance
from fingerdesign.layout.clearance import LEAST_CLEARANCE_MM
from fingerdesign.layout.frames import PlateFrame, PlateRow, plate_rows, row_frames, with_key
from fingerdesign.layout.gaps import flat_corners

CLOSE = 1e-9  # mm; rounding
_HALVINGS = 18  # 10 mm to 0.04 micrometres


@dataclass(frozen=True)
class Change:
    """A remedy in words, and the key and value that follow it; without a key it is not tried."""

    words: str
    key: str = ""
    value: float = 0.0

    @classmethod
    def to(cls, words: str, key: str, value: str) -> Self:
        """``words`` to ``value``: "raise plates.cover_mm to at least 2.1"."""
        if words in ("lower", "set"):
            words = f"{words} {key} to" + (" at most" if words == "lower" else "")
        return cls(f"{words} {value}", key, int(value) if key.endswith("count") else float(value))


@dataclass(frozen=True)
class Misplacement:
    """A fault, by how much (``over``, mm), and how its remedies are found, should it be
    reported."""

    key: str
    value: object
    bound: str
    over: float
    changes: Callable[[], list[Change]]
    otherwise: str

    def fault(self, design: Design, before: set[str], find: Callable[[Design], set[str]]) -> Fault:
        """The fault in words. ``find``: the keys of a changed design's faults; a change that does
        not end this one, or brings another than ``before``, is not reported."""

        def mends(change: Change) -> bool:
            if not change.key:
                return True
            trial = with_key(design, change.key, change.value)
            return trial is not None and find(trial) <= before - {self.key}

        words = [change.words for change in self.changes() if mends(change)]
        return Fault(self.key, self.value, self.bound, " or ".join(words) or self.otherwise)


def worst_by_key(findings: Iterable[Misplacement]) -> list[Misplacement]:
    """One finding a key, the worst."""
    kept: dict[str, Misplacement] = {}
    for finding in findings:
        if finding.key not in kept or finding.over > kept[finding.key].over:
            kept[finding.key] = finding
    return list(kept.values())


def too_near(
    row: PlateRow, distances: Array, unknown: float = -np.inf
) -> tuple[PlateFrame, float] | None:
    """The plate of the least distance (plates,), mm, and that, where it is below the least
    clearance; ``unknown``: what NaN counts as."""
    distances = np.where(np.isnan(distances), unknown, distances)
    worst = int(np.argmin(distances))
    if distances[worst] >= LEAST_CLEARANCE_MM - CLOSE:
        return None
    return row.frames[worst], float(distances[worst])


def mended_by(
    design: Design, key: str, find: Callable[[Design], list[Misplacement]]
) -> Callable[[object], bool]:
    """Whether a value of a key, if it is not refused itself, leaves nothing to ``find``."""

    def mends(value: object) -> bool:
        trial = with_key(design, key, value)
        return trial is not None and not find(trial)

    return mends


def greatest(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """The greatest value in [low, high] up to which ``holds``; None: not at low."""
    if holds(high):
        return high
    return edge(holds, low, high) if holds(low) else None


def least(holds: Callable[[float], bool], low: float, high: float) -> float | None:
    """The least value in [low, high] from which on it ``holds``; None: not at any tried."""
    if holds(low):
        return low
    while not holds(high):  # too far may be as wrong as too near
        high = 0.5 * (low + high)
        if not high - low >= 1e-3:  # nor for NaN
            return None
    return edge(holds, high, low)


def edge(
    holds: Callable[[float], bool], good: float, bad: float, halvings: int = _HALVINGS
) -> float:
    """About the value between a good and a bad one up to which it ``holds``, by bisection."""
    for _ in range(halvings):
        middle = 0.5 * (good + bad)
        good, bad = (middle, bad) if holds(middle) else (good, middle)
    return good


# Whether plates stay between the body's sides along their row.


def limits(body: Body, row: PlateRow) -> tuple[str, str, float, str, str, float]:
    """Axis, key and half-extent of the body along the row, then across it."""
    x = ("x", "body.width_mm", 0.5 * body.width_mm)
    z = ("z", "body.depth_mm" if not body.kind.turned else x[1], 0.5 * body.depth_mm)
    return (*x, *z) if row.table.along == "x" else (*z, *x)


def side_reaches(row: PlateRow) -> Array:
    """How far each plate reaches from the middle along its row, (plates,); infinite: nowhere."""
    if any(frame.bend_radius is not None for frame in row.frames):
        reach = np.array([np.abs(frame.outline()[:, 0]).max() for frame in row.frames])
    else:
        reach = np.abs(flat_corners(row.frames)[..., 0]).max(axis=1)
    return np.where(np.isnan(reach), np.inf, reach)


def row_reach(body: Body, table: Plates) -> float:
    """How far the plates of a row's table reach along it, mm; of a level row without its frames."""
    if not table.layout.level:
        return float(side_reaches(PlateRow(table, tuple(row_frames(body, table, 0)))).max())
    angle = np.radians(table.angle_deg)
    own = table.length_mm * abs(np.cos(angle)) + table.thickness_mm * abs(np.sin(angle))
    row = 0.5 * (table.count - 1) * table.pitch_mm
    return float(abs(table.offset_mm) + row + 0.5 * own)


def side_findings(design: Design, row: PlateRow) -> list[Misplacement]:
    """A row whose plates come too near to the sides, or lie where the surface has ended."""
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

    def changes() -> list[Change]:
        found = []
        inner = allowed - (reach[worst] - abs(frame.place))
        if row.placed:
            if inner >= 0:
                found.append(Change(f"move it to |{axis}| <= {at_most(inner)}"))
        elif name == "pitch_mm":
            most = greatest(lambda p: fits("pitch_mm", p), 0.01, pitch)
            if most is not None:
                found.append(Change.to("lower it to at most", key, at_most(most)))
            fewer = [n for n in range(row.table.count - 1, 0, -1) if fits("count", n)][:1]
            if fewer and most is None:
                found.append(Change.to("lower", row.key("count"), str(fewer[0])))
        elif name == "offset_mm":
            most = greatest(lambda o: fits("offset_mm", np.copysign(o, offset)), 0.0, abs(offset))
            if most is not None:
                sign = "-" if offset < 0 else ""
                found.append(Change.to("set it to", key, sign + at_most(most)))
        if np.isfinite(reach[worst]):
            raised = at_least(2.0 * (reach[worst] + LEAST_CLEARANCE_MM))
            found.append(Change.to(f"raise {wide} to at least", wide, raised))
        return found

    reported = f"{reach[worst]:.4g}" if np.isfinite(reach[worst]) else "beyond the surface"
    bound = (
        f"such that plates stay {LEAST_CLEARANCE_MM} mm inside |{axis}| = {half:g} "
        f"(plate {frame.index} reaches {reported})"
    )
    over = float(min(reach[worst], 1e6)) - allowed
    return [
        Misplacement(key, value, bound, over, changes, "move the plates inward or shorten them")
    ]


# Whether plates end where they may: with the body, or clear of its end faces and walls.


def end_findings(design: Design, row: PlateRow, number: int) -> list[Misplacement]:
    """Plates whose span's ends pass the end faces, or leave a skin below the least over them."""
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
    otherwise = "move the plates inward"
    room = half - LEAST_CLEARANCE_MM
    if name == "span_mm":
        otherwise = f"lower {key} to at most {at_most(2.0 * room)}"
    elif own_z and room > 0.5 * frame.span:
        otherwise = f"move it to |{axis}| <= {at_most(room - 0.5 * frame.span)}"
    return [Misplacement(key, value, bound, float(over[worst]), changes, otherwise)]


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

    bound = (
        f"such that plates stay {LEAST_CLEARANCE_MM} mm inside the round section of radius "
        f"{allowed + LEAST_CLEARANCE_MM:g} (plate {frame.index} reaches {reach[worst]:.4g})"
    )
    over = float(reach[worst] - allowed)
    return [Misplacement(key, value, bound, over, changes, "shorten the row or narrow the plates")]


def wall_findings(design: Design, row: PlateRow) -> list[Misplacement]:
    """Plates too near to the sides of a STEP body."""
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
    bound = (
        f"such that plates stay {LEAST_CLEARANCE_MM} mm inside the body's sides "
        f"(plate {frame.index}: {distance:.4g})"
    )
    over = LEAST_CLEARANCE_MM - distance
    return [Misplacement(key, value, bound, over, list, "lower it or move the plates inward")]


def placing_findings(design: Design) -> list[Misplacement]:
    """Every plate too near to a face of the body; one finding a key.

    A row whose plates reach the sides is not judged against the surface.
    """
    found: list[Misplacement] = []
    for number, row in enumerate(plate_rows(design)):
        beside = side_findings(design, row)
        found += beside
        if any(not np.isfinite(frame.y) for frame in row.frames):
            continue
        ends = end_findings(design, row, number)
        found += ends
        if beside:
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

    reported = f"{distance:.4g}" if np.isfinite(distance) else "beyond it"
    bound = (
        f"such that plates lie {LEAST_CLEARANCE_MM} mm below the contact surface "
        f"(plate {frame.index}: {reported})"
    )
    over = LEAST_CLEARANCE_MM - distance
    return [Misplacement(key, value, bound, over, changes, "move the plates inward")]


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

    bound = (
        f"such that plates stay {LEAST_CLEARANCE_MM} mm above the base y = 0 "
        f"(plate {frame.index}: {height:.4g})"
    )
    return [Misplacement(key, value, bound, short, changes, "move the plates upward")]
