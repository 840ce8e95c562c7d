"""Plates too near to each other, to other rows' plates, or to the core."""

from collections.abc import Callable
from itertools import chain

from fingerdesign.checks.placing import row_reach
from fingerdesign.checks.remedies import (
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
from fingerdesign.design.schema import Design, Plates
from fingerdesign.layout.clearance import LEAST_CLEARANCE_MM
from fingerdesign.layout.gaps import PlateGap, core_gaps, least_gap
from fingerdesign.layout.row_keys import PlateRow, plate_rows
from fingerdesign.layout.rows import row_frames

# Gap between plates, in thicknesses: below it, the rubber between is thinner than half a plate.
LEAST_GAP = 0.5
_MOST_PAIRS = 120  # A remedy for more pairs of plates would take over a second.
_SHORTER = "shorten, thin or turn the plates, or lower plates.count"


def spacing_findings(design: Design) -> list[Misplacement]:
    """Find plates too near to each other, row by row and row against row; or to the core."""
    rows = plate_rows(design)
    numbers = range(len(rows))
    found = [
        *(_within(design, row) for row in rows),
        *(_between(design, first, number) for number in numbers for first in range(number)),
        *(_core(design, number) for number in numbers),
    ]
    return worst_by_key(chain.from_iterable(found))


def _least(design: Design) -> float:
    return LEAST_GAP * design.plates.thickness_mm


def _bound(design: Design, gap: PlateGap) -> str:
    near = "cross" if gap.distance == 0 else f"come within {gap.distance:.4g}"
    apart = f"such that plates stay {_least(design):g} mm (half a thickness) apart"
    return f"{apart} (plates {gap.first} and {gap.second} {near})"


def _within(design: Design, row: PlateRow) -> list[Misplacement]:
    gap, apart = least_gap(row.frames), _least(design)
    if gap is None or gap.distance >= apart - 1e-9:
        return []
    key, value = row.blame(gap.second, "pitch_mm")

    def changes() -> list[Change]:
        if row.placed:
            return [Change(f"move it away from plate {gap.first}")]
        pitch = _wider_pitch(design, row)
        words = f"raise {key} to at least"
        return [] if pitch is None else [Change.to(words, key, at_least(pitch))]

    short = apart - gap.distance
    return [Misplacement(key, value, _bound(design, gap), short, changes, _SHORTER)]


def _wider_pitch(design: Design, row: PlateRow) -> float | None:
    """Find the least pitch from which neighbours are apart, up to the widest that the body
    holds."""
    half = 0.5 * (design.body.width_mm if row.table.along == "x" else design.body.depth_mm)

    def at(pitch: float) -> Plates:
        return row.table.model_copy(update={"pitch_mm": pitch})

    def fits(pitch: float) -> bool:
        return row_reach(design.body, at(pitch)) <= half - LEAST_CLEARANCE_MM

    def apart(pitch: float) -> bool:
        gap = least_gap(tuple(row_frames(design.body, at(pitch), 0)))
        return gap is not None and gap.distance >= _least(design)

    low = row.table.pitch_mm
    enough = row.table.length_mm + row.table.thickness_mm + _least(design)
    widest = greatest(fits, low, max(enough, 2.0 * low))
    if widest is None or not apart(widest):
        return None
    return least(apart, low, widest)


def _between(design: Design, number: int, later: int) -> list[Misplacement]:
    rows = plate_rows(design)
    first, second = rows[number], rows[later]
    gap, apart = least_gap(first.frames, second.frames), _least(design)
    if gap is None or gap.distance >= apart - 1e-9:
        return []
    key, cover = f"plates.rows[{second.number}].cover_mm", second.table.cover_mm
    value = cover if "cover_mm" in second.own else f"(absent: plates.cover_mm = {cover:g})"

    def changes() -> list[Change]:
        if len(first.frames) * len(second.frames) > _MOST_PAIRS:
            return []
        lowest = min(frame.y for frame in second.frames)
        clear = mended_by(design, key, lambda trial: _between(trial, number, later))
        deeper = least(clear, cover, cover + max(lowest, apart))
        found = [] if deeper is None else [Change.to(f"set {key} to", key, at_least(deeper))]
        higher = greatest(lambda less: not clear(cover - less), 0.0, cover - 0.01)
        if higher is not None and higher < cover - 0.02:
            found.append(Change.to(f"set {key} to", key, at_most(cover - higher - 1e-3)))
        return found

    short = apart - gap.distance
    remedy = "move the rows apart"
    return [Misplacement(key, value, _bound(design, gap), short, changes, remedy)]


def _core(design: Design, number: int) -> list[Misplacement]:
    core, row = design.body.core, plate_rows(design)[number]
    if core is None:
        return []
    distances = core_gaps(core, design.body.core_depth_mm, row.frames)
    nearest = too_near(row, distances, float("inf"))
    if nearest is None:
        return []
    frame, distance = nearest
    key, value = row.blame(frame.index, "cover_mm")

    def clear(key: str) -> Callable[[object], bool]:
        return mended_by(design, key, lambda trial: _core(trial, number))

    def changes() -> list[Change]:
        found, cover = [], row.table.cover_mm
        if not row.placed:
            up = least(lambda less: clear(key)(cover - less), 0.0, cover - 0.01)
            if up is not None:
                found.append(Change.to(f"lower {key} to at most", key, at_most(cover - up)))
        high = "body.core.height_mm"
        most = greatest(clear(high), 0.1, core.height_mm)
        if most is not None:
            found.append(Change.to(f"lower {high} to at most", high, at_most(most)))
        return found

    near = "crosses it" if distance == 0 else f"comes within {distance:.4g}"
    bound = f"{STAY} from the core (plate {frame.index} {near})"
    short = LEAST_CLEARANCE_MM - distance
    remedy = "move the plates away from [body.core]"
    return [Misplacement(key, value, bound, short, changes, remedy)]
