"""The atlas: fingers whose verdicts were found in 3-D, for `new --lift --gages --process`.

data/atlas.json is made by `fingerdesign bench atlas`, from a shipped design and some keys for each
finger. An entry is taken by what it lacks of a request, in doublings of mass; another kind of gage
or a mold that cannot be made weighs more than any mass.
"""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, Literal, get_args

from pydantic import TypeAdapter

from fingerdesign.checks.load import load_design, with_values
from fingerdesign.design.mold import ProcessName
from fingerdesign.design.schema import Design
from fingerdesign.design.stock import GageType
from fingerdesign.records.base import DATA, strict
from fingerdesign.records.verdict import Verdict

FILE = DATA / "atlas.json"
GageSource = Literal["film", "bought"]
SOURCES: tuple[str, ...] = get_args(GageSource)
PROCESSES: tuple[ProcessName, ...] = get_args(ProcessName)
_OTHER_GAGES, _NO_MOLD, _NOT_READY = 1e4, 100.0, 1.0  # In doublings of mass.


@strict
@dataclass(frozen=True)
class MoldOutcome:
    """A mold by one process.

    status: refused where it cannot be planned, failed where a check does not pass. passed, checks:
    their numbers. reading_error: greatest change of a reading by plates off their places, a share.
    ready: as a sensor. reasons: why it is not, or why there is no mold.
    """

    status: Literal["ok", "failed", "refused"]
    passed: int = 0
    checks: int = 0
    reading_error: float | None = None
    ready: bool = False
    reasons: tuple[str, ...] = ()

    @property
    def words(self) -> str:
        """The outcome in a line."""
        if self.status == "refused":
            return f"no mold: {self.reasons[0] if self.reasons else 'refused'}"
        error = "" if self.reading_error is None else f", readings within {self.reading_error:.0%}"
        return f"mold passes {self.passed} of {self.checks} checks{error}"


@strict
@dataclass(frozen=True)
class Entry:
    """A verified finger: a shipped design with the keys ``values``, and what was found.

    digest: of the design, so that a change of either is seen. commit: of the state that judged it.
    molds: by process.
    """

    name: str
    design: str
    values: dict[str, int | float | str | tuple[float, ...]]
    digest: str
    commit: str
    mesher: str
    gages: GageSource
    gage: str
    masses_g: tuple[float, ...]
    friction_coefficients: tuple[float, ...]
    verdicts: tuple[Verdict, ...]
    molds: dict[ProcessName, MoldOutcome]

    def finger(self) -> Design:
        """The design, judged like a file. DesignError where it is no longer sound."""
        return finger_of(self.design, self.values)

    @property
    def words(self) -> str:
        """A line: the masses and frictions that the finger was verified for."""
        masses = "–".join(f"{each:g}" for each in self.masses_g)
        own = self.friction_coefficients
        frictions = "–".join(f"{each:g}" for each in dict.fromkeys((min(own), max(own))))
        return f"lifts {masses} g at μ {frictions}, {self.gages} gages ({self.gage})"


@strict
@dataclass(frozen=True)
class Atlas:
    """All entries."""

    schema_version: Literal[1]
    entries: tuple[Entry, ...]


@dataclass(frozen=True)
class Request:
    """Wishes of a user for a finger; None or empty: anything."""

    masses_g: tuple[float, ...] = ()
    gages: str | None = None
    process: str | None = None


def finger_of(design: str, values: Mapping[str, Any]) -> Design:
    """A shipped design with keys set, judged like a file."""
    known = load_design(design)
    return with_values(known, dict(values)) if values else known


def source_of(type_: GageType) -> GageSource:
    """Film is made on the plates; all else is bought."""
    return "film" if type_.kind == "film" else "bought"


@cache
def atlas() -> Atlas:
    return TypeAdapter(Atlas).validate_json(FILE.read_text("utf-8"))


def nearest(request: Request) -> Entry:
    """The entry that lacks least; of equal ones that of the narrowest masses, then the first."""

    def order(entry: Entry) -> tuple[float, float]:
        return distance(entry, request), entry.masses_g[-1] / entry.masses_g[0]

    return min(atlas().entries, key=order)


def distance(entry: Entry, request: Request) -> float:
    """Lack of the entry, in doublings of mass; 0 where all is met."""
    found, own, wish = 0.0, entry.masses_g, request.masses_g
    if wish:
        below, above = math.log2(own[0] / wish[0]), math.log2(wish[-1] / own[-1])
        found += max(below, 0.0) + max(above, 0.0)
    if request.gages not in (None, entry.gages):
        found += _OTHER_GAGES
    if request.process is not None:
        mold = _mold(entry, request)
        found += _NO_MOLD * (mold.status != "ok") + _NOT_READY * (not mold.ready)
    return found


def unmet(entry: Entry, request: Request) -> Iterator[str]:
    """Sentences on what the entry does not meet."""
    own, wish = entry.masses_g, request.masses_g
    if wish and wish[0] < own[0]:
        yield f"{wish[0]:g} g: verified from {own[0]:g} g on"
    if wish and wish[-1] > own[-1]:
        yield f"{wish[-1]:g} g: verified up to {own[-1]:g} g"
    if request.gages not in (None, entry.gages):
        yield f"{request.gages} gages: no such finger is verified; these are {entry.gages}"
    for verdict in entry.verdicts:
        if verdict.status in ("fail", "warning"):
            yield f"{verdict.name}: {verdict.number}, {verdict.target}"
    if request.process is None:
        return
    mold = _mold(entry, request)
    if mold.status != "ok":
        yield f"{request.process}: {mold.words}"
    elif not mold.ready:
        yield from (f"{request.process}, ready as a sensor: {reason}" for reason in mold.reasons)


def _mold(entry: Entry, request: Request) -> MoldOutcome:
    """The mold by the requested process; refused where none was tried."""
    found = {str(process): mold for process, mold in entry.molds.items()}
    return found.get(str(request.process), MoldOutcome("refused", reasons=("none was tried",)))
