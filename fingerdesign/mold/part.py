"""Parts of a mold as triangles, with what is known of each, as the CAD makes them; numpy only."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Generic, Literal, Protocol, TypeVar

from fingerdesign.arrays import Array, IntArray

Point = tuple[float, float, float]
Made = Literal["process", "sheet", "metal", "silicone"]

EDGE_DEG = 30.0  # the sharpest edge of a wall
INSERT, BASE, CORE, RUBBER = "contact_insert", "base_plate", "core", "rubber"
BASE_FRAME = "base_frame"  # of a closed mold: it holds the base plate to the walls
FINGER, MOUNT, SPACER = "finger", "mount", "spacer"  # as cast; its receiver; under the mold
COUPON, COUPON_PIN, CELL, COUPON_COMB = "coupon", "coupon_pin", "coupon_cell", "coupon_comb"
OUTER = "_outer"  # ends the names of combs on the outside: no part of the filled block


COLOURS = {  # by the first word of a part's name
    "contact": "#5b8fc7",
    **dict.fromkeys(("end", "frame", "cell"), "#7fae8c"),
    "side": "#a9b6a0",
    "comb": "#c9a227",
    "base": "#8b8f99",
    "core": "#5f8f4e",
    "rubber": "#8fb4cf",
    "plate": "#b5652a",
    "gage": "#1f7a4d",
    "lead": "#b3261e",
    **dict.fromkeys(("mount", "spacer"), "#6f6a8c"),
    **dict.fromkeys(("bolts", "pins"), "#4b5563"),
    "band": "#8c2f5b",
    "clay": "#9a7b4f",
    "tape": "#d9b44a",
}


def colour_of(name: str) -> str:
    """The colour of a part, or of an aid, by its name."""
    return COLOURS[name.removeprefix("coupon_").partition("_")[0]]


def point(values: Iterable[float]) -> Point:
    """Three numbers as a plain tuple."""
    x, y, z = map(float, values)
    return x, y, z


def axis_name(draw: Sequence[float]) -> str:
    """The axis that a draw runs along.

    >>> axis_name((0.0, 1.0, 0.0)), axis_name((0.0, 0.0, -1.0))
    ('+y', '-z')
    """
    axis = max(range(3), key=lambda k: abs(draw[k]))
    return f"{'+' if draw[axis] > 0 else '-'}{'xyz'[axis]}"


@dataclass(frozen=True)
class PartMesh:
    """One part in its place in the closed mold (mold space, mm), wound outward.

    draw    unit direction in which it is taken off; None: it stays with the finger
    order   parts of a lower order are taken off before; those of one order together
    made    by the "process" of the mold, of "sheet" metal, "metal" (plates), or "silicone"
    volume  of the exact solid, mm^3; chord: the greatest distance found between the triangles and
            the exact surface, mm; blank_volume: of the part before pins, holes, slots and
            windows, by which cavity and mold fill the block
    """

    name: str
    vertices: Array
    triangles: IntArray
    draw: Point | None
    order: int
    made: Made
    volume: float
    chord: float
    blank_volume: float


class _Named(Protocol):
    @property
    def name(self) -> str: ...


Kind = TypeVar("Kind", bound=_Named)
Other = TypeVar("Other", bound=_Named)


@dataclass(frozen=True)
class MoldParts(Generic[Kind]):
    """All of a built mold, as solids or as triangles.

    parts    insert, walls, combs, base plate, core; those that are made
    plates   each plate as cut, with its legs, in its place
    rubber   the elastomer in mold space: the enlarged outline without plates (legs too) and core
    outline  the enlarged outline: elastomer, plates and core of the design, without legs
    low, high   corners of the block that cavity and blanks fill, base plate left out
    coupon   pieces of the test coupon, which are no part of the mold
    """

    parts: tuple[Kind, ...]
    plates: tuple[Kind, ...]
    rubber: Kind
    outline: Kind
    low: Point
    high: Point
    coupon: tuple[Kind, ...] = ()

    def part(self, name: str) -> Kind:
        """The part of a name; KeyError for another."""
        return {each.name: each for each in self.parts}[name]

    def each(self, made: Callable[[Kind], Other]) -> MoldParts[Other]:
        """The same of what is ``made`` of each."""
        kinds = self.parts, self.plates, self.coupon
        parts, plates, coupon = (tuple(map(made, some)) for some in kinds)
        last = made(self.rubber), made(self.outline)
        return MoldParts(parts, plates, *last, self.low, self.high, coupon)


MoldMeshes = MoldParts[PartMesh]


@dataclass(frozen=True)
class Check:
    """One thing that was checked: ``measured`` against ``bound`` in ``unit``, and in words.

    part: its name, or "" for the mold as a whole. A check that is not ``ok`` fails the mold.
    """

    name: str
    part: str
    ok: bool
    measured: float | None
    bound: float | None
    unit: str
    sentence: str

    @classmethod
    def most(
        cls, name: str, part: str, measured: float, bound: float, unit: str, sentence: str
    ) -> Check:
        """Check that ``measured`` is at most ``bound``."""
        return cls(name, part, bool(measured <= bound), float(measured), bound, unit, sentence)

    @classmethod
    def least(
        cls, name: str, part: str, measured: float, bound: float, sentence: str, slack: float = 0.0
    ) -> Check:
        """Check that ``measured`` is at least ``bound``, mm, but for some ``slack``."""
        ok = bool(measured >= bound - slack)
        return cls(name, part, ok, float(measured), bound, "mm", sentence)

    @classmethod
    def none(
        cls, name: str, part: str, wrong: Sequence[str], unit: str, right: str, words: str
    ) -> Check:
        """That nothing is ``wrong``; in ``words`` stand the count and {0}, the first of it."""
        sentence = words.format(*wrong[:1]) if wrong else right
        return cls(name, part, not wrong, float(len(wrong)), 0.0, unit, sentence)
