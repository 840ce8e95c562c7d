"""A thesis's lifts of a wooden object of five weights by two fingers of silicone pillars.

Of the public repository robertburk/ME_THESIS_ROBERT_BURKE (no licence: read it, quote it, do not
hand it on), Experimental Data/EXPERIMENTAL_DATA_20230426.xlsx. The first sheet has lifts at fixed
forces, whose colour is their outcome, and the forces that the thesis's own hand took; the third
the forces of single pillars as they slip. The file is a zip archive of XML.
"""

import lzma
import zipfile
import zlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree

from fingerdesign.errors import DesignError, Fault

SOURCE = "robertburk/ME_THESIS_ROBERT_BURKE, no licence"
# What a damaged archive, or one of other content, raises.
_DAMAGED = (EOFError, zlib.error, lzma.LZMAError, zipfile.BadZipFile)
ZIP_ERRORS = (OSError, LookupError, ValueError, RuntimeError, *_DAMAGED)
PATTERN = "EXPERIMENTAL_DATA_*.xlsx"
_SPACE = "{http://schemas.openxmlformats.org/spreadsheetml/2006/main}"
_MOST_BYTES = 50_000_000  # of one part, unpacked; the author's have 0.4 MB
# First row, of ten, of each weight, N.
_WEIGHTS = {5 + 12 * k: (250 + 125 * k) * 9.80665e-3 for k in range(5)}
_LEGEND = {"held": "Z10", "slipped slowly": "Z11", "failed": "Z12"}  # cells of these colours
_LADDER = [*"OPQRSTUVWXYZ", "AA", "AB", "AC"]  # columns of rising forces


class Lift(NamedTuple):
    """A lift: weight, and force of both fingers together, N; outcome: held, slipped slowly or
    failed."""

    weight: float
    force: float
    outcome: str


class Pillar(NamedTuple):
    """A pillar as it slips: its name, the lift it is of, and its two forces in N."""

    name: str
    lift: str
    normal: float
    tangential: float


@dataclass(frozen=True)
class PillarData:
    """The workbook: lifts at fixed forces, by the thesis's own hand, and single pillars."""

    lifts: tuple[Lift, ...]
    own: tuple[Lift, ...]
    pillars: tuple[Pillar, ...]


_Cells = Mapping[str, tuple[str, str]]  # address to text and fill


def read_pillars(path: Path) -> PillarData:
    """Read the workbook; DesignError where it is another file."""
    try:
        with zipfile.ZipFile(path) as archive:
            centre, friction = (_cells(archive, number) for number in (1, 3))
        lifts, own = tuple(_lifts(centre)), tuple(_own(centre))
        data = PillarData(lifts, own, tuple(_pillars(friction)))
        if len({each.weight for each in lifts if each.outcome == "slipped slowly"}) < 3:
            raise ValueError("fewer than three weights slip slowly")
        return data
    except (*ZIP_ERRORS, ElementTree.ParseError) as error:
        fault = Fault("recording", str(path), "the thesis's workbook", f"fetch it again ({error})")
        raise DesignError([fault]) from None


def _cells(archive: zipfile.ZipFile, sheet: int) -> _Cells:
    shared = ["".join(each.itertext()) for each in _part(archive, "sharedStrings")]
    formats = _part(archive, "styles").iterfind(f"{_SPACE}cellXfs/{_SPACE}xf")
    fills = [each.get("fillId", "") for each in formats]
    found = {}
    for cell in _part(archive, f"worksheets/sheet{sheet}").iter(f"{_SPACE}c"):
        text = cell.findtext(f"{_SPACE}v", "")
        text = shared[int(text)] if cell.get("t") == "s" and text else text
        found[cell.get("r", "")] = (text, fills[int(cell.get("s", "0"))])
    return found


def _part(archive: zipfile.ZipFile, name: str) -> ElementTree.Element:
    part = archive.getinfo(f"xl/{name}.xml")
    content = archive.read(part) if part.file_size <= _MOST_BYTES else b""
    if not content or b"<!DOCTYPE" in content:  # Its entities might grow without end.
        raise ValueError(f"{name} is no part of a workbook")
    return ElementTree.fromstring(content)


def _force(cells: _Cells, address: str) -> float | None:
    """The number of a cell; None where it has none, or a dash."""
    text = cells.get(address, ("", ""))[0]
    force = float(text) if text.strip(" -") else None
    if force is not None and not abs(force) <= 1000.0:
        raise ValueError(f"{address} holds {text}, which is no force")
    return force


def _lifts(cells: _Cells) -> Iterator[Lift]:
    outcome = {cells[address][1]: name for name, address in _LEGEND.items()}
    for first, weight in _WEIGHTS.items():
        for address in (f"{column}{first + k}" for column in _LADDER for k in range(5)):
            force = _force(cells, address)
            if force is not None and cells[address][1] in outcome:
                yield Lift(weight, force, outcome[cells[address][1]])


def _own(cells: _Cells) -> Iterator[Lift]:
    for first, weight in _WEIGHTS.items():
        for row in range(first, first + 10):
            if (force := _force(cells, f"N{row}")) is not None:
                yield Lift(weight, force, "held")


def _pillars(cells: _Cells) -> Iterator[Pillar]:
    columns = [*map(chr, range(65, 91)), *(f"{a}{chr(b)}" for a in "AB" for b in range(65, 91))]
    for sensor, first in ((1, 2), (2, 32)):
        for pillar in range(9):
            place = first + 3 * pillar
            for row in range(4, 54):
                n, t = (_force(cells, f"{columns[place + k]}{row}") for k in (0, 1))
                if n and t:
                    yield Pillar(f"{sensor}.{pillar}", f"{sensor}.{row}", n, t)
