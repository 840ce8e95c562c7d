"""Whether plates lie clear of the contact surface, the base, the sides and the end faces.

Each fault names the worst plate (numbered from 0, row by row) and remedies that have been tried.
"""

from __future__ import annotations

from collections.abc import Set
from dataclasses import replace

import numpy as np

from fingerdesign.design import clearance
from fingerdesign.design.clearance import LEAST_CLEARANCE_MM
from fingerdesign.design.ends import end_findings, wall_findings
from fingerdesign.design.faults import at_least, at_most, involves
from fingerdesign.design.plate_rows import PlateRow, plate_rows, surface_keys
from fingerdesign.design.remedies import Change, Finding, least, set_to, worst_by_key
from fingerdesign.design.schema import Design
from fingerdesign.design.sides import CLOSE, side_findings


def placing_findings(design: Design, doubtful: Set[str], whole: bool = True) -> list[Finding]:
    """Every plate too near to a face of the body; one finding a key.

    Not ``whole``: only what is the same below any surface. A row whose plates reach the sides is
    not judged against the surface.
    """
    body = design.body
    found: list[Finding] = []
    for number, row in enumerate(plate_rows(design)):
        follows = set() if row.table.follow == "level" else surface_keys(body)
        if involves(doubtful, *row.where, *follows):
            continue
        beside, ends = side_findings(design, row, doubtful), list[Finding]()
        found += beside
        if not whole or any(not np.isfinite(frame.y) for frame in row.frames):
            continue
        if not involves(doubtful, *row.spanned):
            ends = end_findings(design, row, doubtful)
            found += ends
        level = {"body.base_height_mm"} if row.placed else row.keys("cover_mm")
        if beside or involves(doubtful, *surface_keys(body), *level):
            continue
        if not ends and not involves(doubtful, *row.spanned):
            found += wall_findings(design, row)
            found += _cover(design, row, number)
        if not involves(doubtful, "body.base_height_mm"):
            found += _base(design, row)
    return worst_by_key(found)


def _again(design: Design, number: int) -> PlateRow:
    return plate_rows(design)[number]


def _cover(design: Design, row: PlateRow, number: int) -> list[Finding]:
    distances = clearance.cover_clearances(design.body, row.frames)
    distances = np.where(np.isnan(distances), -np.inf, distances)
    worst = int(np.argmin(distances))
    if distances[worst] >= LEAST_CLEARANCE_MM - CLOSE:
        return []
    frame = row.frames[worst]
    key, value = row.blame(frame.index, "cover_mm")

    def clear(trial: Design) -> bool:
        distances = clearance.cover_clearances(trial.body, _again(trial, number).frames)
        return bool(distances.min() >= LEAST_CLEARANCE_MM - CLOSE)  # False for NaN

    def lower(down: float) -> bool:
        moved = (replace(frame, y=frame.y - down),)
        return bool(clearance.cover_clearances(design.body, moved)[0] >= LEAST_CLEARANCE_MM)

    def changes() -> list[Change]:
        room = max(frame.y, LEAST_CLEARANCE_MM)
        if row.placed:
            down = least(lower, 0.0, room)
            return [] if down is None else [Change(f"lower its y by at least {at_least(down)}")]
        cover = row.table.cover_mm
        raised = least(lambda c: set_to(design, key, c, clear), cover, cover + room)
        words = f"raise {key} to at least"
        return [] if raised is None else [Change.to(words, key, at_least(raised))]

    told = f"{distances[worst]:.4g}" if np.isfinite(distances[worst]) else "beyond it"
    bound = (
        f"such that plates lie {LEAST_CLEARANCE_MM} mm below the contact surface "
        f"(plate {frame.index}: {told})"
    )
    over = LEAST_CLEARANCE_MM - float(distances[worst])
    return [Finding(key, value, bound, over, changes, "move the plates inward")]


def _base(design: Design, row: PlateRow) -> list[Finding]:
    heights = np.array([frame.outline()[:, 1].min() for frame in row.frames])
    worst = int(np.argmin(heights))
    short = LEAST_CLEARANCE_MM - float(heights[worst])
    if short <= CLOSE:
        return []
    frame = row.frames[worst]
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
        f"(plate {frame.index}: {heights[worst]:.4g})"
    )
    return [Finding(key, value, bound, short, changes, "move the plates upward")]
