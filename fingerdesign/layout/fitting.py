"""Products on sale that fit a design: gages on its plates, sheet of its plates' thickness.

A gage fits where its carrier lies on the plate, its grid in the middle of the design's gage, clear
of holes, and where it can be bent as the plate is. Lengths in mm.
"""

import math
from dataclasses import dataclass

from fingerdesign.design.schema import Design
from fingerdesign.design.stock import GageType, nearest_sheet, sheets_of
from fingerdesign.layout.frames import PlateFrame
from fingerdesign.layout.rows import plate_frames

_ROUNDING_MM = 1e-9
# Of a grid's length or width against what the design averages over: beyond it the readings of the
# model are another gage's. Strain along a plate falls to nothing at its ends, so a third is much.
_ALIKE = 1.33
_STIFFENS = 0.05  # of the plate's own stiffness: as much as leads may change a reading
_STIFFEST = 1.0  # of the plate: a bar that is stiffer than it is no remedy


@dataclass(frozen=True)
class GageFit:
    """The gage that the plates take.

    found     the type whose grid is the nearest to the design's, of those that fit; None: none does
    nearest   the type that needs the least change of the plates; None: no type is of this kind
    length, width   what the plates must have for ``nearest``, along the grid and across, mm
    room      length and width that the smallest plate has, mm
    films     names of types made to measure that would fit
    others    names of types that fit and can read so: of the named kind first, then by their grid
    """

    found: GageType | None
    nearest: GageType | None
    length: float
    width: float
    room: tuple[float, float]
    films: tuple[str, ...]
    others: tuple[str, ...]

    def differs_from(self, design: Design) -> bool:
        """True where the grid that fits is another than the design averages over."""
        if self.found is None or self.found.to_measure:
            return False
        return max(_apart(design, self.found)) > math.log(_ALIKE)


def gage_fit(design: Design) -> GageFit | None:
    """Find the gage that goes onto every plate of a sound design; None: it has no plates."""
    frames = plate_frames(design)
    if not frames:
        return None
    every = design.gage_types
    target = _target(design, every)
    room = min(frame.length for frame in frames), min(_across(design, each) for each in frames)
    fitting = [each for each in every if _fits(design, each, frames, room)]
    found = [each for each in fitting if each in target]
    kinds = {each.kind for each in target}
    nearest = min(target, key=lambda each: _growth(design, each, room), default=None)
    length, width = _needed(design, nearest) if nearest is not None else (0.0, 0.0)
    alike = sorted(fitting, key=lambda each: (each.kind not in kinds, sum(_apart(design, each))))
    return GageFit(
        min(found, key=lambda each: sum(_apart(design, each)), default=None),
        nearest,
        *(max(length, room[0]), max(width, room[1])),
        room,
        tuple(each.name for each in fitting if each.to_measure),
        tuple(
            each.name
            for each in alike
            if each.kind in (*_kinds(design), "film")
            or (each.kind == "bar" and _stiffness(design, each) <= _STIFFEST)
        ),
    )


def _target(design: Design, every: tuple[GageType, ...]) -> list[GageType]:
    """The type that the design names, or all of its grid's kind."""
    named = [each for each in every if each.name == _named(design)]
    return named or [each for each in every if each.kind in _kinds(design)]


def _named(design: Design) -> str | None:
    """The type that the design names: for its mold, else for its readings."""
    return design.gages.kind if design.mold.gage == "auto" else design.mold.gage


def _kinds(design: Design) -> tuple[str, ...]:
    """The kinds that are bought for the design's grid."""
    return ("tee",) if design.gages.grid == "tee" else ("foil",)


def _across(design: Design, frame: PlateFrame) -> float:
    """Width of a plate that a carrier may take, centred as the design's gage is."""
    away = abs(design.gages.z_mm)
    half = 0.5 * frame.span - away
    aside = (abs(hole.w - frame.middle - design.gages.z_mm) - hole.radius for hole in frame.holes)
    return 2.0 * min(half, min(aside, default=half))


def _needed(design: Design, type_: GageType) -> tuple[float, float]:
    """Length and width of what lies on a plate; of bars and film for a tee two, side by side."""
    length, width = type_.carrier(design.gages.length_mm, design.gages.width_mm)
    if type_.kind == "bar" and design.gages.grid == "tee":
        return length, length + width
    if type_.to_measure and design.gages.grid == "tee":
        return length, 2.0 * width
    return length, width


def _fits(
    design: Design, type_: GageType, frames: tuple[PlateFrame, ...], room: tuple[float, float]
) -> bool:
    radii = [frame.bend_radius for frame in frames if frame.bend_radius is not None]
    needed = _needed(design, type_)
    small = all(size <= free + _ROUNDING_MM for size, free in zip(needed, room, strict=True))
    return small and min(radii, default=math.inf) >= type_.bend_mm - _ROUNDING_MM


def _growth(design: Design, type_: GageType, room: tuple[float, float]) -> float:
    """The share by which plates must grow for a type: of both their sizes, together."""
    sizes = zip(_needed(design, type_), room, strict=True)
    return sum(max(size / max(free, 0.01) - 1.0, 0.0) for size, free in sizes)


def _apart(design: Design, type_: GageType) -> tuple[float, float]:
    """The size of the logarithm of the grid's length and width over the design's."""
    gages = design.gages
    long, wide = gages.length_mm / type_.grid_length_mm, gages.width_mm / type_.grid_width_mm
    return abs(math.log(long)), abs(math.log(wide))


def gage_words(design: Design, fit: GageFit | None, mends: str = "") -> str | None:
    """Fault of the gages' sizes, and the nearest plate that mends it; None without a fault.

    mends: keys and values that are known to mend it.
    """
    if fit is None:
        return None
    gages = design.gages
    if fit.found is not None:
        if not fit.differs_from(design):
            return None
        type_ = fit.found
        return (
            f"gages: of the types that fit, the nearest is {type_.name}, whose grid is "
            f"{type_.grid_length_mm:g} x {type_.grid_width_mm:g} mm, not {gages.length_mm:g} x "
            f"{gages.width_mm:g}: set gages.length_mm = {type_.grid_length_mm:g} and "
            f"gages.width_mm = {type_.grid_width_mm:g}, or add yours as [[mold.gage_types]]"
        )
    room = f"{fit.room[0]:.3g} mm along the grid and {fit.room[1]:.3g} across"
    sold = f"{'tee rosette' if gages.grid == 'tee' else 'gage'} that is sold fits"
    named = _named(design)
    words = f"gages: {f'{named} does not fit' if named else f'no {sold}'} plates with {room}"
    if fit.nearest is not None:
        change = mends or _change(design, fit)
        words += f"; the nearest plate that takes one ({fit.nearest.name}) has {change}"
        if (added := _stiffness(design, fit.nearest)) > _STIFFENS:
            words += f", and the gage stiffens it by up to {added:.0%}"
    if fit.others and (named or fit.others[0] not in fit.films):
        key = "gages.kind" if design.mold.gage == "auto" else "mold.gage"
        words += f"; the nearest type that fits: {key} = '{fit.others[0]}'"
    if fit.films:
        words += f"; or film made on the plates: mold.gage = '{fit.films[-1]}'"
    return words


def misfit_words(design: Design) -> str | None:
    """The fault of a type that the design names and its plates cannot carry; None without one."""
    fit = gage_fit(design)
    if fit is None or fit.found is not None or not _named(design):
        return None
    return gage_words(design, fit)


def gage_stiffness(design: Design, fit: GageFit | None) -> float:
    """Stiffness along the grid that the gages add to a plate where they lie, over its own.

    On both faces twice. A gage that covers part of the plate's width adds less, since the plate
    next to it carries on: this is the most.
    """
    return 0.0 if fit is None or fit.found is None else _stiffness(design, fit.found)


def _stiffness(design: Design, type_: GageType) -> float:
    plate = design.material_of("plates").youngs_modulus_MPa * design.plates.thickness_mm
    return design.gages.faces * type_.stiffness / plate


def stiffness_words(design: Design, fit: GageFit | None) -> str | None:
    """The cost of gages that stiffen their plates, or that other gages are cast than are read; None
    where it is little."""
    cast = None if fit is None or fit.found is None else fit.found.name
    if cast is not None and design.gages.kind not in (None, cast):
        read = f"gages: gages.kind = '{design.gages.kind}' is read"
        return f"{read}, but mold.gage = '{cast}' is cast: name the same in both"
    added = gage_stiffness(design, fit)
    if added <= _STIFFENS or fit is None or fit.found is None:
        return None
    name = fit.found.name
    kind = f" with gages.kind = '{name}'" if design.gages.kind is None else ""
    return (
        f"gages: {name} makes a plate up to {added:.0%} stiffer where it lies; plane strain "
        f"ignores this, and its readings are up to as much too high; 3-D{kind} has it"
    )


def _change(design: Design, fit: GageFit) -> str:
    """The keys of a plate that takes the nearest type."""
    changes = []
    if fit.length > fit.room[0]:
        changes.append(f"plates.length_mm = {fit.length:g}")
    wide = fit.width + 2.0 * abs(design.gages.z_mm)
    if wide > min(frame.span for frame in plate_frames(design)) + _ROUNDING_MM:
        changes.append(f"plates.span_mm = {wide:g}")
    if fit.width > fit.room[1] and design.plates.hole_diameter_mm:
        changes.append(_apart_enough(design, fit.width))
    assert fit.nearest is not None
    radii = [f.bend_radius for f in plate_frames(design) if f.bend_radius is not None]
    if min(radii, default=math.inf) < fit.nearest.bend_mm:
        changes.append(f"a radius of {fit.nearest.bend_mm:g} mm at least")
    if fit.length > fit.room[0] and design.plates.number > 1:
        changes.append("a pitch or count that leaves it room")
    return ", ".join(changes)


def _apart_enough(design: Design, width: float) -> str:
    """The distance of holes that leave such a width between them, as far as they then fit into the
    span (checks.plates)."""
    hole = design.plates.hole_diameter_mm or 0.0
    span = max(frame.span for frame in plate_frames(design))
    fits = not design.gages.z_mm and width + 4.0 * hole <= max(span, width)
    return f"plates.hole_pitch_mm = {width + hole:g}" if fits else "no holes"


def sheet_words(design: Design) -> list[str]:
    """Plates and combs of a thickness that is not sold, with the nearest one that is."""
    found, mold = [], design.mold
    given = ("plates.thickness_mm", design.plates.thickness_mm, design.plates.material)
    sheets = [given] if design.plates.number else []
    if design.plates.number and mold.plate_fixture == "comb":
        sheets.append(("mold.comb.sheet_mm", mold.comb.sheet_mm, "metal"))
    for key, thickness, material in sheets:
        stock = mold.sheets_mm or sheets_of(material)
        nearest = nearest_sheet(thickness, stock)
        if nearest is not None:
            words = material.replace("_", " ")
            found.append(
                f"sheet: {key} = {thickness:g} is no thickness that {words} is commonly sold in; "
                f"the nearest is {nearest:g} mm (mold.sheets_mm lists what you have)"
            )
    return found
