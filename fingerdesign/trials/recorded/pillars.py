"""A thesis's lifts of a wooden object of five weights by two fingers of silicone pillars.

Of the public repository robertburk/ME_THESIS_ROBERT_BURKE (no licence: read it, quote it, do not
hand it on), Experimental Data/EXPERIMENTAL_DATA_20230426.xlsx. The sheet "Centre Grasping" has lifts
at fixed forces, whose colour is their outcome, and the forces that the thesis's own hand took; the
sheet "Friction Estimations" the forces of single pillars as they slip. The file is a zip archive
of XML.
"""

from __future__ import annotations

import re
import zipfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree

from fingerdesign.errors import DesignError, Fault

PATTERN = "EXPERIMENTAL_DATA_*.xlsx"
_SPACE = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_MOST_BYTES = 50_000_000  # of one part, unpacked; the author's have 0.4 MB
_FIRST_ROWS = (5, 17, 29, 41, 53)  # of the weights on "Centre Grasping": ten lifts each
_WEIGHTS_G = (250.0, 375.0, 500.0, 625.0, 750.0)
_LEGEND = {10: "held", 11: "slipped slowly", 12: "failed"}  # rows of column Z
_LADDER = [*"OPQRSTUVWXYZ", "AA", "AB", "AC"]
GRAVITY = 9.80665e-3  # N/g


@dataclass(frozen=True)
class Lift:
    """A lift at a fixed force. weight, force: N, of both fingers together; outcome: one of held,
    slipped slowly, failed."""

    weight: float
    force: float
    outcome: str


@dataclass(frozen=True)
class Pillar:
    """A pillar as it slips: its name, the lift it is of, and its two forces in N."""

    name: str
    lift: str
    normal: float
    tangential: float


@dataclass(frozen=True)
class PillarData:
    """What the workbook has. own: weight and force (N) of lifts by the thesis's hand."""

    lifts: tuple[Lift, ...]
    own: tuple[tuple[float, float], ...]
    pillars: tuple[Pillar, ...]


def read_pillars(path: Path) -> PillarData:
    """Read the workbook; DesignError where it is another file or lacks a sheet or the legend."""
    try:
        with zipfile.ZipFile(path) as archive:
            centre, friction = (_cells(archive, number) for number in (1, 3))
        return PillarData(
            tuple(_lifts(centre)), tuple(_own(centre)), tuple(_pillars(friction))
        )
    except (OSError, KeyError, ValueError, ElementTree.ParseError, zipfile.BadZipFile) as error:
        fault = Fault("recording", str(path), "the thesis's workbook", f"fetch it again ({error})")
        raise DesignError([fault]) from None


Cells = Mapping[str, tuple[str, int]]  # address to text and number of its fill


def _cells(archive: zipfile.ZipFile, sheet: int) -> Cells:
    shared = ["".join(each.itertext()) for each in _part(archive, "sharedStrings")]
    formats = _part(archive, "styles").find(f"{_SPACE}cellXfs")
    fills = [int(each.get("fillId", "0")) for each in formats if formats is not None]
    found = {}
    for cell in _part(archive, f"worksheets/sheet{sheet}").iter(f"{_SPACE}c"):
        value = cell.findtext(f"{_SPACE}v", "")
        text = shared[int(value)] if cell.get("t") == "s" and value else value
        found[cell.get("r", "")] = (text, fills[int(cell.get("s", "0"))])
    return found


def _part(archive: zipfile.ZipFile, name: str) -> ElementTree.Element:
    part = f"xl/{name}.xml"
    if archive.getinfo(part).file_size > _MOST_BYTES:
        raise ValueError(f"{part} has over {_MOST_BYTES} bytes")
    content = archive.read(part)
    if b"<!DOCTYPE" in content:  # Entities may grow without end; a workbook has none.
        raise ValueError(f"{part} defines entities")
    return ElementTree.fromstring(content)


def _number(cells: Cells, address: str) -> float | None:
    text = cells.get(address, ("", 0))[0]
    return float(text) if re.fullmatch(r"[\d.]+(E[-+]?\d+)?", text) else None


def _lifts(cells: Cells) -> Iterator[Lift]:
    outcome = {cells[f"Z{row}"][1]: name for row, name in _LEGEND.items()}
    if len(outcome) < len(_LEGEND):
        raise ValueError("its legend has no three colours")
    for weight, first in zip(_WEIGHTS_G, _FIRST_ROWS, strict=True):
        for column in _LADDER:
            for row in range(first, first + 5):
                force = _number(cells, f"{column}{row}")
                if force is not None and cells[f"{column}{row}"][1] in outcome:
                    fill = cells[f"{column}{row}"][1]
                    yield Lift(weight * GRAVITY, force, outcome[fill])


def _own(cells: Cells) -> Iterator[tuple[float, float]]:
    for weight, first in zip(_WEIGHTS_G, _FIRST_ROWS, strict=True):
        for row in range(first, first + 10):
            if (force := _number(cells, f"N{row}")) is not None:
                yield weight * GRAVITY, force


def _pillars(cells: Cells) -> Iterator[Pillar]:
    for sensor, first in ((1, 3), (2, 33)):
        for pillar in range(9):
            normal, tangential = (_column(first + 3 * pillar + k) for k in (0, 1))
            for row in range(4, 54):
                n, t = _number(cells, f"{normal}{row}"), _number(cells, f"{tangential}{row}")
                if n and t:
                    yield Pillar(f"{sensor}.{pillar}", f"{sensor}.{row}", n, t)


def _column(number: int) -> str:
    """Letters of a column: 1 is A, 27 is AA."""
    high, low = divmod(number - 1, 26)
    return (chr(64 + high) if high else "") + chr(65 + low)
