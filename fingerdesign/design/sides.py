"""Whether plates stay between the body's sides along their row."""

from __future__ import annotations

from collections.abc import Set

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.design.clearance import LEAST_CLEARANCE_MM
from fingerdesign.design.faults import at_least, at_most, involves
from fingerdesign.design.gaps import flat_corners
from fingerdesign.design.plate_rows import PlateRow
from fingerdesign.design.remedies import Change, Finding, greatest
from fingerdesign.design.rows import row_frames
from fingerdesign.design.schema import Body, Design, Plates

CLOSE = 1e-9  # mm; rounding


def limits(body: Body, row: PlateRow) -> tuple[str, str, float, str, str, float]:
    """Axis, key and half-extent of the body along the row, then across it."""
    x = ("x", "body.width_mm", 0.5 * body.width_mm)
    z = ("z", "body.depth_mm" if body.shape != "revolved" else x[1], 0.5 * body.depth_mm)
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
    if table.follow != "level":
        return float(side_reaches(PlateRow(table, tuple(row_frames(body, table, 0)))).max())
    angle = np.radians(table.angle_deg)
    own = table.length_mm * abs(np.cos(angle)) + table.thickness_mm * abs(np.sin(angle))
    row = 0.5 * (table.count - 1) * table.pitch_mm
    return float(abs(table.offset_mm) + row + 0.5 * own)


def side_findings(design: Design, row: PlateRow, doubtful: Set[str]) -> list[Finding]:
    """A row whose plates come too near to the sides, or lie where the surface has ended."""
    axis, wide, half, *_ = limits(design.body, row)
    if involves(doubtful, wide):
        return []
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

    told = f"{reach[worst]:.4g}" if np.isfinite(reach[worst]) else "beyond the surface"
    bound = (
        f"such that plates stay {LEAST_CLEARANCE_MM} mm inside |{axis}| = {half:g} "
        f"(plate {frame.index} reaches {told})"
    )
    over = float(min(reach[worst], 1e6)) - allowed
    return [Finding(key, value, bound, over, changes, "move the plates inward or shorten them")]
