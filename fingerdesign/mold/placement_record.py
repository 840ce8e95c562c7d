"""The record of what plates off their places do to the gages, and what it says in words."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from fingerdesign.arrays import Array
from fingerdesign.errors import SolverError
from fingerdesign.layout.frames import plate_frames, surface_height

if TYPE_CHECKING:
    from fingerdesign.design.scene import Scene
    from fingerdesign.design.schema import Design
    from fingerdesign.layout.frames import PlateFrame

Effect = dict[str, Any]

CHANGES = ("along_x", "in_height", "turned")
_READS = 1e-6  # microstrain: a row whose largest reading is below it has none to be relative to


def effect_record(
    design: Design,
    frames: tuple[PlateFrame, ...],
    off: Array,
    right: Array,
    apart: Array,
    shares: Array,
    scene: Scene,
) -> Effect:
    """The record of readings ``right`` (rows, gages), microstrain, and of their changes.

    off (gages, 2): what each plate may be off, mm and degrees. apart (ways, 3, rows, gages):
    changes of readings, by CHANGES; all plates alike first, every second one the other way last.
    shares (3,): how much of each change was solved, to be enlarged. Raises SolverError where no
    gage reads.
    """
    most = np.abs(right).max(axis=1)
    sampled = most > _READS
    if not sampled.any():
        raise SolverError("no gage reads anything in the section")
    ways = np.abs(apart[:, :, sampled]) / most[sampled][:, None]
    share = ways.max(axis=0)
    together = np.sqrt((share**2).sum(axis=0))
    sizes = [round(float(off[:, k].max()), 6) for k in (0, 0, 1)]
    changes = [
        {"name": name, "largest": sizes[k], "unit": "mm" if k < 2 else "degrees"}
        | _summary(share[k], frames)
        | {"rms_alike": _rms(ways[0, k]), "rms_opposed": _rms(ways[-1, k])}
        | {"share_solved": float(shares[k])}
        for k, name in enumerate(CHANGES)
    ]
    cover = _covers(design, frames)
    gages = [
        {"plate": frame.index, "x_mm": round(frame.place, 4), "surface_mm": round(cover[k], 4)}
        | {name: float(share[j, :, k].max()) for j, name in enumerate(CHANGES)}
        | {"together": float(together[:, k].max())}
        for k, frame in enumerate(frames)
    ]
    found: Effect = {
        "tolerance_mm": sizes[0],
        "angle_deg": sizes[2],
        "changes": changes,
        "together": _summary(together, frames),
        "gages": gages,
        "friction_coefficient": scene.object.friction_coefficient,
        "increments_mm": [[round(value, 5) for value in row[:2]] for row in scene.path.rows],
        "largest_reading_microstrain": [float(value) for value in most],
    }
    return found | {"sentences": _sentences(design, found)}


def with_row(
    found: Effect,
    frames: tuple[PlateFrame, ...],
    tolerance: float,
    right: Array,
    apart: Array,
    shares: list[float],
) -> Effect:
    """The record with what the whole row does, off by ``tolerance`` mm along x and in height.

    apart (2, rows, gages): changes of the readings ``right``, microstrain.
    """
    most = np.abs(right).max(axis=1)
    sampled = most > _READS
    share = np.abs(apart[:, sampled]) / most[sampled][:, None]
    changes: list[Effect] = [
        {"name": name, "largest": round(tolerance, 6), "unit": "mm"}
        | _summary(share[k], frames)
        | {"share_solved": float(shares[k])}
        for k, name in enumerate(CHANGES[:2])
    ]
    both = _summary(np.sqrt((share**2).sum(axis=0)), frames)
    x, y = changes
    said = (
        f"The whole row is off against the contact surface by up to {tolerance:.2g} mm (clearance "
        "of the mold's pins and the process's tolerance), whatever holds the plates: along x that "
        f"changes a reading by up to {_percent(x['worst'])} of the largest, in height by up to "
        f"{_percent(y['worst'])}; together by up to {_percent(both['worst'])}, "
        f"{_percent(both['rms'])} root mean square."
    )
    sentences = [found["sentences"][0], said, *found["sentences"][1:]]
    row = {"tolerance_mm": round(tolerance, 6), "changes": changes, "together": both}
    return found | {"row": row, "sentences": sentences}


def _summary(share: Array, frames: tuple[PlateFrame, ...]) -> Effect:
    """RMS and worst of shares (rows, gages), and whose the worst is."""
    worst = int(share.max(axis=0).argmax())
    return {
        "rms": _rms(share),
        "worst": float(share.max()),
        "worst_plate": frames[worst].index,
    }


def _rms(values: Array) -> float:
    return float(np.sqrt((values**2).mean()))


def _covers(design: Design, frames: tuple[PlateFrame, ...]) -> list[float]:
    """Height of the surface above each plate's centre, mm."""
    places = np.array([frame.place for frame in frames])
    heights = surface_height(design.body, places)
    return [float(h - frame.y) for h, frame in zip(heights, frames, strict=True)]


def _sentences(design: Design, found: Effect) -> list[str]:
    """What the numbers say, for the report."""
    x, y, turned = found["changes"]
    both = found["together"]
    said = [
        f"Among the others, a plate {x['largest']:.2g} mm off along x changes a reading by up to "
        f"{_percent(x['worst'])} of the largest, one {y['largest']:.2g} mm off in height by up to "
        f"{_percent(y['worst'])}, one turned by {turned['largest']:.2g} degrees by up to "
        f"{_percent(turned['worst'])}; together by up to {_percent(both['worst'])}, "
        f"{_percent(both['rms'])} root mean square."
    ]
    worst = max(found["gages"], key=lambda each: float(each["in_height"]))
    said.append(
        f"Height counts most for plate {worst['plate']} at x = {worst['x_mm']:g} mm, "
        f"{worst['surface_mm']:.3g} mm below the surface."
    )
    partial = [each["name"] for each in found["changes"] if each["share_solved"] < 1.0]
    if partial:
        said.append(
            f"Plates lie too close for the whole change ({', '.join(partial).replace('_', ' ')}): "
            "a part was solved and enlarged in proportion."
        )
    if design.body.shape not in ("arc", "block") or not design.extruded:
        said.append("In plane strain, of a finger that is not its mid-section throughout: a guide.")
    if any(frame.span < design.body.depth_mm - 1e-9 for frame in plate_frames(design)):
        said.append("Legs of embedded plates stay in the rubber; the section does not show them.")
    else:
        said.append("Legs are trimmed flush with the rubber, which moves no plate.")
    return said


def _percent(share: float) -> str:
    """A share in percent, two digits.

    >>> _percent(0.0312), _percent(1.234)
    ('3.1 %', '120 %')
    """
    value = 100.0 * share
    if value >= 10.0:
        value = round(value, 1 - math.floor(math.log10(value)))
        return f"{value:.0f} %"
    return f"{value:.2g} %"
