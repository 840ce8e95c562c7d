"""Rows of plates with the keys of the file that set them, and designs with one key changed."""

from dataclasses import dataclass

from pydantic import ValidationError

from fingerdesign.design.body import Body
from fingerdesign.design.keys import set_value
from fingerdesign.design.plates import Plates
from fingerdesign.design.schema import Design
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames


@dataclass(frozen=True)
class PlateRow:
    """One row of plates: its values, its frames, and the keys of its values in the file.

    ``number``: None for [plates] itself, else that of ``plates.rows``; ``own``: keys that the row
    gives itself, the others are those of [plates]. ``placed``: a ``plates.placement``.
    """

    table: Plates
    frames: tuple[PlateFrame, ...]
    number: int | None = None
    own: frozenset[str] = frozenset()
    placed: bool = False

    def key(self, name: str) -> str:
        """The dotted key that gave the row's value ``name``."""
        return f"plates.rows[{self.number}].{name}" if name in self.own else f"plates.{name}"

    def value(self, name: str) -> object:
        """The row's value ``name``, or the meaning of its absence."""
        value = getattr(self.table, name)
        return "(absent: the full extent)" if name == "span_mm" and value is None else value

    def blame(self, index: int, name: str) -> tuple[str, object]:
        """Key and value to blame for plate ``index``: the row's ``name``, or its own placement."""
        if self.placed and self.table.placement is not None:
            return f"plates.placement[{index}]", list(self.table.placement[index])
        return self.key(name), self.value(name)


def plate_rows(design: Design) -> tuple[PlateRow, ...]:
    """The rows that hold any plate, each with its frames; a placement is one row."""
    frames = plate_frames(design)
    plates = design.plates
    if plates.placement is not None:
        return (PlateRow(plates, frames, placed=True),) if frames else ()
    rows, start = [], 0
    for number, table in enumerate(plates.all_rows):
        own = frames[start : start + table.count]
        start += table.count
        own_keys = plates.rows[number - 1].model_dump(exclude_none=True) if number else {}
        if own:
            rows.append(PlateRow(table, own, number - 1 if number else None, frozenset(own_keys)))
    return tuple(rows)


def with_key(design: Design, key: str, value: object) -> Design | None:
    """A copy of a design with one dotted key of [body] or [plates] set; None: refused by itself. A
    revolved body's depth goes with its width."""
    table = key.partition(".")[0]
    old: Body | Plates = getattr(design, table)
    data = {table: old.model_dump(mode="json", exclude_none=True)}
    set_value(data, key, value)
    if data[table].get("shape") == "revolved":
        data[table]["depth_mm"] = data[table]["width_mm"]
    try:
        return design.model_copy(update={table: type(old).model_validate(data[table])})
    except ValidationError:
        return None
