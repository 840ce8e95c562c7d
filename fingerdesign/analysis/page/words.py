"""The finger in words: its body, its core and its plates row by row, from the design's keys."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from fingerdesign.layout.frames import PlateFrame
from fingerdesign.records.result import Result
from fingerdesign.runtime.registry import BODIES


def finger_text(result: Result) -> str:
    """Body, core and plates in a few sentences; empty where the result does not hold them."""
    return finger_words(result.parameters)


def finger_words(keys: Mapping[str, Any]) -> str:
    """The same of a design's dotted keys (``body.width_mm``)."""
    if "body.shape" not in keys or "body.width_mm" not in keys:
        return ""
    return " ".join(part for part in (_body(keys), _core(keys), _plates(keys)) if part)


def plate_rows(plates: Sequence[PlateFrame], placed: bool = False) -> tuple[tuple[int, ...], ...]:
    """The plates by rows, by their places in ``plates``: of one direction, from - to +.

    placed: their centres were given one by one, in any order: one row.
    """
    if placed:
        return (tuple(range(len(plates))),) if plates else ()
    rows: list[list[int]] = []
    for k, plate in enumerate(plates):
        before = plates[k - 1] if k else None
        goes_on = before is not None and before.along == plate.along and before.place < plate.place
        if goes_on:
            rows[-1].append(k)
        else:
            rows.append([k])
    return tuple(tuple(row) for row in rows)


def count_text(number: int, what: str) -> str:
    """``number`` things in words.

    >>> count_text(1, "plate"), count_text(0, "plate"), count_text(15, "plate")
    ('1 plate', 'no plates', '15 plates')
    """
    return f"{number or 'no'} {what}{'' if number == 1 else 's'}"


def _body(keys: Mapping[str, Any]) -> str:
    shape = str(keys["body.shape"])
    wide, deep = float(keys["body.width_mm"]), float(keys.get("body.depth_mm") or 0.0)
    if shape == "step":
        return f"The body is the user's own STEP file, {wide:.4g} mm wide and {deep:.4g} mm deep."
    size = f"{wide:g} mm across" if shape == "revolved" else f"{wide:g} mm wide, {deep:g} mm deep"
    entry = BODIES.get(shape)
    top = ((entry and entry.made.words) or shape).format(
        radius=float(keys.get("body.arc_radius_mm") or 0.0),
        dome=float(keys.get("body.dome_radius_mm") or 0.0),
    )
    edge = keys.get("body.edge_radius_mm")
    if edge:
        made = "chamfered by" if keys.get("body.edge") == "chamfer" else "rounded with a radius of"
        top += f"; the edge between top and sides is {made} {float(edge):g} mm"
    return f"The body is {size}, with {top}."


def _core(keys: Mapping[str, Any]) -> str:
    if keys.get("body.core.width_mm") is None:
        return ""
    wide, high = float(keys["body.core.width_mm"]), float(keys["body.core.height_mm"])
    depth, bottom = keys.get("body.core.depth_mm"), float(keys.get("body.core.bottom_mm") or 0.0)
    deep = "over the full depth" if depth is None else f"{float(depth):g} mm deep"
    place = f"{bottom:g} mm above the base" if bottom else "standing on the base"
    material = str(keys.get("body.core.material", "a stiff material")).replace("_", " ")
    return (
        f"A core of {material}, {wide:g} mm wide, {high:g} mm high and {deep}, is bonded inside, "
        f"{place}."
    )


def _plates(keys: Mapping[str, Any]) -> str:
    plates = _plate_keys(keys)
    placement = plates.get("placement")
    if placement is not None:
        reported = [f"{count_text(len(placement), 'plate')} placed one by one"]
    else:
        reported = [_row(table) for table in _rows(plates)]
    if not reported:
        return "It has no plates."
    words = f"Inside lie {'; '.join(reported)}." if len(reported) > 1 else f"Inside: {reported[0]}."
    hole = plates.get("hole_diameter_mm")
    if hole:
        words += f" The plates are perforated, holes {float(hole):g} mm across."
    model = plates.get("model")
    if model == "sheet":
        words += " In the model they are sheets with membrane and bending stiffness."
    if model == "none":
        words += " The model leaves them out."
    return words


def read_plates_text(keys: Mapping[str, Any]) -> str:
    """Which plates slip study and grips read, a sentence after a space; empty where all are.

    >>> read_plates_text({"plates.count": 5, "plates.rows": [{"count": 3, "along": "z"}]})
    ' Of 8 plates the 5 in the row along x are read.'
    """
    plates = _plate_keys(keys)
    if plates.get("placement") is not None:
        return ""
    rows = _rows(plates)
    most = max((int(row["count"]) for row in rows if row.get("along", "x") == "x"), default=0)
    number = sum(int(row["count"]) for row in rows)
    several = sum(row.get("along", "x") == "x" for row in rows) > 1
    which = "one row" if several else "the row"
    return f" Of {number} plates the {most} in {which} along x are read." if most < number else ""


def _plate_keys(keys: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of ``[plates]`` without its name."""
    return {
        key.removeprefix("plates."): value
        for key, value in keys.items()
        if key.startswith("plates.")
    }


def _rows(plates: Mapping[str, Any]) -> list[dict[str, Any]]:
    """Every row of plates with the keys that it takes from ``[plates]``; those of no plate not."""
    rows = [{}, *(plates.get("rows") or [])]
    tables = [{**plates, **{k: v for k, v in row.items() if v is not None}} for row in rows]
    return [table for table in tables if table.get("count")]


def _row(row: Mapping[str, Any]) -> str:
    """One row in words, from its keys."""
    words = f"{count_text(int(row['count']), 'plate')} in a row along {row.get('along') or 'x'}"
    cover = row.get("cover_mm")
    if cover is not None:
        words += f", {float(cover):g} mm below the surface"
    how = {"turned": "turned with the surface", "bent": "bent to the surface"}
    follow = how.get(str(row.get("follow")))
    words += f", {follow}" if follow else ""
    angle = row.get("angle_deg")
    if angle is not None:
        words += f", at {float(angle):g} degrees"
    if row.get("stagger_mm"):
        words += f", staggered by {float(row['stagger_mm']):g} mm"
    return words
